"""How a craft's speed follows what is ordered, with an error that wanders; see `grex_agent.team.along_track`."""

import math

import numpy as np
import numpy.typing as npt

from grex_agent.gaussian import Gaussian, update
from grex_link.config import SpeedModelConfig

Array = npt.NDArray[np.float64]


class SpeedModel:
    """How a craft's speed follows what it orders, with an error that wanders.

    Parameters
    ----------
    config : SpeedModelConfig
        Lag, limits and noises.
    """

    def __init__(self, config: SpeedModelConfig) -> None:
        self.config = config

    def step(self, speed: float, ordered: float, error: float, dt: float) -> tuple[float, tuple[float, float, float]]:
        """Speed after `dt`, and its derivatives by speed, ordered speed and error."""
        gain, most = self._gain(dt), self.config.acceleration_max_mps2 * dt
        change = gain * ((1.0 + error) * ordered - speed)
        if abs(change) > most:
            return speed + math.copysign(most, change), (1.0, 0.0, 0.0)
        return speed + change, (1.0 - gain, gain * (1.0 + error), gain * ordered)

    def step_all(
        self, speed: Array, ordered: Array, error: Array, dt: float
    ) -> tuple[Array, Array | float, Array, Array]:
        """Do the same for many craft at once, shape (n,) each: speeds after `dt`, and the three derivatives."""
        gain, most = self._gain(dt), self.config.acceleration_max_mps2 * dt
        by_order = gain * (1.0 + error)
        change = by_order * ordered - gain * speed
        by_speed, by_error = 1.0 - gain, gain * ordered
        limited = np.abs(change) > most
        if not np.count_nonzero(limited):  # half the time of any()
            return speed + change, by_speed, by_order, by_error
        by_order[limited], by_error[limited] = 0.0, 0.0
        change = np.where(limited, np.copysign(most, change), change)
        return speed + change, np.where(limited, 1.0, by_speed), by_order, by_error

    def fading(self, dt: float) -> tuple[float, float]:
        """Share of the error that is left after `dt`, and the variance that comes in."""
        keep = math.exp(-dt / self.config.error_time_s)
        return keep, self.config.error_relative**2 * (1.0 - keep * keep)

    def hear_speed(self, x: Gaussian, told: float, expected: float, ordered: float, speed: int, error: int) -> Gaussian:
        """Work in a told speed; one that is far off means that the error has changed at once, and frees it."""
        variance = self.config.told_sigma_mps**2
        surprise = told - expected
        if surprise**2 > self.config.surprise**2 * (float(x.covariance[speed, speed]) + variance):
            freed = x.covariance.copy()
            freed[speed, speed] += surprise**2
            freed[error, error] += (surprise / ordered) ** 2
            freed[speed, error] += surprise**2 / ordered
            freed[error, speed] = freed[speed, error]
            x = Gaussian(x.mean, freed)
        return update(x, speed, surprise, variance)

    def _gain(self, dt: float) -> float:
        return 1.0 - math.exp(-dt / self.config.lag_s) if self.config.lag_s > 0.0 else 1.0
