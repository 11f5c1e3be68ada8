"""The pictures of a report; a run of several has its colour and dash in all of them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from grex_link.ledger import EDGES_S
from grex_sim.belief_errors import BAND, BeliefErrors, band_of_mean
from grex_sim.canvas import colour, dash, new_figure, thin
from grex_sim.report import run_figure
from grex_sim.report_data import RunData
from grex_sim.score import Series

if TYPE_CHECKING:
    from grex_sim.canvas import Axes, Figure

_SAMPLES_MAX = 3000
_PAIRS_MAX = 6
_GREY = "0.75"
_NOTHING: list[float] = [0.0] * (len(EDGES_S) + 1)


def overview(run: RunData) -> "Figure":
    """Draw tracks, fd(k) with its parts (Fig. 11), and relative positions (Fig. 12)."""
    return run_figure(run.scenario, run.plan, run.t_s, run.score, run.positions)


def deviations(runs: Sequence[RunData]) -> "Figure":
    """Draw fd(k) of several runs over each other (Fig. 11), and each of its parts."""
    figure = new_figure(12.0, 8.5)
    panels = figure.subplots(4, 1, sharex=True)
    names = ("fd(k) (m and rad)", "distance (m)", "angle (rad)", "cross-track (m)")
    for place, run in enumerate(runs):
        series = (run.score.fd_series, run.score.distance, run.score.angle, run.score.xte)
        for axes, values in zip(panels, series, strict=True):
            axes.plot(
                *_thin(run.t_s, values), color=colour(place), linestyle=_dash(place), linewidth=1.0, label=run.label
            )
    for axes, name in zip(panels, names, strict=True):
        _set_up(axes, name)
    panels[0].set_title("Formation deviation and its parts")
    panels[-1].set_xlabel("mission time (s)")
    return _with_legend(figure)


def coordination(run: RunData) -> "Figure":
    """Draw what the agents saw and ordered: Q_m = Σ (Θ_i − Θ_m), cross-track error, speed ordered."""
    figure = new_figure(12.0, 7.5)
    panels = figure.subplots(3, 1, sharex=True)
    for place, craft in enumerate(run.scenario.craft):
        states = run.states.get(craft, [])
        if not states:
            continue
        t_s = np.array([state.t_ns for state in states]) / 1e9
        columns = [[state.quality, state.xte_m, state.ordered_mps - state.planned_mps] for state in states]
        for axes, values in zip(panels, np.array(columns, dtype=float).T, strict=True):
            axes.plot(*_thin(t_s, values), color=colour(place), linestyle=dash(place), linewidth=0.9, label=craft)
    for axes, name in zip(
        panels, ("Q, sum of Θ differences", "cross-track error (m)", "ordered − planned (m/s)"), strict=True
    ):
        _set_up(axes, name)
    panels[0].set_title("What the agents saw of their coordination, and what they ordered for it")
    panels[-1].set_xlabel("mission time by the craft's clock (s)")
    return _with_legend(figure)


def consistency(run: RunData) -> "Figure | None":
    """Draw the errors of beliefs against the sigma claimed, and the NEES with its 95 % band; None without beliefs."""
    pairs = pairs_of(run)
    if not pairs:
        return None
    figure = new_figure(12.0, 7.5)
    above, below = figure.subplots(2, 1, sharex=True)
    for place, (name, errors) in enumerate(list(pairs.items())[:_PAIRS_MAX]):
        above.plot(*_thin(errors.t_s, errors.distance_m), color=colour(place), linewidth=1.0, label=name)
        above.plot(*_thin(errors.t_s, 2.0 * errors.sigma_m), color=colour(place), linewidth=0.6, linestyle=":")
    more = f" (the first {_PAIRS_MAX} of {len(pairs)} pairs)" if len(pairs) > _PAIRS_MAX else ""
    above.set_title(f"Error of what one believes of another{more}; dotted: twice the sigma claimed")
    _set_up(above, "distance from the truth (m)")
    above.set_ylim(bottom=0.0)
    _draw_nees(below, pairs)
    below.set_xlabel("mission time (s)")
    return _with_legend(figure)


def _draw_nees(axes: "Axes", pairs: Mapping[str, BeliefErrors]) -> None:
    floor = 1e-3
    for errors in list(pairs.values())[:_PAIRS_MAX]:
        axes.plot(*_thin(errors.t_s, np.maximum(errors.nees, floor)), color=_GREY, linewidth=0.6)
    t_s, mean, count = _mean_nees(pairs)
    if not count:
        axes.set_title("No sigma is claimed: there is no NEES")
        return
    low, high = band_of_mean(count)
    axes.axhspan(*BAND, color="#56B4E9", alpha=0.15, linewidth=0.0, label="95 % band of one pair")
    axes.axhspan(low, high, color="#009E73", alpha=0.3, linewidth=0.0, label=f"95 % band of the mean of {count}")
    axes.plot(*_thin(t_s, np.maximum(mean, floor)), color="black", linewidth=1.0, label="mean of all pairs")
    axes.set_title("NEES of the beliefs: above the band they claim too much, below it too little; grey: single pairs")
    _set_up(axes, "NEES (2 is consistent)")
    axes.set_yscale("log")


def _mean_nees(pairs: Mapping[str, BeliefErrors]) -> tuple[Series, Series, int]:
    """Average the pairs tick by tick: time, mean, and of how many pairs that claim a sigma."""
    times = np.unique(np.concatenate([errors.t_s for errors in pairs.values()]))
    total, number = np.zeros(len(times)), np.zeros(len(times))
    for errors in pairs.values():
        known = np.isfinite(errors.nees)
        at = np.searchsorted(times, errors.t_s[known])
        np.add.at(total, at, errors.nees[known])
        np.add.at(number, at, 1.0)
    mean = np.divide(total, number, out=np.full(len(times), np.nan), where=number > 0)
    return times, mean, int(number.max(initial=0.0))


def pairs_of(run: RunData) -> dict[str, BeliefErrors]:
    """Return who believed what of whom, by name."""
    return {f"{craft} of {mate}": errors for craft, mates in run.beliefs.items() for mate, errors in mates.items()}


def link_histograms(runs: Sequence[RunData]) -> "Figure":
    """Draw latency and age of information of all links together, a run beside the other."""
    figure = new_figure(12.0, 4.6)
    left, right = figure.subplots(1, 2)
    width = 0.8 / len(runs)
    used: set[int] = set()
    for place, run in enumerate(runs):
        links = [link.counts for link in run.stats.links.values()]
        latencies = np.sum([_NOTHING, *([float(n) for n in path.latency_counts] for path in links)], axis=0)
        ages = np.sum([_NOTHING, *(path.age_seconds for path in links)], axis=0)
        for axes, values in ((left, latencies), (right, ages)):
            share = 100.0 * values / max(float(values.sum()), 1e-9)
            used |= set(np.flatnonzero(values).tolist())
            places = np.arange(len(values)) + (place - (len(runs) - 1) / 2) * width
            axes.bar(places, share, width, color=colour(place), hatch=("", "//", "..", "xx")[place % 4],
                     edgecolor="white", label=run.label)  # fmt: skip
    shown = range(min(used, default=0), max(used, default=0) + 1)
    for axes, title, unit in ((left, "Latency", "% of deliveries"), (right, "Age of information", "% of the time")):
        axes.set_title(f"{title}, all directed links")
        _set_up(axes, unit)
        axes.set_xlim(shown[0] - 0.6, shown[-1] + 0.6)
        axes.set_xticks(list(shown), [_bin(place) for place in shown], rotation=30)
        axes.set_xlabel("seconds")
    return _with_legend(figure)


def _bin(place: int) -> str:
    if place == len(EDGES_S):
        return f"over {EDGES_S[-1]:g}"
    return f"{EDGES_S[place - 1] if place else 0.0:g} – {EDGES_S[place]:g}"


def _thin(t_s: Series, values: Series) -> tuple[Series, Series]:
    return thin(t_s, _SAMPLES_MAX), thin(values, _SAMPLES_MAX)


def _dash(place: int) -> str:
    """Give each run a dash of its own, for those who see no colours; runs are few."""
    return ("-", "--", ":", "-.")[place % 4]


def _set_up(axes: "Axes", label: str) -> None:
    axes.set(ylabel=label, axisbelow=True)
    axes.grid(visible=True, color="0.9", linewidth=0.6)
    axes.margins(x=0.01)


def _with_legend(figure: "Figure") -> "Figure":
    entries: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(str(label), handle)
    if entries:
        columns = max(1, min(len(entries), 130 // (8 + max(map(len, entries)))))
        legend = figure.legend(
            list(entries.values()), list(entries), loc="outside lower center", ncols=columns, frameon=False
        )
        for text in legend.get_texts():
            text.set_parse_math(False)
    return figure
