"""From mode and orders to what the craft does, and what becomes of orders that are not repeated."""

import math

import msgspec

from grex_agent.path import wrap
from grex_link.messages import Pose
from grex_sim.autopilot.craft import Drive
from grex_sim.autopilot.family import Family, Mode
from grex_sim.autopilot.message import Message
from grex_sim.autopilot.setpoints import Order

STOP_TEXT = "target not received last 3secs, stopping"
_ARRIVED_M = 2.0
_SETTLED_MPS = 0.1
#: Above this speed a craft that goes to a place looks there.
_LOOKS_MPS = 0.05
_APPROACH_PER_S = 0.4
_STICKS_S = 3.0
_STICK_LEAD_RAD = 0.8


class Sticks(msgspec.Struct, frozen=True):
    """MANUAL_CONTROL, each from -1 to 1."""

    ahead: float
    down: float
    turn: float


class Control:
    """Steers one start of one craft.

    Parameters
    ----------
    family : Family
        Its rules.
    pose : Pose
        Where it believes to be, NED about the start.

    Attributes
    ----------
    timeout_s : float
        After that long a set-point that must be repeated is void.
    cruise_mps : float or None
        Speed ordered for positions; None: the family's.
    left : bool
        Whether it left the guided mode for want of set-points, and goes back when they come.
    had_position : bool
        Whether the last order was a position.
    """

    def __init__(self, family: Family, pose: Pose) -> None:
        self._family = family
        self._order: Order | None = None
        self._order_s = -math.inf
        self._sticks: Sticks | None = None
        self._sticks_s = -math.inf
        self._mode: Mode | None = None
        self._place: tuple[float, float] | None = None
        self._goal: tuple[float, float] | None = None
        self._entry = pose
        self._depth_m = pose.down_m
        self.timeout_s = family.setpoints.timeout_s
        self.cruise_mps: float | None = None
        self.left = self.had_position = False

    def take(self, order: Order, now_s: float) -> None:
        """Take a set-point that is obeyed."""
        self._order, self._order_s = order, now_s
        self._place = None
        self.had_position = order.target is not None

    def sticks(self, message: Message, now_s: float) -> None:
        """Take MANUAL_CONTROL; for a craft that dives z = 500 is neutral and 0 is full dive."""
        down = (500.0 - message["z"]) / 500.0
        self._sticks, self._sticks_s = Sticks(message["x"] / 1000.0, down, message["r"] / 1000.0), now_s

    def streamed(self, now_s: float) -> bool:
        """Whether set-points are coming."""
        return now_s - self._order_s <= self.timeout_s

    def goto(self, target: tuple[float, float]) -> None:
        """Keep another place, in a mode that keeps one."""
        self._place = self._goal = target

    def _enter(self, pose: Pose) -> None:
        self._entry, self._place, self._depth_m = pose, self._goal, pose.down_m
        self._goal = None

    def step(self, mode: Mode, pose: Pose, speed_mps: float, now_s: float) -> tuple[Drive, str, bool]:
        """Go on to a time; `speed_mps` is that through the water.

        Returns
        -------
        tuple
            What the craft does, a text or nothing, and whether the guided mode is left for want of set-points.
        """
        if mode != self._mode:
            self._mode = mode
            self._enter(pose)
            if mode.kind != "guided" or not self.streamed(now_s):
                self._order = None
        text, leave = self._expire(mode, pose, now_s)
        return self._drive(mode, pose, speed_mps, now_s), text, leave

    # -- orders that end ----------------------------------------------------------------------------------------

    def _expire(self, mode: Mode, pose: Pose, now_s: float) -> tuple[str, bool]:
        rules, order = self._family.setpoints, self._order
        if mode.kind == "guided" and rules.on_timeout == "leave":
            return "", not self.streamed(now_s)
        if order is None or not order.streamed:
            return "", False
        age_s = now_s - self._order_s
        limit_s = rules.heading_timeout_s if mode.kind == "depth" else self.timeout_s
        if age_s <= limit_s:
            return "", False
        self._order = None
        # Depth stays where it got to; the heading is the pilot's again.
        self._depth_m = pose.down_m
        return (STOP_TEXT if rules.on_timeout == "text" and mode.kind == "guided" else ""), False

    # -- what to do ---------------------------------------------------------------------------------------------

    def _drive(self, mode: Mode, pose: Pose, speed_mps: float, now_s: float) -> Drive:
        if mode.kind == "guided":
            return self._guided(pose, speed_mps)
        if mode.kind == "point":
            return self._stay(pose, speed_mps)
        if mode.kind == "home":
            return self._go(pose, (0.0, 0.0), self._depth_m)
        if mode.kind == "surface":
            return Drive(depth_m=0.0)
        if mode.kind == "stop":
            return Drive()
        return self._piloted(mode, pose, now_s)

    def _guided(self, pose: Pose, speed_mps: float) -> Drive:
        order = self._order
        if order is None:
            return self._stay(pose, speed_mps)
        if order.target is not None:
            return self._go(pose, order.target, self._depth_m if order.depth_m is None else order.depth_m)
        course, look = order.course_rad, order.look_rad
        if order.yaw_rate is not None:
            ahead = wrap(pose.heading_rad + order.yaw_rate * self._family.vehicle.heading.lag_s)
            course, look = (course, ahead) if self._family.setpoints.yaw == "look" else (ahead, look)
        self._depth_m = pose.down_m
        return Drive(course, order.speed_mps, look, order.down_mps)

    def _stay(self, pose: Pose, speed_mps: float) -> Drive:
        """Stop first, then keep the place where the craft came to rest."""
        if self._place is None:
            if speed_mps > _SETTLED_MPS:
                return Drive(depth_m=self._depth_m)
            self._place = pose.north_m, pose.east_m
        return self._go(pose, self._place, self._depth_m)

    def _go(self, pose: Pose, target: tuple[float, float], depth_m: float) -> Drive:
        north, east = target[0] - pose.north_m, target[1] - pose.east_m
        away = math.hypot(north, east)
        if away < _ARRIVED_M:
            return Drive(depth_m=depth_m)
        cruise = self.cruise_mps or self._family.speed_full_mps
        course, speed = math.atan2(east, north), min(cruise, _APPROACH_PER_S * away)
        return Drive(course, speed, course if speed > _LOOKS_MPS else None, depth_m=depth_m)

    def _piloted(self, mode: Mode, pose: Pose, now_s: float) -> Drive:
        holds_depth = mode.kind == "depth"
        if self._sticks is not None and now_s - self._sticks_s < _STICKS_S:
            sticks = self._sticks
            self._entry = self._entry if sticks.turn == 0.0 else pose
            course = wrap(pose.heading_rad + sticks.turn * _STICK_LEAD_RAD)
            full = self._family.speed_full_mps
            down = sticks.down * full if self._family.dives else 0.0
            self._depth_m = pose.down_m if down else self._depth_m
            return Drive(course, sticks.ahead * full, course, down, self._depth_m if holds_depth and not down else None)
        if not holds_depth:
            return Drive()
        order = self._order
        if order is not None and order.depth_m is not None:
            self._depth_m = order.depth_m
        look = order.look_rad if order is not None and order.look_rad is not None else self._entry.heading_rad
        return Drive(look_rad=look, depth_m=self._depth_m)
