"""Who may speak when: slots open on their boundary, and a schedule that cannot work is refused by path."""

import msgspec
import pytest

from grex_link.errors import ConfigError
from grex_link.link_config import SlotConfig, Tdma, WaterConfig
from grex_link.profile import ModemProfile, load_profile
from grex_link.tdma import Schedule, Slot, SlotNeeds, guard_s, plan_schedule, slowest_sound_mps, whole_ms_up
from grex_link.units import NS

TEAM = ("auv1", "auv2", "auv3")

#: auv1 speaks twice a cycle of 60 s, 5 s of which nobody owns.
UNEQUAL = Schedule(
    (
        Slot("auv1", 0, 10 * NS),
        Slot("auv2", 10 * NS, 20 * NS),
        Slot("auv1", 30 * NS, 10 * NS),
        Slot("auv3", 40 * NS, 15 * NS),
    ),
    60 * NS,
)


#: Instant messages, on a modem that takes a while to switch over besides.
S2C = msgspec.structs.replace(load_profile("s2c_im"), turnaround_s=0.03)


def plan(*slots: tuple[str, float, float], cycle_s: float | None = None) -> Schedule:
    mac = Tdma(slots=tuple(SlotConfig(*slot) for slot in slots), cycle_s=cycle_s)
    return plan_schedule(mac, TEAM, SlotNeeds(load_profile("grex2008"), 15, planned_m=5000.0, reach_m=8000.0))


def wet(mac: Tdma, planned_m: float = 500.0, reach_m: float = 500.0, profile: ModemProfile = S2C) -> Schedule:
    """Slots of a team of three on an acoustic modem."""
    needs = SlotNeeds(
        profile, 15, mac.messages_per_slot, planned_m, reach_m, mac.clock_error_s, mac.jitter_s, sound_speed_mps=1400.0
    )
    return plan_schedule(mac, TEAM, needs)


def openings_s(schedule: Schedule, craft: str, from_s: float, before_s: float) -> list[float]:
    return [t_ns / NS for t_ns in schedule.openings(craft, round(from_s * NS), round(before_s * NS))]


def test_default_slots() -> None:
    """Without slots every craft speaks in turn for as long as a message takes: each every 30 s, as in the paper."""
    schedule = plan()
    assert schedule.slots == tuple(Slot(craft, place * 10 * NS, 10 * NS) for place, craft in enumerate(TEAM))
    assert schedule.cycle_ns == 30 * NS
    assert openings_s(schedule, "auv2", 0.0, 100.0) == [10.0, 40.0, 70.0]


def test_default_slots_with_a_pause() -> None:
    """A cycle longer than its slots ends in silence."""
    assert openings_s(plan(cycle_s=45.0), "auv3", 0.0, 100.0) == [20.0, 65.0]


@pytest.mark.parametrize(
    ("from_s", "before_s", "expected"),
    [
        (0.0, 10.0, []),
        (10.0, 10.0, []),
        (10.0, 11.0, [10.0]),
        (9.0, 10.0, []),
        (9.0, 10.000000001, [10.0]),
        (10.000000001, 40.0, []),
        (10.000000001, 70.000000001, [70.0]),
        (20.0, 5.0, []),
    ],
)
def test_bounds(from_s: float, before_s: float, expected: list[float]) -> None:
    """A slot counts if it opens within [from, before): successive windows see every slot once."""
    assert openings_s(UNEQUAL, "auv2", from_s, before_s) == expected


def test_several_slots_a_cycle() -> None:
    """A craft with several slots of a cycle gets all of them, in the order of time."""
    assert openings_s(UNEQUAL, "auv1", 25.0, 130.0) == [30.0, 60.0, 90.0, 120.0]


def test_nobody_speaks_before_the_mission() -> None:
    """No slot opens before mission time zero."""
    assert openings_s(UNEQUAL, "auv1", -100.0, 1.0) == [0.0]
    assert openings_s(UNEQUAL, "auv2", -100.0, 0.0) == []


def test_stranger() -> None:
    """Who owns no slot never speaks."""
    assert openings_s(UNEQUAL, "auv9", 0.0, 1000.0) == []


def test_far_future() -> None:
    """After ten years the cycle still counts from mission time zero, to the nanosecond."""
    t_ns = 5_256_000 * 60 * NS
    assert UNEQUAL.openings("auv3", t_ns, t_ns + 60 * NS) == [t_ns + 40 * NS]


def test_slots_in_any_order() -> None:
    """Slots may be written in any order, and need not begin at zero."""
    schedule = plan(("auv2", 25.0, 10.0), ("auv1", 5.0, 20.0))
    assert schedule.cycle_ns == 35 * NS
    assert openings_s(schedule, "auv1", 0.0, 60.0) == [5.0, 40.0]
    assert openings_s(schedule, "auv2", 0.0, 60.0) == [25.0]


