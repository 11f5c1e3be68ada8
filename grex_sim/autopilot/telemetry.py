"""What an autopilot tells: one function a message, from its knowledge to fields; None is silence."""

import math
from collections.abc import Callable

from grex_sim.autopilot import housekeeping
from grex_sim.autopilot.brain import Brain
from grex_sim.autopilot.housekeeping import Fields, boot_ms
from grex_sim.autopilot.message import State

_CUSTOM_MODE, _ARMED, _GUIDED_BIT, _SAFE = 1, 128, 8, 80
_GROUND_TRUTH_S = 0.7


def heartbeat(brain: Brain, now_s: float) -> Fields:
    """HEARTBEAT."""
    mode = brain.modes.mode
    state = State.ACTIVE if brain.modes.armed else State.STANDBY
    if not brain.boot.settled(now_s):
        state = State.CALIBRATING
    elif brain.critical or (brain.modes.armed and not brain.estimator.aiding and brain.family.autopilot == 3):
        state = State.CRITICAL
    return {
        "type": brain.family.vehicle_type,
        "autopilot": brain.family.autopilot,
        "base_mode": _CUSTOM_MODE
        | (_ARMED if brain.modes.armed else 0)
        | (_GUIDED_BIT if mode.kind == "guided" else _SAFE & 64),
        "custom_mode": mode.number,
        "system_status": state,
        "mavlink_version": 3,
    }


def _global(brain: Brain, now_s: float) -> tuple[int, int]:
    """Latitude and longitude as GLOBAL_POSITION_INT has them: nonsense at first, and sometimes a lie."""
    estimator, times = brain.estimator, brain.family.boot
    known = estimator.aiding or estimator.lies or (times.before == "zero" and brain.boot.past(times.position_s, now_s))
    if not known and times.before == "zero":
        return 0, 0
    belief = estimator.belief
    latitude, longitude = brain.place.globe(belief.north_m, belief.east_m) if known else brain.place.globe(0.0, 0.0)
    return round(latitude * 1e7), round(longitude * 1e7)


def _centidegrees(heading_rad: float) -> int:
    return round(math.degrees(heading_rad) * 100.0) % 36000


def global_position(brain: Brain, now_s: float) -> Fields:
    """GLOBAL_POSITION_INT: it always flows, true or not."""
    latitude, longitude = _global(brain, now_s)
    belief = brain.estimator.belief
    home_down = brain.home[2] if brain.home is not None else 0.0
    return {
        "time_boot_ms": boot_ms(brain, now_s),
        "lat": latitude,
        "lon": longitude,
        "alt": round(-belief.down_m * 1000.0),
        "relative_alt": round((home_down - belief.down_m) * 1000.0),
        "vx": round(belief.north_mps * 100.0),
        "vy": round(belief.east_mps * 100.0),
        "vz": round(belief.down_mps * 100.0),
        "hdg": _centidegrees(brain.craft.heading_rad),
    }


def local_position(brain: Brain, now_s: float) -> Fields:
    """LOCAL_POSITION_NED about an origin of its own; silent without a position."""
    origin, belief = brain.estimator.origin, brain.estimator.belief
    if origin is None or not brain.estimator.aiding:
        return None
    return {
        "time_boot_ms": boot_ms(brain, now_s),
        "x": belief.north_m - origin[0],
        "y": belief.east_m - origin[1],
        "z": belief.down_m - origin[2],
        "vx": belief.north_mps,
        "vy": belief.east_mps,
        "vz": belief.down_mps,
    }


def attitude(brain: Brain, now_s: float) -> Fields:
    """ATTITUDE."""
    truth = brain.craft.truth
    return {
        "time_boot_ms": boot_ms(brain, now_s),
        "roll": truth.roll_rad,
        "pitch": truth.pitch_rad,
        "yaw": truth.heading_rad,
        "yawspeed": brain.craft.yaw_rate,
    }


def satellites(brain: Brain) -> bool:
    """Whether there are satellites."""
    return int(brain.parameters.get(brain.family.gps_parameter)) == brain.family.gps_good


def gps_raw(brain: Brain, now_s: float) -> Fields:
    """GPS_RAW_INT."""
    fix = brain.estimator.fix_type(now_s)
    belief, truth = brain.estimator.belief, brain.craft.truth
    latitude, longitude = brain.place.globe(truth.north_m, truth.east_m) if fix >= 2 else (0.0, 0.0)
    return {
        "time_usec": round(max(0.0, brain.boot.age_s(now_s)) * 1e6),
        "fix_type": fix,
        "lat": round(latitude * 1e7),
        "lon": round(longitude * 1e7),
        "eph": 121 if fix >= 2 else 9999,
        "epv": 200 if fix >= 2 else 9999,
        "vel": round(brain.craft.speed_mps * 100.0),
        "cog": round(math.degrees(math.atan2(belief.east_mps, belief.north_mps)) * 100.0) % 36000,
        "satellites_visible": 10 if fix >= 2 else 0,
        "h_acc": 300,
        "v_acc": 300,
    }


def ekf_status(brain: Brain, now_s: float) -> Fields:
    """EKF_STATUS_REPORT of ArduPilot."""
    del now_s
    variance = 0.02 if brain.estimator.aiding else 0.0
    return {
        "flags": int(brain.estimator.flags()),
        "velocity_variance": variance,
        "pos_horiz_variance": variance,
        "pos_vert_variance": variance,
        "compass_variance": variance,
    }


