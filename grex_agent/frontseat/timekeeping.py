"""The autopilot's time: which message is an echo, how its clock runs, and when it was booted or set. Pure."""

from collections import deque

from grex_agent.frontseat.bootwatch import BootWatch, Finding
from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.echoes import Echoes
from grex_agent.frontseat.outputs import Note, warn
from grex_agent.frontseat.timesync import BootClock
from grex_link.units import NS

#: So many of our last questions may still be answered.
_QUESTIONS = 10
#: A date that moves by more against the time since boot has been set.
_DATE_JUMP_S = 3.0
#: It tells what it wants, not when it is.
_NO_CLOCK = "POSITION_TARGET_LOCAL_NED"


class Timekeeper:
    """See the module's docstring. Times are ours, seconds.

    Parameters
    ----------
    pace : float
        How fast its clock is expected to run.

    Attributes
    ----------
    clock : BootClock
        Its seconds since boot.
    """

    def __init__(self, pace: float) -> None:
        self.clock = BootClock(pace)
        self._watch = BootWatch()
        self._echoes = Echoes()
        self._booted_unix_s: float | None = None
        self._asked_ns: deque[int] = deque(maxlen=_QUESTIONS)

    @property
    def doubtful(self) -> bool:
        """Whether the last message showed another clock than those before."""
        return self._watch.doubtful

    def is_echo(self, message: Mavlink) -> bool:
        """Whether this very message has just been heard; only those with a time in them are looked at."""
        return hasattr(message, "time_boot_ms") and self._echoes.is_one(message)

    def see(self, message: Mavlink, now_s: float) -> Finding | None:
        """Take the time that is in a message, and return what has been found just now."""
        boot_ms = getattr(message, "time_boot_ms", None)
        kind = message.get_type()
        if boot_ms is None or kind == _NO_CLOCK:
            return None
        finding = self._watch.see(kind, boot_ms / 1e3, now_s, self.clock.rate)
        if finding in {"reboot", "jump"}:
            self.clock.reset()
            self._booted_unix_s = None
        elif finding is None and not self._watch.doubtful:
            self.clock.on_boot_time(now_s, boot_ms / 1e3)
        return finding

    def on_date(self, message: Mavlink) -> list[Note]:
        """Take SYSTEM_TIME; a date that is set while it runs is said, although nothing here goes by it."""
        if not message.time_unix_usec:
            return []
        booted_unix_s = message.time_unix_usec / 1e6 - message.time_boot_ms / 1e3
        before, self._booted_unix_s = self._booted_unix_s, booted_unix_s
        if before is None or abs(booted_unix_s - before) < _DATE_JUMP_S:
            return []
        return [
            warn(
                f"the autopilot's date has jumped by {booted_unix_s - before:+.0f} s: its logs are dated wrongly, "
                "positions and set-points go by its time since boot and are not"
            )
        ]

    def question(self, now_s: float) -> Mavlink:
        """TIMESYNC that asks what its clock shows."""
        self._asked_ns.append(round(now_s * NS))
        return mavlink.MAVLink_timesync_message(0, round(now_s * NS))

    def on_timesync(self, message: Mavlink, now_s: float) -> list[Mavlink]:
        """Answer its question, or take its answer to ours."""
        if message.tc1 == 0:
            return [mavlink.MAVLink_timesync_message(round(now_s * NS), message.ts1)]
        # Behind a router we hear what it answers to others, too.
        if message.ts1 in self._asked_ns:
            self.clock.on_exchange(message.ts1 / NS, now_s, message.tc1 / NS)
        return []
