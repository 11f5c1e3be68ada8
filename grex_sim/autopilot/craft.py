"""The craft under the autopilot: our simulated vehicle, and what an autopilot's craft does besides."""

import math

import msgspec

from grex_agent.path import wrap
from grex_link.config import CraftConfig, SeaConfig
from grex_link.messages import Pose, Setpoint
from grex_sim.autopilot.family import Family
from grex_sim.vehicle import LagLoop, Vehicle

STEP_S = 0.02
_CLIMB_LAG_S = 0.4
_CLIMB_MAX_MPS = 1.5
_CLIMB_RATE_MPS2 = 1.5
_DEPTH_GAIN = 0.8


class Drive(msgspec.Struct, frozen=True):
    """What the autopilot makes of its mode and its orders."""

    course_rad: float | None = None
    """Course over ground; None: the thrusters for it stop."""
    speed_mps: float = 0.0
    """Negative: astern, with `course_rad` as heading."""
    look_rad: float | None = None
    """Heading, for craft that can go sideways."""
    down_mps: float = 0.0
    """Vertical velocity, for craft that dive."""
    depth_m: float | None = None
    """Depth to go to, instead."""


class Craft:
    """The craft in its water.

    Parameters
    ----------
    who : str
        Its name.
    family : Family
        Its loops and limits.
    heading_rad : float
        At the start, which is (0, 0, 0).
    current_ned_mps : tuple of float
        Current; while armed the craft makes good its course against it.
    wind_ned_mps : tuple of float
        Drift before the wind while disarmed.
    """

    def __init__(
        self,
        who: str,
        family: Family,
        heading_rad: float,
        current_ned_mps: tuple[float, float, float],
        wind_ned_mps: tuple[float, float],
    ) -> None:
        self._family = family
        config = CraftConfig(vehicle=family.vehicle)
        sea = SeaConfig(current_ned_mps=current_ned_mps)
        self._who, self._wind = who, wind_ned_mps
        self._vehicle = Vehicle(who, config, sea, (0.0, 0.0, 0.0, heading_rad), 0.0, STEP_S)
        self._yaw = LagLoop(family.vehicle.heading, STEP_S)
        self._climb = LagLoop(
            msgspec.structs.replace(family.vehicle.surge, lag_s=_CLIMB_LAG_S, rate_max=_CLIMB_RATE_MPS2), STEP_S
        )
        self._time_s = 0.0
        self.heading_rad, self.yaw_rate = heading_rad, 0.0
        self._look_rad = heading_rad
        self.velocity = (0.0, 0.0, 0.0)
        self.speed_max_mps = math.inf

    @property
    def truth(self) -> Pose:
        """True state, NED about the start."""
        ship = self._vehicle
        north, east, down = ship.north_m, ship.east_m, ship.down_m
        return Pose(self._who, north, east, down, ship.roll_rad, ship.pitch_rad, self.heading_rad, ship.surge_mps)

    @property
    def speed_mps(self) -> float:
        """Speed over ground."""
        return math.hypot(self.velocity[0], self.velocity[1])

    def step(self, drive: Drive, *, armed: bool) -> None:
        """Move one step of `STEP_S`."""
        ship = self._vehicle
        before = ship.north_m, ship.east_m, ship.down_m
        self._time_s += STEP_S
        depth = ship.down_m
        ship.step(self._setpoint(drive, depth) if armed else None)
        ship.down_m = depth
        if self._family.dives and armed:
            ship.down_m = max(0.0, depth + STEP_S * self._sink(drive, depth))
        if not armed:
            ship.north_m += self._wind[0] * STEP_S
            ship.east_m += self._wind[1] * STEP_S
        self._turn(drive, armed=armed)
        after = ship.north_m, ship.east_m, ship.down_m
        self.velocity = tuple((new - old) / STEP_S for new, old in zip(after, before, strict=True))  # type: ignore[assignment]

    def _setpoint(self, drive: Drive, depth: float) -> Setpoint | None:
        if drive.course_rad is None:
            return None
        mean, amplitude, period_s = self._family.wobble
        got = mean + amplitude * math.sin(2.0 * math.pi * self._time_s / period_s)
        speed = math.copysign(min(abs(drive.speed_mps) * got, self.speed_max_mps), drive.speed_mps)
        return Setpoint(0, 0, "steer", drive.course_rad, speed, depth)

    def _sink(self, drive: Drive, depth: float) -> float:
        wanted = drive.down_mps if drive.depth_m is None else _DEPTH_GAIN * (drive.depth_m - depth)
        now = self.velocity[2]
        return now + self._climb.change(min(max(wanted, -_CLIMB_MAX_MPS), _CLIMB_MAX_MPS) - now)

    def _turn(self, drive: Drive, *, armed: bool) -> None:
        """Turn to where the craft looks; the bow of one that cannot go sideways is where its vehicle's is."""
        old = self.heading_rad
        if self._family.setpoints.yaw != "look":
            self.heading_rad = self._vehicle.heading_rad
        elif armed:
            if drive.look_rad is not None:
                self._look_rad = drive.look_rad
            elif drive.course_rad is None:
                self._look_rad = old
            wanted = self._look_rad  # not the course: without an order to look it goes sideways
            self.heading_rad = wrap(old + self._yaw.change(wrap(wanted - old)))
        self.yaw_rate = wrap(self.heading_rad - old) / STEP_S
