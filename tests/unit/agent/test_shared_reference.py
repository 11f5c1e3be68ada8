"""The law of the shared reference with literal times: tracking, not keeping up, telling and answering."""

import math

import pytest

from grex_agent.mission import plan_mission
from grex_agent.plan_time import PlanTime
from grex_agent.reference_talk import ReferenceTalk
from grex_agent.shared_reference import Heard, OwnAbility, SharedReference
from grex_agent.team.interface import Own
from grex_link import reference_wire, wire
from grex_link.messages import Received
from grex_link.reference_wire import Limit, ReferenceWord
from grex_link.scenario import decode

FORMATION = {"a": [0.0, 0.0, 0.0], "b": [-6.0, -25.0, 0.0], "c": [-6.0, 25.0, 0.0]}
TEAM = list(FORMATION)


def scenario(**reference):
    """The paper's team with the law."""
    return decode(
        {
            "mission": {"type": "lawnmower", "formation_m": FORMATION, "legs": 4},
            "craft": {name: {} for name in TEAM},
            "team": {
                "controller": "shared_reference",
                "estimator": "none",
                "own_filter": {},
                "reference": reference,
            },
        }
    )


def law(craft="a", **reference):
    """Return a craft's law."""
    config = scenario(**reference)
    return SharedReference(config, craft, plan_mission(config))


def at(seconds):
    """Own state so many plan seconds along the first leg."""
    return Own(seconds, 0.0, seconds / 400.0)


def run(reference, from_s, to_s, behind=lambda _: 0.0, heard=()):
    """Step once a second, so far behind the clock; returns the beliefs at the end."""
    for now in range(from_s, to_s + 1):
        beliefs = reference.step(float(now), at(now - behind(now)), [], heard if now == to_s else ())
    return beliefs


def word(craft, t_s, hold_s=0.0, lag_s=0.0, limits=(), *, asks=False):
    """Return a word in which nobody is limited but those named: craft=(version, speed)."""
    known = {craft: (1, None)} | dict(limits)
    told = tuple(Limit(*known.get(mate, (0, None))) for mate in TEAM)
    return ReferenceWord(TEAM.index(craft), t_s, hold_s, lag_s, told, asks)


# -- tracking -----------------------------------------------------------------------------------------------------


def test_on_the_reference_it_goes_at_planned_speed():
    """No lag, planned speed; 1 s behind it goes faster by the gain, 1 s ahead slower."""
    for behind_s, speed in ((0.0, 1.0), (1.0, 1.15), (-1.0, 0.85)):
        reference = law()
        run(reference, 0, 100, lambda _, behind_s=behind_s: behind_s)
        assert reference.speed(1.0, 0.0, []) == pytest.approx(speed)
        assert reference.lag_s == pytest.approx(-behind_s)


def test_it_speeds_up_before_the_arc():
    """The outer craft orders the arc's speed as long before the arc as its surge takes to follow, and not sooner."""
    reference = law("b")
    run(reference, 0, 397)
    assert reference.speed(1.0, 0.0, []) == pytest.approx(1.0)
    run(reference, 398, 399)
    assert reference.speed(1.0, 0.0, []) == pytest.approx(math.hypot(6.0, 90.0) / 65.0)


def test_the_order_keeps_the_limits():
    """However far it is behind or ahead, the order is within the speed limits of the team."""
    for behind_s, speed in ((300.0, 3.0), (-300.0, 0.3)):
        reference = law()
        reference.step(400.0, at(400.0 - behind_s), [], [])
        assert reference.speed(1.0, 0.0, []) == speed


def test_it_does_not_wind_up():
    """After any time behind, the order is that of the lag now and of nothing before."""
    reference = law()
    run(reference, 0, 300, lambda now: min(0.2 * now, 60.0))
    assert reference.speed(1.0, 0.0, []) == 3.0
    run(reference, 301, 320)
    assert reference.speed(1.0, 0.0, []) == pytest.approx(1.0)


def test_it_yields_with_the_reference():
    """While a mate makes 0.8 m/s, a craft on the reference orders 0.8 m/s."""
    reference = law()
    run(reference, 0, 100, heard=[Heard("c", word("c", 100.0, limits={"c": (2, 0.8)}))])
    for now in range(101, 161):
        reference.step(float(now), at(now - reference.hold_s - 0.2), [], [])
    assert reference.speed(1.0, 0.0, []) == pytest.approx(0.8, abs=0.01)


# -- not keeping up -----------------------------------------------------------------------------------------------


def ability():
    """Return a new ability of craft a."""
    return OwnAbility(PlanTime(plan_mission(scenario())), "a", 1.0)


def test_who_falls_behind_finds_out_its_speed():
    """At 0.8 m/s from 100 s on, a craft is 1 s behind after 5 s; then it knows its speed. Back at 1 m/s it keeps up."""
    own, limits = ability(), {}
    plan_s = 0.0
    for now in range(201):
        own.see(float(now), plan_s, plan_s - now, 1.0)
        limits[now] = own.limit_mps
        plan_s += 0.8 if 100 <= now < 150 else 1.0
    assert all(limits[now] is None for now in range(105))
    assert limits[120] == pytest.approx(0.8)
    assert limits[149] == pytest.approx(0.8)
    assert limits[160] is None


