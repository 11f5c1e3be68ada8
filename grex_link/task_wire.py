"""Tasks on the air: an order in 12 bytes, and the echo that acknowledges it in 6; never as long as a team state.

=========  =====  ====================================================================
order      bits   unit
=========  =====  ====================================================================
type       4      3
to         4      place of the receiver in the team, modulo 16; in a larger team the address
                  on the modem or land link tells who
number     8      of this sender, modulo 256
kind       3      place in `KINDS`
then       2      return, surface, hold
shape      1      circle, box
north      17     0.125 m, ±8192 m in the mission frame
east       17     as north
depth      12     0.1 m, 0 … 409.5 m
duration   10     4 s, up to 4092 s; of what lasts, at least one step. Track number of `Follow`
radius     8      0.5 m, 0.5 … 127.5 m
speed      7      0.05 m/s, 0.05 … 6.35 m/s
zeros      3
=========  =====  ====================================================================

=========  =====  ====================================================================
echo       bits   unit
=========  =====  ====================================================================
type       4      4
to         4      place in the team, modulo 16, of the order's sender
number     8      of the order
hash       24     of the order's bytes: whoever echoes it has read every bit of it
status     4      place in `STATUSES`
reason     4      place in `REASONS`
=========  =====  ====================================================================
"""

import hashlib
import math
from typing import Literal, NamedTuple

from grex_link.errors import WireError
from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface, Task
from grex_link.wire import compiled

ORDER_BYTES = 12
ECHO_BYTES = 6
KINDS: tuple[type[Task], ...] = (GoTo, Follow, Hold, Inspect, Surface, Return)
Status = Literal["started", "refused", "done", "interrupted", "returned"]
STATUSES: tuple[Status, ...] = ("started", "refused", "done", "interrupted", "returned")
#: Why a task is refused.
REASONS = ("", "speed", "radius", "depth", "tracks", "no_fix", "cable")
POSITION_STEP_M = 0.125
DEPTH_STEP_M = 0.1
TIME_STEP_S = 4.0
RADIUS_STEP_M = 0.5
SPEED_STEP_MPS = 0.05

_THEN: tuple[Literal["return", "surface", "hold"], ...] = ("return", "surface", "hold")
_SHAPES: tuple[Literal["circle", "box"], ...] = ("circle", "box")
_ORDER_TYPE, _ECHO_TYPE = 3, 4
_ORDER = compiled("u4u4u8u3u2u1s17s17u12u10u8u7u3")
_ECHO = compiled("u4u4u8u24u4u4")


class Order(NamedTuple):
    """An order as it travels: for whom (place in the team, modulo 16), its number, and the task."""

    to: int
    number: int
    task: Task


class Echo(NamedTuple):
    """What the receiver of an order says of it; see the module's docstring."""

    to: int
    number: int
    hash: int
    status: Status
    reason: str = ""


def is_task_mail(payload: bytes) -> bool:
    """Whether a payload is an order or an echo, by its length and type."""
    kind = payload[0] >> 4 if payload else 0
    return (len(payload), kind) in {(ORDER_BYTES, _ORDER_TYPE), (ECHO_BYTES, _ECHO_TYPE)}


def is_order(payload: bytes) -> bool:
    """Whether task mail is an order."""
    return len(payload) == ORDER_BYTES


def hash_of(payload: bytes) -> int:
    """24 bits of the SHA-256 of an order's bytes."""
    return int.from_bytes(hashlib.sha256(payload).digest()[:3], "big")


