"""Navigation filter of the own state: position, speed, actuator error and current from noisy fixes.

State x = [north, east, v, β, c_north, c_east]: position (m), speed through the water (m/s), speed error as a share of
the speed ordered, current (m/s). Driven by the speed ordered through the water and the measured heading; the surge loop
is that of `SpeedModel`. A steady current and a speed error look alike on one course, and part at the first turn.

Of an inertial navigation the fixes have an error that stays and drifts. Then the state goes on with b_north, b_east (m)
and their rates (m/s), which walk at random; a fix measures position plus b, and only ranges to others tell them apart.
A range belongs to a moment that has passed when it comes: the filter goes back to the step of that moment, works it in
there, and does the steps since then anew, as the mates' filters do with late messages (GREX 2008, eq. 11).
"""

import math
from collections import deque
from itertools import islice

import msgspec
import numpy as np

from grex_agent.gaussian import Gaussian, Matrix, propagate, update, update_along
from grex_agent.path import wrap
from grex_agent.range_gate import Gate
from grex_agent.range_update import Range, Surprise, surprise, with_free_offset, work_in
from grex_agent.team.speed_model import SpeedModel
from grex_link.config import OwnFilterConfig, SpeedModelConfig
from grex_link.messages import Fix
from grex_link.ranging_config import InertialConfig, RangingConfig

_NORTH, _EAST, _SPEED, _ERROR, _CURRENT_NORTH, _CURRENT_EAST = range(6)
_OFF_NORTH, _OFF_EAST, _DRIFT_NORTH, _DRIFT_EAST = range(6, 10)
_ABSOLUTE_STATES, _INERTIAL_STATES = 6, 10
_NO_RANGES = RangingConfig()


class _Step(msgspec.Struct):
    """One step, as it can be done again."""

    t_s: float
    dt: float
    ordered_mps: float
    heading_rad: float
    """Mean of the step."""
    fix: Fix | None
    down_m: float
    before: Gaussian
    after: Gaussian
    ranges: list[tuple[Range, bool]]
    """Of times from this step to the next, in their order; and whether the offset was set free for it."""


