"""The guard that keeps craft apart: whoever would come too near to a mate ahead goes only as fast as it may.

From what is believed now, everybody is taken to go on along its own plan, as far beside it as it is: oneself at the
speed ordered, the mates as fast as they are believed to go (`grex_agent.separation_pace`). If two come nearer than the
minimum within the horizon T, the one behind yields and the other goes on. Behind is, along the mean course of the team,
who is further back; where the team has no common course, who has less progress; and of equals the later one in the
team. (Progress alone would not do: in a line astern everybody has the same, and who runs into the mate in front even
has more.) That is one order for the whole team: the foremost is never held up.

Who yields takes the greatest speed with which the minimum is kept within T; if it is not kept now, the greatest with
which the two come no nearer and it is kept at the end of T. For one behind the other that is a control barrier,

    v ≤ v_mate + (d - d_min)/T,

so it slows down smoothly, no more than it has to, and who follows can slow down, too. It never goes slower than
`speed_min_mps`, so nobody is made to stop and the gap opens by itself.

A mate that yields slows down unnoticed until its next message. But who is behind whom is known to all: every craft
works out what the guards of the mates near it do, from the foremost on, and takes them to be held back accordingly
since they were last heard. That is why a column can follow. In a formation that is kept no guard acts, and nothing is
changed.

A mate's place is not known exactly: the minimum is greater by twice its standard deviation, but at most doubled, and by
no more than half of what the plan leaves between the two. More care would only slow down everybody behind.

A craft on a task of its own is not where its plan says. Where it has told its place, it is taken to go straight on from
there, for a minute at most, and whoever has it ahead yields. On a task, a craft yields to whoever is ahead of it on its
own course.

Not covered: a mate that slows down by itself, until its next message comes; a mate that stands still, or comes head on
(one goes on at `speed_min_mps`); a mate on a task that has not said where it is and whither it heads, or turns after it
has; and craft that stand by or are called from there, which have no guard, though others yield to what they tell. A
speed is all that is changed: who has a place ahead of a mate in its own lane to return to, stays behind that mate.
"""

import math
from collections.abc import Collection, Sequence

import numpy as np
import numpy.typing as npt

from grex_agent.closest import closest_approach
from grex_agent.mission import TeamPlan, planned_places
from grex_agent.plan_time import PlanTime
from grex_agent.separation_pace import MatePace
from grex_agent.separation_turns import Obstacle, Runner, Turns
from grex_agent.separation_ways import HORIZON_S, Array, Point, fastest, keep, ways_straight
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import MateBelief
from grex_link.wire import TeamState