def test_cycle_of_decimal_slots() -> None:
    """Slots of 10.1 s and 16.1 s fill a cycle of 26.2 s."""
    assert plan(("auv1", 0.0, 10.1), ("auv2", 10.1, 16.1)).cycle_ns == 26_200_000_000
    assert plan(("auv1", 0.0, 10.1), ("auv2", 10.1, 16.1), cycle_s=26.3).cycle_ns == 26_300_000_000


def test_cycle_that_fits_exactly() -> None:
    """A cycle that its slots fill exactly is accepted, though 10.1 + 16.1 is a hair above 26.2 in binary."""
    assert plan(("auv1", 0.0, 10.1), ("auv2", 10.1, 16.1), cycle_s=26.2).cycle_ns == 26_200_000_000


@pytest.mark.parametrize(
    ("slots", "cycle_s", "path", "says"),
    [
        ([("auv1", 0.0, 10.0), ("auv2", 10.0, 9.9)], None, "$.link.mac.slots[1].length_s", "a message takes 10 s"),
        ([("auv1", 0.0, 10.0), ("auv2", 9.5, 10.0)], None, "$.link.mac.slots[1].start_s", "ends at 10 s"),
        (
            [("auv1", 9.5, 10.0), ("auv2", 0.0, 10.0)],
            None,
            "$.link.mac.slots[0].start_s",
            "of auv2, which ends at 10 s",
        ),
        ([("auv1", 0.0, 50.0), ("auv2", 20.0, 10.0)], None, "$.link.mac.slots[1].start_s", "ends at 50 s"),
        ([("auv1", 0.0, 10.0), ("auv1", 0.0, 10.0)], None, "$.link.mac.slots[1].start_s", "overlaps the slot of auv1"),
        ([("auv1", 0.0, 10.0), ("auv9", 10.0, 10.0)], None, "$.link.mac.slots[1].craft", "auv1, auv2, auv3"),
        ([("auv1", 0.0, 10.0), ("auv2", 15.0, 10.0)], 24.0, "$.link.mac.cycle_s", "ends at 25 s"),
        ([], 29.0, "$.link.mac.cycle_s", "ends at 30 s"),
    ],
)
def test_schedule_that_cannot_work(slots, cycle_s: float | None, path: str, says: str) -> None:
    """A slot too short, an overlap, a stranger or a cycle too short is named by path, with what would be right."""
    with pytest.raises(ConfigError) as caught:
        plan(*slots, cycle_s=cycle_s)
    assert caught.value.path == path
    assert says in caught.value.problem


# -- the guard ----------------------------------------------------------------------------------------------------


def test_guard_of_instant_messages() -> None:
    """S2C instant messages over 500 m of the slowest water need 0.478 s of guard (acoustic-link, section 8)."""
    profile = load_profile("s2c_im")
    assert guard_s(profile, 500.0, sound_speed_mps=1400.0) == pytest.approx(0.478, abs=0.0006)
    assert guard_s(profile, 500.0) == pytest.approx(500.0 / 1450.0 + 0.02 + 0.0904 + 0.01)


def test_every_part_of_the_guard_counts_once() -> None:
    """Range, decoding, turnaround and jitter count once, the error of the clocks twice: both may be off."""
    base = guard_s(S2C, 100.0, 0.0, 0.0, 1000.0)
    assert base == pytest.approx(0.1 + 0.0904 + 0.03)
    assert guard_s(S2C, 100.0, 0.03, 0.0, 1000.0) - base == pytest.approx(0.06)
    assert guard_s(S2C, 100.0, 0.0, 0.03, 1000.0) - base == pytest.approx(0.03)
    assert guard_s(S2C, 300.0, 0.0, 0.0, 1000.0) - base == pytest.approx(0.2)


def test_no_guard_where_one_speaks_at_a_time() -> None:
    """The paper's modem needs no guard, whatever the distance."""
    assert guard_s(load_profile("grex2008"), 1e6) == 0.0
    assert plan().guard_ns == 0


@pytest.mark.parametrize(
    ("water", "speed_mps"),
    [
        (WaterConfig(), 1500.0),
        (WaterConfig(sound_speed=1482.5), 1482.5),
        (WaterConfig(sound_speed=1600.0, layers=((0.0, 1520.0), (50.0, 1488.0), (90.0, 1495.0))), 1488.0),
        (WaterConfig(sound_speed="mackenzie"), 1400.0),
    ],
)
def test_the_slowest_water_makes_the_guard(water: WaterConfig, speed_mps: float) -> None:
    """A guard is for the slowest sound there may be: the speed given, the slowest layer, or a bound."""
    assert slowest_sound_mps(water) == speed_mps


@pytest.mark.parametrize(("seconds", "rounded"), [(0.7947, 0.795), (10.0, 10.0), (0.795, 0.795), (0.7950001, 0.796)])
def test_whole_milliseconds(seconds: float, rounded: float) -> None:
    """Slots are rounded up to milliseconds, and a whole number of them stays what it is."""
    assert whole_ms_up(seconds) == rounded


