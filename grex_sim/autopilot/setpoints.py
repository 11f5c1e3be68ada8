"""Which set-points a family obeys. Whatever it does not is met with silence: no ACK, no text, ever."""

import math
from collections.abc import Callable

import msgspec

from grex_agent.path import wrap
from grex_link.messages import Pose
from grex_sim.autopilot.family import Family, SetpointRules
from grex_sim.autopilot.message import Frame, Mask, Message

_BODY = (Frame.BODY_NED, Frame.BODY_OFFSET_NED)
_OFFSET = (Frame.LOCAL_OFFSET_NED, Frame.BODY_OFFSET_NED)
#: SET_ATTITUDE_TARGET: the attitude itself is to be ignored; so is thrust.
_NO_ATTITUDE = 0x80
_NO_THRUST = 0x40


class Order(msgspec.Struct, frozen=True):
    """A set-point as it was understood; NED about the start, metres and radians."""

    course_rad: float | None = None
    speed_mps: float = 0.0
    look_rad: float | None = None
    yaw_rate: float | None = None
    down_mps: float = 0.0
    target: tuple[float, float] | None = None
    """Position to go to and stay at."""
    depth_m: float | None = None
    streamed: bool = True
    """Whether it must be repeated."""


Place = tuple[float, float, float]
Locate = Callable[[float, float], tuple[float, float]]


def from_local(message: Message, rules: SetpointRules, pose: Pose, origin: Place) -> Order | None:
    """Understand SET_POSITION_TARGET_LOCAL_NED; None: dropped.

    Parameters
    ----------
    message : Message
        The set-point.
    rules : SetpointRules
        The family's.
    pose : Pose
        Where the craft believes to be, NED about the start.
    origin : tuple of float
        Origin of the autopilot's own local frame, NED about the start.
    """
    frame, mask = message["coordinate_frame"], message["type_mask"]
    if frame not in rules.frames or _accelerates(mask, rules):
        return None
    if mask & Mask.HORIZONTAL == 0:
        target = _placed(message["x"], message["y"], frame, pose, origin)
        depth = None if mask & Mask.Z else message["z"] + (pose.down_m if frame in _OFFSET + _BODY else origin[2])
        return _finite(Order(target=target, depth_m=depth, streamed=rules.positions_streamed))
    return _velocity(message, rules, pose, body=frame in _BODY)


def from_global(
    message: Message, rules: SetpointRules, pose: Pose, locate: Locate, *, depth_only: bool
) -> Order | None:
    """Understand SET_POSITION_TARGET_GLOBAL_INT; altitudes are negative depths."""
    mask = message["type_mask"]
    if _accelerates(mask, rules):
        return None
    if depth_only:
        return None if mask & Mask.Z else _finite(Order(depth_m=-message["alt"]))
    if mask & Mask.HORIZONTAL == 0:
        target = locate(message["lat_int"] * 1e-7, message["lon_int"] * 1e-7)
        depth = None if mask & Mask.Z else -message["alt"]
        return _finite(Order(target=target, depth_m=depth, streamed=rules.positions_streamed))
    return _velocity(message, rules, pose, body=False)


def from_attitude(message: Message, family: Family, *, depth_holding: bool) -> Order | None:
    """Understand SET_ATTITUDE_TARGET: thrust is speed, or up and down, or nothing."""
    mask = message["type_mask"]
    if mask & _NO_ATTITUDE:
        return None
    heading = _yaw_of(message["q"])
    if family.setpoints.attitude == "stop":
        return _finite(Order())
    if family.setpoints.attitude == "speed":
        return _finite(Order(course_rad=heading, speed_mps=message["thrust"] * family.speed_full_mps))
    if depth_holding:
        return _finite(Order(look_rad=heading))
    # Half thrust keeps the depth, less sinks.
    climb = 0.0 if mask & _NO_THRUST else 2.0 * (message["thrust"] - 0.5)
    return _finite(Order(look_rad=heading, down_mps=-climb * family.speed_full_mps))


def _velocity(message: Message, rules: SetpointRules, pose: Pose, *, body: bool) -> Order | None:
    mask = message["type_mask"]
    if mask & rules.velocity_mask or mask & Mask.VELOCITY == Mask.VELOCITY:
        return None
    north, east = message["vx"], message["vy"]
    speed = math.hypot(north, east)
    turn = pose.heading_rad if body else 0.0
    course = wrap(math.atan2(east, north) + turn) if speed > 1e-6 else None
    yaw = None if mask & Mask.YAW else wrap(message["yaw"] + turn)
    rate = None if mask & Mask.YAW_RATE else message["yaw_rate"]
    down = 0.0 if mask & Mask.VZ else message["vz"]
    if rules.yaw == "ignored":
        return _finite(Order(course, speed))
    if rules.yaw == "look":
        return _finite(Order(course, speed, look_rad=yaw, yaw_rate=rate, down_mps=down))
    if yaw is not None:
        return _finite(Order(yaw, math.copysign(speed, north)))
    if rate is not None:
        return _finite(Order(pose.heading_rad, math.copysign(speed, north), yaw_rate=rate))
    return _finite(Order(course, speed))


def _placed(x: float, y: float, frame: int, pose: Pose, origin: Place) -> tuple[float, float]:
    if frame not in _OFFSET + _BODY:
        return x + origin[0], y + origin[1]
    if frame in _BODY:
        ahead, side = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        x, y = x * ahead - y * side, x * side + y * ahead
    return pose.north_m + x, pose.east_m + y


def _accelerates(mask: int, rules: SetpointRules) -> bool:
    return rules.acceleration_ignored and mask & Mask.ACCELERATION != Mask.ACCELERATION


def _yaw_of(q: list[float]) -> float:
    w, x, y, z = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _finite(order: Order) -> Order | None:
    """Drop what no autopilot can steer by."""
    target = order.target or (0.0, 0.0)
    values = (order.course_rad, order.speed_mps, order.look_rad, order.yaw_rate, order.down_mps, order.depth_m, *target)
    return order if all(math.isfinite(value) for value in values if value is not None) else None
