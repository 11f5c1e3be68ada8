"""The autopilot's clock as we see it: how fast it runs, and what it shows at a time of ours.

A sample is a moment of ours, what the autopilot's clock showed then, and how uncertain that is. TIMESYNC gives samples
whose uncertainty is half of the round trip; the time in every message is a sample that is late by an unknown delay. The
best of the last seconds counts: a fixed limit on the round trip would refuse all that some autopilots give.
"""

from collections import deque
from dataclasses import dataclass

#: Samples older than this, in our seconds, are forgotten.
_MEMORY_S = 10.0
#: The rate is measured over as long.
_RATE_S = 20.0
_RATE_LEAST_S = 2.0
#: What an old sample loses, seconds a second: the rate is not known better.
_AGEING = 1e-3
_SPACING_S = 0.5
#: A delay of less, seconds of ours, is that of a busy machine, however fast the autopilot's clock runs.
_BUSY_S = 0.3


def older(passed_s: float, rate: float, limit_s: float) -> bool:
    """Whether something is older than it may be.

    Parameters
    ----------
    passed_s : float
        Its age in seconds of ours.
    rate : float
        Seconds of the autopilot in one of ours.
    limit_s : float
        Greatest age, seconds of the autopilot.
    """
    return passed_s * rate > limit_s and passed_s > min(limit_s, _BUSY_S)


@dataclass(frozen=True, slots=True)
class _Sample:
    ours_s: float
    theirs_s: float
    uncertain_s: float


class BootClock:
    """The clock that counts from the autopilot's boot; see the module's docstring.

    Parameters
    ----------
    rate : float
        Its seconds in one of ours, until that has been measured.

    Attributes
    ----------
    rate : float
        Its seconds in one of ours.
    round_trip_s : float or None
        Least round trip of the last seconds.
    """

    def __init__(self, rate: float = 1.0) -> None:
        self.rate = rate
        self._first_rate = rate
        self._exchanged: deque[_Sample] = deque()
        self._one_way: deque[_Sample] = deque()
        self._history: deque[tuple[float, float]] = deque()

    def reset(self) -> None:
        """Forget everything: it has been booted, or set. Its rate stays what it was."""
        self._exchanged.clear()
        self._one_way.clear()
        self._history.clear()

    @property
    def known(self) -> bool:
        """Whether there is any sample."""
        return bool(self._exchanged or self._one_way)

    @property
    def round_trip_s(self) -> float | None:
        """Least round trip of the last seconds."""
        return min((2.0 * sample.uncertain_s for sample in self._exchanged), default=None)

    def on_exchange(self, sent_s: float, received_s: float, theirs_s: float) -> None:
        """Take an answer to TIMESYNC: when we asked, when it came, and what the clock showed."""
        if received_s < sent_s:
            return
        uncertain_s = (received_s - sent_s) / 2.0
        self._exchanged.append(_Sample(sent_s + uncertain_s, theirs_s, uncertain_s))
        self._forget(received_s)

    def on_boot_time(self, now_s: float, theirs_s: float) -> None:
        """Take the time of a message that has just come."""
        self._one_way.append(_Sample(now_s, theirs_s, 0.0))
        if not self._history or now_s - self._history[-1][0] >= _SPACING_S:
            self._history.append((now_s, theirs_s))
            self._measure()
        self._forget(now_s)

    def ours_s(self, theirs_s: float) -> float:
        """Our time at which it showed a time of its own."""
        best = self._best()
        return best.ours_s + (theirs_s - best.theirs_s) / self.rate

    def theirs_s(self, now_s: float) -> float:
        """Read it at a time of ours; 0 before anything is known."""
        if not self.known:
            return 0.0
        best = self._best()
        return best.theirs_s + (now_s - best.ours_s) * self.rate

    def _best(self) -> _Sample:
        if self._exchanged:
            newest_s = self._exchanged[-1].ours_s
            return min(self._exchanged, key=lambda each: each.uncertain_s + _AGEING * (newest_s - each.ours_s))
        # The message that was least late is the one that shows the most for its time.
        return max(self._one_way, key=lambda each: each.theirs_s - each.ours_s * self.rate)

    def _measure(self) -> None:
        (first_s, first), (last_s, last) = self._history[0], self._history[-1]
        if last_s - first_s >= _RATE_LEAST_S and last > first:
            self.rate = (last - first) / (last_s - first_s)

    def _forget(self, now_s: float) -> None:
        for samples in (self._exchanged, self._one_way):
            while len(samples) > 1 and now_s - samples[0].ours_s > _MEMORY_S:
                samples.popleft()
        if self._exchanged and self._one_way and now_s - self._exchanged[-1].ours_s > 3.0 * _MEMORY_S:
            self._exchanged.clear()
        while len(self._history) > 2 and now_s - self._history[0][0] > _RATE_S:
            self._history.popleft()
