"""What the agent wants, as the set-point that is in force: with its age, and with the craft's speed put right. Pure."""

from grex_agent.frontseat.dialect import Mavlink
from grex_agent.frontseat.families.table import Family, Order
from grex_agent.frontseat.navigation import Navigation
from grex_agent.frontseat.timesync import BootClock, older
from grex_agent.frontseat.trim import SpeedTrim
from grex_link.messages import Setpoint


class Steering:
    """The set-point in force. Times are ours, seconds.

    Parameters
    ----------
    family : Family
        How it is to be encoded.
    source : (int, int)
        For whom it is.
    age_max_s : float
        An agent that has been silent for longer is stale, seconds of the autopilot.
    """

    def __init__(self, family: Family, source: tuple[int, int], age_max_s: float) -> None:
        self._family = family
        self._source = source
        self._age_max_s = age_max_s
        self._trim = SpeedTrim()
        self._wanted: Setpoint | None = None
        self._spoken_s = 0.0
        self._started = False

    def start(self, from_s: float) -> None:
        """Begin the mission: from a time on, which may be yet to come, a silent agent is stale."""
        self._started = True
        self._spoken_s = from_s

    def reset(self) -> None:
        """Forget what has been learnt of the craft."""
        self._trim.reset()

    def on_setpoint(self, setpoint: Setpoint, now_s: float) -> None:
        """Take what the agent wants."""
        self._wanted, self._spoken_s = setpoint, max(now_s, self._spoken_s)

    def fresh(self, now_s: float, rate: float) -> bool:
        """Whether the agent speaks, or need not yet."""
        return not self._started or not older(now_s - self._spoken_s, rate, self._age_max_s)

    def message(self, navigation: Navigation, clock: BootClock, now_s: float) -> Mavlink:
        """Encode what is wanted now; standing still before the agent has said anything."""
        here = navigation.at(now_s, now_s, clock.rate)
        boot_s = clock.theirs_s(now_s)
        wanted = self._wanted
        if wanted is None:
            order = Order(here.heading_rad, 0.0, navigation.depth_m, navigation.depth_m)
        else:
            speed_mps = wanted.speed_mps if wanted.mode == "steer" else 0.0
            if self._family.trims_speed:
                made_good = navigation.velocity_mps if here.valid else None
                speed_mps = self._trim.asked_mps(speed_mps, wanted.course_rad, made_good, boot_s)
            order = Order(wanted.course_rad, speed_mps, wanted.depth_m, navigation.depth_m)
        return self._family.encode(order, round(boot_s * 1e3) % 2**32, *self._source)
