"""What the command lines of all three packages share."""

from pathlib import Path
from typing import Annotated

import tyro

ScenarioFile = Annotated[
    Path, tyro.conf.Positional, tyro.conf.arg(metavar="SCENARIO", help="The scenario file (TOML).")
]
Overrides = Annotated[
    tyro.conf.UseAppendAction[tuple[str, ...]],
    tyro.conf.arg(name="set", metavar="PATH=VALUE", help="Override a value of the scenario; may be repeated."),
]
AsJson = Annotated[bool, tyro.conf.arg(name="json", help="Print JSON for programs.")]
