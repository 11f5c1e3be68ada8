"""Pictures of plans and runs.

Pictures of tracks have north up and east to the right; craft are numbered in the order of the team.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import CraftPlan, TeamPlan
from grex_agent.path import Track
from grex_link.config import Scenario
from grex_sim.canvas import colour as _colour
from grex_sim.canvas import dash as _dash
from grex_sim.canvas import new_figure as _figure
from grex_sim.canvas import save as _save
from grex_sim.canvas import thin
from grex_sim.plan_text import plan_text
from grex_sim.report_events import mark_events
from grex_sim.score import Score, Series
from grex_sim.summary import SERIES_FILE

if TYPE_CHECKING:
    from grex_sim.canvas import Axes, Figure

__all__ = ["draw", "draw_plan", "plan_text", "relative_positions", "run_figure"]

PICTURE_FILE = "run.png"
#: The parts of fd(k): column of series.csv, name, unit, shade.
_PARTS = (
    ("fd_distance", "distance", "m", "#d0d7de"),
    ("fd_angle", "angle", "rad", "#8c99a6"),
    ("fd_xte", "cross-track", "m", "#3d4852"),
)
_FORMATIONS = 9
_DESIRED = 60
_SAMPLES_MAX = 6000
_LEGEND_MAX = 40


_Taken = dict[tuple[int, int], list[tuple[float, float]]]


@dataclass(frozen=True, slots=True)
class _Run:
    """What a run's series.csv holds: t_s and fd's columns by name, and positions of shape (l, craft, 2).

    `members` has the positions of the formation alone.
    """

    columns: dict[str, Series]
    positions: Series
    members: Series


def draw(folder: Path, scenario: Scenario, plan: TeamPlan) -> Path | None:
    """Draw a run: its tracks, fd(k) (paper, Fig. 11) and the positions relative to the first craft (Fig. 12).

    Parameters
    ----------
    folder : Path
        The run's folder, with series.csv; run.png goes there.
    scenario : Scenario
        What was run.
    plan : TeamPlan
        What was planned for it.

    Returns
    -------
    Path or None
        The picture; None if the run broke off before its first tick, so that there is nothing to draw.

    Raises
    ------
    ConfigError
        If the picture cannot be written.
    """
    run = _read(folder / SERIES_FILE, list(scenario.craft), list(plan.craft))
    if run is None:
        return None
    return _save(_draw_run(scenario, plan, run), folder / PICTURE_FILE)


def run_figure(scenario: Scenario, plan: TeamPlan, t_s: Series, result: Score, positions: Series) -> "Figure":
    """Draw the same of a run that is in memory.

    Parameters
    ----------
    scenario, plan
        What was asked for, and planned.
    t_s : ndarray, shape (l,)
        Mission time of the ticks.
    result : Score
        fd(k) and its parts.
    positions : ndarray, shape (l, craft, 2)
        True north and east, metres.
    """
    columns = {"t_s": t_s, "fd": result.fd_series}
    columns |= {"fd_distance": result.distance, "fd_angle": result.angle, "fd_xte": result.xte}
    places = [place for place, craft in enumerate(scenario.craft) if craft in plan.craft]
    return _draw_run(scenario, plan, _Run(columns, positions, positions[:, places]))


def _draw_run(scenario: Scenario, plan: TeamPlan, run: _Run) -> "Figure":
    figure = _figure(14.0, 10.5)
    axes: dict[str, Axes] = figure.subplot_mosaic(**_arrangement(plan))
    _draw_tracks(axes["tracks"], run, plan)
    mark_events(axes["tracks"], scenario)
    _draw_deviation(axes["fd"], run)
    if "relative" in axes:
        _draw_relative(axes["relative"], run, plan)
    subtitle = f"estimator {scenario.team.estimator}, {len(scenario.craft)} craft, {run.columns['t_s'][-1]:.0f} s"
    _finish(figure, scenario, subtitle)
    return figure


def draw_plan(path: Path, scenario: Scenario, plan: TeamPlan) -> None:
    """Draw the planned tracks with their numbers and directions.

    Parameters
    ----------
    path : Path
        Where the picture goes; its suffix says of which kind it is, PNG without one.
    scenario : Scenario
        What was asked for.
    plan : TeamPlan
        What was planned for it.

    Raises
    ------
    ConfigError
        If the picture cannot be written.
    """
    north, east = _extent(plan)
    figure = _figure(12.0, 2.5 + 10.0 * min(max(north / east, 0.35), 0.9))
    axes = figure.subplots()
    _set_up_map(axes)
    axes.set_title("Planned tracks, with their numbers")
    _fill_formation(axes, np.array([craft.point(0.0) for craft in plan.craft.values()]), "formation at the start")
    for place, craft in _members(plan):
        axes.plot(*_path(craft).T[::-1], color=_colour(place), linestyle=_dash(place), linewidth=1.6)
    _mark_ends(axes, plan)
    _mark_tracks(axes, plan, 0.035 * math.hypot(north, east))
    mark_events(axes, scenario)
    _name_craft(axes, plan)
    _finish(figure, scenario, f"{len(scenario.craft)} craft, {plan.duration_s:.0f} s")
    _save(figure, path)


def relative_positions(positions: Series, plan: TeamPlan) -> tuple[Series, Series]:
    """Place the other craft in a frame at the first one, which turns as much as the first one's tracks do.

    On a line it has the line's course; an arc turns it on from there. So a lawnmower's formation stands still in it,
    wherever in the formation the first craft is.

    Parameters
    ----------
    positions : ndarray, shape (l, craft, 2)
        True north and east, metres.
    plan : TeamPlan
        The plan, in the same order of craft.

    Returns
    -------
    desired, real : ndarray, shape (l, craft - 1, 2)
        Metres ahead and to starboard of the first craft; desired is the plan at the first craft's progress.
    """
    team = list(plan.craft.values())
    processor, turns = ManoeuvreProcessor(team[0]), _turns(team[0])
    headings, planned = np.empty(len(positions)), np.empty_like(positions)
    for step, (north, east) in enumerate(positions[:, 0].tolist()):
        theta = processor.follow(north, east).theta
        heading, turn = turns[processor.number]
        headings[step] = heading + theta * turn
        planned[step] = [craft.point(processor.progress) for craft in team]
    return _seen_from_first(planned, headings), _seen_from_first(positions, headings)


def _turns(craft: CraftPlan) -> list[tuple[float, float]]:
    """Heading of the frame at the start of every track, and by how much it turns on it, radians."""
    turns: list[tuple[float, float]] = []
    for track in craft.tracks:
        turn = track.curvature * track.length_m
        heading = sum(turns[-1]) if turn and turns else track.locate(*track.point(0.0)).course_rad
        turns.append((heading, turn))
    return turns


def _seen_from_first(positions: Series, headings: Series) -> Series:
    away = positions[:, 1:] - positions[:, :1]
    cos, sin = np.cos(headings)[:, None], np.sin(headings)[:, None]
    ahead, starboard = away[..., 0] * cos + away[..., 1] * sin, away[..., 1] * cos - away[..., 0] * sin
    return np.stack([ahead, starboard], axis=-1)


def _members(plan: TeamPlan) -> Iterator[tuple[int, CraftPlan]]:
    """Yield place in the team and plan of those who are in the formation."""
    return ((place, each) for place, (craft, each) in enumerate(plan.everybody.items()) if craft in plan.craft)


def _read(path: Path, team: Sequence[str], members: Sequence[str]) -> _Run | None:
    """Read a series; None if there is none, or one without steps."""
    if not path.is_file():
        return None
    names, *rows = path.read_text(encoding="utf-8").splitlines()
    if not rows:
        return None
    table = np.loadtxt(rows, delimiter=",", ndmin=2)
    columns = dict(zip(names.split(","), table.T, strict=True))
    places = [[columns[f"{craft}_{axis}_m"] for axis in ("north", "east")] for craft in team]
    positions = np.array(places).transpose(2, 0, 1)
    return _Run(columns, positions, positions[:, [team.index(craft) for craft in members]])


# -- the three panels of a run ------------------------------------------------------------------------------------


def _arrangement(plan: TeamPlan) -> dict[str, Any]:
    """Give the tracks the shape they need."""
    north, east = _extent(plan)
    alone = len(plan.craft) == 1
    if north > 1.3 * east or (alone and 1.5 * north > east):
        return {"mosaic": [["tracks", "fd"], ["tracks", "fd" if alone else "relative"]], "width_ratios": [1.0, 1.1]}
    if alone or east > 3.0 * north:
        below = ["fd", "fd"] if alone else ["fd", "relative"]
        return {"mosaic": [["tracks", "tracks"], below], "width_ratios": [1.5, 1.0], "height_ratios": [1.2, 1.0]}
    return {"mosaic": [["tracks", "relative"], ["fd", "fd"]], "width_ratios": [1.6, 1.0], "height_ratios": [1.5, 1.0]}


def _draw_tracks(axes: "Axes", run: _Run, plan: TeamPlan) -> None:
    _set_up_map(axes)
    axes.set_title("Tracks")
    for number, craft in enumerate(plan.craft.values()):
        label = "" if number else "planned track"
        axes.plot(*_path(craft).T[::-1], color="0.82", linewidth=2.5, label=label)
    steps = np.unique(np.linspace(0, len(run.positions) - 1, _FORMATIONS).astype(int))
    for step in steps:
        _fill_formation(axes, run.members[step], "" if step else "formation")
    thin = _thin(run.positions)
    for place in range(len(plan.everybody)):
        axes.plot(thin[:, place, 1], thin[:, place, 0], color=_colour(place), linestyle=_dash(place), linewidth=1.2)
    _mark_ends(axes, plan)
    _name_craft(axes, plan)


def _draw_deviation(axes: "Axes", run: _Run) -> None:
    time_s, total = _thin(run.columns["t_s"]), _thin(run.columns["fd"])
    below = np.zeros_like(time_s)
    for column, name, unit, shade in _PARTS:
        above = below + _thin(run.columns[column])
        label = f"{name} (mean {run.columns[column].mean():.4f} {unit})"
        axes.fill_between(time_s, below, above, color=shade, linewidth=0.0, label=label)
        below = above
    axes.plot(time_s, total, color="black", linewidth=0.7, marker="o" if len(time_s) == 1 else "", label="fd(k)")
    axes.set_title(f"Formation deviation FD = {run.columns['fd'].mean():.4f}, the mean of fd(k)")
    axes.set(xlabel="mission time (s)", ylabel="fd(k), sum of its parts (m and rad)", axisbelow=True)
    axes.set_ylim(0.0, 1.3 * max(float(total.max()), 1e-3))
    axes.margins(x=0.01)
    axes.grid(visible=True, color="0.9", linewidth=0.6)
    axes.legend(loc="upper left", ncols=2, frameon=False, fontsize="small")


def _draw_relative(axes: "Axes", run: _Run, plan: TeamPlan) -> None:
    desired, real = relative_positions(run.members, plan)
    errors = np.hypot(*(real - desired).transpose(2, 0, 1))
    _set_up_map(axes, "starboard (m)", "ahead (m)")
    axes.set_title(
        f"Positions relative to {next(iter(plan.craft))}:\n"
        f"{math.sqrt(float((errors**2).mean())):.3g} m r.m.s. off the desired, {errors.max():.3g} m at most"
    )
    axes.plot(0.0, 0.0, "^", color=_colour(0), markersize=9)
    for place, (ahead, starboard) in enumerate(_thin(real).transpose(1, 2, 0), start=1):
        axes.plot(starboard, ahead, ".-", color=_colour(place), markersize=2.0, linewidth=0.6)
    wanted = desired[np.unique(np.linspace(0, len(desired) - 1, _DESIRED).astype(int))]
    axes.plot(*wanted.reshape(-1, 2).T[::-1], "k+", markersize=11, label="desired place")
    for place, (ahead, starboard) in enumerate(wanted[0], start=2):
        axes.annotate(str(place), (starboard, ahead), (5, 5), textcoords="offset points", fontsize="small")


# -- parts of maps ------------------------------------------------------------------------------------------------


def _set_up_map(axes: "Axes", across: str = "east (m)", up: str = "north (m)") -> None:
    axes.set(xlabel=across, ylabel=up, axisbelow=True)
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(visible=True, color="0.9", linewidth=0.6)


def _fill_formation(axes: "Axes", places: Series, label: str) -> None:
    """Draw the polygon of the formation; two craft make a line."""
    if len(places) > 1:
        (polygon,) = axes.fill(places[:, 1], places[:, 0], facecolor="0.5", edgecolor="0.2", alpha=0.5, zorder=3)
        polygon.set_label(label)


def _mark_ends(axes: "Axes", plan: TeamPlan) -> None:
    starts = np.array([craft.point(0.0) for craft in plan.everybody.values()])
    axes.scatter(
        starts[:, 1],
        starts[:, 0],
        s=36,
        c=[_colour(place) for place in range(len(starts))],
        edgecolors="white",
        zorder=4,
        label="start",
    )


def _mark_tracks(axes: "Axes", plan: TeamPlan, apart_m: float) -> None:
    """Put numbers and arrows on the tracks, as many as find room."""
    taken: _Taken = {}
    for place, craft in _members(plan):
        for number, track in enumerate(craft.tracks):
            north, east = track.point(0.5)
            if _find_room(taken, north / apart_m, east / apart_m):
                _put_number(axes, number, north, east, _colour(place))
    for place, craft in _members(plan):
        for track in craft.tracks:
            if _find_room(taken, *(metres / apart_m for metres in track.point(0.25))):
                _put_arrow(axes, track, _colour(place))


def _find_room(taken: _Taken, north: float, east: float) -> bool:
    """Take a place if it is 1 or more away from all others; `taken` has them by cells of 1 by 1."""
    up, across = math.floor(north), math.floor(east)
    near = (taken.get((up + i, across + j), []) for i in (-1, 0, 1) for j in (-1, 0, 1))
    if any(math.dist(other, (north, east)) < 1.0 for cell in near for other in cell):
        return False
    taken.setdefault((up, across), []).append((north, east))
    return True


def _put_number(axes: "Axes", number: int, north: float, east: float, colour: str) -> None:
    box = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": colour, "linewidth": 0.8}
    axes.text(east, north, str(number), ha="center", va="center", fontsize="small", bbox=box, zorder=5, clip_on=True)


def _put_arrow(axes: "Axes", track: Track, colour: str) -> None:
    behind, tip = track.point(0.249), track.point(0.25)
    style = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 18}
    axes.annotate("", tip[::-1], behind[::-1], arrowprops=style, zorder=4)


def _name_craft(axes: "Axes", plan: TeamPlan) -> None:
    """Enter the craft into the legend, with their numbers."""
    names = list(plan.everybody)
    for place, craft in enumerate(names[:_LEGEND_MAX]):
        label = f"{place + 1}: {craft}" + (" (stands by)" if craft in plan.standby else "")
        axes.plot([], [], color=_colour(place), linestyle=_dash(place), linewidth=1.8, label=label)
    if len(names) > _LEGEND_MAX:
        axes.plot([], [], " ", label=f"and {len(names) - _LEGEND_MAX} more")


def _path(craft: CraftPlan) -> Series:
    """Points along all tracks, shape (n, 2); on arcs one every three degrees."""
    return np.array([point for track in craft.tracks for point in _points(track)])


def _points(track: Track) -> Iterator[tuple[float, float]]:
    pieces = max(1, math.ceil(abs(track.curvature) * track.length_m / math.radians(3.0)))
    return (track.point(piece / pieces) for piece in range(pieces + 1))


def _extent(plan: TeamPlan) -> tuple[float, float]:
    """Size of all planned tracks to the north and to the east, metres, never 0."""
    points = np.concatenate([_path(craft) for craft in plan.everybody.values()])
    north, east = np.maximum(points.max(axis=0) - points.min(axis=0), 1.0).tolist()
    return north, east


# -- figures ------------------------------------------------------------------------------------------------------


def _thin(series: Series) -> Series:
    """Leave out steps that no picture could show."""
    return thin(series, _SAMPLES_MAX)


def _finish(figure: "Figure", scenario: Scenario, subtitle: str) -> None:
    """Give the figure its title, and below one legend for all panels but that of fd(k)."""
    title = shorten(scenario.title, 110, placeholder=" …")
    figure.suptitle(f"{title}\n{subtitle}" if title else subtitle, parse_math=False)
    handles, labels = [], []
    for axes in figure.axes:
        if axes.get_legend() is None:
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                handles.append(handle)
                labels.append(label)
    columns = max(1, min(len(labels), 150 // (6 + max(map(len, labels)))))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize="small")