#: A planned distance may be short of the minimum by such a share: arcs are looked at every few degrees.
_ROUNDING = 0.005
#: Speeds that differ by less are the same, m/s.
_SAME_MPS = 1e-9
#: Where tracks change, so long what is ordered may be for the next one already.
_CHANGE_S = 2.0
#: What the craft makes more than it is ordered counts as its average over so many seconds.
_EXCESS_S = 10.0
#: So long a craft on a task is taken to go straight on from where it was.
_STRAIGHT_S = 60.0


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
        Least speed of a craft that yields.
    """

    def __init__(self, craft: str, plan: TeamPlan, *, least_m: float, yielding_mps: float) -> None:
        self._craft = craft
        self._plan = plan.craft
        self._time = PlanTime(plan)
        self._turns = Turns(plan, self._time, least_m, yielding_mps)
        self._least_m = least_m
        self._yielding_mps = yielding_mps
        self._fastest_mps = {name: max(track.speed_mps for track in each.tracks) for name, each in plan.craft.items()}
        self._paces: dict[str, MatePace] = {}
        self._told: dict[str, TeamState] = {}
        self._excess_mps: float | None = None
        self._limited_mps = self._seen_s = 0.0

    def hear(self, craft: str, state: TeamState) -> None:
        """Take a team state: it says where a craft on a task is."""
        if craft not in self._told or state.t_s >= self._told[craft].t_s:
            self._told[craft] = state

    def limit(
        self,
        now_s: float,
        ordered_mps: float,
        speed_mps: float,
        place: Point,
        progress: float,
        mates: Sequence[MateBelief],
        on_task: Collection[str] = (),
    ) -> tuple[float, bool]:
        """Limit the speed of a craft that follows its plan.

        Parameters
        ----------
        now_s : float
            Mission time, seconds.
        ordered_mps : float
            What the coordination law orders.
        speed_mps : float
            How fast the craft is over ground. What it makes more than it was ordered, on an average, it goes on to.
        place : (float, float, float)
            Own north, east and depth, metres.
        progress : float
            Own progress: track number plus Θ.
        mates : sequence of MateBelief
            What is believed of the mates; one of whom nothing finite is believed is passed over.
        on_task : collection of str
            Craft on a task of their own.

        Returns
        -------
        (float, bool)
            The speed, never above what was ordered, and whether the craft yields.
        """
        excess_mps = self._excess(now_s, ordered_mps, speed_mps)
        makes_mps = ordered_mps + excess_mps
        known = [mate for mate in mates if _is_known(mate) and mate.craft not in on_task]
        runners = self._near(now_s, makes_mps, place, known)
        obstacles = self._on_task(now_s, on_task)
        limited_mps = ordered_mps
        if runners or obstacles:
            plan_s = self._time.at(progress)
            planned_mps = max(self._time.speed(self._craft, at_s) for at_s in (plan_s, plan_s + _CHANGE_S))
            own = Runner(self._craft, place, plan_s, 0.0, makes_mps / planned_mps)
            team = [(self._craft, progress), *((mate.craft, mate.progress) for mate in known)]
            own_rate, *rates = self._turns.rates([own, *runners], obstacles, team)
            for runner, rate in zip(runners, rates, strict=True):
                self._paces[runner.craft].held(rate)
            if own_rate < own.rate:
                limited_mps = max(own_rate * planned_mps - excess_mps, self._yielding_mps)
        yields = limited_mps < ordered_mps - _SAME_MPS
        self._limited_mps = limited_mps if yields else ordered_mps
        return self._limited_mps, yields

    def limit_on_task(
        self,
        now_s: float,
        ordered_mps: float,
        course_rad: float,
        place: Point,
        mates: Sequence[MateBelief],
        on_task: Collection[str] = (),
    ) -> tuple[float, bool]:
        """Limit the speed of the craft when it is on a task of its own: it is taken to go straight on; see `limit`.

        Parameters
        ----------
        now_s, ordered_mps, course_rad : float
            Mission time, and what the task orders.
        place, mates, on_task
            As in `limit`.
        """
        self._excess_mps = None
        known = [mate for mate in mates if _is_known(mate) and mate.craft not in on_task]
        runners = self._near(now_s, ordered_mps, place, known)
        obstacles = [*self._on_task(now_s, on_task), *map(self._turns.obstacle, runners)]
        ahead = [each for each in obstacles if each.is_ahead(place, course_rad)]
        if not ahead:
            return ordered_mps, False
        ways, least_m = np.array([each.way for each in ahead]), np.array([each.least_m for each in ahead])

        def are_kept(speeds_mps: Array) -> npt.NDArray[np.bool_]:
            return keep(ways_straight(place, course_rad, speeds_mps), ways, least_m)

        limited_mps = fastest(are_kept, self._yielding_mps, ordered_mps)
        return limited_mps, limited_mps < ordered_mps

    # -- inside -------------------------------------------------------------------------------------------------

    def _excess(self, now_s: float, ordered_mps: float, speed_mps: float) -> float:
        """Average what the craft makes more than it is ordered, m/s."""
        if self._excess_mps is None:
            self._excess_mps = max(speed_mps - ordered_mps, 0.0)
        else:
            share = min(max(now_s - self._seen_s, 0.0) / _EXCESS_S, 1.0)
            excess_mps = speed_mps - self._limited_mps
            self._excess_mps = max(self._excess_mps + share * (excess_mps - self._excess_mps), 0.0)
        self._seen_s = now_s
        return self._excess_mps

    def _near(self, now_s: float, speed_mps: float, place: Point, mates: Sequence[MateBelief]) -> list[Runner]:
        """Find the mates that may be met within the time looked ahead, and see how they get on."""
        near = [mate for mate in mates if self._may_meet(speed_mps, place, mate)]
        # Who comes near again begins anew.
        self._paces = {mate.craft: self._paces.get(mate.craft) or MatePace(self._time) for mate in near}
        for mate in near:
            self._paces[mate.craft].see(now_s, mate)
        return [self._runner(mate) for mate in near]

    def _runner(self, mate: MateBelief) -> Runner:
        """Take a mate to be as far behind what is believed as it has been slower since it was heard."""
        pace, plan = self._paces[mate.craft], self._plan[mate.craft]
        north, east, plan_s = mate.north_m, mate.east_m, self._time.at(mate.progress)
        lag_s = pace.lag_s
        if lag_s > 0.0:
            plan_s -= lag_s
            believed, taken = plan.point(mate.progress), plan.point(self._time.progress(plan_s))
            north, east = north + taken[0] - believed[0], east + taken[1] - believed[1]
        return Runner(mate.craft, (north, east, plan.depth(mate.progress)), plan_s, mate.sigma_m, pace.rate)

    def _on_task(self, now_s: float, on_task: Collection[str]) -> list[Obstacle]:
        """Craft on a task, going straight on from where they have told that they were."""
        obstacles = []
        for craft in sorted(on_task):
            told = self._told.get(craft)
            # The shorter forms tell no heading.
            if told is None or told.form != "full" or not 0.0 <= now_s - told.t_s <= _STRAIGHT_S:
                continue
            gone_m = told.speed_mps * (now_s - told.t_s)
            north = told.north_m + gone_m * math.cos(told.heading_rad)
            east = told.east_m + gone_m * math.sin(told.heading_rad)
            way = ways_straight((north, east, told.depth_m), told.heading_rad, np.array([told.speed_mps]))[0]
            obstacles.append(self._turns.obstacle_on(way, told.sigma_m))
        return obstacles

    def _may_meet(self, speed_mps: float, place: Point, mate: MateBelief) -> bool:
        """Whether a mate is near enough to be met within the time looked ahead."""
        reach_m = (speed_mps + self._fastest_mps[mate.craft]) * HORIZON_S
        return math.hypot(mate.north_m - place[0], mate.east_m - place[1]) < 2.0 * self._least_m + reach_m


def _is_known(mate: MateBelief) -> bool:
    return math.isfinite(mate.north_m + mate.east_m + mate.progress + mate.sigma_m)
