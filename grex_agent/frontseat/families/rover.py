"""ArduPilot Rover: boats and ground vehicles."""

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.families.settings import ARDUPILOT, Frame, Setting, unless
from grex_agent.frontseat.families.table import Family, Order, velocity


def _encode(order: Order, time_boot_ms: int, system: int, component: int) -> Mavlink:
    """Velocity; to stand still a speed of exactly zero, for anything else is lifted to the least throttle.

    That needs a yaw. Under way it has none: with one a velocity to the south would be taken for astern.
    """
    stands = order.speed_mps == 0.0
    return velocity(order, 0.0, time_boot_ms, system, component, with_yaw=stands)


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
    frame=Frame("FRAME_CLASS", {1: "rover", 2: "boat", 3: "balance bot"}),
    encode=_encode,
    settings=(
        *ARDUPILOT,
        Setting("FS_GCS_ENABLE", unless(1, say="nothing happens when our heartbeats stop; set it to 1")),
        Setting("FS_ACTION", unless(1, 2, 3, 4, 6, say="its failsafe does not stop the boat; set it to 2, HOLD")),
        Setting("FS_EKF_ACTION", unless(1, say="it does not stop when it has lost its position; set it to 1, HOLD")),
    ),
)
