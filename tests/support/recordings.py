"""What tests read of recordings, and write into them."""

from pathlib import Path
from typing import Any

from missions import SCENARIOS

from grex_link.recording import Recording, run_metadata
from grex_link.scenario import load

#: Of a run of case d.
METADATA = run_metadata(load(SCENARIOS / "paper-d.toml"))


def recorded_messages(run: Path, topic: str, craft: str = "") -> list[Any]:
    """Read the messages of a topic in the order of writing; of all craft, or of one."""
    return [entry.message for entry in Recording(run).entries({topic}) if craft in {"", entry.craft}]
