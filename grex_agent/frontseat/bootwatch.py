"""Watches the times in an autopilot's messages: a reboot, a jump of its clock, or two autopilots with one system id.

The times of one kind of message rise. One fall is a reboot; falls again and again are two clocks. A rise beyond what
has passed is a jump.
"""

from collections import deque
from typing import Literal

Finding = Literal["reboot", "jump", "duplicate"]

#: Falls of one kind of message within this many seconds of ours that make two clocks.
_WINDOW_S = 5.0
_FALLS = 4
#: A fall of less is a datagram that came late.
_LATE_S = 1.0
_JUMP_S = 3.0
#: A new clock counts when nothing of the old one has been heard for so long and this many messages have.
_CONFIRM_S = 0.7
_CONFIRM = 3


class BootWatch:
    """See the module's docstring."""

    def __init__(self) -> None:
        self._newest: dict[str, float] = {}
        self._falls: dict[str, deque[float]] = {}
        self._clock: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None
        self._other_since_s = 0.0
        self._other_count = 0

    def see(self, kind: str, boot_s: float, now_s: float, rate: float) -> Finding | None:
        """Take the time of one message.

        Parameters
        ----------
        kind : str
            Kind of message.
        boot_s : float
            Seconds since boot that it shows.
        now_s : float
            When it came.
        rate : float
            Seconds of that clock in one of ours.

        Returns
        -------
        str or None
            What has been found just now.
        """
        if self._fell_too_often(kind, boot_s, now_s):
            return "duplicate"
        if self._clock is None or _follows(self._clock, boot_s, now_s, rate):
            self._clock = now_s, max(boot_s, self._clock[1] if self._clock else boot_s)
            self._other = None
            return None
        return self._see_other(boot_s, now_s, rate)

    @property
    def doubtful(self) -> bool:
        """Whether the last message showed another clock than those before."""
        return self._other is not None

    def _fell_too_often(self, kind: str, boot_s: float, now_s: float) -> bool:
        newest = self._newest.get(kind)
        self._newest[kind] = boot_s
        falls = self._falls.setdefault(kind, deque())
        if newest is not None and boot_s < newest:
            falls.append(now_s)
        while falls and now_s - falls[0] > _WINDOW_S:
            falls.popleft()
        return len(falls) >= _FALLS

    def _see_other(self, boot_s: float, now_s: float, rate: float) -> Finding | None:
        assert self._clock is not None  # noqa: S101 - the caller has looked
        if self._other is None or not _follows(self._other, boot_s, now_s, rate):
            self._other_since_s, self._other_count = now_s, 0
        self._other = now_s, boot_s
        self._other_count += 1
        if self._other_count < _CONFIRM or now_s - self._other_since_s < _CONFIRM_S:
            return None
        fell = boot_s < self._clock[1]
        self._clock, self._other = self._other, None
        return "reboot" if fell else "jump"


def _follows(clock: tuple[float, float], boot_s: float, now_s: float, rate: float) -> bool:
    """Whether a time goes on from where a clock stood; one that came late does, and one that lags does."""
    then_s, shown_s = clock
    passed_s = (now_s - then_s) * max(rate, 1.0)
    return shown_s - _LATE_S <= boot_s <= shown_s + 1.5 * passed_s + _JUMP_S
