"""Speed as ratios in one run: lockstep against a bare barrier of as many processes, one process against many."""

import json
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from grex_link.scenario import load
from grex_sim import barrier
from grex_sim.launch import Launch, free_port
from grex_sim.run import simulate_in_process
from grex_sim.summary import Summary

#: Craft, ticks a round, rounds.
SIZES = ((3, 3000, 5), (10, 1000, 3), (30, 200, 1))


@dataclass(frozen=True, slots=True)
class Row:
    """Rates of one team size; ticks or barriers a second, medians of the rounds.

    Attributes
    ----------
    craft : int
        Number of craft; there are as many agents, the link and the simulator.
    barrier_per_s, processes_per_s, in_process_per_s : float
        Bare barrier, lockstep between processes, and everybody in one process.
    """

    craft: int
    barrier_per_s: float
    processes_per_s: float
    in_process_per_s: float

    @property
    def lockstep_to_bare_barrier(self) -> float:
        """How much of a bare barrier's rate the whole team keeps."""
        return self.processes_per_s / self.barrier_per_s

    @property
    def in_process_to_processes(self) -> float:
        """How much faster the same run is in one process."""
        return self.in_process_per_s / self.processes_per_s


def run_bench(*, as_json: bool) -> str:
    """Measure all sizes; see `Row`."""
    rows = [measure(*size) for size in SIZES]
    if as_json:
        return json.dumps(_as_object(rows))
    return _as_table(rows)


def measure(craft: int, ticks: int, rounds: int) -> Row:
    """Measure one team size, the alternatives in turn."""
    with TemporaryDirectory(prefix="grex-bench-") as folder:
        file = Path(folder) / "bench.toml"
        file.write_text(scenario_text(craft, ticks), encoding="utf-8")
        alternatives: tuple[Callable[[Path], float], ...] = (_barrier, _processes, _in_process)
        rates = [[measure_one(file) for measure_one in alternatives] for _ in range(rounds)]
    return Row(craft, *(statistics.median(column) for column in zip(*rates, strict=True)))


def scenario_text(craft: int, ticks: int) -> str:
    """Return the paper's case d for any number of craft, in line abreast 25 m apart, with a step of 1 s."""
    names = [f"auv{number}" for number in range(1, craft + 1)]
    formation = "\n".join(f"{name} = [0.0, {25.0 * place}, 0.0]" for place, name in enumerate(names))
    tables = "\n".join(f"[craft.{name}]" for name in names)
    return f"""
duration_s = {ticks}
[team]
estimator = "second_level"
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 10000.0
[mission.formation_m]
{formation}
{tables}
[craft.auv1.vehicle]
speed_error_relative = 0.0125
"""


def _barrier(file: Path) -> float:
    overrides = [f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]']
    scenario = load(file, overrides)
    ticks = int(scenario.duration_s or 0)
    return barrier.measure(file, scenario, overrides, len(scenario.craft) + 1, ticks)


def _processes(file: Path) -> float:
    out = file.parent / "processes"
    out.mkdir(exist_ok=True)
    with Launch(load(file), [str(file)], out) as launch:
        return launch.wait(_quiet).ticks_per_s


def _in_process(file: Path) -> float:
    summary: Summary = simulate_in_process(load(file), file.parent / "in-process", _quiet)
    return summary.ticks_per_s


def _quiet(time_s: float) -> None:
    del time_s


def _as_object(rows: list[Row]) -> dict[str, object]:
    """Return the first size's ratios by name, and all rows."""
    return {
        "lockstep_to_bare_barrier": rows[0].lockstep_to_bare_barrier,
        "in_process_to_processes": rows[0].in_process_to_processes,
        "rows": [
            {
                "craft": row.craft,
                "lockstep_to_bare_barrier": row.lockstep_to_bare_barrier,
                "in_process_to_processes": row.in_process_to_processes,
                "barrier_per_s": row.barrier_per_s,
                "processes_ticks_per_s": row.processes_per_s,
                "in_process_ticks_per_s": row.in_process_per_s,
                "processes_real_time_factor": row.processes_per_s,
                "in_process_real_time_factor": row.in_process_per_s,
            }
            for row in rows
        ],
    }


def _as_table(rows: list[Row]) -> str:
    lines = [
        "case d, 1 s a tick, so ticks per second are the real-time factor; all are recorded",
        "craft  bare barrier/s  processes  in process  lockstep/barrier  in process/processes",
    ]
    lines += [
        f"{row.craft:5d}  {row.barrier_per_s:14.0f}  {row.processes_per_s:8.0f}x  {row.in_process_per_s:9.0f}x"
        f"  {row.lockstep_to_bare_barrier:16.2f}  {row.in_process_to_processes:20.2f}"
        for row in rows
    ]
    return "\n".join(lines)
