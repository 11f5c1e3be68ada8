"""Parameters of autopilots on which a team's safety hangs, and what is to be said of a value that does not do."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

#: (value, our system id) → what is wrong and what to do; empty if nothing is.
Judge = Callable[[float, int], str]
_TIMEOUT_MAX_S = 10.0


@dataclass(frozen=True, slots=True)
class Setting:
    """One parameter.

    Attributes
    ----------
    name : str
        Its name; a firmware that calls it otherwise has another entry.
    judge : callable
        Says what is wrong with a value.
    """

    name: str
    judge: Judge

    def advice(self, value: float, own_system: int) -> str:
        """One line, or nothing."""
        words = self.judge(value, own_system)
        return f"{self.name} is {value:g}: {words}" if words else ""


@dataclass(frozen=True, slots=True)
class Frame:
    """The parameter that says what kind of craft an autopilot takes itself to be on.

    Attributes
    ----------
    name : str
        Its name.
    words : mapping of int to str
        What its values mean; others are shown as numbers.
    """

    name: str
    words: Mapping[int, str]

    def describe(self, value: float | None) -> str:
        """Say it to a person."""
        if value is None:
            return "it does not say"
        word = self.words.get(int(value))
        return f"{word} ({self.name} {value:g})" if word else f"{self.name} {value:g}"


def unless(*good: float, say: str) -> Judge:
    """Judge that accepts some values only."""
    return lambda value, _: "" if value in good else say


def at_most(most: float, say: str) -> Judge:
    """Judge that accepts what is above 0 and not more than a limit."""
    return lambda value, _: "" if 0.0 < value <= most else say


def _ours(value: float, own_system: int) -> str:
    if value == own_system:
        return ""
    return (
        f"its failsafe counts the heartbeats of system {value:g}, and ours come from {own_system}; "
        f"set it to {own_system}, or frontseat.own_system to {value:g}"
    )


#: What every ArduPilot has, under its names of 4.5, 4.6 and 4.7.
ARDUPILOT: tuple[Setting, ...] = (
    Setting("SYSID_MYGCS", _ours),
    Setting("MAV_GCS_SYSID", _ours),
    Setting("FS_GCS_TIMEOUT", at_most(_TIMEOUT_MAX_S, "too long to be without us; set it to 5")),
    Setting("ARMING_CHECK", lambda value, _: "" if value else "all checks before arming are off; set it to 1"),
    Setting("ARMING_SKIPCHK", unless(0.0, say="checks before arming are left out; set it to 0")),
)
