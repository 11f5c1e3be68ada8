"""What the command lines share: a scenario file, overrides that may be repeated, and output for programs."""

from pathlib import Path

import pytest
import tyro

from grex_link.console import AsJson, Overrides, ScenarioFile


def command(scenario: ScenarioFile, overrides: Overrides = (), as_json: AsJson = False) -> tuple:  # noqa: FBT002
    """Return what was asked for."""
    return scenario, overrides, as_json


@pytest.mark.parametrize(
    ("arguments", "asked"),
    [
        (["a.toml"], (Path("a.toml"), (), False)),
        (["a.toml", "--set", "link.loss=0.3"], (Path("a.toml"), ("link.loss=0.3",), False)),
        (["--set", "a=1", "--set", "b=two words", "a.toml", "--json"], (Path("a.toml"), ("a=1", "b=two words"), True)),
    ],
)
def test_arguments(arguments: list[str], asked: tuple) -> None:
    """The scenario is a place on the line, ``--set`` may be repeated, and ``--json`` is a switch."""
    assert tyro.cli(command, args=arguments) == asked


def test_no_scenario(capsys) -> None:
    """Without a scenario file the command line is refused with status 2."""
    with pytest.raises(SystemExit) as caught:
        tyro.cli(command, args=[])
    assert caught.value.code == 2
    assert "SCENARIO" in capsys.readouterr().err
