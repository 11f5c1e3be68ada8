"""Runs scenarios in memory."""

from pathlib import Path

from grex_link.scenario import load, loads
from grex_sim.run import simulate_in_process
from grex_sim.summary import Summary

SCENARIOS = Path(__file__).parents[2] / "deploy" / "scenarios"


def fly(name: str, *overrides: str, out: Path | None = None) -> Summary:
    """Run a scenario of deploy/scenarios in this process."""
    return simulate_in_process(load(SCENARIOS / f"{name}.toml", overrides), out, lambda _: None)


def fly_text(text: str, *overrides: str, out: Path | None = None) -> Summary:
    """Run a scenario given as text in this process."""
    return simulate_in_process(loads(text, overrides), out, lambda _: None)
