"""Faults to order: from a script on the command line, or from parameters while it runs."""

import re
from collections.abc import Iterator

import msgspec

from grex_link import draws
from grex_link.errors import ConfigError
from grex_sim.autopilot.message import Out

#: Name, what its value means, and the value without one. ``once``: it happens; the others last.
KINDS: dict[str, tuple[str, float, bool]] = {
    "silence": ("says nothing and hears nothing", 1.0, False),
    "deaf": ("hears nothing, and goes on talking", 1.0, False),
    "gps": ("no satellites", 1.0, False),
    "loss": ("this part of the datagrams is lost, each way", 0.3, False),
    "duplicate": ("this part of the messages goes out twice", 0.3, False),
    "garbage": ("this many times a second random bytes go out", 5.0, False),
    "late": ("ACKs come so many seconds late", 5.0, False),
    "refuse": ("arming fails", 1.0, False),
    "jump": ("its date is so many seconds wrong", 3600.0, False),
    "reboot": ("loses power for a moment, even when armed", 1.0, True),
    "disarm": ("disarms", 1.0, True),
    "pilot": ("a pilot takes over: the mode of this name or number", -1.0, True),
}
_SCRIPT = re.compile(r"(?P<kind>\w+)@(?P<at>[\d.]+)(?::(?P<lasts>[\d.]+))?(?:=(?P<value>[\w.]+))?")
#: Names of the parameters: at most 16 characters.
PREFIX = "GREX_"
_GARBAGE_BYTES = 40
_VALUE_MAX = 1e9


class Fault(msgspec.Struct, frozen=True):
    """One fault of the script."""

    kind: str
    at_s: float
    """Autopilot seconds since it was started."""
    until_s: float
    value: float | str


def parse(text: str) -> Fault:
    """Read ``KIND@AT[:LASTS][=VALUE]``, for instance ``silence@20:10``, ``loss@0:60=0.3``, ``pilot@30=HOLD``.

    Raises
    ------
    ConfigError
        If it cannot be read.
    """
    match = _SCRIPT.fullmatch(text.strip())
    if match is None or match["kind"] not in KINDS:
        raise ConfigError("--fault", f"{text!r} is none; write KIND@AT[:LASTS][=VALUE] with KIND of {', '.join(KINDS)}")
    try:
        at, lasts = float(match["at"]), float(match["lasts"] or "inf")
    except ValueError:
        raise ConfigError("--fault", f"{text!r}: AT and LASTS are seconds") from None
    return Fault(match["kind"], at, at + lasts, _value(match["kind"], match["value"], text))


def _value(kind: str, given: str | None, text: str) -> float | str:
    if given is None:
        return KINDS[kind][1]
    try:
        return float(given)
    except ValueError:
        if kind == "pilot":
            return given
        raise ConfigError("--fault", f"{text!r}: the value is a number") from None


def parameter_rows() -> tuple[tuple[str, str, float], ...]:
    """Parameters that start a fault when they are set, and end it with 0 (pilot: -1)."""
    return tuple((PREFIX + kind.upper(), "f32", -1.0 if kind == "pilot" else 0.0) for kind in KINDS)


class Faults:
    """The faults of one autopilot.

    Parameters
    ----------
    script : tuple of Fault
        What comes at its time.
    seed : int
        Seed of the draws.
    """

    def __init__(self, script: tuple[Fault, ...], seed: int) -> None:
        self._script = script
        self._seed = seed
        self._set: dict[str, float] = {}
        self._once: list[tuple[str, float | str]] = []
        self._next = sorted((fault for fault in script if KINDS[fault.kind][2]), key=lambda fault: fault.at_s)
        self._draws = 0
        self._silent_until_s = 0.0
        self._garbage_s = 0.0

    def on_parameter(self, name: str, value: float, now_s: float) -> bool:
        """Start or end a fault by its parameter; False if it is none. GREX_SILENCE is seconds of silence."""
        kind = name.removeprefix(PREFIX).lower()
        if not name.startswith(PREFIX) or kind not in KINDS or not abs(value) <= _VALUE_MAX:
            return False
        if kind == "silence":
            self._silent_until_s = now_s + value
        elif not KINDS[kind][2]:
            self._set[kind] = value
        elif value > (-1.0 if kind == "pilot" else 0.0):
            self._once.append((kind, value))
        return True

    def value(self, kind: str, now_s: float) -> float:
        """Value of a lasting fault now; 0 for none."""
        if kind == "silence" and now_s < self._silent_until_s:
            return 1.0
        scripted = [fault.value for fault in self._script if fault.kind == kind and fault.at_s <= now_s < fault.until_s]
        return float(scripted[-1]) if scripted else self._set.get(kind, 0.0)

    def happening(self, now_s: float) -> list[tuple[str, float | str]]:
        """Take what happens now, once."""
        happens, self._once = self._once, []
        while self._next and self._next[0].at_s <= now_s:
            fault = self._next.pop(0)
            happens.append((fault.kind, fault.value))
        return happens

    def hears(self, now_s: float) -> bool:
        """Whether a message that comes now is heard."""
        if self.value("silence", now_s) or self.value("deaf", now_s):
            return False
        return self._draw() >= self.value("loss", now_s)

    def outgoing(self, out: list[Out], now_s: float) -> Iterator[Out]:
        """Pass on what really goes out now."""
        if self.value("silence", now_s):
            return
        loss, duplicate = self.value("loss", now_s), self.value("duplicate", now_s)
        for item in out:
            if loss and self._draw() < loss:
                continue
            yield item
            if duplicate and self._draw() < duplicate:
                yield item
        rate = self.value("garbage", now_s)
        if rate and now_s >= self._garbage_s:
            self._garbage_s = now_s + 1.0 / rate
            yield Out(bytes(int(256 * self._draw()) for _ in range(_GARBAGE_BYTES)))

    def _draw(self) -> float:
        self._draws += 1
        return draws.uniform(self._seed, "autopilot fault", self._draws)