def test_default_slots_hold_message_and_guard() -> None:
    """Left out, a slot is airtime and guard, rounded up to a millisecond, and the cycle is all of them."""
    schedule = wet(Tdma())
    airtime_s = 0.1503 + 15 * 0.01109
    assert schedule.guard_ns == pytest.approx(guard_s(S2C, 500.0, sound_speed_mps=1400.0) * NS, abs=1)
    (length_ns,) = {slot.length_ns for slot in schedule.slots}
    assert 0 <= length_ns - round(airtime_s * NS) - schedule.guard_ns < 1_000_000
    assert [slot.start_ns for slot in schedule.slots] == [0, length_ns, 2 * length_ns]
    assert schedule.cycle_ns == 3 * length_ns


def test_several_messages_a_slot() -> None:
    """A slot of several messages holds their airtimes, the modem's turnaround between them, and one guard."""
    one, four = wet(Tdma()), wet(Tdma(messages_per_slot=4))
    airtime_s = 0.1503 + 15 * 0.01109
    longer_s = (four.slots[0].length_ns - one.slots[0].length_ns) / NS
    assert longer_s == pytest.approx(3 * (airtime_s + S2C.turnaround_s), abs=0.001)
    assert (four.messages_per_slot, four.guard_ns) == (4, one.guard_ns)


def test_long_slots_hold_long_messages() -> None:
    """The longest message is what fits before the guard of the shortest slot, and never less than a state."""
    slots = tuple(SlotConfig(craft, 5.0 * place, 1.2) for place, craft in enumerate(TEAM))
    schedule = wet(Tdma(slots=slots))
    room_s = 1.2 - schedule.guard_ns / NS
    assert S2C.airtime_ns(schedule.message_bytes) / NS <= room_s < S2C.airtime_ns(schedule.message_bytes + 1) / NS
    assert wet(Tdma()).message_bytes == 15
    assert plan().message_bytes == 32


def test_unequal_slots_with_silence_between() -> None:
    """Slots may be unequal and the cycle longer; the guard is what is left of the shortest, if that is less."""
    slots = (SlotConfig("auv1", 0.0, 0.7), SlotConfig("auv2", 1.0, 2.0), SlotConfig("auv1", 3.0, 0.9))
    schedule = wet(Tdma(slots=slots, cycle_s=9.0))
    assert openings_s(schedule, "auv1", 0.0, 18.0) == [0.0, 3.0, 9.0, 12.0]
    assert schedule.guard_ns == pytest.approx((0.7 - 0.1503 - 15 * 0.01109) * NS, abs=2)


LENGTH = "$.link.mac.slots[1].length_s"


@pytest.mark.parametrize(
    ("mac", "path", "would_do"),
    [
        (Tdma(guard_s=0.35), "$.link.mac.guard_s", 0.508),
        (Tdma(guard_s=0.0), "$.link.mac.guard_s", 0.508),
        (Tdma(slots=(SlotConfig("auv1", 0.0, 5.0), SlotConfig("auv2", 5.0, 0.6))), LENGTH, 0.825),
        (Tdma(slots=(SlotConfig("auv1", 0.0, 5.0), SlotConfig("auv2", 5.0, 0.2))), LENGTH, 0.825),
        (Tdma(slots=(SlotConfig("auv1", 0.0, 5.0), SlotConfig("auv2", 5.0, 0.8)), guard_s=1.0), LENGTH, 1.317),
        (Tdma(slots=(SlotConfig("auv1", 0.0, 5.0), SlotConfig("auv2", 5.0, 0.9)), messages_per_slot=2), LENGTH, 1.172),
    ],
)
def test_a_silence_too_short_names_what_would_do(mac: Tdma, path: str, would_do: float) -> None:
    """A guard the sound does not fit into, or a slot without room for it, is refused; what it says would do, does."""
    with pytest.raises(ConfigError) as caught:
        wet(mac)
    assert caught.value.path == path
    said = float(caught.value.problem.rsplit("; ", 1)[1].removesuffix(" s would do"))
    assert said == pytest.approx(would_do, abs=0.0011)
    if path == LENGTH:
        wet(Tdma(slots=(mac.slots[0], SlotConfig("auv2", 5.0, said)), guard_s=mac.guard_s))
    else:
        wet(Tdma(guard_s=said))


def test_a_guard_that_just_does() -> None:
    """A guard as long as the sound takes over the mission is accepted, though more would be wise."""
    assert wet(Tdma(guard_s=500.0 / 1400.0), reach_m=800.0).guard_ns == pytest.approx(357_142_857, abs=1)


def test_a_range_that_is_less_than_planned() -> None:
    """A guard made for less than the planned distance is refused where that distance is given."""
    with pytest.raises(ConfigError, match=r"planned to be 500\.0 m apart") as caught:
        wet(Tdma(range_max_m=100.0), reach_m=100.0)
    assert caught.value.path == "$.link.mac.range_max_m"
