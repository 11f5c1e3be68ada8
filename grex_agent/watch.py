"""One craft as a base sees it, that stays where it is: from what the craft tells, and from ranges (the paper's ref. 5).

State x = [north, east, v_north, v_east, b_north, b_east]: position (m), velocity over ground (m/s) and the error of the
positions that the craft tells (m). Between measurements the velocity turns as the plan does, and follows where the
planned speed changes with the track, as fast as a craft can; with white noise besides. b is a Gauss-Markov process,
because the error of a navigation stays for a while: that a hundred messages say the same does not make it true. A
message measures position plus b, and the velocity; a range measures the position alone. The filter stands at the time
of the newest measurement and is carried on from there for every belief, so that nothing has to be done twice: what one
craft says comes in the order of its time. What does not is left out.

A craft that says it is on a task of its own is not on its plan, and neither is one that comes back from there and heads
elsewhere yet. It is carried on along the heading it tells, with the noise of one that turns when it likes; on a task
its progress stands still.
"""

import math

import numpy as np

from grex_agent.gaussian import Gaussian, Matrix, propagate, update, update_along
from grex_agent.mission import CraftPlan
from grex_agent.path import wrap
from grex_agent.range_gate import Gate
from grex_agent.range_update import Range, surprise, with_free_offset, work_in
from grex_agent.team.path_length import PathLength
from grex_link.config import SpeedModelConfig
from grex_link.messages import MateBelief, PlaceBelief
from grex_link.ranging_config import BaseConfig, RangingConfig
from grex_link.wire import NAVIGATION_VALID, ON_TASK, TeamState

_NORTH, _EAST, _V_NORTH, _V_EAST, _OFF_NORTH, _OFF_EAST = range(6)
#: Noise of a velocity told: that of a moment, as steps of speed and heading.
_TOLD_SIGMA_MPS = 0.05
_STEP_S = 1.0
#: What the velocity of a craft off its plan changes by over a second, as a share of the planned speed: it may turn.
_ASTRAY = 0.2
#: Who heads so far from the course of its plan is not on it, rad; a crab angle is less.
_ELSEWHERE_RAD = 0.5


