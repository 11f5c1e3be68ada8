"""Slots: a cycle of them counted from the start of the mission, and the silence each of them ends with."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from grex_link.errors import ConfigError
from grex_link.link_config import SlotConfig, Tdma, WaterConfig
from grex_link.profile import ModemProfile
from grex_link.units import NS

#: No water that a craft swims in is slower: fresh water at 0 °C has 1402 m/s.
SLOWEST_SOUND_MPS = 1400.0
_ROUNDING_S = 1e-9


@dataclass(frozen=True, slots=True)
class Slot:
    """One slot of the cycle; times from the start of the cycle, nanoseconds."""

    craft: str
    start_ns: int
    length_ns: int


@dataclass(frozen=True, slots=True)
class Schedule:
    """The slots of a cycle that repeats for ever from mission time zero, by each craft's own clock.

    Attributes
    ----------
    slots : tuple of Slot
        In any order.
    cycle_ns : int
        Length of the cycle.
    messages_per_slot : int
        How many messages a slot has room for, one after another with the modem's turnaround between them.
    message_bytes : int
        Longest message that fits so often into every slot.
    guard_ns : int
        Silence that every slot ends with, at least.
    """

    slots: tuple[Slot, ...]
    cycle_ns: int
    messages_per_slot: int = 1
    message_bytes: int = 0
    guard_ns: int = 0

    @property
    def interval_ns(self) -> int:
        """Mean time between two slots of the craft that has most of them."""
        return self.cycle_ns // max(Counter(slot.craft for slot in self.slots).values())

    def openings(self, craft: str, from_ns: int, before_ns: int) -> list[int]:
        """Mission times, nanoseconds, at which slots of a craft open within [from, before)."""
        times: list[int] = []
        for slot in self.slots:
            if slot.craft == craft:
                first = -(-(from_ns - slot.start_ns) // self.cycle_ns)
                times += range(slot.start_ns + max(first, 0) * self.cycle_ns, before_ns, self.cycle_ns)
        return sorted(times)


def guard_s(
    profile: ModemProfile,
    range_max_m: float,
    clock_error_s: float = 0.01,
    jitter_s: float = 0.01,
    sound_speed_mps: float = 1450.0,
) -> float:
    """Silence a slot must end with: R/c + 2ε + turnaround + jitter (acoustic-link, section 8).

    The turnaround is what a modem needs from the end of what it hears until it can speak itself: decoding, and
    switching over. Its transmit latency is no part of it: that is the same for all, and delays every slot alike.

    Parameters
    ----------
    profile : ModemProfile
        The modem of all; where only one can speak at a time the guard is 0.
    range_max_m : float
        R, longest distance from which a message must not reach into the next slot.
    clock_error_s : float
        ε, how far a clock may be off.
    jitter_s : float
        How late a modem may begin.
    sound_speed_mps : float
        c, lowest speed of sound on the way.

    Returns
    -------
    float
        Seconds.
    """
    if profile.one_speaker_at_a_time:
        return 0.0
    turnaround_s = profile.decode_latency_s + profile.turnaround_s
    return range_max_m / sound_speed_mps + 2.0 * clock_error_s + turnaround_s + jitter_s


def slowest_sound_mps(water: WaterConfig) -> float:
    """Lowest speed of sound that a scenario's water can have, m/s."""
    if water.layers:
        return min(speed_mps for _, speed_mps in water.layers)
    return SLOWEST_SOUND_MPS if isinstance(water.sound_speed, str) else water.sound_speed


