"""ArduPilot Sub: vehicles under water."""

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.families.settings import ARDUPILOT, Frame, Setting
from grex_agent.frontseat.families.table import Family, Order, velocity

#: Vertical speed asked for each metre of depth error, and its limit.
_DEPTH_GAIN_PER_S = 0.3
_VERTICAL_MAX_MPS = 0.3


def _encode(order: Order, time_boot_ms: int, system: int, component: int) -> Mavlink:
    """Velocity in three axes; GUIDED takes no depth beside a velocity, so the loop is closed here.

    Without a yaw the bow stays where it was told to look before, and the craft goes sideways.
    """
    down_mps = _DEPTH_GAIN_PER_S * (order.depth_m - order.at_depth_m)
    down_mps = min(max(down_mps, -_VERTICAL_MAX_MPS), _VERTICAL_MAX_MPS)
    return velocity(order, down_mps, time_boot_ms, system, component, with_yaw=True)


def _judge_failsafe(value: float, own_system: int) -> str:
    del own_system
    what = {3.0: "", 4.0: "", 2.0: "it disarms in mid-water when our heartbeats stop"}
    words = what.get(value, "nothing happens when our heartbeats stop")
    return words and f"{words}; set it to 4, surface, or 3, hold the depth"


FAMILY = Family(
    name="sub",
    title="ArduPilot Sub",
    autopilot=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    types=frozenset({mavlink.MAV_TYPE_SUBMARINE}),
    modes={
        0: "STABILIZE",
        1: "ACRO",
        2: "ALT_HOLD",
        3: "AUTO",
        4: "GUIDED",
        7: "CIRCLE",
        9: "SURFACE",
        16: "POSHOLD",
        19: "MANUAL",
    },
    guided=4,
    # ALT_HOLD needs no position.
    holds=(16, 2),
    frame=Frame(
        "FRAME_CONFIG", {0: "BlueROV1", 1: "vectored", 2: "vectored, 6 DOF", 4: "SimpleROV-3", 5: "SimpleROV-4"}
    ),
    encode=_encode,
    under_water=True,
    # It makes good some 80 % of the speed it is asked for.
    trims_speed=True,
    settings=(*ARDUPILOT, Setting("FS_GCS_ENABLE", _judge_failsafe)),
)
