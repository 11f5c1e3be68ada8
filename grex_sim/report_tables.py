"""The tables of a report, as rows of text: figures side by side with differences, links, beliefs, scenarios."""

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

import msgspec
import numpy as np

from grex_sim.intervals import mean_of_series
from grex_sim.link_stats import Spread
from grex_sim.report_data import RunData
from grex_sim.report_pictures import pairs_of
from grex_sim.score import Series

#: Heading and rows; the first column of a row is its name.
Rows = list[list[str]]
_LINKS_MAX = 90
_NONE = "–"


def merits(runs: Sequence[RunData]) -> Rows:
    """Compare FD and its parts: mean with its 95 % interval, and how much the others differ from the first run."""
    heads = ["", *(run.label for run in runs), *(f"{run.label} − {runs[0].label}" for run in runs[1:])]
    rows = [heads]
    for name, column in (
        ("FD", "fd_series"),
        ("distance, m", "distance"),
        ("angle, rad", "angle"),
        ("cross-track, m", "xte"),
    ):
        series = [getattr(run.score, column) for run in runs]
        differences = [
            _difference(runs[0].t_s, series[0], run.t_s, each) for run, each in zip(runs, series, strict=True)
        ]
        rows.append([name, *(str(mean_of_series(each)) for each in series), *differences[1:]])
    return rows


def _difference(times: Series, one: Series, other_times: Series, other: Series) -> str:
    """Difference of two series where both are, tick by tick, so that what both went through cancels."""
    _, mine, theirs = np.intersect1d(times, other_times, return_indices=True)
    return str(mean_of_series(other[theirs] - one[mine])) if len(mine) else _NONE


def facts(runs: Sequence[RunData]) -> Rows:
    """Say of each run what it was, how it ended, and how fast it went."""
    rows = [["", *(run.label for run in runs)]]
    table: dict[str, list[str]] = {
        "title": [run.scenario.title or _NONE for run in runs],
        "estimator": [run.scenario.team.estimator for run in runs],
        "modem": [run.scenario.link.profile for run in runs],
        "craft": [str(len(run.scenario.craft)) for run in runs],
        "seed": [str(run.scenario.seed) for run in runs],
        "mission time, s": [f"{run.t_s[-1]:.0f}" for run in runs],
        "ended": [_ending(run) for run in runs],
        "pace": [str(run.scenario.clock.pace) for run in runs],
        "wall time, s": [f"{run.summary.wall_s:.1f}" if run.summary else _NONE for run in runs],
        "real-time factor": [f"{run.summary.real_time_factor:.0f}" if run.summary else _NONE for run in runs],
        "late ticks": [str(run.summary.late_ticks) if run.summary else _NONE for run in runs],
        "late setpoints": [str(run.summary.late_setpoints) if run.summary else _NONE for run in runs],
        "latency, s": [_spread(run.stats.latency) for run in runs],
        "age of information, s": [_spread(run.stats.age) for run in runs],
        "digest": [run.summary.digest[:16] if run.summary else _NONE for run in runs],
    }
    return rows + [[name, *values] for name, values in table.items()]


def _ending(run: RunData) -> str:
    if run.summary is None:
        return "killed: there is no summary"
    return "complete" if run.summary.complete else f"broke off: {run.summary.fault}"


def differing(runs: Sequence[RunData]) -> Rows:
    """List what the scenarios do not have in common."""
    flat = [dict(_leaves(msgspec.to_builtins(run.scenario), "$")) for run in runs]
    paths = dict.fromkeys(path for each in flat for path in each)
    rows = [
        [path, *(each.get(path, _NONE) for each in flat)]
        for path in paths
        if len({each.get(path, _NONE) for each in flat}) > 1
    ]
    return [["", *(run.label for run in runs)], *rows]


def _leaves(value: Any, path: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            yield from _leaves(inner, f"{path}.{key}")
    else:
        yield path, msgspec.json.encode(value).decode()


def links(run: RunData) -> Rows:
    """Return the ledger of every directed link."""
    rows = [["link", "sent", "delivered", "overheard", "lost", "of which", "on the way", "latency s", "age s"]]
    for name, link in islice(run.stats.links.items(), _LINKS_MAX):
        counts = link.counts
        lost = sum(counts.lost.values())
        causes = ", ".join(f"{reason} {n}" for reason, n in sorted(counts.lost.items(), key=lambda entry: -entry[1]))
        numbers = (counts.sent, counts.delivered, counts.overheard, lost)
        rows.append(
            [
                name,
                *map(str, numbers),
                causes or _NONE,
                str(counts.on_the_way),
                _spread(link.latency),
                _spread(link.age),
            ]
        )
    return rows


def beliefs(run: RunData) -> Rows:
    """Return for each pair how far beliefs are off, and whether their sigma says so."""
    rows = [["belief", "error r.m.s. m", "largest m", "mean sigma m", "mean NEES (2)", "inside its band (95 %)"]]
    for name, errors in islice(pairs_of(run).items(), _LINKS_MAX):
        sigma = errors.sigma_m[np.isfinite(errors.sigma_m)]
        distance = errors.distance_m[np.isfinite(errors.distance_m)]
        claimed = [_NONE] * 3
        if len(sigma):
            claimed = [f"{sigma.mean():.3f}", str(errors.mean_nees), f"{100 * errors.inside:.1f} %"]
        rows.append([name, f"{errors.rms_m:.3f}", f"{distance.max(initial=0.0):.3f}", *claimed])
    return rows


def left_out(run: RunData) -> str:
    """Say how many links and beliefs the tables leave out; empty if none."""
    more = max(len(run.stats.links), len(pairs_of(run))) - _LINKS_MAX
    return f"{more} further links are left out; grex link stats and grex export have them." if more > 0 else ""


def _spread(spread: Spread) -> str:
    """Mean, median and 90 % quantile."""
    if spread.mean_s is None or spread.p50_s is None or spread.p90_s is None:
        return _NONE
    return f"{spread.mean_s:.2f} (50 % {spread.p50_s:.2f}, 90 % {spread.p90_s:.2f})"
