"""Who gives way to whom, and how fast everybody may go: every craft in its turn, from the foremost on."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from grex_agent.mission import TeamPlan
from grex_agent.plan_time import PlanTime
from grex_agent.separation_ways import Point, Way, keeps, nearest_m, way_on_plan

_SIGMAS = 2.0
#: Of what the plan leaves between two craft beyond the minimum, this share may be asked for.
_OF_ROOM = 0.5
#: A mean of unit vectors shorter than this is no common course.
_COMMON = 0.5
#: So often the range of speeds is halved: to a hundredth of it.
_HALVINGS = 7


@dataclass(slots=True)
class Runner:
    """A craft that follows its plan, as it is taken to go on."""

    craft: str
    place: Point
    """North, east and depth, metres."""
    plan_s: float
    """Where it stands, as plan time."""
    sigma_m: float
    """Of its place; 0 of oneself."""
    rate: float
    """How fast it goes, as a share of the planned speed."""
    way: Way = field(default=())


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A craft that goes its way whatever others do, and the distance to be kept from it."""

    way: Way
    least_m: float

    def is_ahead(self, place: Point, course_rad: float) -> bool:
        """Whether it is ahead of a place on a course."""
        north, east = self.way[0][0] - place[0], self.way[0][1] - place[1]
        return north * math.cos(course_rad) + east * math.sin(course_rad) > 0.0


def fastest(is_kept: Callable[[float], bool], least: float, most: float) -> float:
    """Find the greatest speed between two with which a distance is kept: the least one if it is kept with none."""
    if most <= least or is_kept(most):
        return most
    if not is_kept(least):
        return least
    kept, broken = least, most
    for _ in range(_HALVINGS):
        middle = 0.5 * (kept + broken)
        kept, broken = (middle, broken) if is_kept(middle) else (kept, middle)
    return kept


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
        self._order = {name: place for place, name in enumerate(plan.craft)}
        self._least_m = least_m
        self._yielding_mps = yielding_mps

    def rates(
        self, runners: Sequence[Runner], obstacles: Sequence[Obstacle], team: Sequence[tuple[str, float]]
    ) -> dict[str, float]:
        """Say how fast craft that are near each other may go, as shares of their planned speeds.

        Parameters
        ----------
        runners : sequence of Runner
            The craft; their ways are worked out here.
        obstacles : sequence of Obstacle
            Others; everybody who has one ahead gives way.
        team : sequence of (str, float)
            Craft and progress of the whole team, as far as it is known: for the common course.
        """
        north, east = self._common_course(team)

        def rank(runner: Runner) -> tuple[float, float, int]:
            along_m = runner.place[0] * north + runner.place[1] * east
            return along_m, self._time.progress(runner.plan_s), -self._order[runner.craft]

        inorder = sorted(runners, key=rank, reverse=True)
        for runner in inorder:
            runner.way = self._way(runner, runner.rate)
        if self._meet(inorder, obstacles):
            for turn, runner in enumerate(inorder):
                self._give_way(runner, inorder[:turn], obstacles)
        return {runner.craft: runner.rate for runner in inorder}

    def obstacle(self, runner: Runner) -> Obstacle:
        """Take a craft that follows its plan to do that whatever others do."""
        return self.obstacle_on(self._way(runner, runner.rate), runner.sigma_m)

    def obstacle_on(self, way: Way, sigma_m: float) -> Obstacle:
        """Take a craft whose place has a standard deviation (metres) to go a way."""
        return Obstacle(way, self._least_m + min(_SIGMAS * sigma_m, self._least_m))

    # -- inside -------------------------------------------------------------------------------------------------

    def _way(self, runner: Runner, rate: float) -> Way:
        return way_on_plan(self._plan[runner.craft], self._time, runner.place, runner.plan_s, rate)

    def _meet(self, inorder: Sequence[Runner], obstacles: Sequence[Obstacle]) -> bool:
        """Whether anybody comes too near to anybody, if all go on as fast as they do."""
        ways = [*(runner.way for runner in inorder), *(obstacle.way for obstacle in obstacles)]
        for turn, (runner, distances) in enumerate(zip(inorder, nearest_m(ways), strict=False)):
            for ahead, distance_m in zip(inorder[:turn], distances, strict=False):
                if distance_m < 2.0 * self._least_m and distance_m < self._distance_m(runner, ahead):
                    return True
            for obstacle, distance_m in zip(obstacles, distances[len(inorder) :], strict=True):
                if distance_m < obstacle.least_m:
                    return True
        return False

    def _give_way(self, runner: Runner, ahead: Sequence[Runner], obstacles: Sequence[Obstacle]) -> None:
        """Slow a craft down as far as it has to, for those whose turn was before it."""
        plan, plan_s = self._plan[runner.craft], runner.plan_s
        course_rad = plan.course_rad(self._time.progress(plan_s))
        watched = [(mate.way, self._distance_m(runner, mate)) for mate in ahead]
        watched += [(each.way, each.least_m) for each in obstacles if each.is_ahead(runner.place, course_rad)]

        def is_kept(rate: float) -> bool:
            way = self._way(runner, rate)
            return all(keeps(way, other, least_m) for other, least_m in watched)

        rate = fastest(is_kept, self._yielding_mps / self._time.speed(runner.craft, plan_s), runner.rate)
        if rate < runner.rate:
            runner.rate, runner.way = rate, self._way(runner, rate)

    def _distance_m(self, one: Runner, other: Runner) -> float:
        """Least distance to be kept by two craft, as sure as their places are."""
        progress = self._time.progress(one.plan_s)
        places = [(*plan.point(progress), plan.depth(progress)) for plan in (self._plan[one.craft], self._plan[other.craft])]
        room_m = max(math.dist(*places) - self._least_m, 0.0)
        return self._least_m + min(_SIGMAS * max(one.sigma_m, other.sigma_m), self._least_m, _OF_ROOM * room_m)

    def _common_course(self, team: Sequence[tuple[str, float]]) -> tuple[float, float]:
        """North and east of the mean course of a team, craft and progress each; (0, 0) if it has none in common."""
        courses = [self._plan[craft].course_rad(progress) for craft, progress in team]
        north = sum(math.cos(course) for course in courses) / len(courses)
        east = sum(math.sin(course) for course in courses) / len(courses)
        return (north, east) if math.hypot(north, east) > _COMMON else (0.0, 0.0)
