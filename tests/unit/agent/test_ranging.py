"""From what a modem says to ranges: literal times of the two ends."""

import pytest

from grex_agent.mission import plan_mission
from grex_agent.ranging import Ranging, ranged_to
from grex_link.messages import RangeResult, Received
from grex_link.profile import load_profile
from grex_link.scenario import loads
from grex_link.units import NS
from grex_link.wire import ON_TASK, TeamState

TEAM = """
[team]
own_filter = {}
[team.ranging]
mode = "%s"
every = 2
[mission]
type = "lawnmower"
leg_length_m = 400.0
turn_radius_m = 100.0
[mission.formation_m]
boat = [0.0, 0.0, 0.0]
ship = [0.0, 60.0, 0.0]
auv1 = [0.0, -30.0, 10.0]
auv2 = [0.0, 30.0, 10.0]
[link]
profile = "%s"
[craft.boat]
[craft.ship]
[craft.auv1.inertial]
[craft.auv2.inertial]
[craft.base.base]
place_ned_m = [0.0, -2000.0, 30.0]
watch = "auv1"
"""


def ranging(craft="auv1", mode="two_way", profile="umodem_psk1"):
    """The ranging of a craft, and the modem it is for."""
    scenario = loads(TEAM % (mode, profile))
    modem = load_profile(profile)
    return Ranging(scenario, craft, plan_mission(scenario), modem), modem


def told(t_s, *, north=100.0, east=0.0, source=0, speed=1.0, track=0, theta=0.25, flags=1):
    """A state of the boat, on its way to the north."""
    return TeamState(source, t_s, north, east, 0.0, speed, 0.0, track, theta, 0.2, flags)


def received(source="boat", one_way_s=None):
    """A message of 15 bytes."""
    return Received(source, bytes(15), one_way_s=one_way_s)


def test_only_craft_that_know_where_they_are():
    """A craft that drifts ranges to those with GPS, these to nobody, a base to the craft it watches."""
    scenario = loads(TEAM % ("two_way", "umodem_psk1"))
    assert ranged_to(scenario, "auv1") == ranged_to(scenario, "auv2") == ["boat", "ship"]
    assert ranged_to(scenario, "boat") == []
    assert ranged_to(scenario, "base") == ["auv1"]
    own, _ = ranging()
    own.on_message(received("auv2"), 10 * NS, told(9.0, source=3))
    own.on_range(RangeResult(0, "auv2", 60.0), 12 * NS)
    assert own.take() == []


def test_one_way_by_the_beginning_of_the_sound():
    """A message out at 106.04 s, of 3.4 s, after 0.5 s of decoding and 0.04 s on the way, left at 102.1 s: 60 m."""
    own, modem = ranging(mode="one_way")
    assert (modem.airtime_ns(15), modem.decode_latency_s) == (3.4 * NS, 0.5)
    own.on_message(received(one_way_s=0.04), round(106.04 * NS), told(100.0))
    (heard,) = own.take()
    assert (heard.t_s, heard.there_s, heard.range_m) == pytest.approx((102.14, 102.1, 60.0))
    # The boat told its place of 100 s; until 102.1 s it has gone on at 1 m/s, give or take a tenth of that.
    assert (heard.north_m, heard.east_m, heard.down_m) == pytest.approx((102.1, 0.0, 0.0))
    assert heard.sigma_m == pytest.approx((0.2**2 + 0.21**2) ** 0.5)
    assert own.take() == []


def test_without_a_travel_time_there_is_no_one_way_range():
    """A message without a measured time is only a message."""
    own, _ = ranging(mode="one_way")
    own.on_message(received(), 106 * NS, told(100.0))
    assert own.take() == []


def test_the_ambiguity_is_resolved_by_the_plan():
    """A modem that knows travel times modulo 1 s gives 1.333 s as 0.333 s: by the plan the base is 2 km away."""
    base, _ = ranging("base", mode="one_way")
    base.on_message(received("auv1", one_way_s=1.0 / 3.0), 110 * NS, told(100.0, east=-30.0, source=2))
    (heard,) = base.take()
    assert heard.range_m == pytest.approx(2000.0)
    own, _ = ranging(mode="one_way")
    own.on_message(received(one_way_s=0.995), 110 * NS, told(100.0))  # noise has made a short time negative
    assert own.take()[0].range_m == pytest.approx(-7.5)


