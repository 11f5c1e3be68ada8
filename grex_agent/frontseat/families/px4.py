"""PX4: any vehicle of it that takes velocity set-points in OFFBOARD."""

from grex_agent.frontseat.dialect import mavlink
from grex_agent.frontseat.families.table import Family

_OFFBOARD = 6 << 16
_POSCTL = 3 << 16
_LOITER = 4 << 16 | 3 << 24

FAMILY = Family(
    name="px4",
    title="PX4",
    autopilot=mavlink.MAV_AUTOPILOT_PX4,
    types=frozenset(),
    modes={
        1 << 16: "MANUAL",
        2 << 16: "ALTCTL",
        _POSCTL: "POSCTL",
        4 << 16 | 2 << 24: "AUTO.TAKEOFF",
        _LOITER: "AUTO.LOITER",
        4 << 16 | 4 << 24: "AUTO.MISSION",
        4 << 16 | 5 << 24: "AUTO.RTL",
        4 << 16 | 6 << 24: "AUTO.LAND",
        5 << 16: "ACRO",
        _OFFBOARD: "OFFBOARD",
        7 << 16: "STABILIZED",
    },
    guided=_OFFBOARD,
    holds=(_LOITER, _POSCTL),
    estimator=mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS,
    streams_before=True,
    returns_by_itself=True,
    # Speed control as it comes is off by up to a quarter.
    trims_speed=True,
)
