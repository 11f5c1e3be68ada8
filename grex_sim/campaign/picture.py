"""The picture of a campaign: FD and age of information of every cell, with their 95 % intervals."""

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from grex_sim.campaign.results import CellResult
from grex_sim.canvas import colour, dash, new_figure, save

if TYPE_CHECKING:
    from grex_sim.canvas import Axes

PICTURE_FILE = "campaign.png"
_PANELS = (("fd", "formation deviation FD (m and rad)"), ("age_mean_s", "mean age of information (s)"))
_MARKERS = "osD^vPX"
#: Of the distance of two values, how far lines stand apart, so that intervals do not hide each other.
_APART = 0.03
_LEGEND_MAX = 40


def draw(path: Path, title: str, results: Sequence[CellResult]) -> None:
    """Draw all cells over one of the paths that vary, a line for each combination of the others.

    Parameters
    ----------
    path : Path
        Where the picture goes.
    title : str
        Of the scenario.
    results : sequence of CellResult
        All cells.

    Raises
    ------
    ConfigError
        If the picture cannot be written.
    """
    figure = new_figure(12.0, 6.5)
    across = _across(results)
    lines = _lines(results, across)
    for axes, (name, label) in zip(figure.subplots(1, 2), _PANELS, strict=True):
        _draw_panel(axes, name, lines, across)
        axes.set(ylabel=label, axisbelow=True)
        axes.grid(visible=True, color="0.9", linewidth=0.6)
    runs = sum(result.runs for result in results)
    text = f"{runs} runs; means and their 95 % intervals"
    figure.suptitle(f"{shorten(title, 110, placeholder=' …')}\n{text}" if title else text, parse_math=False)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    if labels and any(labels):
        columns = max(1, min(len(labels), 130 // (8 + max(map(len, labels)))))
        legend = figure.legend(
            handles[:_LEGEND_MAX], labels[:_LEGEND_MAX], loc="outside lower center", ncols=columns, frameon=False
        )
        for entry in legend.get_texts():
            entry.set_parse_math(False)
    save(figure, path)


def _across(results: Sequence[CellResult]) -> str:
    """Choose what goes along the axis: the path of numbers with the most values, else that with the most."""
    values = {name: [result.values[name] for result in results] for name in results[0].values}
    return max(values, key=lambda name: (_numeric(values[name]), len(set(map(str, values[name])))), default="")


def _numeric(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def _lines(results: Sequence[CellResult], across: str) -> dict[str, list[CellResult]]:
    lines: dict[str, list[CellResult]] = {}
    for result in results:
        label = ", ".join(f"{name}={value}" for name, value in result.values.items() if name != across)
        lines.setdefault(label, []).append(result)
    return lines


def _draw_panel(axes: "Axes", name: str, lines: dict[str, list[CellResult]], across: str) -> None:
    values = [result.values.get(across, "all runs") for result in next(iter(lines.values()))]
    numeric = _numeric(values)
    places = [float(value) for value in values] if numeric else [float(place) for place in range(len(values))]
    nearest = min((abs(b - a) for a, b in zip(sorted(places), sorted(places)[1:], strict=False)), default=1.0)
    for number, (label, cells) in enumerate(lines.items()):
        shift = (number - (len(lines) - 1) / 2) * min(_APART, 0.5 / len(lines)) * nearest
        estimates = [cell.estimates[name] for cell in cells]
        axes.errorbar(
            [place + shift for place in places],
            [estimate.mean for estimate in estimates],
            [estimate.half if math.isfinite(estimate.half) else 0.0 for estimate in estimates],
            color=colour(number),
            linestyle=dash(number) if numeric else "",
            marker=_MARKERS[number % len(_MARKERS)],
            markersize=5,
            linewidth=1.2,
            capsize=3,
            label=label,
        )
    axes.set_xlabel(across, parse_math=False)
    if not numeric:
        axes.set_xticks(places, [str(value) for value in values], rotation=20 if len(values) > 3 else 0)
        axes.margins(x=0.15)
