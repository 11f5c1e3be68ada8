"""ArduPilot Rover 4.6 on a motor boat, as measured."""

from grex_link.config import Loop, VehicleConfig
from grex_sim.autopilot.family import BootTimes, Family, GcsRules, LossTimes, Mode, SetpointRules
from grex_sim.autopilot.message import Frame, Mask, Result
from grex_sim.autopilot.parameters import ARDUPILOT

_STREAMS = (
    "SYS_STATUS POWER_STATUS MEMINFO MISSION_CURRENT GPS_RAW_INT NAV_CONTROLLER_OUTPUT GLOBAL_POSITION_INT "
    "SERVO_OUTPUT_RAW RC_CHANNELS RAW_IMU SCALED_PRESSURE ATTITUDE SIMSTATE VFR_HUD SYSTEM_TIME EKF_STATUS_REPORT "
    "BATTERY_STATUS"
)

FAMILY = Family(
    name="rover",
    vehicle_type=11,
    autopilot=3,
    version=(4, 6, 3),
    modes=(
        Mode("MANUAL", 0, "manual"),
        Mode("ACRO", 1, "manual"),
        Mode("STEERING", 3, "manual"),
        Mode("HOLD", 4, "stop"),
        Mode("LOITER", 5, "point", needs_position=True),
        Mode("RTL", 11, "home", needs_position=True),
        Mode("SMART_RTL", 12, "home", needs_position=True),
        Mode("GUIDED", 15, "guided", needs_position=True),
        Mode("INITIALISING", 16, "stop"),
    ),
    first_mode="MANUAL",
    boot_mode="INITIALISING",
    guided="GUIDED",
    hold="HOLD",
    point="LOITER",
    boot=BootTimes(
        console_lines=9,
        heartbeat_s=1.0,
        settled_s=1.4,
        position_s=7.5,
        before="zero",
        clock_s=9.7,
        arm_s=23.0,
        ready_s=42.0,
    ),
    loss=LossTimes(
        fix_s=2.0,
        aiding_s=7.5,
        lie="runs_on",
        lie_s=40.0,
        text="AHRS: DCM active",
        failsafe_s=8.2,
        failsafe_mode="HOLD",
        failsafe_text="EKF failsafe",
    ),
    setpoints=SetpointRules(
        velocity_mask=Mask.VELOCITY,
        acceleration_ignored=True,
        frames=(Frame.LOCAL_NED, Frame.LOCAL_OFFSET_NED, Frame.BODY_NED, Frame.BODY_OFFSET_NED),
    ),
    gcs=GcsRules(
        enable="FS_GCS_ENABLE",
        actions=((1, "HOLD"),),
        timeout="FS_GCS_TIMEOUT",
        extra_s=1.5,
        lost_text="Radio Failsafe",
        back_text="GCS Failsafe Cleared",
    ),
    parameters=(
        *ARDUPILOT,
        ("CRUISE_SPEED", "f32", 5.0),
        ("WP_SPEED", "f32", 5.0),
        ("WP_RADIUS", "f32", 2.0),
        ("LOIT_RADIUS", "f32", 2.0),
        ("FS_ACTION", "i8", 2),
        ("FS_TIMEOUT", "f32", 1.5),
        ("FS_THR_ENABLE", "i8", 1),
        ("FS_EKF_ACTION", "i8", 1),
        ("FS_EKF_THRESH", "f32", 0.8),
        ("FS_GCS_ENABLE", "i8", 0),
        ("FS_GCS_TIMEOUT", "f32", 5.0),
        ("FRAME_CLASS", "i8", 2),
        ("ARMING_CHECK", "i32", 1),
        ("SCHED_LOOP_RATE", "i16", 50),
    ),
    streams=dict.fromkeys(_STREAMS.split(), 1.0),
    rate_max_hz=40.0,
    unknown_interval=Result.DENIED,
    ack_s=(0.015, 0.028),
    timesync_s=0.022,
    change_speed="after_position",
    gps_parameter="SIM_GPS_DISABLE",
    gps_good=0,
    external_fix=(("GPS1_TYPE", 14), ("EK3_SRC1_POSXY", 6)),
    external_messages=("GPS_INPUT", "VISION_POSITION_ESTIMATE"),
    clock_ppm=-400.0,
    vehicle=VehicleConfig(
        heading=Loop(lag_s=0.9, min=-1e9, max=1e9, rate_max=0.75),
        surge=Loop(lag_s=1.0, min=-2.0, max=5.0, rate_max=0.9),
    ),
    # CRUISE_SPEED limits nothing: with CRUISE_THROTTLE it is what the throttle is fed forward by.
    speed_parameters=("WP_SPEED",),
    speed_full_mps=5.0,
)
