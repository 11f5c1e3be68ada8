"""Feeds positions into an autopilot that has no GPS: a craft under water that is told where it is by sound.

They come on the bus, as fixes in the mission frame on ``{craft}/nav``, from whatever process navigates the craft.
"""

import math
from typing import Literal

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.geodesy import to_degrees, to_mission
from grex_agent.frontseat.overground import OverGround, Velocity
from grex_link.config import DatumConfig
from grex_link.messages import Fix
from grex_link.units import NS

RATE_HZ = 5.0
#: A fix older than this is not fed any more: the autopilot must know that there is none.
_AGE_MAX_S = 4.0
_GPS_EPOCH_S = 315_964_800
_WEEK_S = 604_800
#: GPS is ahead of UTC by the leap seconds since 1980.
_LEAP_S = 18
#: The velocity over ground is not among them: an ArduPilot takes one that is left out for zero, and fuses it.
_NO_ALTITUDE_OR_VERTICAL = (
    mavlink.GPS_INPUT_IGNORE_FLAG_ALT
    | mavlink.GPS_INPUT_IGNORE_FLAG_VEL_VERT
    | mavlink.GPS_INPUT_IGNORE_FLAG_VERTICAL_ACCURACY
)
#: Roll and pitch are told as 0, which a craft under way keeps to some ten degrees; a compass in a hull of steel and
#: currents is no better. It is also the least that an ArduPilot believes of a yaw from outside (VISO_YAW_M_NSE).
_ATTITUDE_SIGMA_RAD = 0.2


class Feeder:
    """Turns fixes into GPS_INPUT or VISION_POSITION_ESTIMATE.

    Parameters
    ----------
    kind : str
        ``gps_input`` or ``vision``.
    datum : DatumConfig
        Origin of the mission frame.
    unix_offset_ns : int
        Wall time minus the time that is given to `due`.
    """

    def __init__(self, kind: Literal["gps_input", "vision"], datum: DatumConfig, unix_offset_ns: int) -> None:
        self._kind = kind
        self._datum = datum
        self._unix_offset_ns = unix_offset_ns
        self._fix: Fix | None = None
        self._fix_s = 0.0
        self._over_ground = OverGround()
        self._origin: DatumConfig | None = None

    def on_fix(self, fix: Fix, now_s: float, rate: float) -> None:
        """Take a position; one that is not valid ends the feeding.

        Parameters
        ----------
        fix : Fix
            In the mission frame.
        now_s : float
            Our time.
        rate : float
            Seconds of the autopilot in one of ours.
        """
        numbers = fix.north_m + fix.east_m + fix.down_m + fix.heading_rad + fix.speed_mps + fix.sigma_m
        passed_s = (now_s - self._fix_s) * rate
        self._fix = fix if fix.valid and math.isfinite(numbers) else None
        self._fix_s = now_s
        if self._fix is None or passed_s > _AGE_MAX_S:
            self._over_ground.reset()
        if self._fix is not None:
            self._over_ground.on_fix(self._fix, passed_s)

    def on_origin(self, message: Mavlink) -> None:
        """Take GPS_GLOBAL_ORIGIN: vision is told about the autopilot's own origin."""
        if message.latitude or message.longitude:
            self._origin = DatumConfig(message.latitude / 1e7, message.longitude / 1e7)

    @property
    def needs_origin(self) -> bool:
        """Whether the autopilot has to be asked for its origin, or given one."""
        return self._kind == "vision" and self._origin is None

    def origin(self, system: int) -> Mavlink:
        """Message that gives the autopilot the datum as its origin; it is ignored when there is one."""
        return mavlink.MAVLink_set_gps_global_origin_message(
            system, round(self._datum.latitude_deg * 1e7), round(self._datum.longitude_deg * 1e7), 0
        )

    def due(self, now_s: float, rate: float) -> Mavlink | None:
        """Return the message for now, carried on by the velocity over ground; None without a fresh fix.

        A GPS has a velocity: GPS_INPUT begins when the positions have shown one.
        """
        fix, over_ground = self._fix, self._over_ground.velocity
        age_s = (now_s - self._fix_s) * rate
        if fix is None or age_s > _AGE_MAX_S or (self._kind == "vision" and self._origin is None):
            return None
        bow = fix.speed_mps * math.cos(fix.heading_rad), fix.speed_mps * math.sin(fix.heading_rad)
        velocity = over_ground or Velocity(*bow, math.inf)
        north_m, east_m = fix.north_m + age_s * velocity.north_mps, fix.east_m + age_s * velocity.east_mps
        now_ns = round(now_s * NS)
        if self._kind == "vision":
            # A PX4 places it by our answers to its TIMESYNC, which are on the same clock.
            return self._vision(fix, north_m, east_m, now_ns)
        if over_ground is None:
            return None
        return self._gps_input(fix, (north_m, east_m), over_ground, self._unix_offset_ns + now_ns)

    def _vision(self, fix: Fix, north_m: float, east_m: float, now_ns: int) -> Mavlink:
        assert self._origin is not None  # noqa: S101 - `due` has looked
        x, y = to_mission(self._origin, *to_degrees(self._datum, north_m, east_m))
        variance = fix.sigma_m**2
        covariance = [math.nan] * 21
        # The upper triangle, row by row: x, y, z, roll, pitch, yaw. An ArduPilot that finds the first a number adds up
        # all six: one NaN among them is an internal error of its estimator.
        covariance[0] = covariance[6] = covariance[11] = variance
        covariance[15] = covariance[18] = covariance[20] = _ATTITUDE_SIGMA_RAD**2
        return mavlink.MAVLink_vision_position_estimate_message(
            now_ns // 1000, x, y, fix.down_m, 0.0, 0.0, fix.heading_rad, covariance, 0
        )

    def _gps_input(self, fix: Fix, place_m: tuple[float, float], over_ground: Velocity, unix_ns: int) -> Mavlink:
        latitude, longitude = to_degrees(self._datum, *place_m)
        gps_ms = unix_ns // 1_000_000 - (_GPS_EPOCH_S - _LEAP_S) * 1000
        week, week_ms = divmod(gps_ms, _WEEK_S * 1000)
        return mavlink.MAVLink_gps_input_message(
            unix_ns // 1000,
            0,
            _NO_ALTITUDE_OR_VERTICAL,
            week_ms,
            week,
            mavlink.GPS_FIX_TYPE_3D_FIX,
            round(latitude * 1e7),
            round(longitude * 1e7),
            0.0,
            1.0,
            1.0,
            *(over_ground.north_mps, over_ground.east_mps, 0.0),
            over_ground.sigma_mps,
            max(fix.sigma_m, 0.1),
            0.0,
            10,
        )
