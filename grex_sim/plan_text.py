"""The resolved plan as a text for a person: what ``grex check`` prints."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import msgspec

from grex_agent.mission import TeamPlan
from grex_agent.path import Track
from grex_link.config import Lawnmower, Scenario
from grex_link.profile import ModemProfile, load_profile
from grex_sim.layout import entry, table
from grex_sim.link_text import LinkText
from grex_sim.task_text import tasking

_LISTED = 6


def plan_text(scenario: Scenario, plan: TeamPlan) -> str:
    """Say in words and tables what a scenario comes to.

    Parameters
    ----------
    scenario : Scenario
        What was asked for.
    plan : TeamPlan
        What was planned for it.

    Returns
    -------
    str
        Several paragraphs without a newline at the end; lengths in metres, times in seconds.

    Raises
    ------
    ConfigError
        If the slots cannot work, or there is no such modem.
    """
    profile = load_profile(scenario.link.profile)
    link = LinkText(scenario, plan, profile)
    parts = [
        scenario.title,
        "\n".join(_head(scenario, plan)),
        "\n".join(_starts(plan)),
        "\n".join(_autopilots(scenario)),
        "\n".join(_tracks(plan)),
        "\n".join(tasking(scenario, plan)),
        "\n".join(link.access()),
        "\n".join(link.message()),
        "\n".join(_modem(scenario.link.profile, profile)),
    ]
    return "\n\n".join(part for part in parts if part)


# -- paragraphs ---------------------------------------------------------------------------------------------------


def _head(scenario: Scenario, plan: TeamPlan) -> Iterator[str]:
    team = scenario.team
    yield from entry("Team", f"{team.name}, {len(scenario.craft)} craft: {', '.join(scenario.craft)}")
    yield from entry("Estimator", team.estimator)
    yield from entry(
        "Controller",
        f"{team.controller}, gain K = {team.gain_mps:g} m/s per unit of Θ, "
        f"speed {team.speed_min_mps:g} … {team.speed_max_mps:g} m/s",
    )
    pace = scenario.clock.pace
    yield from entry(
        "Pace", f"{pace if isinstance(pace, str) else f'{pace:g} x real time'}, tick {scenario.clock.tick_s:g} s"
    )
    yield from entry("Duration", _duration(scenario, plan))
    yield from entry("Mission", _mission(scenario))
    yield from entry("Sea current", _current(scenario))


def _duration(scenario: Scenario, plan: TeamPlan) -> str:
    seconds = scenario.duration_s or plan.duration_s
    ticks = max(1, round(seconds / scenario.clock.tick_s))
    kind = (
        "the planned mission" if scenario.duration_s is None else f"the planned mission takes {plan.duration_s:.1f} s"
    )
    return f"{seconds:.1f} s, {ticks} ticks ({kind})"


def _mission(scenario: Scenario) -> str:
    mission = scenario.mission
    end = "goes straight on" if mission.at_end == "continue" else "holds its place"
    if not isinstance(mission, Lawnmower):
        return f"explicit tracks; at the end every craft {end}"
    return (
        f"lawnmower, {mission.legs} legs of {mission.leg_length_m:g} m, heading {mission.heading_deg:g}°, turn radius "
        f"{mission.turn_radius_m:g} m, first turn to {mission.first_turn}, reference point at "
        f"{mission.speed_mps:g} m/s; at the end every craft {end}"
    )


def _current(scenario: Scenario) -> str:
    sea = scenario.sea
    known = sea.current_ned_mps if sea.known_current_ned_mps is None else sea.known_current_ned_mps
    if known == sea.current_ned_mps:
        return _flow(known) + (", known to the craft" if any(known) else "")
    return f"{_flow(sea.current_ned_mps)}; the craft compensate for {_flow(known)}"


def _flow(current_ned_mps: tuple[float, float, float]) -> str:
    if not any(current_ned_mps):
        return "none"
    north, east, down = current_ned_mps
    towards = f", {math.hypot(north, east):.2f} m/s towards {math.degrees(math.atan2(east, north)) % 360.0:.0f}°"
    return f"north {north:g}, east {east:g}, down {down:g} m/s{towards if north or east else ''}"


def _starts(plan: TeamPlan) -> Iterator[str]:
    rows = []
    for craft, craft_plan in plan.everybody.items():
        north, east, course = craft_plan.start
        degrees = f"{math.degrees(course) % 360.0:.1f}"
        rows.append((craft, f"{north:z.1f}", f"{east:z.1f}", f"{craft_plan.start_depth_m:z.1f}", degrees))
    yield "Starts"
    yield from table(("craft", "north m", "east m", "depth m", "course °"), rows, left=1)


def _autopilots(scenario: Scenario) -> Iterator[str]:
    """Say what is different for craft on MAVLink."""
    if not scenario.mavlink_craft or scenario.datum is None:
        return
    datum = scenario.datum
    yield "Autopilots (MAVLink)"
    rows = []
    for craft, config in scenario.mavlink_craft.items():
        takes = "the adapter sets the mode and arms" if config.arm else "a person sets the mode and arms"
        rows.append((craft, config.url, "any" if config.system is None else str(config.system), takes))
    yield from table(("craft", "address", "system", "before the mission"), rows, left=4)
    yield f"North 0, east 0 is {datum.latitude_deg:.6f}°, {datum.longitude_deg:.6f}°."
    yield "The mission starts when every position is valid. From where they are then these craft go to their first"
    yield "track, by their guidance; they should be near the starts above."


def _tracks(plan: TeamPlan) -> Iterator[str]:
    rows = []
    for craft, craft_plan in plan.craft.items():
        name = craft
        for shape, numbers in _equal_tracks(craft_plan.tracks).items():
            rows.append((name, _series(numbers), str(len(numbers)), *shape))
            name = ""
    count = len(next(iter(plan.craft.values())).tracks)
    yield f"Tracks ({count} a craft, numbered from 0; equal ones on one line)"
    headings = ("craft", "number", "how many", "kind", "length m", "speed m/s", "duration s", "depth m")
    yield from table(headings, rows, left=4)


def _equal_tracks(tracks: Sequence[Track]) -> dict[tuple[str, ...], list[int]]:
    """Numbers of the tracks that read the same."""
    groups: dict[tuple[str, ...], list[int]] = {}
    for number, track in enumerate(tracks):
        shape = (
            _kind(track),
            f"{track.length_m:.1f}",
            f"{track.speed_mps:.3f}",
            f"{track.length_m / track.speed_mps:.1f}",
            f"{track.depth_m:z.1f}",
        )
        groups.setdefault(shape, []).append(number)
    return groups


def _kind(track: Track) -> str:
    if track.curvature == 0.0:
        return "line"
    side = "starboard" if track.curvature > 0.0 else "port"
    angle = math.degrees(abs(track.curvature) * track.length_m)
    return f"arc {angle:.0f}° to {side}, radius {1.0 / abs(track.curvature):.1f} m"


def _series(numbers: Sequence[int]) -> str:
    """List some numbers, short if they are many: ``0, 2 … 14`` for equal steps."""
    steps = {later - earlier for earlier, later in pairwise(numbers)}
    if len(numbers) > 3 and len(steps) == 1:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    shown = numbers if len(numbers) <= _LISTED else numbers[: _LISTED - 1]
    return ", ".join(map(str, shown)) + ("" if shown is numbers else f" … {numbers[-1]}")


def _modem(name: str, profile: ModemProfile) -> Iterator[str]:
    yield from entry("Modem", f"{name}: {profile.title}")
    for field, value in _fields(msgspec.to_builtins(profile)):
        if field not in {"title", "sources", "assumed"} and value is not None:
            note = "   assumed: not published" if {field, field.partition(".")[0]} & set(profile.assumed) else ""
            yield from entry(f"  {field:<30}", f"{_plain(value)}{note}")
    for source in profile.sources:
        yield from entry("  source", source)


# -- words and tables ---------------------------------------------------------------------------------------------


def _fields(table: dict[str, Any], within: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the fields of a table and of the tables in it, with their names."""
    for field, value in table.items():
        if field == "ranging" and not (value["two_way"] or value["one_way"]):
            yield field, "none"
        elif isinstance(value, dict):
            yield from _fields(value, f"{within}{field}.")
        else:
            yield f"{within}{field}", value


def _plain(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(_plain, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
