"""How often the messages of a key come, from the times at which they came."""

import math
from typing import NamedTuple


class Rate(NamedTuple):
    """How often messages have come; seconds and 1/s. Of fewer than two messages nothing can be said."""

    messages: int
    hz: float | None
    min_s: float | None
    """Shortest time between two."""
    max_s: float | None
    std_s: float | None
    """Standard deviation of the times between two."""


class Intervals:
    """Times between messages of one key, summed up as they come; nothing is kept of each."""

    def __init__(self) -> None:
        self._count = 0
        self._first_s = self._last_s = 0.0
        self._min_s, self._max_s = math.inf, 0.0
        self._mean_s = self._squares = 0.0

    def add(self, now_s: float) -> None:
        """Take that a message came at a time, seconds, on a clock that never jumps."""
        if self._count == 0:
            self._first_s = now_s
        else:
            apart_s = now_s - self._last_s
            self._min_s, self._max_s = min(self._min_s, apart_s), max(self._max_s, apart_s)
            # Welford: the sum of the squares itself would cancel.
            off_s = apart_s - self._mean_s
            self._mean_s += off_s / self._count
            self._squares += off_s * (apart_s - self._mean_s)
        self._last_s = now_s
        self._count += 1

    @property
    def rate(self) -> Rate:
        """How often they have come so far."""
        gaps = self._count - 1
        if gaps < 1:
            return Rate(self._count, None, None, None, None)
        lasting_s = self._last_s - self._first_s
        hz = gaps / lasting_s if lasting_s > 0.0 else math.inf
        return Rate(self._count, hz, self._min_s, self._max_s, math.sqrt(self._squares / gaps))
