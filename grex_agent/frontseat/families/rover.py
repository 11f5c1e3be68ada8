"""ArduPilot Rover: boats and ground vehicles."""

from grex_agent.frontseat.dialect import mavlink
from grex_agent.frontseat.families.table import Family

FAMILY = Family(
    name="rover",
    title="ArduPilot Rover",
    autopilot=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    types=frozenset({mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_TYPE_SURFACE_BOAT}),
    modes={
        0: "MANUAL",
        1: "ACRO",
        3: "STEERING",
        4: "HOLD",
        5: "LOITER",
        6: "FOLLOW",
        7: "SIMPLE",
        8: "DOCK",
        9: "CIRCLE",
        10: "AUTO",
        11: "RTL",
        12: "SMART_RTL",
        15: "GUIDED",
        16: "INITIALISING",
    },
    guided=15,
    # HOLD needs no position, and is where the autopilot's own failsafes end.
    holds=(4, 5),
)
