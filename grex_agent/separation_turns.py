"""Who gives way to whom, and how fast everybody may go: every craft in its turn, from the foremost on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grex_agent.mission import TeamPlan
from grex_agent.plan_time import PlanTime
from grex_agent.separation_ways import Array, PlannedWays, Point, fastest, keep, nearest_m

_SIGMAS = 2.0
#: Of what the plan leaves between two craft beyond the minimum, this share may be asked for.
_OF_ROOM = 0.5
#: A mean of unit vectors shorter than this is no common course.
_COMMON = 0.5


@dataclass(frozen=True, slots=True)
class Runner:
    """A craft that follows its plan, as it is taken to go on."""

    craft: str
    place: Point
    plan_s: float
    """Where it stands, as plan time."""
    sigma_m: float
    """Of its place; 0 of oneself."""
    rate: float
    """How fast it goes, as a share of the planned speed."""


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A craft that goes its way whatever others do, and the distance to be kept from it."""

    way: Array
    least_m: float

    def is_ahead(self, place: Point, course_rad: float) -> bool:
        """Whether it is ahead of a place on a course."""
        north, east = float(self.way[0, 0]) - place[0], float(self.way[0, 1]) - place[1]
        return north * math.cos(course_rad) + east * math.sin(course_rad) > 0.0


class Turns:
    """The order of a team, and the distances it keeps.

    Parameters
    ----------
    plan : TeamPlan
        Of the team, in its order.
    time : PlanTime
        The same as time.
    least_m : float
        Minimum distance.
    yielding_mps : float
        Least speed of a craft that yields.
    """

    def __init__(self, plan: TeamPlan, time: PlanTime, least_m: float, yielding_mps: float) -> None:
        self._plan = plan.craft
        self._time = time
        self._ways = PlannedWays(plan, time)
        self._order = {name: place for place, name in enumerate(plan.craft)}
        self._least_m = least_m
        self._yielding_mps = yielding_mps

    def rates(
        self, runners: Sequence[Runner], obstacles: Sequence[Obstacle], team: Sequence[tuple[str, float]]
    ) -> list[float]:
        """Say how fast craft that are near each other may go, as shares of their planned speeds.

        Parameters
        ----------
        runners : sequence of Runner
            The craft.
        obstacles : sequence of Obstacle
            Others; everybody who has one ahead gives way.
        team : sequence of (str, float)
            Craft and progress of the whole team, as far as it is known: for the common course.
        """
        rates = [runner.rate for runner in runners]
        ways = self._ways_of(runners)
        crossed = [nearest_m(ways, each.way) < each.least_m for each in obstacles]
        distances = self._distances_m(runners)
        close = nearest_m(ways[:, None], ways) < distances
        np.fill_diagonal(close, val=False)
        if not close.any() and not any(each.any() for each in crossed):
            return rates
        turns = self._in_order(runners, team)
        for turn, place in enumerate(turns):
            ahead, runner = turns[:turn], runners[place]
            course_rad = self._plan[runner.craft].course_rad(self._time.progress(runner.plan_s))
            before = [each for each in obstacles if each.is_ahead(runner.place, course_rad)]
            others = np.array([*ways[ahead], *(each.way for each in before)])
            least_m = np.array([*distances[place, ahead], *(each.least_m for each in before)])
            if len(others) and not keep(ways[place : place + 1], others, least_m)[0]:
                rates[place] = self._fastest(runner, others, least_m)
                ways[place] = self._ways_at(runner, np.array([rates[place]]))[0]
        return rates

    def obstacle(self, runner: Runner) -> Obstacle:
        """Take a craft that follows its plan to do that whatever others do."""
        return self.obstacle_on(self._ways_of([runner])[0], runner.sigma_m)

    def obstacle_on(self, way: Array, sigma_m: float) -> Obstacle:
        """Take a craft whose place has a standard deviation (metres) to go a way."""
        return Obstacle(way, self._least_m + min(_SIGMAS * sigma_m, self._least_m))

    # -- inside -------------------------------------------------------------------------------------------------

    def _ways_of(self, runners: Sequence[Runner]) -> Array:
        rows = np.array([self._order[runner.craft] for runner in runners])
        numbers = np.array([(*runner.place, runner.plan_s, runner.rate) for runner in runners])
        return self._ways.ways(rows, numbers[:, :3], numbers[:, 3], numbers[:, 4])

    def _ways_at(self, runner: Runner, rates: Array) -> Array:
        rows, places = np.full(len(rates), self._order[runner.craft]), np.tile(runner.place, (len(rates), 1))
        return self._ways.ways(rows, places, np.full(len(rates), runner.plan_s), rates)

    def _fastest(self, runner: Runner, others: Array, least_m: Array) -> float:
        least = self._yielding_mps / self._time.speed(runner.craft, runner.plan_s)
        return fastest(lambda rates: keep(self._ways_at(runner, rates), others, least_m), least, runner.rate)

    def _distances_m(self, runners: Sequence[Runner]) -> Array:
        """Least distance to be kept by any two, as sure as their places are: (n, n).

        What the plan leaves is that of the moment at which the first one stands.
        """
        rows = np.array([self._order[runner.craft] for runner in runners])
        planned = self._ways.points(rows, np.full((len(rows), 1), runners[0].plan_s))[:, 0]
        room_m = np.maximum(np.linalg.norm(planned[:, None] - planned, axis=-1) - self._least_m, 0.0)
        sigma_m = np.array([runner.sigma_m for runner in runners])
        unsure_m = _SIGMAS * np.maximum(sigma_m[:, None], sigma_m)
        distances: Array = self._least_m + np.minimum(np.minimum(unsure_m, self._least_m), _OF_ROOM * room_m)
        return distances

    def _in_order(self, runners: Sequence[Runner], team: Sequence[tuple[str, float]]) -> list[int]:
        """Who goes before whom: places in the list, the foremost first."""
        north, east = self._common_course(team)

        def rank(place: int) -> tuple[float, float, int]:
            runner = runners[place]
            along_m = runner.place[0] * north + runner.place[1] * east
            return along_m, runner.plan_s, -self._order[runner.craft]

        return sorted(range(len(runners)), key=rank, reverse=True)

    def _common_course(self, team: Sequence[tuple[str, float]]) -> tuple[float, float]:
        """North and east of the mean course of a team, craft and progress each; (0, 0) if it has none in common."""
        courses = [self._plan[craft].course_rad(progress) for craft, progress in team]
        north = sum(math.cos(course) for course in courses) / len(courses)
        east = sum(math.sin(course) for course in courses) / len(courses)
        return (north, east) if math.hypot(north, east) > _COMMON else (0.0, 0.0)
