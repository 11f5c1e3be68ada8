"""Properties of the water: whatever is sent, nothing is early, nothing is missing from the books, slots are safe."""

from collections import Counter
from itertools import pairwise

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slot_water import SlotWater

from grex_link.errors import ConfigError
from grex_link.link_config import SlotConfig, Tdma
from grex_link.messages import Received, Transmit
from grex_link.profile import ModemProfile, load_profile
from grex_link.slot_medium import SlotMedium
from grex_link.tdma import Schedule, SlotNeeds, plan_schedule
from grex_link.units import NS

TEAM = ["auv1", "auv2", "auv3"]
FOREVER = 10**18
PAPER = load_profile("grex2008")

PROFILES = st.builds(
    msgspec.structs.replace,
    st.just(PAPER),
    airtime_fixed_s=st.integers(1, 10_000).map(lambda milliseconds: milliseconds / 1000),
    airtime_per_byte_s=st.integers(0, 500).map(lambda milliseconds: milliseconds / 1000),
)

#: (milliseconds since the request before, place in the team, payload bytes)
GAPS = st.lists(st.tuples(st.integers(0, 20_000), st.integers(0, 2), st.integers(0, 40)), max_size=25)
LOSSES = st.sampled_from([0.0, 0.3, 1.0])


def requests(gaps: list[tuple[int, int, int]]) -> list[tuple[str, Transmit]]:
    t_ns, numbers, made = 0, Counter(), []
    for gap_ms, place, size in gaps:
        t_ns += gap_ms * NS // 1000
        made.append((TEAM[place], Transmit(numbers[place], t_ns, bytes([place]) * size)))
        numbers[place] += 1
    return made


def transmit_all(profile: ModemProfile, loss: float, gaps: list[tuple[int, int, int]]) -> SlotWater:
    medium = SlotWater(TEAM, loss, profile=profile)
    for source, request in requests(gaps):
        medium.transmit(source, request)
    return medium


def apart(intervals: list[tuple[int, int]]) -> bool:
    return all(end <= start for (_, end), (start, _) in pairwise(intervals))


@given(PROFILES, LOSSES, GAPS)
def test_every_request_is_accounted_for(profile: ModemProfile, loss: float, gaps) -> None:
    """Requested = refused + started, and every started one has exactly one outcome at each of the other craft."""
    log = transmit_all(profile, loss, gaps).log(FOREVER)
    fates = Counter((line.source, line.seq) for line in log if line.kind in {"refused", "started"})
    assert fates == Counter((source, request.seq) for source, request in requests(gaps))
    outcomes = Counter((line.source, line.seq, line.destination) for line in log if line.kind in {"delivered", "lost"})
    started = [(line.source, line.seq) for line in log if line.kind == "started"]
    assert outcomes == Counter((*who, mate) for who in started for mate in TEAM if mate != who[0])


@given(PROFILES, LOSSES, GAPS)
def test_events_agree_with_the_log(profile: ModemProfile, loss: float, gaps) -> None:
    """Each sender is told once what became of its request, and each delivery in the log is one event, unchanged."""
    medium = transmit_all(profile, loss, gaps)
    events, log = medium.events(FOREVER), medium.log(FOREVER)
    told = Counter((craft, event.ticket, event.status) for _, craft, event in events if not isinstance(event, Received))
    words = {"started": "SENT", "refused": "FAILED"}
    assert told == Counter((line.source, line.seq, words[line.kind]) for line in log if line.kind in words)
    heard = Counter((t, craft, event.source) for t, craft, event in events if isinstance(event, Received))
    assert heard == Counter((line.t_ns, line.destination, line.source) for line in log if line.kind == "delivered")
    assert all(set(event.payload) <= {TEAM.index(event.source)} for *_, event in events if isinstance(event, Received))


@given(PROFILES, LOSSES, GAPS)
def test_never_early(profile: ModemProfile, loss: float, gaps) -> None:
    """A transmission at t causes no event before t + lookahead: what was taken up to there stays complete."""
    medium = SlotWater(TEAM, loss, profile=profile)
    for source, request in requests(gaps):
        medium.advance(request.t_ns)
        SlotMedium.events(medium, request.t_ns + medium.lookahead_ns)
        medium.transmit(source, request)
        medium.advance(request.t_ns + 1)
        assert SlotMedium.events(medium, request.t_ns + medium.lookahead_ns) == []


@given(PROFILES, LOSSES, GAPS)
def test_one_speaker_at_a_time(profile: ModemProfile, loss: float, gaps) -> None:
    """No two transmissions that were started are on the air in the same nanosecond."""
    log = transmit_all(profile, loss, gaps).log(FOREVER)
    on_air = [(line.t_ns, line.t_ns + profile.airtime_ns(line.size_bytes)) for line in log if line.kind == "started"]
    assert apart(on_air)


@given(PROFILES, LOSSES, GAPS)
def test_order_of_time(profile: ModemProfile, loss: float, gaps) -> None:
    """Events and log lines come in the order of time, events of one time in the order of the team."""
    medium = transmit_all(profile, loss, gaps)
    keys = [(t_ns, TEAM.index(craft)) for t_ns, craft, _ in medium.events(FOREVER)]
    assert keys == sorted(keys)
    times = [line.t_ns for line in medium.log(FOREVER)]
    assert times == sorted(times)


