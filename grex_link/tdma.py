"""Who may speak when: a cycle of slots counted from the start of the mission."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from grex_link.config import SlotConfig, Tdma
from grex_link.errors import ConfigError
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import TEAM_STATE_BYTES

_ROUNDING_S = 1e-9


@dataclass(frozen=True, slots=True)
class Slot:
    """One slot of the cycle; times from the start of the cycle, nanoseconds."""

    craft: str
    start_ns: int
    length_ns: int


@dataclass(frozen=True, slots=True)
class Schedule:
    """The slots of a cycle that repeats for ever from mission time zero."""

    slots: tuple[Slot, ...]
    cycle_ns: int

    def openings(self, craft: str, from_ns: int, before_ns: int) -> list[int]:
        """Mission times, nanoseconds, at which slots of a craft open within [from, before)."""
        times: list[int] = []
        for slot in self.slots:
            if slot.craft == craft:
                first = -(-(from_ns - slot.start_ns) // self.cycle_ns)
                times += range(slot.start_ns + max(first, 0) * self.cycle_ns, before_ns, self.cycle_ns)
        return sorted(times)


def plan_schedule(mac: Tdma, team: Sequence[str], profile: ModemProfile) -> Schedule:
    """Build the schedule of a scenario and check it.

    Parameters
    ----------
    mac : Tdma
        The scenario's table; without slots every craft gets one as long as a team state needs.
    team : sequence of str
        The craft, in their order.
    profile : ModemProfile
        The modem they use.

    Raises
    ------
    ConfigError
        For an unknown craft, a slot shorter than a message, slots that overlap, or a cycle they do not fit into.
    """
    airtime_s = profile.airtime_ns(TEAM_STATE_BYTES) / NS
    slots = mac.slots or tuple(
        SlotConfig(craft=craft, start_s=place * airtime_s, length_s=airtime_s) for place, craft in enumerate(team)
    )
    for place, slot in enumerate(slots):
        if slot.craft not in team:
            raise ConfigError(
                f"$.link.mac.slots[{place}].craft", f"unknown craft {slot.craft!r}; there are {', '.join(team)}"
            )
        if slot.length_s < airtime_s:
            raise ConfigError(
                f"$.link.mac.slots[{place}].length_s",
                f"{slot.length_s:g} s is too short: a message takes {airtime_s:g} s on this modem",
            )
    _check_overlaps(slots)
    end_s = max(slot.start_s + slot.length_s for slot in slots)
    cycle_s = mac.cycle_s or end_s
    if cycle_s < end_s - _ROUNDING_S:
        raise ConfigError("$.link.mac.cycle_s", f"{cycle_s:g} s is too short: the last slot ends at {end_s:g} s")
    return Schedule(
        tuple(Slot(slot.craft, round(slot.start_s * NS), round(slot.length_s * NS)) for slot in slots),
        round(cycle_s * NS),
    )


def _check_overlaps(slots: Sequence[SlotConfig]) -> None:
    in_order = sorted(range(len(slots)), key=lambda place: slots[place].start_s)
    for before, after in pairwise(in_order):
        end_s = slots[before].start_s + slots[before].length_s
        if slots[after].start_s < end_s - _ROUNDING_S:
            raise ConfigError(
                f"$.link.mac.slots[{after}].start_s",
                f"slot of {slots[after].craft} overlaps the slot of {slots[before].craft}, which ends at {end_s:g} s",
            )
