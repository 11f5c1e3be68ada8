"""What one family of autopilots is to the adapter: numbers of its modes, and how it wants its set-points."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.families.settings import Frame, Setting

#: Velocity only: position, acceleration, yaw and yaw rate are ignored, vz is *not*. Leaving vz out as well, the habit
#: of boats, is obeyed by some firmwares and dropped by others without a word.
VELOCITY_ONLY = 0x0DC7
#: The same with a yaw: of a craft that goes sideways as well, and of one that stands still.
VELOCITY_AND_YAW = 0x09C7
#: A speed of zero has no direction, and without a yaw a boat would turn north.
_STANDSTILL_MPS = 0.001


@dataclass(frozen=True, slots=True)
class Order:
    """What the craft shall do now.

    Attributes
    ----------
    course_rad, speed_mps : float
        Over ground; speed 0 is standing still.
    depth_m : float
        Wanted.
    at_depth_m : float
        Where it is.
    """

    course_rad: float = 0.0
    speed_mps: float = 0.0
    depth_m: float = 0.0
    at_depth_m: float = 0.0


#: (order, autopilot's time since boot in ms, system, component) → the set-point
Encode = Callable[[Order, int, int, int], Mavlink]


def velocity(
    order: Order, down_mps: float, time_boot_ms: int, system: int, component: int, *, with_yaw: bool = False
) -> Mavlink:
    """Velocity set-point in NED axes; its origin does not matter. With a yaw it also says where the bow is to be."""
    speed_mps = order.speed_mps if with_yaw else max(order.speed_mps, _STANDSTILL_MPS)
    north, east = speed_mps * math.cos(order.course_rad), speed_mps * math.sin(order.course_rad)
    return mavlink.MAVLink_set_position_target_local_ned_message(
        time_boot_ms,
        system,
        component,
        mavlink.MAV_FRAME_LOCAL_NED,
        VELOCITY_AND_YAW if with_yaw else VELOCITY_ONLY,
        *(0.0, 0.0, 0.0),
        *(north, east, down_mps),
        *(0.0, 0.0, 0.0),
        *(order.course_rad if with_yaw else 0.0, 0.0),
    )


def along_the_surface(order: Order, time_boot_ms: int, system: int, component: int) -> Mavlink:
    """Set-point of a craft that floats."""
    return velocity(order, 0.0, time_boot_ms, system, component)


@dataclass(frozen=True, slots=True)
class Family:
    """One family; see the module's docstring.

    Attributes
    ----------
    name : str
        What a scenario calls it.
    title : str
        What a person calls it.
    autopilot : int
        MAV_AUTOPILOT of its heartbeat.
    types : frozenset of int
        MAV_TYPE of its heartbeat; empty for all.
    modes : mapping of int to str
        Its custom modes that have to do with us.
    guided : int
        The mode in which it obeys set-points.
    holds : tuple of int
        Modes in which it keeps the craft safe by itself; the first is asked for, then the next.
    encode : callable
        Makes its set-point.
    estimator : int
        Message with the flags of its estimator.
    under_water : bool
        Whether it has a depth.
    streams_before : bool
        Whether it wants set-points before the mode that obeys them.
    returns_by_itself : bool
        Whether it leaves ``guided`` when set-points stop, and comes back by itself when they go on.
    trims_speed : bool
        Whether it makes good another speed than it is asked for, so that the adapter has to close that loop.
    feeds : tuple of str
        How it can be told where it is.
    frame : Frame
        What kind of craft it takes itself to be on.
    settings : tuple of Setting
        Its parameters that a person should look at before trusting it with a craft.
    """

    name: str
    title: str
    autopilot: int
    types: frozenset[int]
    modes: Mapping[int, str]
    guided: int
    holds: tuple[int, ...]
    frame: Frame
    encode: Encode = along_the_surface
    estimator: int = mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT
    under_water: bool = False
    streams_before: bool = False
    returns_by_itself: bool = False
    trims_speed: bool = False
    feeds: tuple[str, ...] = ("gps_input", "vision")
    settings: tuple[Setting, ...] = ()

    @property
    def bytewise(self) -> bool:
        """Whether integer parameters travel as their bytes."""
        return bool(self.autopilot == mavlink.MAV_AUTOPILOT_PX4)

    def suits(self, heartbeat: Mavlink) -> bool:
        """Whether an autopilot with this heartbeat is of the family."""
        return heartbeat.autopilot == self.autopilot and (not self.types or heartbeat.type in self.types)

    def mode_name(self, custom_mode: int | None) -> str:
        """Name of a mode for a person."""
        return "no mode" if custom_mode is None else self.modes.get(custom_mode, f"mode {custom_mode}")

    def mode_parameters(self, custom_mode: int) -> tuple[float, float, float]:
        """Parameters of DO_SET_MODE: the base mode says that the custom mode counts."""
        if self.autopilot == mavlink.MAV_AUTOPILOT_PX4:
            return 1.0, float(custom_mode >> 16 & 0xFF), float(custom_mode >> 24)
        return 1.0, float(custom_mode), 0.0