def estimator_status(brain: Brain, now_s: float) -> Fields:
    """ESTIMATOR_STATUS of PX4."""
    return {
        "time_usec": round(max(0.0, brain.boot.age_s(now_s)) * 1e6),
        "flags": int(brain.estimator.flags()),
        "pos_horiz_accuracy": 0.3 if brain.estimator.aiding else 100.0,
        "pos_vert_accuracy": 0.5,
    }


def system_time(brain: Brain, now_s: float) -> Fields:
    """SYSTEM_TIME: no date before there are satellites, and then a little late."""
    dated = brain.boot.past(brain.family.boot.clock_s, now_s)
    unix_s = brain.settings.epoch_unix_s + now_s - _GROUND_TRUTH_S + brain.body.faults.value("jump", now_s)
    return {"time_unix_usec": round(unix_s * 1e6) if dated else 0, "time_boot_ms": boot_ms(brain, now_s)}


def origin(brain: Brain, now_s: float) -> Fields:
    """GPS_GLOBAL_ORIGIN."""
    ned = brain.estimator.origin
    if ned is None:
        return None
    latitude, longitude = brain.place.globe(ned[0], ned[1])
    return {
        "latitude": round(latitude * 1e7),
        "longitude": round(longitude * 1e7),
        "altitude": round(-ned[2] * 1000.0),
        "time_usec": round(max(0.0, brain.boot.age_s(now_s)) * 1e6),
    }


def home(brain: Brain, now_s: float) -> Fields:
    """HOME_POSITION, which is not the origin."""
    del now_s
    if brain.home is None:
        return None
    latitude, longitude = brain.place.globe(brain.home[0], brain.home[1])
    return {
        "latitude": round(latitude * 1e7),
        "longitude": round(longitude * 1e7),
        "altitude": round(-brain.home[2] * 1000.0),
        "q": [1.0, 0.0, 0.0, 0.0],
    }


def sim_state(brain: Brain, now_s: float) -> Fields:
    """SIMSTATE: the truth, as ArduPilot's simulator tells it."""
    del now_s
    truth = brain.craft.truth
    latitude, longitude = brain.place.globe(truth.north_m, truth.east_m)
    return {
        "roll": truth.roll_rad,
        "pitch": truth.pitch_rad,
        "yaw": truth.heading_rad,
        "lat": round(latitude * 1e7),
        "lng": round(longitude * 1e7),
    }


def hud(brain: Brain, now_s: float) -> Fields:
    """VFR_HUD."""
    del now_s
    belief = brain.estimator.belief
    return {
        "airspeed": brain.craft.truth.surge_mps,
        "groundspeed": math.hypot(belief.north_mps, belief.east_mps),
        "heading": round(math.degrees(brain.craft.heading_rad)) % 360,
        "throttle": round(min(100.0, abs(brain.craft.truth.surge_mps) / brain.family.speed_full_mps * 100.0)),
        "alt": -belief.down_m,
        "climb": -belief.down_mps,
    }


def timesync_question(brain: Brain, now_s: float) -> Fields:
    """TIMESYNC as a question of our own."""
    return {"tc1": 0, "ts1": round(brain.boot.age_s(now_s) * 1e9)}


BUILDERS: dict[str, tuple[int, Callable[[Brain, float], Fields]]] = {
    "HEARTBEAT": (0, heartbeat),
    "SYS_STATUS": (1, housekeeping.sys_status),
    "SYSTEM_TIME": (2, system_time),
    "GPS_RAW_INT": (24, gps_raw),
    "RAW_IMU": (27, housekeeping.raw_imu),
    "SCALED_PRESSURE": (29, housekeeping.pressure),
    "ATTITUDE": (30, attitude),
    "LOCAL_POSITION_NED": (32, local_position),
    "GLOBAL_POSITION_INT": (33, global_position),
    "SERVO_OUTPUT_RAW": (36, housekeeping.constant),
    "MISSION_CURRENT": (42, housekeeping.constant),
    "GPS_GLOBAL_ORIGIN": (49, origin),
    "NAV_CONTROLLER_OUTPUT": (62, housekeeping.constant),
    "RC_CHANNELS": (65, housekeeping.timed),
    "VFR_HUD": (74, hud),
    "TIMESYNC": (111, timesync_question),
    "POWER_STATUS": (125, housekeeping.constant),
    "BATTERY_STATUS": (147, housekeeping.battery),
    "AUTOPILOT_VERSION": (148, housekeeping.version),
    "MEMINFO": (152, housekeeping.constant),
    "SIMSTATE": (164, sim_state),
    "EKF_STATUS_REPORT": (193, ekf_status),
    "ESTIMATOR_STATUS": (230, estimator_status),
    "HOME_POSITION": (242, home),
    "EXTENDED_SYS_STATE": (245, housekeeping.landed),
    "NAMED_VALUE_FLOAT": (251, housekeeping.named_value),
}
NAMES = {number: name for name, (number, _) in BUILDERS.items()}
_ONLY = {"EKF_STATUS_REPORT": 3, "SIMSTATE": 3, "ESTIMATOR_STATUS": 12, "EXTENDED_SYS_STATE": 12}
"""Messages that only this autopilot has."""


def name_of(brain: Brain, number: int) -> str | None:
    """Name of a message this autopilot can send; None for all others."""
    name = NAMES.get(number)
    return name if name is None or _ONLY.get(name, brain.family.autopilot) == brain.family.autopilot else None


def build(brain: Brain, name: str, now_s: float) -> Fields:
    """Fields of a message now; None for silence."""
    return BUILDERS[name][1](brain, now_s)
