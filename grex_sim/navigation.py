"""The error of a craft's own navigation: fixed offset, white noise, and an error that grows (paper, Fig. 4)."""

import math

from grex_link import draws
from grex_link.config import NavigationConfig
from grex_link.messages import Fix, Pose
from grex_link.units import NS


class Navigation:
    """Turns true poses into fixes.

    Parameters
    ----------
    craft : str
        Its name keys the draws.
    config : NavigationConfig
        The errors.
    seed : int
        Seed of the run.
    """

    def __init__(self, craft: str, config: NavigationConfig, seed: int) -> None:
        self._craft = craft
        self._config = config
        self._seed = seed
        self._drifts = any(config.drift_ned_mps)
        self._sigma_at_start_m = self._sigma_m(0.0)

    def fix(self, pose: Pose, tick: int, t_ns: int, modem_events: int) -> Fix:
        """Fix the craft's position at a tick, as its navigation would."""
        offset, drift, white = self._config.offset_ned_m, self._config.drift_ned_mps, self._config.white_m
        t_s = t_ns / NS
        noise_north = noise_east = 0.0
        if white:
            unit_north, unit_east = draws.normal(self._seed, "navigation", self._craft, tick)
            noise_north, noise_east = white * unit_north, white * unit_east
        return Fix(
            tick,
            t_ns,
            pose.north_m + offset[0] + drift[0] * t_s + noise_north,
            pose.east_m + offset[1] + drift[1] * t_s + noise_east,
            pose.down_m + offset[2] + drift[2] * t_s,
            pose.heading_rad,
            pose.surge_mps,
            self._sigma_m(t_s) if self._drifts else self._sigma_at_start_m,
            modem_events=modem_events,
        )

    def _sigma_m(self, t_s: float) -> float:
        """Return what an honest navigation would claim: noise, and offset and drift as if they were random."""
        config = self._config
        bias = [offset + drift * t_s for offset, drift in zip(config.offset_ned_m, config.drift_ned_mps, strict=True)]
        return math.sqrt(config.white_m**2 + (bias[0] ** 2 + bias[1] ** 2) / 2.0)