class Watch:
    """Estimates one craft from a fixed place.

    Parameters
    ----------
    base : BaseConfig
        Where the base is, and how the craft moves and errs.
    ranging : RangingConfig
        Noise and gate of ranges.
    speed : SpeedModelConfig
        How fast the craft changes its speed.
    plan : CraftPlan
        Of the craft watched.
    """

    def __init__(self, base: BaseConfig, ranging: RangingConfig, speed: SpeedModelConfig, plan: CraftPlan) -> None:
        self._base = base
        self._ranging = ranging
        self._speed = speed
        self._path = PathLength(plan)
        self._x: Gaussian | None = None
        self._time_s = 0.0
        #: Change of speed that the plan has ordered and the craft has not made yet, m/s.
        self._pending_mps = 0.0
        self._told: TeamState | None = None
        self._astray = False
        self._gate = Gate(ranging.gate)

    def hear(self, state: TeamState) -> None:
        """Work in what the craft tells of itself."""
        if not state.flags & NAVIGATION_VALID:
            return
        velocity = state.speed_mps * math.cos(state.heading_rad), state.speed_mps * math.sin(state.heading_rad)
        if self._x is not None and state.t_s < self._time_s:
            return
        astray = self._is_astray(state)
        if self._x is None:
            self._told, self._astray = state, astray
            self._begin(state, velocity)
            return
        x, pending = self._at(self._x, state.t_s)
        # Off the plan a craft has a speed of its own.
        self._pending_mps = 0.0 if self._astray or astray else pending + self._track_change(state, x)
        self._told, self._astray = state, astray
        for axis, off, told in ((_NORTH, _OFF_NORTH, state.north_m), (_EAST, _OFF_EAST, state.east_m)):
            row = np.zeros(6)
            row[axis] = row[off] = 1.0
            x = update_along(x, row, told - x.mean[axis] - x.mean[off], state.sigma_m**2)
        for axis, speed in zip((_V_NORTH, _V_EAST), velocity, strict=True):
            x = update(x, axis, speed - x.mean[axis], _TOLD_SIGMA_MPS**2)
        self._x, self._time_s = x, state.t_s

    def hear_range(self, heard: Range) -> bool:
        """Work in a range to the craft; False if it is an outlier."""
        if self._x is None or self._told is None or heard.there_s < self._time_s:
            return True
        x, pending = self._at(self._x, heard.there_s)
        north, east, down = self._base.place_ned_m
        here = heard._replace(north_m=north, east_m=east, down_m=down, sigma_m=0.0)
        seen = surprise(x, here, self._told.depth_m, self._ranging.sigma_m)
        verdict = self._gate.judge(heard.craft, heard.there_s, seen.sigmas)
        if verdict == "outlier":
            return False
        if verdict == "wrong":
            x = with_free_offset(x, _OFF_NORTH, seen.innovation_m**2)
            seen = surprise(x, here, self._told.depth_m, self._ranging.sigma_m)
        self._x, self._time_s, self._pending_mps = work_in(x, seen), heard.there_s, pending
        return verdict == "good"

    def belief(self, craft: str, now_s: float) -> tuple[MateBelief, PlaceBelief] | None:
        """Say where the craft is now, with its progress and with the covariance; None before its first message."""
        if self._x is None or self._told is None:
            return None
        x, _ = self._at(self._x, now_s)
        north, east, p = x.mean[_NORTH], x.mean[_EAST], x.covariance
        variance_north, variance_east = float(p[_NORTH, _NORTH]), float(p[_EAST, _EAST])
        sigma_m = math.sqrt(max(variance_north, variance_east))
        progress = self._path.progress(self._distance_m(now_s))
        return (
            MateBelief(craft, north, east, progress, sigma_m, now_s - self._told.t_s),
            PlaceBelief(craft, north, east, (variance_north, variance_east, float(p[_NORTH, _EAST]))),
        )

    # -- inside -------------------------------------------------------------------------------------------------

    def _begin(self, state: TeamState, velocity: tuple[float, float]) -> None:
        variance, speed = state.sigma_m**2, _TOLD_SIGMA_MPS**2
        covariance = np.diag((2.0 * variance, 2.0 * variance, speed, speed, variance, variance))
        for axis, off in ((_NORTH, _OFF_NORTH), (_EAST, _OFF_EAST)):
            covariance[axis, off] = covariance[off, axis] = -variance
        self._x = Gaussian((state.north_m, state.east_m, *velocity, 0.0, 0.0), covariance)
        self._time_s = state.t_s

    def _is_astray(self, state: TeamState) -> bool:
        """Whether the craft is not on its plan: it says so, or heads elsewhere."""
        track = self._path.tracks[min(state.track, len(self._path.tracks) - 1)]
        course = track.locate(*track.point(state.theta)).course_rad
        return bool(state.flags & ON_TASK) or abs(wrap(state.heading_rad - course)) > _ELSEWHERE_RAD

    def _distance_m(self, t_s: float) -> float:
        """How far along its plan the craft has come, from what it has told; a new track has another speed."""
        if self._told is None:
            return 0.0
        distance_m, _ = self._path.told(self._told)
        if self._told.flags & ON_TASK:
            return distance_m
        left_s, planned = max(t_s - self._told.t_s, 0.0), self._planned_mps(distance_m)
        ahead_m = distance_m + self._told.speed_mps * left_s
        change = self._planned_mps(ahead_m) - planned
        if change and self._told.speed_mps > 0.0:
            start_m = self._path.starts[self._path.number(ahead_m)]
            ahead_m += change * max(left_s - (start_m - distance_m) / self._told.speed_mps, 0.0)
        return ahead_m

    def _planned_mps(self, distance_m: float) -> float:
        return self._path.tracks[self._path.number(distance_m)].speed_mps

    def _track_change(self, state: TeamState, x: Gaussian) -> float:
        """Pending change of speed that a message adds: of a track that is newer, or older, than was thought."""
        told_m, _ = self._path.told(state)
        thought_m = self._distance_m(state.t_s)
        if self._path.number(told_m) == self._path.number(thought_m):
            return 0.0
        change = self._planned_mps(told_m) - self._planned_mps(thought_m)
        return change - (state.speed_mps - math.hypot(x.mean[_V_NORTH], x.mean[_V_EAST]))

    def _at(self, x: Gaussian, t_s: float) -> tuple[Gaussian, float]:
        """Carry a state on from the time of the newest measurement; and what is pending then."""
        then_s, pending = self._time_s, self._pending_mps
        thought_mps = self._planned_mps(self._distance_m(then_s))
        while t_s > then_s:
            dt = min(t_s - then_s, _STEP_S)
            then_s += dt
            track = self._path.tracks[self._path.number(self._distance_m(then_s))]
            pending += 0.0 if self._astray else track.speed_mps - thought_mps
            thought_mps = track.speed_mps
            most = self._speed.acceleration_max_mps2 * dt
            share = 1.0 - math.exp(-dt / self._speed.lag_s) if self._speed.lag_s else 1.0
            faster = min(max(share * pending, -most), most)
            pending -= faster
            x = self._predict(x, 0.0 if self._astray else track.curvature, faster, dt)
        return x, pending

    def _predict(self, x: Gaussian, curvature: float, faster: float, dt: float) -> Gaussian:
        v_north, v_east = x.mean[_V_NORTH], x.mean[_V_EAST]
        speed = math.hypot(v_north, v_east)
        turn = curvature * speed * dt
        stretch = 1.0 + faster / speed if speed > abs(faster) else 1.0
        cos, sin = stretch * math.cos(turn), stretch * math.sin(turn)
        keep = math.exp(-dt / self._base.told_time_s)
        jacobian: Matrix = np.diag((1.0, 1.0, cos, cos, keep, keep))
        jacobian[_V_NORTH, _V_EAST], jacobian[_V_EAST, _V_NORTH] = -sin, sin
        jacobian[_NORTH, [_V_NORTH, _V_EAST]] = 0.5 * dt * np.array((1.0 + cos, -sin))
        jacobian[_EAST, [_V_NORTH, _V_EAST]] = 0.5 * dt * np.array((sin, 1.0 + cos))
        after = tuple((jacobian @ np.array(x.mean)).tolist())
        told = 0.0 if self._told is None else self._told.sigma_m**2
        # When and how fast a craft changes its speed is known roughly only.
        pushed = self._base.acceleration_noise_mps**2 + faster**2 / dt
        pushed += (_ASTRAY * self._planned_mps(self._distance_m(self._time_s))) ** 2 if self._astray else 0.0
        drifted = told * (1.0 - keep * keep)
        noise = np.diag((pushed * dt**3 / 3.0, pushed * dt**3 / 3.0, pushed * dt, pushed * dt, drifted, drifted))
        noise[_NORTH, _V_NORTH] = noise[_V_NORTH, _NORTH] = pushed * dt**2 / 2.0
        noise[_EAST, _V_EAST] = noise[_V_EAST, _EAST] = pushed * dt**2 / 2.0
        return propagate(after, x.covariance, jacobian, noise)
