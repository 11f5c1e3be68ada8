"""ArduPilot Sub 4.6 on a vectored frame, as measured."""

from grex_link.config import Loop, VehicleConfig
from grex_sim.autopilot.family import BootTimes, Family, GcsRules, LossTimes, Mode, SetpointRules
from grex_sim.autopilot.message import Frame, Mask, Result
from grex_sim.autopilot.parameters import ARDUPILOT

_STREAMS = (
    "SYS_STATUS POWER_STATUS MEMINFO MISSION_CURRENT NAV_CONTROLLER_OUTPUT SERVO_OUTPUT_RAW RC_CHANNELS RAW_IMU "
    "SCALED_PRESSURE SIMSTATE VFR_HUD SYSTEM_TIME EKF_STATUS_REPORT BATTERY_STATUS"
)

FAMILY = Family(
    name="sub",
    vehicle_type=12,
    autopilot=3,
    version=(4, 6, 0),
    modes=(
        Mode("STABILIZE", 0, "manual"),
        Mode("ACRO", 1, "manual"),
        Mode("ALT_HOLD", 2, "depth"),
        Mode("GUIDED", 4, "guided", needs_position=True),
        Mode("SURFACE", 9, "surface", needs_position=True),
        Mode("POSHOLD", 16, "point", needs_position=True),
        Mode("MANUAL", 19, "manual"),
    ),
    first_mode="MANUAL",
    boot_mode="MANUAL",
    guided="GUIDED",
    hold="ALT_HOLD",
    point="POSHOLD",
    boot=BootTimes(
        console_lines=5,
        heartbeat_s=1.0,
        settled_s=1.0,
        position_s=40.0,
        before="home",
        clock_s=9.7,
        arm_s=1.0,
        ready_s=40.0,
    ),
    loss=LossTimes(
        fix_s=2.0,
        aiding_s=14.0,
        lie="frozen",
        lie_s=0.0,
        text="EKF3 IMU0 stopped aiding",
        failsafe_s=None,
    ),
    setpoints=SetpointRules(
        velocity_mask=Mask.VELOCITY | Mask.VZ,
        acceleration_ignored=True,
        frames=(Frame.LOCAL_NED, Frame.LOCAL_OFFSET_NED, Frame.BODY_NED, Frame.BODY_OFFSET_NED),
        yaw="look",
        attitude="depth",
        on_timeout="silence",
    ),
    gcs=GcsRules(
        enable="FS_GCS_ENABLE",
        # Only disarming was measured.
        actions=((2, "disarm"), (3, "ALT_HOLD"), (4, "SURFACE")),
        timeout="FS_GCS_TIMEOUT",
        extra_s=1.0,
        lost_text="MYGCS: 255, heartbeat lost",
        back_text="GCS Failsafe Cleared",
    ),
    parameters=(
        *ARDUPILOT,
        ("WPNAV_SPEED", "f32", 100.0),
        ("PILOT_SPEED_DN", "i16", 150),
        ("SURFACE_DEPTH", "f32", -10.0),
        ("FS_GCS_ENABLE", "i8", 2),
        ("FS_GCS_TIMEOUT", "f32", 5.0),
        ("FS_PILOT_INPUT", "i8", 2),
        ("FS_PILOT_TIMEOUT", "f32", 3.0),
        ("FRAME_CONFIG", "i8", 1),
        ("ARMING_CHECK", "i32", 1),
        ("SCHED_LOOP_RATE", "i16", 400),
    ),
    streams=dict.fromkeys(_STREAMS.split(), 1.0)
    | {"ATTITUDE": 10.0, "GLOBAL_POSITION_INT": 3.0, "GPS_RAW_INT": 2.0, "NAMED_VALUE_FLOAT": 17.0},
    rate_max_hz=320.0,
    unknown_interval=Result.DENIED,
    ack_s=(0.001, 0.028),
    timesync_s=0.0056,
    dives=True,
    gps_parameter="SIM_GPS_DISABLE",
    gps_good=0,
    external_fix=(("GPS1_TYPE", 14), ("EK3_SRC1_POSXY", 6)),
    external_messages=("GPS_INPUT", "VISION_POSITION_ESTIMATE"),
    clock_ppm=-400.0,
    vehicle=VehicleConfig(
        heading=Loop(lag_s=0.8, min=-1e9, max=1e9, rate_max=0.8),
        surge=Loop(lag_s=1.0, min=0.0, max=1.5, rate_max=0.5),
        # Asked for 0.5 m/s it was seen to make 0.39.
        speed_error_relative=-0.2,
    ),
    speed_full_mps=1.5,
)
