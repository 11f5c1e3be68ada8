"""Parameters on the wire: unknown names get silence, types coerce, integers travel by value or as bytes."""

import math
import struct
from collections.abc import Iterator

import msgspec

from grex_sim.autopilot.message import Message

BY_NAME = 65535
"""``param_index`` of an answer to a question by name."""
_TYPES = {"i8": (2, 8), "i16": (4, 16), "i32": (6, 32), "f32": (9, 0)}
_LIST_PER_S = 1300.0

#: What any ArduPilot has, among a thousand others.
ARDUPILOT: tuple[tuple[str, str, float], ...] = (
    ("FORMAT_VERSION", "i16", 16),
    ("SYSID_THISMAV", "i16", 1),
    ("SYSID_MYGCS", "i16", 255),
    ("SYSID_ENFORCE", "i8", 0),
    ("GPS1_TYPE", "i8", 1),
    ("EK3_ENABLE", "i8", 1),
    ("EK3_SRC1_POSXY", "i8", 3),
    ("EK3_SRC1_VELXY", "i8", 3),
    ("EK3_SRC1_POSZ", "i8", 1),
    ("EK3_SRC1_VELZ", "i8", 3),
    ("EK3_SRC1_YAW", "i8", 1),
    ("VISO_TYPE", "i8", 0),
    ("AHRS_EKF_TYPE", "i8", 3),
    ("ARMING_REQUIRE", "i8", 1),
    ("BRD_SAFETY_DEFLT", "i8", 0),
    ("LOG_BACKEND_TYPE", "i8", 1),
    ("SERIAL0_PROTOCOL", "i8", 2),
    ("SERIAL1_PROTOCOL", "i8", 2),
    ("SERIAL1_BAUD", "i32", 57),
    ("SIM_GPS_DISABLE", "i8", 0),
    ("SIM_SPEEDUP", "f32", 1.0),
    *((f"RC{n}_{what}", "i16", value) for n in range(1, 17) for what, value in (("MIN", 1100), ("MAX", 1900))),
    *((f"SERVO{n}_{what}", "i16", value) for n in range(1, 17) for what, value in (("MIN", 1100), ("FUNCTION", 0))),
)

#: ArduPilot 4.7's new names of what 4.6 calls otherwise.
RENAMED_47 = {"SYSID_THISMAV": "MAV_SYSID", "SYSID_MYGCS": "MAV_GCS_SYSID", "ARMING_CHECK": "ARMING_SKIPCHK"}


class Parameter(msgspec.Struct):
    """One parameter."""

    name: str
    type: str
    value: float


class Parameters:
    """All parameters of one autopilot; they outlive a reboot.

    Parameters
    ----------
    rows : tuple
        Name, type and default of each.
    bytewise : bool
        Whether integers travel as their bytes.
    renamed : dict
        Other names of this version.
    """

    def __init__(
        self, rows: tuple[tuple[str, str, float], ...], *, bytewise: bool = False, renamed: dict[str, str] | None = None
    ) -> None:
        self._renamed = renamed or {}
        names = [(self._renamed.get(name, name), kind, value) for name, kind, value in rows]
        self._all = {name: Parameter(name, kind, value) for name, kind, value in names}
        self._order = list(self._all)
        self._bytewise = bytewise

    def __contains__(self, name: str) -> bool:
        return self._renamed.get(name, name) in self._all

    def get(self, name: str, default: float = 0.0) -> float:
        """Value of a parameter by its name of version 4.6; the default if there is none."""
        found = self._all.get(self._renamed.get(name, name))
        return default if found is None else found.value

    def set(self, name: str, value: float) -> bool:
        """Give a parameter a value by its present name, as a type allows; False if nobody knows it."""
        found = self._all.get(name)
        if found is None:
            return False
        found.value = _coerce(found.type, value)
        return True

    def read(self, message: Message) -> Message | None:
        """Answer PARAM_REQUEST_READ; None, which is silence, for what is unknown."""
        index = message["param_index"]
        name = message["param_id"] if index < 0 else self._order[index] if index < len(self._order) else ""
        return self._say(name, BY_NAME if index < 0 else index) if name in self._all else None

    def write(self, message: Message) -> Message | None:
        """Obey PARAM_SET and answer with what is now stored; None, which is silence, for what is unknown."""
        found = self._all.get(message["param_id"])
        if found is None:
            return None
        value = message["param_value"]
        if self._bytewise and found.type != "f32":
            value = float(struct.unpack("<i", struct.pack("<f", value))[0])
        if not math.isfinite(value):
            return None
        found.value = _coerce(found.type, value)
        return self._say(found.name, BY_NAME)

    def listed(self, now_s: float) -> Iterator[tuple[float, Message]]:
        """All of them with the times at which they are sent."""
        for index, name in enumerate(self._order):
            yield now_s + index / _LIST_PER_S, self._say(name, index)

    def _say(self, name: str, index: int) -> Message:
        found = self._all[name]
        value = found.value
        if self._bytewise and found.type != "f32":
            value = struct.unpack("<f", struct.pack("<i", int(value)))[0]
        fields = {
            "param_id": name,
            "param_value": value,
            "param_type": _TYPES[found.type][0],
            "param_count": len(self._order),
            "param_index": index,
        }
        return Message("PARAM_VALUE", fields)


def _coerce(kind: str, value: float) -> float:
    """Do what a cast in C does to a value, without its undefined parts."""
    bits = _TYPES[kind][1]
    if not bits:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    most = 2 ** (bits - 1)
    return float(min(max(int(value), -most), most - 1))