def pack_order(order: Order) -> bytes:
    """Pack an order.

    Raises
    ------
    WireError
        For a place outside ±8192 m or above the water, or a value that does not fit: a craft would do something else.
    """
    task = order.task
    at = getattr(task, "at_ned_m", (0.0, 0.0, 0.0))
    north, east = (_steps(axis, value, POSITION_STEP_M, -65535, 65535) for axis, value in zip(("north", "east"), at[:2], strict=True))  # fmt: skip  # noqa: E501
    lasting = task.track if isinstance(task, Follow) else _duration(getattr(task, "for_s", 0.0))
    packed: bytes = _ORDER.pack(
        _ORDER_TYPE,
        order.to % 16,
        order.number % 256,
        KINDS.index(type(task)),
        _THEN.index(getattr(task, "then", "return")),
        _SHAPES.index(getattr(task, "shape", "circle")),
        north,
        east,
        _steps("depth", at[2], DEPTH_STEP_M, 0, 4095),
        lasting,
        _steps("radius", getattr(task, "radius_m", RADIUS_STEP_M), RADIUS_STEP_M, 1, 255),
        _steps("speed", getattr(task, "speed_mps", SPEED_STEP_MPS), SPEED_STEP_MPS, 1, 127),
        0,
    )
    return packed


def unpack_order(payload: bytes) -> Order:
    """Unpack an order.

    Raises
    ------
    WireError
        If it is none.
    """
    if len(payload) != ORDER_BYTES:
        raise WireError(f"an order has {ORDER_BYTES} bytes, not {len(payload)}")
    kind, to, number, task, then, shape, north, east, depth, lasting, radius, speed, zeros = _ORDER.unpack(payload)
    if kind != _ORDER_TYPE or task >= len(KINDS) or then >= len(_THEN) or zeros or radius == 0 or speed == 0:
        raise WireError("this is not an order")
    at = north * POSITION_STEP_M, east * POSITION_STEP_M, depth * DEPTH_STEP_M
    speed_mps, for_s = speed * SPEED_STEP_MPS, lasting * TIME_STEP_S
    order = Order(to, number, _task(task, at, speed_mps, for_s, lasting, radius * RADIUS_STEP_M, _SHAPES[shape], then))
    if pack_order(order) != payload:
        raise WireError("this is not an order: it says what its kind of task does not have")
    return order


def pack_echo(echo: Echo) -> bytes:
    """Pack an echo."""
    status, reason = STATUSES.index(echo.status), REASONS.index(echo.reason)
    packed: bytes = _ECHO.pack(_ECHO_TYPE, echo.to % 16, echo.number % 256, echo.hash, status, reason)
    return packed


def unpack_echo(payload: bytes) -> Echo:
    """Unpack an echo.

    Raises
    ------
    WireError
        If it is none.
    """
    if len(payload) != ECHO_BYTES:
        raise WireError(f"an echo has {ECHO_BYTES} bytes, not {len(payload)}")
    kind, to, number, its_hash, status, reason = _ECHO.unpack(payload)
    if kind != _ECHO_TYPE or status >= len(STATUSES) or reason >= len(REASONS):
        raise WireError("this is not an echo")
    return Echo(to, number, its_hash, STATUSES[status], REASONS[reason])


def _task(
    kind: int,
    at: tuple[float, float, float],
    speed_mps: float,
    for_s: float,
    track: int,
    radius_m: float,
    shape: Literal["circle", "box"],
    then: int,
) -> Task:
    if KINDS[kind] is Inspect:
        if not for_s:
            raise WireError("this is not an order: an inspection that does not last")
        return Inspect(at, for_s, radius_m, shape, speed_mps, _THEN[then])
    if KINDS[kind] is Follow and track > 255:
        raise WireError(f"this is not an order: there is no track {track}")
    made: dict[type[Task], Task] = {
        GoTo: GoTo(at, speed_mps),
        Follow: Follow(track, speed_mps),
        Hold: Hold(for_s),
        Surface: Surface(for_s, speed_mps),
        Return: Return(speed_mps),
    }
    return made[KINDS[kind]]


def _duration(for_s: float) -> int:
    """Count the steps of a duration: what lasts at all is never rounded to nothing, which would be for ever."""
    steps = _steps("duration", for_s, TIME_STEP_S, 0, 1023)
    return max(steps, 1) if for_s > 0.0 else steps


def _steps(name: str, value: float, step: float, least: int, most: int) -> int:
    steps = round(value / step) if math.isfinite(value) else most + 1
    if not least <= steps <= most:
        raise WireError(f"{name} {value:g} does not fit into an order: {least * step:g} … {most * step:g} would")
    return steps
