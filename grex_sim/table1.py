"""Table I of the paper, from four runs as processes in lockstep."""

import json
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from grex_link.errors import ConfigError
from grex_link.scenario import load
from grex_sim.launch import Launch
from grex_sim.run import check_scenario
from grex_sim.summary import Summary

#: Case and the paper's FD (GREX 2008, Table I): to be printed beside ours, and for nothing else.
PAPER = {"a": 12.5996, "b": 0.4283, "c": 0.4636, "d": 0.4594}
SCENARIOS = Path(__file__).parents[1] / "deploy" / "scenarios"


@dataclass(frozen=True, slots=True)
class Case:
    """One row of the table."""

    name: str
    summary: Summary

    @property
    def fd(self) -> float:
        """Formation deviation of our run."""
        return self.summary.fd or 0.0

    @property
    def deviation_percent(self) -> float:
        """How far ours is from the paper's."""
        return 100.0 * (self.fd / PAPER[self.name] - 1.0)


def run_table(*, as_json: bool) -> str:
    """Run cases a to d and put them beside the paper's.

    Raises
    ------
    ConfigError
        If the scenario files are not there.
    """
    cases = [_run_case(name) for name in PAPER]
    return json.dumps(_as_object(cases)) if as_json else _as_table(cases)


def _run_case(name: str) -> Case:
    file = SCENARIOS / f"paper-{name}.toml"
    if not file.is_file():
        raise ConfigError(str(file), "is not there; run from a checkout of the project, which has deploy/scenarios")
    scenario = load(file)
    check_scenario(scenario)
    with TemporaryDirectory(prefix="grex-table1-") as folder, Launch(scenario, [str(file)], Path(folder)) as launch:
        return Case(name, launch.wait(lambda _: None))


def _ratios(fd: dict[str, float]) -> dict[str, float]:
    return {"a/b": fd["a"] / fd["b"], "c/b": fd["c"] / fd["b"], "d/b": fd["d"] / fd["b"]}


def _as_object(cases: list[Case]) -> dict[str, object]:
    return {
        "rows": [
            {
                "case": case.name,
                "estimator": case.summary.estimator,
                "fd": case.fd,
                "paper": PAPER[case.name],
                "deviation_percent": case.deviation_percent,
                "fd_distance": case.summary.fd_distance,
                "fd_angle": case.summary.fd_angle,
                "fd_xte": case.summary.fd_xte,
                "real_time_factor": case.summary.real_time_factor,
                "digest": case.summary.digest,
            }
            for case in cases
        ],
        "ratios": _ratios({case.name: case.fd for case in cases}),
        "paper_ratios": _ratios(PAPER),
    }


def _as_table(cases: list[Case]) -> str:
    lines = ["case  estimator        FD      paper  deviation   distance   angle   cross-track"]
    for case in cases:
        run = case.summary
        lines.append(
            f"{case.name:4s}  {run.estimator:12s} {case.fd:8.4f} {PAPER[case.name]:8.4f}"
            f"   {case.deviation_percent:+5.1f} %    {run.fd_distance:8.4f} {run.fd_angle:8.4f} {run.fd_xte:8.4f}"
        )
    ours, paper = _ratios({case.name: case.fd for case in cases}), _ratios(PAPER)
    lines.append("ratios: " + ", ".join(f"{name} {ours[name]:.4g} (paper {paper[name]:.4g})" for name in ours))
    return "\n".join(lines)
