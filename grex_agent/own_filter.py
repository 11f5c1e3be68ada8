"""Navigation filter of the own state: position, speed, actuator error and current from noisy fixes.

State x = [north, east, v, β, c_north, c_east]: position (m), speed through the water (m/s), speed error as a share of
the speed ordered, current (m/s). Driven by the speed ordered through the water and the measured heading; the surge loop
is that of `SpeedModel`. A steady current and a speed error look alike on one course, and part at the first turn.
"""

import math

import numpy as np

from grex_agent.gaussian import Gaussian, Matrix, propagate, update
from grex_agent.path import wrap
from grex_agent.team.speed_model import SpeedModel
from grex_link.config import OwnFilterConfig, SpeedModelConfig
from grex_link.messages import Fix

_NORTH, _EAST, _SPEED, _ERROR, _CURRENT_NORTH, _CURRENT_EAST = range(6)


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
    """

    def __init__(self, config: OwnFilterConfig, speed: SpeedModelConfig, known_current: tuple[float, float]) -> None:
        self._config = config
        self._speed = SpeedModel(speed)
        self._known_current = known_current
        self._x: Gaussian | None = None
        self._time_s = self._heading_rad = 0.0

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
        if now_s > self._time_s:
            middle = self._heading_rad + wrap(heading - self._heading_rad) / 2.0
            self._x = self._predict(self._x, ordered_mps, middle, now_s - self._time_s)
            self._time_s = now_s
        self._heading_rad = heading
        if fix is not None:
            self._x = self._correct(self._x, fix)

    # -- inside -------------------------------------------------------------------------------------------------

    def _begin(self, now_s: float, fix: Fix) -> None:
        place, current = self._fix_variance(fix), self._config.current_sigma_mps**2
        speed = self._speed.config
        # The surge at the beginning is what the craft says, give or take the error of its order.
        speed_variance = (speed.error_relative * max(abs(fix.speed_mps), 1.0)) ** 2
        covariance = np.diag((place, place, speed_variance, speed.error_relative**2, current, current))
        self._x = Gaussian((fix.north_m, fix.east_m, fix.speed_mps, 0.0, *self._known_current), covariance)
        self._time_s, self._heading_rad = now_s, fix.heading_rad

    def _predict(self, x: Gaussian, ordered: float, heading: float, dt: float) -> Gaussian:
        north, east, speed, error, current_north, current_east = x.mean
        after, (by_speed, _, by_error) = self._speed.step(speed, ordered, error, dt)
        keep, error_noise = self._speed.fading(dt)
        cos, sin = math.cos(heading), math.sin(heading)
        half = dt / 2.0
        jacobian = np.eye(6)
        for row, part in ((_NORTH, cos), (_EAST, sin)):
            jacobian[row, _SPEED] = half * (1.0 + by_speed) * part
            jacobian[row, _ERROR] = half * by_error * part
        jacobian[_NORTH, _CURRENT_NORTH] = jacobian[_EAST, _CURRENT_EAST] = dt
        jacobian[_SPEED, _SPEED], jacobian[_SPEED, _ERROR] = by_speed, by_error
        jacobian[_ERROR, _ERROR] = keep
        place, drift = self._config.place_noise_m**2 * dt, self._config.current_noise_mps**2 * dt
        noise = np.diag((place, place, self._speed.config.noise_mps**2 * dt, error_noise, drift, drift))
        mean = (
            north + half * (speed + after) * cos + dt * current_north,
            east + half * (speed + after) * sin + dt * current_east,
            after,
            keep * error,
            current_north,
            current_east,
        )
        return propagate(mean, x.covariance, jacobian, noise)

    def _correct(self, x: Gaussian, fix: Fix) -> Gaussian:
        variance = self._fix_variance(fix)
        x = update(x, _NORTH, fix.north_m - x.mean[_NORTH], variance)
        x = update(x, _EAST, fix.east_m - x.mean[_EAST], variance)
        if self._config.speed_sigma_mps is not None:
            x = update(x, _SPEED, fix.speed_mps - x.mean[_SPEED], self._config.speed_sigma_mps**2)
        return x

    def _fix_variance(self, fix: Fix) -> float:
        return max(fix.sigma_m, self._config.fix_sigma_min_m) ** 2
