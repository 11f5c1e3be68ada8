"""Where the craft is, by what its autopilot says, and whether that may be believed.

An autopilot whose navigation is lost goes on telling a global position, frozen or running on for minutes. Its word
counts only while its estimator claims an absolute position, its GPS has a fix, and LOCAL_POSITION_NED, which falls
silent first, keeps coming. The autopilot's own local origin is of no use: it lies where that estimator was started.
Nor does a position count that is far from the datum: then that is not this mission's, and every course is wrong.
"""

import math
from dataclasses import dataclass, replace

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.geodesy import distance_m, say_distance, to_mission
from grex_agent.frontseat.outputs import Estimate
from grex_agent.frontseat.timesync import BootClock, older
from grex_agent.path import wrap
from grex_link.config import DatumConfig

#: Oldest that a position and the sign of life of the local position may be, seconds of the autopilot.
_POSITION_MAX_S = 1.5
_LOCAL_MAX_S = 1.5
#: And it is carried on by its velocity for no longer than this.
_CARRY_MAX_S = 5.0
_FLAGS_MAX_S = 3.0
_GPS_MAX_S = 5.0
_ABSOLUTE = mavlink.EKF_POS_HORIZ_ABS
_CONSTANT = mavlink.EKF_CONST_POS_MODE
#: Farther from the datum is nobody in this mission: a team state reaches 8.2 km from it (`grex_link.wire`), and there
#: the plane of the mission frame leaves the sea by 30 m. A wrong datum is off by far more.
_AWAY_MAX_M = 20_000.0
_FIX_3D = mavlink.GPS_FIX_TYPE_3D_FIX
_HEADING_UNKNOWN = 65535
_EPH_UNKNOWN = 65535
#: Standard deviation of each axis for a horizontal dilution of 1, and when nothing is said.
_SIGMA_PER_HDOP_M = 1.5
_SIGMA_UNKNOWN_M = 3.0


@dataclass(frozen=True, slots=True)
class _Position:
    measured_s: float
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    heading_rad: float | None
    latitude_deg: float
    longitude_deg: float
    away_m: float
    """Distance from the datum."""

    @property
    def nowhere(self) -> bool:
        """Whether the autopilot has not found itself yet."""
        return self.latitude_deg == self.longitude_deg == 0.0


