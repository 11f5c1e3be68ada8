"""The one place that reads a clock: wall time, and mission time at the live paces."""

import time

from grex_link.units import NS


class WallClock:
    """Mission time that runs with the wall clock, `pace` times as fast.

    Parameters
    ----------
    pace : float
        Mission seconds per wall second.
    epoch_unix_ns : int
        Wall time of mission time zero.
    """

    def __init__(self, pace: float, epoch_unix_ns: int) -> None:
        self.pace = pace
        self.epoch_unix_ns = epoch_unix_ns

    def now_ns(self) -> int:
        """Mission time, integer nanoseconds."""
        return int((time.time_ns() - self.epoch_unix_ns) * self.pace)

    def wall_s_until(self, t_ns: int) -> float:
        """Wall seconds from now until a mission time; 0 if it has passed."""
        return max(0.0, (t_ns - self.now_ns()) / NS / self.pace)


def unix_ns() -> int:
    """Wall time, nanoseconds since 1970."""
    return time.time_ns()


def monotonic_s() -> float:
    """Seconds on a clock that never jumps."""
    return time.monotonic()


def sleep_s(seconds: float) -> None:
    """Let wall time pass."""
    time.sleep(seconds)
