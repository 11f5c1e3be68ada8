"""The clocks of the craft: each has an offset and a drift, and GPS may set it at the surface.

Whatever an agent or a modem stamps is stamped by its own clock; only the medium, the score and the log know true time.
"""

from grex_link.config import CraftClockConfig, Scenario
from grex_link.messages import Truth
from grex_link.units import NS


class CraftClock:
    """One craft's clock: local = true + offset + drift · (true - set).

    Parameters
    ----------
    config : CraftClockConfig
        Its error, and whether GPS sets it.
    """

    def __init__(self, config: CraftClockConfig) -> None:
        self._config = config
        self._offset_ns = round(config.offset_s * NS)
        self._set_ns = 0

    def see(self, t_ns: int, depth_m: float) -> None:
        """Let GPS set the clock if the craft is at the surface at a true time."""
        if self._config.gps_at_surface and depth_m <= self._config.surface_depth_m:
            self._offset_ns = 0
            self._set_ns = t_ns

    def error_ns(self, t_ns: int) -> int:
        """How far the clock is ahead of a true time."""
        return self._offset_ns + round((t_ns - self._set_ns) * self._config.drift_ppm * 1e-6)

    def local_ns(self, t_ns: int) -> int:
        """Read the clock at a true time."""
        return t_ns + self.error_ns(t_ns)

    def true_ns(self, local_ns: int) -> int:
        """Find the true time at which the clock reads this, to the nanosecond."""
        if not self._config.drift_ppm:
            return local_ns - self._offset_ns
        since_set_ns = local_ns - self._offset_ns - self._set_ns
        return self._set_ns + round(since_set_ns / (1.0 + self._config.drift_ppm * 1e-6))

    @property
    def right(self) -> bool:
        """Whether it has no error at any time."""
        return not (self._offset_ns or self._config.drift_ppm)


class TeamClocks:
    """The clocks of all craft of a scenario.

    Whoever sees the same poses in the same order has the same clocks: the sea and the link need not talk of them.

    Parameters
    ----------
    scenario : Scenario
        The run.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.craft = {craft: CraftClock(config.clock) for craft, config in scenario.craft.items()}

    def see(self, truth: Truth) -> None:
        """Let GPS set the clocks of those at the surface."""
        for pose in truth.poses:
            self.craft[pose.craft].see(truth.t_ns, pose.down_m)
