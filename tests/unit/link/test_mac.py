"""Medium access aboard: the same openings whatever windows are asked for, at the rates that were asked for."""

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.link_config import PureAloha, SlottedAloha, Tdma
from grex_link.mac import Mac, PureAlohaMac, SlottedAlohaMac, guard_range_m, plan_mac
from grex_link.profile import load_profile
from grex_link.tdma import Schedule, Slot
from grex_link.units import NS

CRAFT = "auv2"

slots = st.lists(st.tuples(st.sampled_from(["auv1", CRAFT]), st.integers(NS // 5, 5 * NS)), min_size=1, max_size=6)
seeds = st.integers(0, 2**63 - 1)


@st.composite
def macs(draw: st.DrawFn) -> Mac:
    """Any of the three."""
    kind = draw(st.sampled_from(["tdma", "slotted", "pure"]))
    if kind == "slotted":
        return SlottedAlohaMac(draw(st.floats(0.01, 1.0)), draw(st.integers(NS // 5, 5 * NS)), 15, draw(seeds))
    if kind == "pure":
        return PureAlohaMac(draw(st.floats(0.05, 5.0)), 15, draw(seeds))
    at_ns, cycle = 0, []
    for craft, length_ns in draw(slots):
        cycle.append(Slot(craft, at_ns, length_ns))
        at_ns += length_ns
    return Schedule(tuple(cycle), at_ns + draw(st.integers(0, 3 * NS)))


def expected(mac: Mac) -> list[int]:
    """Openings of a minute and a half, asked for at once."""
    return mac.openings(CRAFT, 0, 90 * NS)


@given(macs(), st.lists(st.integers(0, 90 * NS), max_size=30))
def test_windows_change_nothing(mac: Mac, cuts: list[int]) -> None:
    """Asked for in any windows that follow each other, the openings are the same, each once and in order."""
    edges = [0, *sorted(cuts), 90 * NS]
    pieces = [t_ns for start, end in pairwise(edges) for t_ns in mac.openings(CRAFT, start, end)]
    assert pieces == expected(mac)
    assert pieces == sorted(pieces)


@given(macs(), st.integers(-(10**12), 10**12), st.integers(-(10**12), 10**10))
def test_openings_lie_in_their_window(mac: Mac, from_ns: int, length_ns: int) -> None:
    """No opening lies outside the window that was asked for, nor before mission time zero."""
    window = mac.openings(CRAFT, from_ns, from_ns + min(length_ns, 90 * NS))
    assert all(max(from_ns, 0) <= t_ns < from_ns + length_ns for t_ns in window)


@given(macs(), st.integers(0, 89 * NS))
def test_single_openings_are_found(mac: Mac, start_ns: int) -> None:
    """A window of one nanosecond finds an opening exactly if there is one."""
    inside = [t_ns for t_ns in expected(mac) if t_ns >= start_ns][:3]
    for t_ns in inside:
        assert t_ns in mac.openings(CRAFT, t_ns, t_ns + 1)
        assert t_ns not in mac.openings(CRAFT, t_ns + 1, t_ns + 2) or inside.count(t_ns + 1)
        assert t_ns not in mac.openings(CRAFT, t_ns - 5, t_ns)


def test_slotted_aloha_speaks_with_its_probability() -> None:
    """Of 20 000 slots a craft uses its share, within four standard deviations, and only their beginnings."""
    mac = SlottedAlohaMac(0.3, 1_700_000_000, 15, seed=5)
    count = 20_000
    opened = mac.openings("auv1", 0, count * mac.slot_ns)
    assert abs(len(opened) / count - 0.3) < 4.0 * math.sqrt(0.3 * 0.7 / count)
    assert not any(t_ns % mac.slot_ns for t_ns in opened)
    assert SlottedAlohaMac(1.0, NS, 15, 5).openings("auv1", 0, 7 * NS) == [place * NS for place in range(7)]


def test_slotted_aloha_draws_are_independent() -> None:
    """Craft draw by themselves: two of them meet as often as chance has it, with another seed elsewhere."""
    mac, count = SlottedAlohaMac(0.5, NS, 15, seed=5), 20_000
    first, second = (set(mac.openings(craft, 0, count * NS)) for craft in ("auv1", "auv2"))
    assert abs(len(first & second) / count - 0.25) < 4.0 * math.sqrt(0.25 * 0.75 / count)
    other = set(SlottedAlohaMac(0.5, NS, 15, seed=6).openings("auv1", 0, count * NS))
    assert abs(len(first & other) / count - 0.25) < 4.0 * math.sqrt(0.25 * 0.75 / count)


def test_pure_aloha_is_a_poisson_process() -> None:
    """Of 20 000 intervals the mean, the spread and the share of long ones are those of an exponential law."""
    rate = 0.37
    opened = PureAlohaMac(rate, 15, seed=3).openings("auv1", 0, round(20_000 / rate) * NS)
    gaps = [(later - earlier) / NS * rate for earlier, later in pairwise(opened)]
    count = len(gaps)
    mean = sum(gaps) / count
    assert abs(count / 20_000 - 1.0) < 4.0 / math.sqrt(20_000)
    assert abs(sum((gap - mean) ** 2 for gap in gaps) / count - 1.0) < 4.0 * math.sqrt(8.0 / count)
    for limit in (0.1, 0.5, 1.0, 2.0, 4.0):
        chance = math.exp(-limit)
        share = sum(gap > limit for gap in gaps) / count
        assert abs(share - chance) < 4.0 * math.sqrt(chance * (1.0 - chance) / count), limit


def test_pure_aloha_has_no_memory() -> None:
    """What comes after an opening does not depend on what came before: neighbouring intervals do not correlate."""
    opened = PureAlohaMac(1.0, 15, seed=11).openings("auv1", 0, 20_000 * NS)
    gaps = [(later - earlier) / NS - 1.0 for earlier, later in pairwise(opened)]
    correlation = sum(a * b for a, b in pairwise(gaps)) / sum(a * a for a in gaps)
    assert abs(correlation) < 4.0 / math.sqrt(len(gaps))


def test_rare_and_frequent_openings() -> None:
    """Rates from one in years to thousands a second give what they say, at once."""
    assert PureAlohaMac(1e-9, 15, 1).openings("auv1", 0, NS) == []
    many = PureAlohaMac(5000.0, 15, 1).openings("auv1", 0, NS)
    assert abs(len(many) - 5000) < 4.0 * math.sqrt(5000)


# -- the plan -----------------------------------------------------------------------------------------------------

OWN = """
title = "a modem of ours"
payload_max_bytes = 64
airtime_fixed_s = 0.2
airtime_per_byte_s = 0.01
turnaround_s = 0.05
frequency_hz = 26000.0
bandwidth_hz = 16000.0
source_level_db = 184.0
reception = { type = "threshold", sinr_db = 3.0 }
sources = ["us"]
assumed = []
"""


@pytest.fixture
def wet(tmp_path, make) -> Callable[..., Scenario]:
    """Scenarios on an acoustic modem of our own."""
    file = tmp_path / "own.toml"
    file.write_text(OWN, "utf-8")
    return lambda *overrides: make(f"link.profile='{file}'", *overrides)


def test_the_paper_keeps_its_slots(make) -> None:
    """On the paper's modem slots are ten seconds and nothing else, however far the craft are apart."""
    mac = plan_mac(make(), 4000.0, 15)
    assert mac.openings("auv2", 0, 100 * NS) == [10 * NS, 40 * NS, 70 * NS]
    assert (mac.messages_per_slot, mac.message_bytes) == (1, 32)


def test_tdma_by_default(wet) -> None:
    """The default slot is airtime, sound over half as much again as planned and 50 m, clocks, turnaround, jitter."""
    mac = plan_mac(wet(), 100.0, 15)
    slot_s = 0.35 + 200.0 / 1500.0 + 0.02 + 0.05 + 0.01
    assert mac.openings("auv2", 0, NS) == [round(math.ceil(slot_s * 1000.0) * 1e6)]


def test_the_scenario_says_how_far(wet) -> None:
    """A range, clock error, jitter and speed of sound of the scenario's own make the guard."""
    mac = "link.mac={type='tdma',range_max_m=300,clock_error_s=0.1,jitter_s=0.07,messages_per_slot=2}"
    planned = plan_mac(wet(mac, "link.water.sound_speed=1480"), 100.0, 15)
    slot_s = 2 * 0.35 + 0.05 + 300.0 / 1480.0 + 0.2 + 0.05 + 0.07
    assert planned.openings("auv2", 0, 2 * NS) == [round(math.ceil(slot_s * 1000.0) * 1e6)]
    assert planned.messages_per_slot == 2


@pytest.mark.parametrize(
    ("mac", "range_m"),
    [
        (Tdma(), 200.0),
        (Tdma(range_max_m=120.0), 120.0),
        (SlottedAloha(probability=0.1), 200.0),
        (PureAloha(rate_per_s=1.0), 200.0),
    ],
)
def test_guard_range(mac: Tdma | SlottedAloha | PureAloha, range_m: float) -> None:
    """Craft that are apart still fit: half as much again as planned and 50 m, if the scenario says nothing else."""
    assert guard_range_m(mac, 100.0) == range_m


def test_slotted_aloha_has_slots_like_tdma(wet) -> None:
    """Left out, a slot of Aloha is as long as one of TDMA."""
    aloha = plan_mac(wet("link.mac={type='slotted_aloha',probability=1.0}"), 100.0, 15)
    tdma = plan_mac(wet(), 100.0, 15)
    assert aloha.openings("auv1", NS // 10, NS) == tdma.openings("auv2", 0, NS)
    assert aloha.message_bytes == tdma.message_bytes


@pytest.mark.parametrize(("slot_s", "says"), [(0.3, "a message takes 0.35 s"), (0.4, "sound takes 0.067 s")])
def test_slotted_aloha_with_slots_too_short(wet, slot_s: float, says: str) -> None:
    """A slot in which message and sound have no room is refused with the number that would do."""
    with pytest.raises(ConfigError, match=says) as caught:
        plan_mac(wet(f"link.mac={{type='slotted_aloha',probability=0.5,slot_s={slot_s}}}"), 100.0, 15)
    assert caught.value.path == "$.link.mac.slot_s"
    assert "0.564 s would do" in caught.value.problem
    plan_mac(wet("link.mac={type='slotted_aloha',probability=0.5,slot_s=0.564}"), 100.0, 15)


def test_pure_aloha_carries_what_the_modem_does(wet) -> None:
    """Without slots the longest message is the modem's, and the link's seed draws the times."""
    rate = "link.mac={type='aloha',rate_per_s=0.5}"
    mac = plan_mac(wet(rate), 100.0, 15)
    assert mac.message_bytes == load_profile(wet().link.profile).payload_max_bytes
    assert mac.openings("auv1", 0, 100 * NS) != plan_mac(wet(rate, "link.seed=9"), 100.0, 15).openings(
        "auv1", 0, 100 * NS
    )