class Navigation:
    """See the module's docstring. Times are ours, ages are in the autopilot's seconds.

    Parameters
    ----------
    datum : DatumConfig or None
        Origin of the mission frame. Without one the craft may be anywhere, and its north and east are 0.
    needs_gps : bool
        Whether a GPS fix is asked for; not when the position comes from elsewhere.
    under_water : bool
        Whether the craft has a depth.
    """

    def __init__(self, datum: DatumConfig | None, *, needs_gps: bool = True, under_water: bool = False) -> None:
        self._datum = datum
        self._needs_gps = needs_gps
        self._under_water = under_water
        self.reset()

    def reset(self) -> None:
        """Forget everything: the autopilot has booted."""
        self._position: _Position | None = None
        self._local_s: float | None = None
        self._depth_m = self._down_mps = 0.0
        self._yaw: tuple[float, float] | None = None
        self.flags: tuple[float, int] | None = None
        self.gps: tuple[float, int] | None = None
        self._gps_sigma_m: float | None = None
        self._estimator_sigma_m: float | None = None

    @property
    def depth_m(self) -> float:
        """Depth now; 0 for a craft that floats."""
        return self._depth_m

    @property
    def place(self) -> tuple[float, float] | None:
        """Latitude and longitude as they were last told, degrees; None before."""
        position = self._position
        return None if position is None or position.nowhere else (position.latitude_deg, position.longitude_deg)

    @property
    def misplaced(self) -> str:
        """What is wrong with the datum, if the craft is too far from it; else empty."""
        if self._position is None or self._position.nowhere or self._position.away_m <= _AWAY_MAX_M:
            return ""
        away = say_distance(self._position.away_m)
        return f"the autopilot is {away} from the datum; set [datum] to where the mission is"

    @property
    def away_m(self) -> float:
        """Distance from the datum, metres; 0 before a position is known, and without a datum."""
        return 0.0 if self._position is None else self._position.away_m

    @property
    def velocity_mps(self) -> tuple[float, float] | None:
        """Velocity over ground north and east, m/s, as it was last told; None before."""
        return None if self._position is None else (self._position.north_mps, self._position.east_mps)

    def on_message(self, message: Mavlink, now_s: float, boot: BootClock) -> None:
        """Take a message of the autopilot."""
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            self._on_global(message, boot.ours_s(message.time_boot_ms / 1e3) if boot.known else now_s)
        elif kind == "LOCAL_POSITION_NED":
            self._local_s = now_s
            if self._under_water:
                # Its zero is where the depth sensor was set to zero: the surface.
                self._depth_m, self._down_mps = message.z, message.vz
        elif kind == "ATTITUDE":
            self._yaw = now_s, message.yaw
        elif kind in {"EKF_STATUS_REPORT", "ESTIMATOR_STATUS"}:
            self.flags = now_s, message.flags
            accuracy = getattr(message, "pos_horiz_accuracy", 0.0)
            self._estimator_sigma_m = accuracy / math.sqrt(2.0) if accuracy > 0.0 else None
        elif kind == "GPS_RAW_INT":
            self._on_gps(message, now_s)

    def at(self, at_s: float, now_s: float, rate: float) -> Estimate:
        """Find where the craft is at a time, carried there by its velocity from when it was measured.

        Parameters
        ----------
        at_s : float
            The time asked for, ours.
        now_s : float
            The time now, ours.
        rate : float
            Seconds of the autopilot in one of ours.
        """
        position = self._position
        if position is None:
            return Estimate(reason="there is no GLOBAL_POSITION_INT yet")
        age_s = (at_s - position.measured_s) * rate
        carried_s = min(max(age_s, -_CARRY_MAX_S), _CARRY_MAX_S)
        heading = position.heading_rad
        if self._yaw is not None and (heading is None or (now_s - self._yaw[0]) * rate <= _POSITION_MAX_S):
            heading = self._yaw[1]
        estimate = Estimate(
            position.north_m + carried_s * position.north_mps,
            position.east_m + carried_s * position.east_mps,
            self._depth_m,
            wrap(heading or 0.0),
            math.hypot(position.north_mps, position.east_mps),
            self._sigma_m(),
            valid=True,
        )
        reason = self._doubt(position, age_s, now_s, rate)
        if not reason and heading is None:
            reason = "its heading is unknown"
        return replace(estimate, valid=False, reason=reason) if reason else estimate

    def _doubt(self, position: _Position, age_s: float, now_s: float, rate: float) -> str:
        if position.nowhere:
            return "the autopilot does not know where it is (latitude 0, longitude 0)"
        if older(age_s / rate, rate, _POSITION_MAX_S):
            return f"the last GLOBAL_POSITION_INT is {age_s:.1f} s old"
        return (
            self._doubt_estimator(now_s, rate)
            or self._doubt_gps(now_s, rate)
            or self._doubt_local(now_s, rate)
            or self.misplaced
        )

    def _doubt_estimator(self, now_s: float, rate: float) -> str:
        if self.flags is None or older(now_s - self.flags[0], rate, _FLAGS_MAX_S):
            return "its estimator says nothing of itself"
        flags = self.flags[1]
        if not flags & _ABSOLUTE:
            return f"its estimator has no position (flags 0x{flags:03x})"
        if flags & _CONSTANT:
            return f"its estimator only holds its position (flags 0x{flags:03x})"
        return ""

    def _doubt_gps(self, now_s: float, rate: float) -> str:
        if not self._needs_gps:
            return ""
        if self.gps is None or older(now_s - self.gps[0], rate, _GPS_MAX_S):
            return "its GPS says nothing"
        return f"its GPS has no fix (type {self.gps[1]})" if self.gps[1] < _FIX_3D else ""

    def _doubt_local(self, now_s: float, rate: float) -> str:
        if self._local_s is None:
            return "there is no LOCAL_POSITION_NED yet"
        if not older(now_s - self._local_s, rate, _LOCAL_MAX_S):
            return ""
        return f"LOCAL_POSITION_NED has been silent for {(now_s - self._local_s) * rate:.1f} s"

    def _on_global(self, message: Mavlink, measured_s: float) -> None:
        place = message.lat / 1e7, message.lon / 1e7
        away_m = 0.0 if self._datum is None else distance_m(self._datum, *place)
        north = east = 0.0
        if self._datum is not None and away_m <= _AWAY_MAX_M:
            north, east = to_mission(self._datum, *place)
        heading = None if message.hdg == _HEADING_UNKNOWN else math.radians(message.hdg / 100.0)
        self._position = _Position(
            measured_s, north, east, message.vx / 100.0, message.vy / 100.0, heading, *place, away_m
        )

    def _on_gps(self, message: Mavlink, now_s: float) -> None:
        self.gps = now_s, message.fix_type
        accuracy_mm = getattr(message, "h_acc", 0)
        if accuracy_mm:
            self._gps_sigma_m = accuracy_mm / 1e3 / math.sqrt(2.0)
        elif message.eph != _EPH_UNKNOWN:
            self._gps_sigma_m = message.eph / 100.0 * _SIGMA_PER_HDOP_M
        else:
            self._gps_sigma_m = None

    def _sigma_m(self) -> float:
        return self._estimator_sigma_m or self._gps_sigma_m or _SIGMA_UNKNOWN_M
