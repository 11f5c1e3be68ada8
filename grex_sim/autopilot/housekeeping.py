"""What an autopilot tells of itself that no navigation is made of: health, battery, pressure, version."""

from grex_sim.autopilot.brain import Brain

Fields = dict[str, object] | None

_CAPABILITIES = 0x0002 | 0x0004 | 0x0008 | 0x0080 | 0x0100 | 0x2000
"""Float parameters, COMMAND_INT, attitude, local and global set-points, MAVLink 2: what is really there."""
_G = 9.80665


def boot_ms(brain: Brain, now_s: float) -> int:
    """Milliseconds since the last start."""
    return int(max(0.0, brain.boot.age_s(now_s)) * 1000.0) & 0xFFFFFFFF


def sys_status(brain: Brain, now_s: float) -> Fields:
    """SYS_STATUS."""
    del now_s
    gyro_accelerometer_compass, gps, prearm = 0x07, 0x20, 0x10000000
    healthy = gyro_accelerometer_compass | (gps | prearm if brain.estimator.aiding else 0)
    present = gyro_accelerometer_compass | gps | prearm
    return {
        "onboard_control_sensors_present": present,
        "onboard_control_sensors_enabled": present,
        "onboard_control_sensors_health": healthy,
        "load": 120,
        "voltage_battery": 12600,
        "current_battery": 300,
        "battery_remaining": 95,
    }


def battery(brain: Brain, now_s: float) -> Fields:
    """BATTERY_STATUS."""
    del brain, now_s
    return {
        "temperature": 32767,
        "voltages": [12600] + [65535] * 9,
        "current_battery": 300,
        "current_consumed": -1,
        "energy_consumed": -1,
        "battery_remaining": 95,
    }


def pressure(brain: Brain, now_s: float) -> Fields:
    """SCALED_PRESSURE."""
    depth_hpa = 1025.0 * _G * brain.estimator.belief.down_m / 100.0
    return {"time_boot_ms": boot_ms(brain, now_s), "press_abs": 1013.25 + depth_hpa, "temperature": 1500}


def raw_imu(brain: Brain, now_s: float) -> Fields:
    """RAW_IMU."""
    return {"time_usec": round(max(0.0, brain.boot.age_s(now_s)) * 1e6), "zacc": -1000}


def landed(brain: Brain, now_s: float) -> Fields:
    """EXTENDED_SYS_STATE."""
    del now_s
    return {"vtol_state": 0, "landed_state": 2 if brain.modes.armed else 1}


def named_value(brain: Brain, now_s: float) -> Fields:
    """NAMED_VALUE_FLOAT, of which a Sub sends many."""
    return {"time_boot_ms": boot_ms(brain, now_s), "name": "PilotGain", "value": 0.5}


def version(brain: Brain, now_s: float) -> Fields:
    """AUTOPILOT_VERSION."""
    del now_s
    major, minor, patch = brain.family.version
    if brain.settings.firmware:
        major, minor, patch = int(brain.settings.firmware.split(".")[0]), int(brain.settings.firmware.split(".")[1]), 0
    return {
        "capabilities": _CAPABILITIES,
        "flight_sw_version": major << 24 | minor << 16 | patch << 8 | 255,
        "flight_custom_version": list(b"grexsim\0"),
        "uid": 0x67726578 << 8 | brain.settings.system,
    }


def timed(brain: Brain, now_s: float) -> Fields:
    """Messages of which only the time is true here."""
    return {"time_boot_ms": boot_ms(brain, now_s)}


def constant(brain: Brain, now_s: float) -> Fields:
    """Messages that are only there because a real one sends them."""
    del brain, now_s
    return {}
