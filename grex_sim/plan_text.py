"""The resolved plan as a text for a person: what ``grex check`` prints."""

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import msgspec

from grex_agent.mission import TeamPlan
from grex_agent.path import Track
from grex_link.config import Lawnmower, Scenario
from grex_link.profile import ModemProfile, load_profile
from grex_link.tdma import Schedule, plan_schedule
from grex_link.units import NS
from grex_link.wire import TEAM_STATE_BYTES

_WIDTH = 110
_INDENT = 15
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
    schedule = plan_schedule(scenario.link.mac, list(scenario.craft), profile)
    parts = [
        scenario.title,
        "\n".join(_head(scenario, plan)),
        "\n".join(_starts(plan)),
        "\n".join(_tracks(plan)),
        "\n".join(_slots(schedule)),
        "\n".join(_message(scenario, schedule, profile)),
        "\n".join(_modem(scenario.link.profile, profile)),
    ]
    return "\n\n".join(part for part in parts if part)


def age_of_information_s(schedule: Schedule, craft: str, airtime_s: float, loss: float = 0.0) -> float:
    """Mean age of what the mates know of a craft: T + C/2 for one slot in a cycle and no loss.

    A state is sampled when a slot opens and known T later, until the next one arrives. With the gaps g_i between a
    craft's n openings and the probability q of loss the mean is T + Σ g_i/C·[g_i/2 + Σ_j q^j g_(i-j) / (1 - q^n)].

    Parameters
    ----------
    schedule : Schedule
        The slots.
    craft : str
        Whose state it is.
    airtime_s : float
        T, seconds.
    loss : float
        q.

    Returns
    -------
    float
        Seconds; infinite for a craft that is never heard.
    """
    opens = sorted(slot.start_ns / NS for slot in schedule.slots if slot.craft == craft)
    if not opens or loss >= 1.0:
        return math.inf
    count, cycle_s = len(opens), schedule.cycle_ns / NS
    gaps = [later - earlier for earlier, later in zip(opens, [*opens[1:], opens[0] + cycle_s], strict=True)]
    age_s = airtime_s
    for place, gap in enumerate(gaps):
        missed = sum(loss**back * gaps[place - back] for back in range(1, count + 1)) / (1.0 - loss**count)
        age_s += gap / cycle_s * (gap / 2.0 + missed)
    return age_s


# -- paragraphs ---------------------------------------------------------------------------------------------------


def _head(scenario: Scenario, plan: TeamPlan) -> Iterator[str]:
    team = scenario.team
    yield from _entry("Team", f"{team.name}, {len(scenario.craft)} craft: {', '.join(scenario.craft)}")
    yield from _entry("Estimator", team.estimator)
    yield from _entry(
        "Controller",
        f"{team.controller}, gain K = {team.gain_mps:g} m/s per unit of Θ, "
        f"speed {team.speed_min_mps:g} … {team.speed_max_mps:g} m/s",
    )
    pace = scenario.clock.pace
    yield from _entry(
        "Pace", f"{pace if isinstance(pace, str) else f'{pace:g} x real time'}, tick {scenario.clock.tick_s:g} s"
    )
    yield from _entry("Duration", _duration(scenario, plan))
    yield from _entry("Mission", _mission(scenario))
    yield from _entry("Sea current", _current(scenario))


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
    for craft, craft_plan in plan.craft.items():
        north, east, course = craft_plan.start
        degrees = f"{math.degrees(course) % 360.0:.1f}"
        rows.append((craft, f"{north:z.1f}", f"{east:z.1f}", f"{craft_plan.start_depth_m:z.1f}", degrees))
    yield "Starts"
    yield from _table(("craft", "north m", "east m", "depth m", "course °"), rows, left=1)


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
    yield from _table(headings, rows, left=4)


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


def _slots(schedule: Schedule) -> Iterator[str]:
    on_air_ns = sum(slot.length_ns for slot in schedule.slots)
    yield (
        f"TDMA schedule (cycle C = {schedule.cycle_ns / NS:g} s from mission time 0; "
        f"{on_air_ns / schedule.cycle_ns:.0%} of it in slots)"
    )
    in_order = sorted(schedule.slots, key=lambda slot: slot.start_ns)
    rows = [(slot.craft, f"{slot.start_ns / NS:g}", f"{slot.length_ns / NS:g}") for slot in in_order]
    yield from _table(("craft", "start s", "length s"), rows, left=1)


def _message(scenario: Scenario, schedule: Schedule, profile: ModemProfile) -> Iterator[str]:
    airtime_s, loss = profile.airtime_ns(TEAM_STATE_BYTES) / NS, scenario.link.loss
    yield from _entry("Message", f"{TEAM_STATE_BYTES} bytes, airtime T = {airtime_s:g} s, lost with p = {loss:g}")
    by_age: dict[str, list[str]] = {}
    for craft in scenario.craft if len(scenario.craft) > 1 else ():
        by_age.setdefault(f"{age_of_information_s(schedule, craft, airtime_s, loss):.1f}", []).append(craft)
    for age_s, team in by_age.items():
        if age_s == "inf":
            yield from _entry("Never heard", ", ".join(team))
        else:
            formula = _age_formula(schedule, team[0], loss)
            yield from _entry("Mean age", f"{age_s} s = {formula}, of what the mates know of {', '.join(team)}")


def _age_formula(schedule: Schedule, craft: str, loss: float) -> str:
    if sum(slot.craft == craft for slot in schedule.slots) > 1:
        return "T + mean time since the opening of the last slot heard"
    return f"T + C·(1/(1 - {loss:g}) - 1/2)" if loss else "T + C/2"


def _modem(name: str, profile: ModemProfile) -> Iterator[str]:
    yield from _entry("Modem", f"{name}: {profile.title}")
    for field, value in msgspec.structs.asdict(profile).items():
        if field not in {"title", "sources", "assumed"}:
            note = "   assumed: not published" if field in profile.assumed else ""
            yield f"  {field:<30} {_plain(value)}{note}"
    for source in profile.sources:
        yield from _entry("  source", source)


# -- words and tables ---------------------------------------------------------------------------------------------


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _entry(name: str, text: str) -> list[str]:
    """Lay out a name and its text, wrapped under itself."""
    start = f"{name:<{_INDENT}}"
    return textwrap.wrap(text, _WIDTH, initial_indent=start, subsequent_indent=" " * _INDENT, break_long_words=False)


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]], left: int) -> Iterator[str]:
    """Lay out a table; the first columns are set to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    for row in (headings, *rows):
        yield "  " + "  ".join(_cells(row, widths, left)).rstrip()


def _cells(row: Iterable[str], widths: Iterable[int], left: int) -> Iterator[str]:
    for place, (cell, width) in enumerate(zip(row, widths, strict=True)):
        yield cell.ljust(width) if place < left else cell.rjust(width)