class OwnFilter:
    """Filters the fixes of one craft.

    Parameters
    ----------
    config : OwnFilterConfig
        Noises.
    speed : SpeedModelConfig
        The surge loop, and how its error changes.
    known_current : tuple of float
        Current that the craft compensates, north and east, m/s: where the estimate begins.
    inertial : InertialConfig or None
        How the fixes drift; None if they do not.
    ranging : RangingConfig
        Noise of ranges, and how late they may come.
    """

    def __init__(
        self,
        config: OwnFilterConfig,
        speed: SpeedModelConfig,
        known_current: tuple[float, float],
        inertial: InertialConfig | None = None,
        ranging: RangingConfig = _NO_RANGES,
    ) -> None:
        self._config = config
        self._speed = SpeedModel(speed)
        self._known_current = known_current
        self._inertial = inertial
        self._ranging = ranging
        self._memory_s = ranging.memory_s if ranging.mode != "off" else 0.0
        self._x: Gaussian | None = None
        self._time_s = self._heading_rad = 0.0
        self._history: deque[_Step] = deque()
        self._gate = Gate(ranging.gate)

    @property
    def state(self) -> tuple[float, ...] | None:
        """North, east, speed, speed error, current north and east; None before the first fix."""
        return None if self._x is None else self._x.mean

    @property
    def covariance(self) -> Matrix | None:
        """Of `state`; None before the first fix."""
        return None if self._x is None else self._x.covariance

    @property
    def sigma_m(self) -> float:
        """Standard deviation of each coordinate of the position, metres; the greater one."""
        if self._x is None:
            return math.inf
        return math.sqrt(max(self._x.covariance[_NORTH, _NORTH], self._x.covariance[_EAST, _EAST]))

    @property
    def current(self) -> tuple[float, float]:
        """Current north and east, m/s."""
        return self._known_current if self._x is None else (self._x.mean[_CURRENT_NORTH], self._x.mean[_CURRENT_EAST])

    def step(self, now_s: float, fix: Fix | None, ordered_mps: float) -> None:
        """Advance to a time, and work in a fix of that time.

        Parameters
        ----------
        now_s : float
            Mission time, seconds; a time that is not later than the last one advances nothing.
        fix : Fix or None
            A new fix, or none: then the heading is taken to be the last one.
        ordered_mps : float
            Speed through the water that has been ordered since the last step, m/s.
        """
        if self._x is None:
            if fix is not None:
                self._begin(now_s, fix)
            return
        heading = self._heading_rad if fix is None else fix.heading_rad
        dt = max(now_s - self._time_s, 0.0)
        middle = self._heading_rad + wrap(heading - self._heading_rad) / 2.0
        self._time_s, self._heading_rad = max(now_s, self._time_s), heading
        down = self._history[-1].down_m if fix is None and self._history else 0.0 if fix is None else fix.down_m
        step = _Step(self._time_s, dt, ordered_mps, middle, fix, down, self._x, self._x, [])
        self._x = step.after = self._done(step, self._x)
        self._remember(step)

    def hear_range(self, heard: Range) -> bool:
        """Work in a range at its time; False if it is an outlier, or too old.

        Outliers are left out. When all mates disagree it is the own position that is wrong (`Gate`): then the offset of
        the navigation is set free by as much.
        """
        place = next((i for i, step in enumerate(reversed(self._history)) if step.t_s <= heard.t_s), None)
        if place is None:
            return False
        index = len(self._history) - 1 - place
        step = self._history[index]
        seen = self._surprise(step, step.after, heard)
        verdict = self._gate.judge(heard.craft, heard.t_s, seen.sigmas)
        if verdict == "outlier":
            return False
        step.ranges.append((heard, verdict == "wrong"))
        step.ranges.sort()
        self._do_again(index)
        return verdict == "good"

    # -- inside -------------------------------------------------------------------------------------------------

    def _remember(self, step: _Step) -> None:
        if self._memory_s:
            self._history.append(step)
            while self._time_s - self._history[0].t_s > self._memory_s:
                self._history.popleft()

    def _do_again(self, index: int) -> None:
        """Do the steps from one on again."""
        x = self._history[index].before
        for step in islice(self._history, index, None):
            step.before = x
            step.after = x = self._done(step, x)
        self._x = x

    def _done(self, step: _Step, x: Gaussian) -> Gaussian:
        """Do one step after a state."""
        if step.dt > 0.0:
            x = self._predict(x, step.ordered_mps, step.heading_rad, step.dt)
        if step.fix is not None:
            x = self._correct(x, step.fix)
        return self._with_ranges(step, x, step.ranges)

    def _with_ranges(self, step: _Step, x: Gaussian, ranges: list[tuple[Range, bool]]) -> Gaussian:
        for heard, freed in ranges:
            seen = self._surprise(step, x, heard)
            if freed:
                x = with_free_offset(x, _OFF_NORTH, seen.innovation_m**2)
                seen = self._surprise(step, x, heard)
            x = work_in(x, seen)
        return x

    def _surprise(self, step: _Step, x: Gaussian, heard: Range) -> Surprise:
        """Compare a range with the position at its time, which may be a part of a step later."""
        later = heard.t_s - step.t_s
        north = x.mean[_SPEED] * math.cos(step.heading_rad) + x.mean[_CURRENT_NORTH]
        east = x.mean[_SPEED] * math.sin(step.heading_rad) + x.mean[_CURRENT_EAST]
        return surprise(x, heard, step.down_m, self._ranging.sigma_m, (later * north, later * east))

    def _begin(self, now_s: float, fix: Fix) -> None:
        place, current = self._fix_variance(fix), self._config.current_sigma_mps**2
        speed = self._speed.config
        # The surge at the beginning is what the craft says, give or take the error of its order.
        speed_variance = (speed.error_relative * max(abs(fix.speed_mps), 1.0)) ** 2
        variances = [place, place, speed_variance, speed.error_relative**2, current, current]
        mean = [fix.north_m, fix.east_m, fix.speed_mps, 0.0, *self._known_current]
        covariance = np.diag(variances)
        if self._inertial is not None:
            offset, drift = self._inertial.offset_sigma_m**2, self._inertial.drift_sigma_mps**2
            covariance = np.diag([*variances, offset, offset, drift, drift])
            mean += [0.0] * (_INERTIAL_STATES - _ABSOLUTE_STATES)
            for axis, off in ((_NORTH, _OFF_NORTH), (_EAST, _OFF_EAST)):
                covariance[axis, axis] += offset
                covariance[axis, off] = covariance[off, axis] = -offset
        self._x = Gaussian(tuple(mean), covariance)
        self._time_s, self._heading_rad = now_s, fix.heading_rad
        self._remember(_Step(now_s, 0.0, 0.0, fix.heading_rad, None, fix.down_m, self._x, self._x, []))

    def _predict(self, x: Gaussian, ordered: float, heading: float, dt: float) -> Gaussian:
        north, east, speed, error, current_north, current_east = x.mean[:_ABSOLUTE_STATES]
        after, (by_speed, _, by_error) = self._speed.step(speed, ordered, error, dt)
        keep, error_noise = self._speed.fading(dt)
        cos, sin = math.cos(heading), math.sin(heading)
        half = dt / 2.0
        jacobian = np.eye(len(x.mean))
        for row, part in ((_NORTH, cos), (_EAST, sin)):
            jacobian[row, _SPEED] = half * (1.0 + by_speed) * part
            jacobian[row, _ERROR] = half * by_error * part
        jacobian[_NORTH, _CURRENT_NORTH] = jacobian[_EAST, _CURRENT_EAST] = dt
        jacobian[_SPEED, _SPEED], jacobian[_SPEED, _ERROR] = by_speed, by_error
        jacobian[_ERROR, _ERROR] = keep
        place, drift = self._config.place_noise_m**2 * dt, self._config.current_noise_mps**2 * dt
        noise = [place, place, self._speed.config.noise_mps**2 * dt, error_noise, drift, drift]
        mean: tuple[float, ...] = (
            north + half * (speed + after) * cos + dt * current_north,
            east + half * (speed + after) * sin + dt * current_east,
            after,
            keep * error,
            current_north,
            current_east,
        )
        if self._inertial is not None:
            off_north, off_east, drift_north, drift_east = x.mean[_ABSOLUTE_STATES:]
            mean += (off_north + dt * drift_north, off_east + dt * drift_east, drift_north, drift_east)
            jacobian[_OFF_NORTH, _DRIFT_NORTH] = jacobian[_OFF_EAST, _DRIFT_EAST] = dt
            walk = self._inertial.drift_noise_mps**2 * dt
            noise += [0.0, 0.0, walk, walk]
        return propagate(mean, x.covariance, jacobian, np.diag(noise))

    def _correct(self, x: Gaussian, fix: Fix) -> Gaussian:
        variance = self._fix_variance(fix)
        if self._inertial is None:
            x = update(x, _NORTH, fix.north_m - x.mean[_NORTH], variance)
            x = update(x, _EAST, fix.east_m - x.mean[_EAST], variance)
        else:
            for axis, off, seen in ((_NORTH, _OFF_NORTH, fix.north_m), (_EAST, _OFF_EAST, fix.east_m)):
                row = np.zeros(_INERTIAL_STATES)
                row[axis] = row[off] = 1.0
                x = update_along(x, row, seen - x.mean[axis] - x.mean[off], variance)
        if self._config.speed_sigma_mps is not None:
            x = update(x, _SPEED, fix.speed_mps - x.mean[_SPEED], self._config.speed_sigma_mps**2)
        return x

    def _fix_variance(self, fix: Fix) -> float:
        if self._inertial is not None:
            return self._inertial.noise_m**2  # what the fix claims besides is the drift, which is in the state
        return max(fix.sigma_m, self._config.fix_sigma_min_m) ** 2