def test_who_is_behind_and_catches_up_keeps_up():
    """A craft that is behind but faster than the reference asks for nothing."""
    own = ability()
    for now in range(60):
        own.see(float(now), 1.1 * now - 20.0, 0.1 * now - 20.0, 1.0)
        assert own.limit_mps is None


def test_who_waits_for_others_keeps_up():
    """A craft that goes as slowly as the reference is not slow itself."""
    own = ability()
    for now in range(60):
        own.see(float(now), 0.5 * now - 1.5, -1.5, 0.5)
        assert own.limit_mps is None


def test_who_cannot_keep_up_goes_on_trying():
    """Though its reference has become as slow as it is, it orders planned speed: else it would never see it can."""
    reference = law("c")
    run(reference, 0, 60, lambda now: 0.2 * now, [Heard("a", word("a", 60.0))])
    told = reference.word()
    assert told.limits[2] == Limit(2, pytest.approx(0.8))
    reference.step(61.0, at(60.8 - 12.0), [told], [])
    for now in range(62, 160):
        reference.step(float(now), at(0.8 * now), [], [])
    assert reference.lag_s == pytest.approx(0.0, abs=1.5)
    assert reference.speed(1.0, 0.0, []) >= 1.0


# -- what is told -------------------------------------------------------------------------------------------------


def test_a_limit_is_owed_until_all_know_it():
    """A new limit is to be said until every mate that is heard has said that it knows it."""
    reference = law("c")
    run(reference, 0, 20, heard=[Heard("a", word("a", 20.0)), Heard("b", word("b", 20.0))])
    assert not reference.owes
    run(reference, 21, 60, lambda now: 0.2 * now)
    assert reference.owes
    told = reference.word()
    assert told.asks
    reference.step(61.0, at(48.8), [told], [Heard("a", word("a", 61.0, limits={"c": (2, 0.8)}))])
    assert reference.owes
    reference.step(62.0, at(49.6), [], [Heard("b", word("b", 62.0, limits={"c": (2, 0.8)}))])
    assert not reference.owes
    assert not reference.word().asks


def test_who_asks_is_answered_once():
    """A mate that wants an answer gets one in the next own slot, and another only if it asks again."""
    reference = law()
    asking = Heard("c", word("c", 50.0, limits={"c": (2, 0.8)}, asks=True))
    run(reference, 0, 50, heard=[asking])
    assert reference.owes
    assert reference.word().limits[2] == Limit(2, 0.8)
    assert not reference.owes


def test_a_mate_whose_copy_is_ahead_is_told():
    """Who has heard of a hold that a mate does not have passes it on."""
    reference = law()
    run(reference, 0, 50, heard=[Heard("c", word("c", 50.0, 20.0))])
    run(reference, 51, 120, lambda _: reference.hold_s)
    assert not reference.owes
    reference.step(121.0, at(101.0), [], [Heard("b", word("b", 121.0))])
    assert reference.owes
    assert reference.word().hold_s == pytest.approx(20.0, abs=0.1)


def test_what_the_mates_believe():
    """Before its first word they take it to be on the reference; the doubt is its lag; a word that has left ends it."""
    reference = law()
    run(reference, 0, 50, lambda _: 0.8)
    assert reference.doubt_m == pytest.approx(0.8)
    told = reference.word()
    reference.step(51.0, at(50.2), [told], [])
    assert reference.doubt_m < 0.2


def test_beliefs_come_from_the_words():
    """A mate not heard is taken to be on the reference; one heard, where its word and its limit put it."""
    beliefs = run(law(), 0, 50, heard=[Heard("c", word("c", 40.0, 0.0, -5.0, {"c": (2, 0.8)}))])
    unheard, heard = beliefs
    assert (unheard.craft, unheard.age_s) == ("b", -1.0)
    assert (unheard.north_m, unheard.east_m) == pytest.approx((44.0, -25.0))
    assert (heard.craft, heard.age_s) == ("c", 10.0)
    assert heard.north_m == pytest.approx(50.0 - 6.0 - 5.0 - 10 * 0.2)
    assert heard.progress == pytest.approx(43.0 / 400.0)


# -- on the air ---------------------------------------------------------------------------------------------------


def test_what_is_read_is_what_the_sender_takes_it_for():
    """The sender knows what its mates read: the same word, and whose it is."""
    payload, as_read = ReferenceTalk("c", TEAM, law("c")).pack(word("c", 40.0, 3.0, -5.0, {"c": (2, 0.8)}))
    talk = ReferenceTalk("a", TEAM, law())
    assert talk.read(Received("c", payload), 50.0) == Heard("c", as_read)
    assert talk.bad_frames == 0


def test_what_is_no_word_of_a_mate_is_counted():
    """A team state, a word of a stranger, of oneself, or in another's name is a bad frame."""
    talk = ReferenceTalk("a", TEAM, law())
    state = wire.pack(wire.TeamState(1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0, 0.1, 0.1))
    said = reference_wire.pack(word("b", 40.0))
    for number, (source, payload) in enumerate([("b", state), ("x", said), ("a", said), ("c", said)], start=1):
        assert talk.read(Received(source, payload), 50.0) is None
        assert talk.bad_frames == number


def test_a_mate_whose_clock_is_ahead():
    """A word from the future by the own clock counts as of now."""
    heard = ReferenceTalk("a", TEAM, law()).read(Received("c", reference_wire.pack(word("c", 55.0))), 50.0)
    assert heard.word.t_s == 50.0