@given(PROFILES, GAPS, st.lists(st.integers(0, 30_000), max_size=30))
def test_portions(profile: ModemProfile, gaps, portions_ms: list[int]) -> None:
    """Events and log are the same taken at once or in portions of any length."""
    whole, piecewise = transmit_all(profile, 0.3, gaps), transmit_all(profile, 0.3, gaps)
    events, log, t_ns = [], [], 0
    for portion_ms in portions_ms:
        t_ns += portion_ms * NS // 1000
        events += piecewise.events(t_ns)
        log += piecewise.log(t_ns)
        assert piecewise.next_event_ns() is None or piecewise.next_event_ns() >= t_ns
    assert events + piecewise.events(FOREVER) == whole.events(FOREVER)
    assert log + piecewise.log(FOREVER) == whole.log(FOREVER)


# -- the slots -------------------------------------------------------------------------------------------------------

#: (silence before, length beyond a message, place in the team), times in milliseconds
SLOTS = st.lists(st.tuples(st.integers(0, 9_999), st.integers(0, 9_999), st.integers(0, 2)), min_size=1, max_size=8)


@st.composite
def schedules(draw) -> Schedule:
    """Any schedule that a scenario can ask for, in milliseconds."""
    slots, end_ms = [], 0
    for gap_ms, more_ms, place in draw(SLOTS):
        start_ms, length_ms = end_ms + gap_ms, 10_000 + more_ms
        end_ms = start_ms + length_ms
        slots.append(SlotConfig(TEAM[place], start_ms / 1000, length_ms / 1000))
    order = draw(st.permutations(slots))
    cycle_s = draw(st.none() | st.integers(1, 9_999).map(lambda more_ms: (end_ms + more_ms) / 1000))
    return plan_schedule(Tdma(slots=tuple(order), cycle_s=cycle_s), TEAM, SlotNeeds(PAPER, 15))


#: (start, length beyond a message, place in the team), times in milliseconds; most of these overlap.
ANY_SLOTS = st.lists(
    st.tuples(st.integers(0, 60_000), st.integers(0, 5_000), st.integers(0, 2)), min_size=1, max_size=4
)


def owned_ms(slots) -> list[tuple[int, int]]:
    return sorted((start_ms, start_ms + 10_000 + more_ms) for start_ms, more_ms, _ in slots)


@given(ANY_SLOTS)
def test_overlap_is_found(slots) -> None:
    """Slots are refused exactly when two of them own the same instant."""
    configs = tuple(SlotConfig(TEAM[place], ms / 1000, (10_000 + more_ms) / 1000) for ms, more_ms, place in slots)
    link = Tdma(slots=configs)
    if apart(owned_ms(slots)):
        assert len(plan_schedule(link, TEAM, SlotNeeds(PAPER, 15)).slots) == len(slots)
    else:
        with pytest.raises(ConfigError, match=r"^\$\.link\.mac\.slots\[\d\]\.start_s: .* overlaps "):
            plan_schedule(link, TEAM, SlotNeeds(PAPER, 15))


@given(schedules())
def test_one_owner_at_a_time(schedule: Schedule) -> None:
    """No two craft own the same nanosecond of any schedule, nor does a cycle reach into the next."""
    owned = sorted((slot.start_ns, slot.start_ns + slot.length_ns) for slot in schedule.slots)
    assert apart([*owned, (owned[0][0] + schedule.cycle_ns, 0)])


@given(schedules(), st.integers(0, 10**6), st.integers(0, 10**6))
def test_openings_are_those_of_every_cycle(schedule: Schedule, from_ms: int, length_ms: int) -> None:
    """The openings of a window are found by counting through all cycles, and no window loses or repeats one."""
    from_ns, before_ns = from_ms * NS // 1000, (from_ms + length_ms) * NS // 1000
    middle_ns = (from_ns + before_ns) // 2
    for craft in TEAM:
        counted = sorted(
            cycle * schedule.cycle_ns + slot.start_ns
            for slot in schedule.slots
            for cycle in range(before_ns // schedule.cycle_ns + 1)
            if slot.craft == craft and from_ns <= cycle * schedule.cycle_ns + slot.start_ns < before_ns
        )
        assert schedule.openings(craft, from_ns, before_ns) == counted
        halves = schedule.openings(craft, from_ns, middle_ns) + schedule.openings(craft, middle_ns, before_ns)
        assert halves == counted


@given(schedules())
def test_own_slots_are_free(schedule: Schedule) -> None:
    """Who keeps to its slots is never refused."""
    medium = SlotWater(TEAM)
    until_ns = 3 * schedule.cycle_ns
    openings = [(t_ns, craft) for craft in TEAM for t_ns in schedule.openings(craft, 0, until_ns)]
    for t_ns, source in sorted(openings):
        medium.transmit(source, Transmit(t_ns, t_ns, bytes(15)))
    log = medium.log(FOREVER)
    assert sum(line.kind == "started" for line in log) == 3 * len(schedule.slots)
    assert all(line.kind != "refused" for line in log)