def whole_ms_up(seconds: float) -> float:
    """Round a time up to whole milliseconds."""
    return math.ceil(round(seconds * NS) / (NS // 1000)) / 1000.0


@dataclass(frozen=True, slots=True)
class SlotNeeds:
    """What a slot must have room for on a modem, over a mission.

    Attributes
    ----------
    profile : ModemProfile
        The modem.
    messages, message_bytes : int
        How many messages a slot takes, and their length.
    planned_m : float
        Greatest distance of the planned mission.
    reach_m : float
        Distance the guard is made for: more, so that a team that is apart still fits.
    clock_error_s, jitter_s : float
        See `guard_s`.
    sound_speed_mps : float
        Lowest speed of sound.
    """

    profile: ModemProfile
    message_bytes: int
    messages: int = 1
    planned_m: float = 0.0
    reach_m: float = 0.0
    clock_error_s: float = 0.01
    jitter_s: float = 0.01
    sound_speed_mps: float = SLOWEST_SOUND_MPS

    @property
    def guard_s(self) -> float:
        """Silence that would do, see `guard_s`."""
        return guard_s(self.profile, self.reach_m, self.clock_error_s, self.jitter_s, self.sound_speed_mps)

    @property
    def delay_s(self) -> float:
        """What sound takes over the planned mission: with less silence the messages of two slots collide."""
        return 0.0 if self.profile.one_speaker_at_a_time else self.planned_m / self.sound_speed_mps

    @property
    def speaking_s(self) -> float:
        """What the messages of a slot take."""
        return self._speaking_s(self.message_bytes)

    def slot_s(self, silence_s: float) -> float:
        """Length of a slot that ends with a silence, whole milliseconds."""
        return whole_ms_up(self.speaking_s + silence_s)

    def longest_message(self, room_s: float) -> int:
        """Bytes of the longest message that fits often enough into a time, not less than what was planned."""
        low, high = self.message_bytes, max(self.message_bytes, self.profile.payload_max_bytes)
        while low < high:
            middle = (low + high + 1) // 2
            if self._speaking_s(middle) <= room_s + _ROUNDING_S:
                low = middle
            else:
                high = middle - 1
        return low

    def check_slot(self, length_s: float, silence_s: float, path: str) -> None:
        """Refuse a slot too short for its messages, the silence asked for, or the sound to get there."""
        spare_s = length_s - self.speaking_s
        would_do = f"{self.slot_s(max(silence_s, self.guard_s)):g} s would do"
        if spare_s < -_ROUNDING_S:
            many = "a message takes" if self.messages == 1 else f"{self.messages} messages take"
            raise ConfigError(
                path, f"{length_s:g} s is too short: {many} {self.speaking_s:g} s on this modem; {would_do}"
            )
        if spare_s < self.delay_s - _ROUNDING_S:
            raise ConfigError(path, f"{length_s:g} s leaves {spare_s:.3g} s of silence, but {self._sound}; {would_do}")
        if spare_s < silence_s - _ROUNDING_S:
            raise ConfigError(
                path, f"{length_s:g} s leaves {spare_s:.3g} s of silence, not guard_s = {silence_s:g} s; {would_do}"
            )

    def check_guard(self, given_s: float | None) -> None:
        """Refuse a guard in which the sound does not get there."""
        if given_s is not None and given_s < self.delay_s - _ROUNDING_S:
            would_do = f"{whole_ms_up(self.guard_s):g} s would do"
            raise ConfigError("$.link.mac.guard_s", f"{given_s:g} s is too short: {self._sound}; {would_do}")
        if given_s is None and self.guard_s < self.delay_s - _ROUNDING_S:
            raise ConfigError(
                "$.link.mac.range_max_m",
                f"{self.reach_m:g} m is too short: craft are planned to be {self.planned_m:.1f} m apart",
            )

    @property
    def _sound(self) -> str:
        return f"sound takes {self.delay_s:.3f} s over the {self.planned_m:.0f} m of the mission"

    def _speaking_s(self, size_bytes: int) -> float:
        airtime_s = self.profile.airtime_ns(size_bytes) / NS
        return self.messages * airtime_s + (self.messages - 1) * self.profile.turnaround_s


def plan_schedule(mac: Tdma, team: Sequence[str], needs: SlotNeeds) -> Schedule:
    """Build the schedule of a scenario and check it.

    Parameters
    ----------
    mac : Tdma
        The scenario's table; without slots every craft gets one as long as its messages and the guard need, rounded up
        to whole milliseconds.
    team : sequence of str
        The craft, in their order.
    needs : SlotNeeds
        What a slot must have room for.

    Raises
    ------
    ConfigError
        For an unknown craft, a slot too short for its messages, a silence too short for the sound, slots that overlap,
        or a cycle they do not fit into.
    """
    needs.check_guard(mac.guard_s)
    silence_s = needs.guard_s if mac.guard_s is None else mac.guard_s
    slots = mac.slots or _default_slots(team, needs.slot_s(silence_s))
    for place, slot in enumerate(slots):
        if slot.craft not in team:
            raise ConfigError(
                f"$.link.mac.slots[{place}].craft", f"unknown craft {slot.craft!r}; there are {', '.join(team)}"
            )
        needs.check_slot(slot.length_s, mac.guard_s or 0.0, f"$.link.mac.slots[{place}].length_s")
    _check_overlaps(slots)
    end_s = max(slot.start_s + slot.length_s for slot in slots)
    cycle_s = mac.cycle_s or end_s
    if cycle_s < end_s - _ROUNDING_S:
        raise ConfigError("$.link.mac.cycle_s", f"{cycle_s:g} s is too short: the last slot ends at {end_s:g} s")
    shortest_s = min(slot.length_s for slot in slots)
    kept_s = min(silence_s, shortest_s - needs.speaking_s)
    return Schedule(
        tuple(Slot(slot.craft, round(slot.start_s * NS), round(slot.length_s * NS)) for slot in slots),
        round(cycle_s * NS),
        needs.messages,
        needs.longest_message(shortest_s - kept_s),
        round(kept_s * NS),
    )


def _default_slots(team: Sequence[str], length_s: float) -> tuple[SlotConfig, ...]:
    return tuple(
        SlotConfig(craft=craft, start_s=place * length_s, length_s=length_s) for place, craft in enumerate(team)
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