def test_two_way_by_the_middle():
    """A result at 50 s, of pings of 1 s, 0.5 s of decoding, 0.05 s to answer and 75 m, is of 48.425 s."""
    own, _ = ranging()
    own.on_message(received(), 47 * NS, told(44.425))
    own.on_range(RangeResult(0, "boat", 75.0), 50 * NS)
    (heard,) = own.take()
    assert (heard.t_s, heard.there_s, heard.range_m) == pytest.approx((48.425, 48.425, 75.0))
    assert heard.north_m == pytest.approx(104.0)


def test_carried_round_the_bend():
    """On an arc the place told is carried along the arc: radius 100 m about (400, 100)."""
    own, _ = ranging()
    own.on_message(received(), 600 * NS, told(598.425, north=400.0, east=0.0, track=1, theta=0.0))
    own.on_range(RangeResult(0, "boat", 75.0), round(601.575 * NS) + 10 * NS)
    (heard,) = own.take()
    way = heard.t_s - 598.425
    assert way == pytest.approx(11.575)
    assert ((heard.north_m - 400.0) ** 2 + (heard.east_m - 100.0) ** 2) ** 0.5 == pytest.approx(100.0, abs=0.01)
    assert heard.east_m == pytest.approx(way**2 / 200.0, abs=0.01)


def test_nothing_known_of_the_other_end():
    """Without a message, without an answer, or from a mate whose navigation is not valid, there is no range."""
    own, _ = ranging()
    own.on_range(RangeResult(0, "boat", 75.0), 50 * NS)
    own.on_message(received(), 47 * NS, told(45.0, flags=0))
    own.on_range(RangeResult(0, "boat", 75.0), 50 * NS)
    own.on_message(received(), 47 * NS, told(45.0))
    own.on_range(RangeResult(0, "boat", None), 50 * NS)
    assert own.take() == []


@pytest.mark.parametrize("flags", [0, 1 | ON_TASK])
def test_who_leaves_its_plan_is_no_reference(flags):
    """A mate that says it is on a task, or lost, was where it told before: that is no longer carried along its plan."""
    own, _ = ranging()
    own.on_message(received(), 47 * NS, told(44.0))
    own.on_message(received(), 70 * NS, told(67.0, flags=flags))
    own.on_range(RangeResult(0, "boat", 75.0), 75 * NS)
    assert own.take() == []
    own.on_message(received(), 147 * NS, told(144.0))
    own.on_range(RangeResult(0, "boat", 75.0), 150 * NS)
    assert len(own.take()) == 1


def test_a_base_goes_on_ranging_to_who_leaves_its_plan():
    """To a base it is no matter where the craft ought to be: the range to a craft on a task counts."""
    base, _ = ranging("base")
    base.on_message(received("auv1"), 47 * NS, told(44.0, source=2, flags=1 | ON_TASK))
    base.on_range(RangeResult(0, "auv1", 2000.0), 50 * NS)
    assert [heard.range_m for heard in base.take()] == [2000.0]


def test_an_old_message_is_no_reference():
    """A mate that has been silent for more than five minutes may be anywhere."""
    own, _ = ranging()
    own.on_message(received(), 47 * NS, told(44.0))
    own.on_range(RangeResult(0, "boat", 75.0), 340 * NS)
    assert len(own.take()) == 1
    own.on_range(RangeResult(0, "boat", 75.0), 350 * NS)
    assert own.take() == []


def test_all_are_asked_in_turn():
    """After every second own message the next one is asked; without two-way ranging nobody is, by a base always."""
    own, _ = ranging()
    asked = []
    for _ in range(8):
        own.on_own_messages(1)
        asked.append(own.next_to_ask())
    assert asked == [None, "boat", None, "ship"] * 2
    listening, _ = ranging(mode="one_way")
    listening.on_own_messages(9)
    assert listening.next_to_ask() is None
    base, _ = ranging("base")
    assert [base.next_to_ask(), base.next_to_ask()] == ["auv1", "auv1"]
