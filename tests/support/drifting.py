"""A craft whose inertial fixes drift, and a boat beside it that knows where it is."""

import math

import numpy as np
from core_steps import fix

from grex_agent.own_filter import OwnFilter
from grex_agent.range_update import Range
from grex_link.config import OwnFilterConfig, SpeedModelConfig
from grex_link.ranging_config import InertialConfig, RangingConfig

INERTIAL = InertialConfig(offset_sigma_m=0.5, drift_sigma_mps=0.02, noise_m=0.05)
RANGING = RangingConfig(mode="two_way", sigma_m=0.2)
SPEED = SpeedModelConfig()
_LEG_S = 60


class Drifting:
    """Truth and filter of a craft that turns by 90° every minute at 1 m/s; the boat keeps 40 m to its starboard.

    Parameters
    ----------
    offset, drift : tuple of float
        Error of the fixes at the start and its rate.
    draw : numpy.random.Generator or None
        Draws all other errors as the filter models them; None for no noise at all.
    """

    def __init__(self, offset=(0.0, 0.0), drift=(0.0, 0.0), draw=None):
        self.filter = OwnFilter(OwnFilterConfig(current_sigma_mps=0.05), SPEED, (0.0, 0.0), INERTIAL, RANGING)
        self.place, self.offset, self.drift = np.zeros(2), np.array(offset), np.array(drift)
        self.draw, self.heading, self.speed = draw, 0.0, 1.0
        self.current = self._noise(0.05)
        self.now = -1

    def step(self):
        """One second on: the truth, and the filter with a fix."""
        self.now += 1
        heading = math.pi / 2.0 * (self.now // _LEG_S % 4)
        if self.now:
            turn = math.remainder(heading - self.heading, 2.0 * math.pi)
            middle = self.heading + turn / 2.0
            way = self.speed * np.array([math.cos(middle), math.sin(middle)])
            self.place = self.place + way + self.current + self._noise(0.02)
            self.offset = self.offset + self.drift
            self.drift = self.drift + self._noise(INERTIAL.drift_noise_mps)
        self.heading = heading
        north, east = self.place + self.offset + self._noise(INERTIAL.noise_m)
        self.filter.step(
            float(self.now), fix(self.now, north, east, down_m=10.0, heading_rad=heading, speed_mps=1.0), 1.0
        )

    def range(self, sigma=0.0, extra=0.0):
        """A range to the boat now, with what the boat tells of itself."""
        boat = self.place + 40.0 * np.array([-math.sin(self.heading), math.cos(self.heading)])
        told = boat + self._noise(sigma)
        slant = math.hypot(40.0, 10.0) + float(self._noise(RANGING.sigma_m)[0]) + extra
        return Range(float(self.now), float(self.now), "boat", slant, *told.tolist(), 0.0, sigma)

    @property
    def error(self):
        """Believed less true position."""
        return np.array(self.filter.state[:2]) - self.place

    def _noise(self, sigma):
        return np.zeros(2) if self.draw is None else sigma * self.draw.normal(size=2)
