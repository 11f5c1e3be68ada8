"""Reads parameters of an autopilot by their names; one that it does not have is met with silence. Pure."""

import struct
from collections.abc import Iterable

from grex_agent.frontseat.dialect import Mavlink, mavlink

#: So many are asked for at once, each again after so many seconds of ours, so often.
_AT_ONCE = 4
_RETRY_S = 0.4
_TRIES = 3
_BY_NAME = -1


class ParameterReader:
    """Asks for some parameters until each is known or has been asked for in vain; see the module's docstring.

    Parameters
    ----------
    names : iterable of str
        Which.
    target : (int, int)
        System and component of the autopilot.
    bytewise : bool
        Whether its integers travel as their bytes (PX4), not as their value (ArduPilot).

    Attributes
    ----------
    values : dict of str to float
        What is known so far.
    """

    def __init__(self, names: Iterable[str], target: tuple[int, int], *, bytewise: bool) -> None:
        self._waiting = dict.fromkeys(names, 0)
        self._target = target
        self._bytewise = bytewise
        self._again_s = -1e9
        self.values: dict[str, float] = {}

    @property
    def done(self) -> bool:
        """Whether there is nothing left to ask."""
        return not self._waiting

    def on_message(self, message: Mavlink) -> None:
        """Take PARAM_VALUE."""
        name = message.param_id
        if self._waiting.pop(name, None) is not None:
            self.values[name] = self._value(message)

    def due(self, now_s: float) -> list[Mavlink]:
        """Return what is to be asked at a time."""
        if now_s < self._again_s:
            return []
        self._again_s = now_s + _RETRY_S
        for name in [name for name, tries in self._waiting.items() if tries >= _TRIES]:
            del self._waiting[name]
        asked = list(self._waiting)[:_AT_ONCE]
        for name in asked:
            self._waiting[name] += 1
        return [
            mavlink.MAVLink_param_request_read_message(*self._target, name.encode("ascii"), _BY_NAME) for name in asked
        ]

    def _value(self, message: Mavlink) -> float:
        if self._bytewise and message.param_type != mavlink.MAV_PARAM_TYPE_REAL32:
            return float(struct.unpack("<i", struct.pack("<f", message.param_value))[0])
        return float(message.param_value)
