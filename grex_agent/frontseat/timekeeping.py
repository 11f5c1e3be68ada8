"""The autopilot's time: which message is an echo, how its clock runs, and when it was booted or set. Pure."""

from grex_agent.frontseat.bootwatch import BootWatch, Finding
from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.echoes import Echoes
from grex_agent.frontseat.outputs import Note, warn
from grex_agent.frontseat.timesync import BootClock
from grex_link.units import NS

#: An answer to TIMESYNC that is older is none of ours.
_ANSWER_MAX_S = 3.0
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

    @staticmethod
    def question(now_s: float) -> Mavlink:
        """TIMESYNC that asks what its clock shows."""
        return mavlink.MAVLink_timesync_message(0, round(now_s * NS))

    def on_timesync(self, message: Mavlink, now_s: float) -> list[Mavlink]:
        """Answer its question, or take its answer to ours."""
        if message.tc1 == 0:
            return [mavlink.MAVLink_timesync_message(round(now_s * NS), message.ts1)]
        sent_s = message.ts1 / NS
        # An answer to somebody else has a time that is none of ours.
        if 0.0 <= now_s - sent_s < _ANSWER_MAX_S:
            self.clock.on_exchange(sent_s, now_s, message.tc1 / NS)
        return []
