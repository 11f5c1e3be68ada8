"""Messages as the cores know them – name and fields – and the numbers of the protocol that decide anything."""

import heapq
import math
from enum import IntEnum, IntFlag
from typing import Any

import msgspec


class Message(msgspec.Struct, frozen=True):
    """One MAVLink message; fields have MAVLink's names and units."""

    name: str
    fields: dict[str, Any]
    system: int = 0
    """Who said it; 0 for what we say."""
    component: int = 0

    def __getitem__(self, field: str) -> Any:
        return self.fields[field]


def whole(value: float) -> int:
    """Return a parameter of a command as the integer it stands for; -1 if it is no number."""
    return int(value) if math.isfinite(value) else -1


class Out(msgspec.Struct, frozen=True):
    """Something to send."""

    message: Message | bytes
    """Bytes go out as they are: console text, garbage."""
    link: int | None = None
    """Number of the link; None: all of them."""


class Outbox:
    """What will be said, and when."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, Out]] = []
        self._count = 0

    def put(self, at_s: float, message: Message | bytes, link: int | None = None) -> None:
        """Say something at a time."""
        self._count += 1
        heapq.heappush(self._heap, (at_s, self._count, Out(message, link)))

    def due(self, now_s: float) -> list[Out]:
        """Take what is due, in order."""
        out = []
        while self._heap and self._heap[0][0] <= now_s:
            out.append(heapq.heappop(self._heap)[2])
        return out


class Result(IntEnum):
    """MAV_RESULT."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


class Command(IntEnum):
    """The part of MAV_CMD that is known here."""

    LOITER_UNLIM = 17
    RETURN_TO_LAUNCH = 20
    SET_MODE = 176
    CHANGE_SPEED = 178
    SET_HOME = 179
    REPOSITION = 192
    CALIBRATE = 241
    REBOOT = 246
    ARM = 400
    GET_HOME = 410
    GET_INTERVAL = 510
    SET_INTERVAL = 511
    REQUEST_MESSAGE = 512
    REQUEST_CAPABILITIES = 520
    EXTERNAL_POSITION = 43003


class Severity(IntEnum):
    """MAV_SEVERITY."""

    CRITICAL = 2
    WARNING = 4
    NOTICE = 5
    INFO = 6


class State(IntEnum):
    """MAV_STATE."""

    CALIBRATING = 2
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5


class Ekf(IntFlag):
    """ESTIMATOR_STATUS_FLAGS, which EKF_STATUS_REPORT shares."""

    ATTITUDE = 0x01
    VELOCITY_HORIZONTAL = 0x02
    VELOCITY_VERTICAL = 0x04
    POSITION_RELATIVE = 0x08
    POSITION_ABSOLUTE = 0x10
    POSITION_VERTICAL = 0x20
    CONST_POSITION = 0x80
    PREDICTED_RELATIVE = 0x100
    PREDICTED_ABSOLUTE = 0x200
    GOOD = 0x33F
    """As seen with a good position."""
    NO_POSITION = 0xA7
    """As seen before, and after it is lost."""


class Frame(IntEnum):
    """The MAV_FRAMEs of set-points that anybody obeys."""

    LOCAL_NED = 1
    LOCAL_OFFSET_NED = 7
    BODY_NED = 8
    BODY_OFFSET_NED = 9


class Mask(IntFlag):
    """POSITION_TARGET_TYPEMASK: what to ignore of a set-point."""

    X = 0x01
    Y = 0x02
    Z = 0x04
    VX = 0x08
    VY = 0x10
    VZ = 0x20
    ACCELERATION = 0x1C0
    YAW = 0x400
    YAW_RATE = 0x800
    HORIZONTAL = X | Y
    VELOCITY = VX | VY
