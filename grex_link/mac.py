"""Who may speak when, aboard: slots in turn, slots at random (slotted Aloha), or any time at random (pure Aloha).

Every time is by the craft's own clock. What is drawn is a hash of what it is for, so that the openings are the same
whatever windows are asked for: nothing here has a memory.
"""

import math
from dataclasses import dataclass
from typing import Protocol

from grex_link import draws
from grex_link.config import Scenario
from grex_link.link_config import PureAloha, SlottedAloha, Tdma
from grex_link.profile import load_profile
from grex_link.tdma import SlotNeeds, plan_schedule, slowest_sound_mps
from grex_link.units import NS

#: The guard is made for the planned distances and so much more, so that a team that is apart still fits.
MARGIN = 1.5
MARGIN_M = 50.0


class Mac(Protocol):
    """Medium access aboard a craft.

    Attributes
    ----------
    messages_per_slot : int
        How many messages may follow an opening, one after another with the modem's turnaround between them.
    message_bytes : int
        Longest message there is time for.
    interval_ns : int
        Mean time between two openings of a craft; of the one that has most of them.
    """

    @property
    def messages_per_slot(self) -> int:
        """How many messages may follow an opening."""

    @property
    def interval_ns(self) -> int:
        """Mean time between two openings of a craft."""

    @property
    def message_bytes(self) -> int:
        """Longest message there is time for."""

    def openings(self, craft: str, from_ns: int, before_ns: int) -> list[int]:
        """Return the times within [from, before) at which a craft may begin to speak, in order, nanoseconds."""


@dataclass(frozen=True, slots=True)
class SlottedAlohaMac:
    """In every slot every craft speaks with some probability; slots are counted from mission time zero.

    Attributes
    ----------
    probability : float
        Of speaking, for each craft and slot.
    slot_ns : int
        Length of a slot.
    message_bytes : int
        Longest message that fits into a slot.
    seed : int
        Of the draws.
    messages_per_slot : int
        Always 1.
    """

    probability: float
    slot_ns: int
    message_bytes: int
    seed: int
    messages_per_slot: int = 1

    @property
    def interval_ns(self) -> int:
        """Mean time between two openings of a craft; see `Mac`."""
        return round(self.slot_ns / self.probability)

    def openings(self, craft: str, from_ns: int, before_ns: int) -> list[int]:
        """Return the beginnings of the slots within [from, before) that the craft uses."""
        first = max(-(-from_ns // self.slot_ns), 0)
        numbers = range(first, -(-before_ns // self.slot_ns))
        return [number * self.slot_ns for number in numbers if self._speaks(craft, number)]

    def _speaks(self, craft: str, number: int) -> bool:
        return draws.uniform(self.seed, "slotted_aloha", craft, number) < self.probability


@dataclass(frozen=True, slots=True)
class PureAlohaMac:
    """Every craft speaks at the points of a Poisson process of its own.

    Time is cut into bins of one mean interval; each has a Poisson number of points, even over the bin. That is a
    Poisson process, and every bin can be drawn by itself.

    Attributes
    ----------
    rate_per_s : float
        Mean number of openings a second.
    message_bytes : int
        Longest message: the modem's.
    seed : int
        Of the draws.
    messages_per_slot : int
        Always 1.
    """

    rate_per_s: float
    message_bytes: int
    seed: int
    messages_per_slot: int = 1

    @property
    def interval_ns(self) -> int:
        """Mean time between two openings of a craft; see `Mac`."""
        return max(round(NS / self.rate_per_s), 1)

    def openings(self, craft: str, from_ns: int, before_ns: int) -> list[int]:
        """Return the points within [from, before)."""
        if before_ns <= max(from_ns, 0):
            return []
        bin_ns = self.interval_ns
        numbers = range(max(from_ns, 0) // bin_ns, (before_ns - 1) // bin_ns + 1)
        points = (point for number in numbers for point in self._points(craft, number, bin_ns))
        return sorted(point for point in points if from_ns <= point < before_ns)

    def _points(self, craft: str, number: int, bin_ns: int) -> list[int]:
        count = _poisson(draws.uniform(self.seed, "aloha", craft, number), self.rate_per_s * bin_ns / NS)
        return [
            number * bin_ns + int(draws.uniform(self.seed, "aloha", craft, number, place) * bin_ns)
            for place in range(count)
        ]


def plan_mac(scenario: Scenario, planned_m: float, message_bytes: int) -> Mac:
    """Work out who may speak when, and check that it can work.

    Parameters
    ----------
    scenario : Scenario
        The run.
    planned_m : float
        Greatest distance between two craft in the planned mission. The guard is for `guard_range_m` of it.
    message_bytes : int
        Length of a team state on the air.

    Raises
    ------
    ConfigError
        With the path of the fault and what would do.
    """
    mac = scenario.link.mac
    profile = load_profile(scenario.link.profile)
    if isinstance(mac, PureAloha):
        return PureAlohaMac(mac.rate_per_s, profile.payload_max_bytes, scenario.link_seed)
    needs = slot_needs(scenario, planned_m, message_bytes)
    if isinstance(mac, Tdma):
        return plan_schedule(mac, scenario.speakers, needs)
    return _plan_slotted_aloha(mac, needs, scenario.link_seed)


def slot_needs(scenario: Scenario, planned_m: float, message_bytes: int) -> SlotNeeds:
    """Say what a slot must have room for; see `plan_mac`."""
    mac = scenario.link.mac
    tdma = mac if isinstance(mac, Tdma) else Tdma()
    return SlotNeeds(
        load_profile(scenario.link.profile),
        message_bytes,
        tdma.messages_per_slot,
        planned_m,
        guard_range_m(mac, planned_m),
        tdma.clock_error_s,
        tdma.jitter_s,
        slowest_sound_mps(scenario.link.water),
    )


def guard_range_m(mac: Tdma | SlottedAloha | PureAloha, planned_m: float) -> float:
    """Distance the guard is for: the scenario's, else half as much again as planned and 50 m."""
    given_m = mac.range_max_m if isinstance(mac, Tdma) else None
    return MARGIN * planned_m + MARGIN_M if given_m is None else given_m


def _plan_slotted_aloha(mac: SlottedAloha, needs: SlotNeeds, seed: int) -> SlottedAlohaMac:
    slot_s = needs.slot_s(needs.guard_s) if mac.slot_s is None else mac.slot_s
    needs.check_slot(slot_s, 0.0, "$.link.mac.slot_s")
    silence_s = min(needs.guard_s, slot_s - needs.speaking_s)
    return SlottedAlohaMac(mac.probability, round(slot_s * NS), needs.longest_message(slot_s - silence_s), seed)


def _poisson(uniform: float, mean: float) -> int:
    """Invert the distribution function of a Poisson number of a small mean."""
    count, chance = 0, math.exp(-mean)
    below = chance
    while uniform >= below and chance > 0.0:
        count += 1
        chance *= mean / count
        below += chance
    return count
