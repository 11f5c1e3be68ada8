"""The guard that keeps craft apart: whoever would come too near to a mate ahead goes as slowly as it may.

From what is believed now, everybody is taken to go on along its own plan: oneself at the speed ordered, the mates at
their planned speeds, each as far beside its plan as it is. If two come nearer than the minimum within the time looked
ahead, the one behind yields and the other goes on. Behind is, along the mean course of the team, who is further back;
where the team has no common course, who has less progress; and of equals the later one in the team. (Progress alone
would not do: in a line astern everybody has the same, and who runs into the mate in front even has more.) That is one
order for the whole team: the foremost is never held up. And nobody is made to stop, so the gap opens by itself.

A mate's place is not known exactly: the minimum is greater by twice its standard deviation, but at most doubled. Of a
mate of whom hardly anything is known more care would only slow down everybody behind it.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

from grex_agent.closest import closest_approach
from grex_agent.mission import CraftPlan, TeamPlan, planned_places
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import MateBelief

#: How far the guard looks ahead, seconds, and in steps of how many.
_HORIZON_S = 30.0
_STEP_S = 5.0
_SIGMAS = 2.0
#: A mean of unit vectors shorter than this is no common course.
_COMMON = 0.5
#: A planned distance may be short of the minimum by such a share: arcs are looked at every few degrees.
_ROUNDING = 0.005

Point = tuple[float, float, float]


def check_separation(scenario: Scenario, plan: TeamPlan) -> None:
    """Check that the guard can work: the plan itself keeps the minimum, and whoever yields still moves.

    Raises
    ------
    ConfigError
        With what would do.
    """
    least = scenario.team.separation_min_m
    if least is None:
        return
    if scenario.team.speed_min_mps <= 0.0:
        raise ConfigError(
            "$.team.speed_min_mps", "must be above 0 with separation_min_m: a craft that yields has to keep moving"
        )
    approach = closest_approach(planned_places(plan))
    if approach is not None and approach.distance_m < least * (1.0 - _ROUNDING):
        names = [*plan.craft, *plan.standby, *scenario.bases]
        raise ConfigError(
            "$.team.separation_min_m",
            f"{names[approach.first]} and {names[approach.second]} are planned to come as near as "
            f"{approach.distance_m:.1f} m; plan them at least {least:g} m apart, or take less",
        )


def load_guard(scenario: Scenario, craft: str, plan: TeamPlan) -> "SeparationGuard | None":
    """Build the guard of a craft, if the scenario has one and it is in the formation."""
    team = scenario.team
    if team.separation_min_m is None or craft not in plan.craft:
        return None
    return SeparationGuard(
        craft,
        plan,
        least_m=team.separation_min_m,
        yielding_mps=team.speed_min_mps,
    )


class SeparationGuard:
    """Limits the own speed so that nobody comes too near to a mate ahead.

    Parameters
    ----------
    craft : str
        Whose guard it is.
    plan : TeamPlan
        Of the whole team, in its order.
    least_m : float
        Minimum distance.
    yielding_mps : float
        Speed of a craft that yields.
    """

    def __init__(self, craft: str, plan: TeamPlan, *, least_m: float, yielding_mps: float) -> None:
        self._plan = plan.craft
        self._order = {name: place for place, name in enumerate(plan.craft)}
        self._craft = craft
        self._least_m = least_m
        self._yielding_mps = yielding_mps
        self._fastest_mps = {name: max(track.speed_mps for track in each.tracks) for name, each in plan.craft.items()}

    def limit(
        self, ordered_mps: float, speed_mps: float, place: Point, progress: float, mates: Sequence[MateBelief]
    ) -> tuple[float, bool]:
        """Limit a speed.

        Parameters
        ----------
        ordered_mps : float
            What the coordination law orders.
        speed_mps : float
            How fast the craft is over ground; it goes on at the greater of the two.
        place : (float, float, float)
            Own north, east and depth, metres.
        progress : float
            Own progress: track number plus Θ.
        mates : sequence of MateBelief
            What is believed of the mates; one of whom nothing finite is believed is passed over.

        Returns
        -------
        (float, bool)
            The speed, never above what was ordered, and whether the craft yields.
        """
        if ordered_mps <= self._yielding_mps:
            return ordered_mps, False
        faster_mps = max(ordered_mps, speed_mps)
        known = [mate for mate in mates if _is_known(mate)]
        near = [mate for mate in known if self._may_meet(faster_mps, place, mate)]
        if not near:
            return ordered_mps, False
        north, east = self._common_course([(self._craft, progress), *((mate.craft, mate.progress) for mate in known)])

        def rank(craft: str, there: tuple[float, float], progress: float) -> tuple[float, float, int]:
            return there[0] * north + there[1] * east, progress, -self._order[craft]

        own = rank(self._craft, place[:2], progress)
        ahead = [mate for mate in near if rank(mate.craft, (mate.north_m, mate.east_m), mate.progress) > own]
        way = _on_its_way(self._plan[self._craft], place, progress, faster_mps)
        yields = any(self._too_near(way, mate) for mate in ahead)
        return (self._yielding_mps if yields else ordered_mps), yields

    # -- inside -------------------------------------------------------------------------------------------------

    def _distance_m(self, mate: MateBelief) -> float:
        """Least distance to keep from a mate."""
        return self._least_m + min(_SIGMAS * mate.sigma_m, self._least_m)

    def _may_meet(self, ordered_mps: float, place: Point, mate: MateBelief) -> bool:
        """Whether a mate is near enough to be met within the time looked ahead."""
        reach_m = (ordered_mps + self._fastest_mps[mate.craft]) * _HORIZON_S
        apart_m = math.hypot(mate.north_m - place[0], mate.east_m - place[1])
        return apart_m < self._distance_m(mate) + reach_m

    def _too_near(self, own: Sequence[Point], mate: MateBelief) -> bool:
        plan = self._plan[mate.craft]
        there = mate.north_m, mate.east_m, plan.track(mate.progress).depth_m
        return _nearest_m(own, _on_its_way(plan, there, mate.progress, None)) < self._distance_m(mate)

    def _common_course(self, team: Sequence[tuple[str, float]]) -> tuple[float, float]:
        """North and east of the mean course of a team, craft and progress each; (0, 0) if it has none in common."""
        courses = [self._plan[craft].course_rad(progress) for craft, progress in team]
        north = sum(math.cos(course) for course in courses) / len(courses)
        east = sum(math.sin(course) for course in courses) / len(courses)
        return (north, east) if math.hypot(north, east) > _COMMON else (0.0, 0.0)


def _is_known(mate: MateBelief) -> bool:
    return math.isfinite(mate.north_m + mate.east_m + mate.progress + mate.sigma_m)


def _nearest_m(one: Sequence[Point], other: Sequence[Point]) -> float:
    """Least distance of two craft that go straight from place to place, in step."""
    away = [(b[0] - a[0], b[1] - a[1], b[2] - a[2]) for a, b in zip(one, other, strict=True)]
    return min(_nearest_to_origin_m(start, end) for start, end in pairwise(away))


def _nearest_to_origin_m(start: Point, end: Point) -> float:
    move = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length2 = move[0] ** 2 + move[1] ** 2 + move[2] ** 2
    towards = -(start[0] * move[0] + start[1] * move[1] + start[2] * move[2])
    share = min(max(towards / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return math.hypot(start[0] + share * move[0], start[1] + share * move[1], start[2] + share * move[2])


def _on_its_way(plan: CraftPlan, place: Point, progress: float, speed_mps: float | None) -> list[Point]:
    """Where a craft is going to be, step by step, on a line beside its plan; at planned speed if none is given."""
    north, east = plan.point(progress)
    beside = place[0] - north, place[1] - east
    places = [place]
    for _ in range(round(_HORIZON_S / _STEP_S)):
        progress = _further(plan, progress, speed_mps, _STEP_S)
        north, east = plan.point(progress)
        places.append((north + beside[0], east + beside[1], place[2]))
    return places


def _further(plan: CraftPlan, progress: float, speed_mps: float | None, time_s: float) -> float:
    """Progress some time later; the last track goes on beyond its end."""
    last = len(plan.tracks) - 1
    while True:
        number = min(max(int(progress), 0), last)
        track = plan.tracks[number]
        rate = (track.speed_mps if speed_mps is None else speed_mps) / track.length_m
        needed_s = (number + 1.0 - progress) / rate
        if number == last or needed_s > time_s:
            return progress + rate * time_s
        progress, time_s = number + 1.0, time_s - needed_s
