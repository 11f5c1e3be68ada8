"""Modes and arming: what is accepted, what is taken back, and what the vehicle changes by itself."""

from grex_sim.autopilot.boot import Boot
from grex_sim.autopilot.family import Family, Mode
from grex_sim.autopilot.message import Result

_TAKEN_BACK_AFTER_S = 1.2

Answer = tuple[Result, str]
"""Result for the ACK, and a text or nothing."""


class Modes:
    """Mode and arming of one start.

    Parameters
    ----------
    family : Family
        The table of modes.
    boot : Boot
        Phases of this start.
    """

    def __init__(self, family: Family, boot: Boot) -> None:
        self._family, self._boot = family, boot
        self.mode: Mode = family.known(family.boot_mode)
        self.armed = False
        self._take_back_s: float | None = None
        self._settled = False

    def step(self, now_s: float) -> str:
        """Go on to a time; return what it says to that, or nothing."""
        if not self._settled and self._boot.settled(now_s):
            self._settled = True
            if self.mode.name == self._family.boot_mode:
                self.mode = self._family.known(self._family.first_mode)
        if self._take_back_s is not None and now_s >= self._take_back_s:
            self._take_back_s = None
            self.mode = self._family.known(self._family.first_mode)
            return "Flight mode change failed"
        return ""

    def ask(self, number: int, now_s: float, *, position: bool, streamed: bool) -> Answer:
        """Change the mode because somebody asks; `streamed` says whether set-points are coming."""
        wanted = self._family.mode(number)
        if wanted is None or wanted.name == "INITIALISING":
            return Result.FAILED, f"No such mode {number}"
        if not self._boot.settled(now_s):
            # ACCEPTED is not a fact: what comes up says yes, shows the mode, and takes it back.
            self._take_back_s = now_s + _TAKEN_BACK_AFTER_S * self._boot.scale
            self.mode = wanted
            return Result.ACCEPTED, ""
        refused = self._refusal(wanted, position=position, streamed=streamed)
        if refused is not None:
            return refused
        self._take_back_s = None
        self.mode = wanted
        return Result.ACCEPTED, ""

    def force(self, name: str) -> bool:
        """Change the mode because a failsafe or a pilot wants it; False if it is that already."""
        wanted = self._family.known(name)
        changed = wanted != self.mode
        self.mode = wanted
        self._take_back_s = None
        return changed

    def arm(self, now_s: float, *, position: bool, streamed: bool) -> Answer:
        """Arm, if the mode has what it needs."""
        if self.armed:
            return Result.ACCEPTED, ""
        early = not self._boot.past(self._boot.times.arm_s, now_s)
        blind = self.mode.needs_position and not position
        idle = self._family.own_mode_encoding and self.mode.kind == "guided" and not streamed
        if not (early or blind or idle):
            self.armed = True
            return Result.ACCEPTED, ""
        if self._family.reject_event:
            return Result.TEMPORARILY_REJECTED, ""
        return Result.FAILED, self._boot.why_not_armed(now_s)

    def disarm(self) -> None:
        """Disarm."""
        self.armed = False

    def _refusal(self, wanted: Mode, *, position: bool, streamed: bool) -> Answer | None:
        if self._family.own_mode_encoding:
            missing = (wanted.kind == "guided" and not streamed) or (wanted.needs_position and not position)
            return (Result.TEMPORARILY_REJECTED, "") if self.armed and missing else None
        # A rover lets itself be put into any mode while disarmed; arming checks later. A sub does not.
        lenient = not self._family.dives and not self.armed
        if wanted.needs_position and not position and not lenient:
            return Result.FAILED, f"Mode change to {wanted.name} failed: requires position"
        return None
