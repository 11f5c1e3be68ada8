"""Who may speak when: slots open on their boundary, and a schedule that cannot work is refused by path."""

import pytest

from grex_link.config import SlotConfig
from grex_link.errors import ConfigError
from grex_link.profile import load_profile
from grex_link.tdma import Schedule, Slot, plan_schedule
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


def plan(*slots: tuple[str, float, float], cycle_s: float | None = None) -> Schedule:
    link = Tdma(slots=tuple(SlotConfig(*slot) for slot in slots), cycle_s=cycle_s)
    return plan_schedule(link, TEAM, load_profile("grex2008"))


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
        ([("auv1", 9.5, 10.0), ("auv2", 0.0, 10.0)], None, "$.link.mac.slots[0].start_s", "of auv2, which ends at 10 s"),
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
