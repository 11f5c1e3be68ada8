"""The copy of the shared reference, with literal times: when it yields, how fast, to whom, and for how long."""

import pytest

from grex_agent.mission import plan_mission
from grex_agent.plan_time import PlanTime
from grex_agent.team_reference import TeamReference
from grex_link.coordination_config import ReferenceConfig
from grex_link.reference_wire import Limit, ReferenceWord
from grex_link.scenario import decode

FORMATION = {"a": [0.0, 0.0, 0.0], "b": [-6.0, -25.0, 0.0], "c": [-6.0, 25.0, 0.0]}
TEAM = list(FORMATION)
PLAN = plan_mission(
    decode(
        {"mission": {"type": "lawnmower", "formation_m": FORMATION, "legs": 4}, "craft": {name: {} for name in TEAM}}
    )
)
TIME = PlanTime(PLAN)


def copy(craft="a", **config):
    """Return a craft's copy."""
    return TeamReference(craft, TIME, TEAM, ReferenceConfig(**config))


def word(craft, t_s, hold_s=0.0, lag_s=0.0, limits=(), *, asks=False):
    """Return a word in which nobody is limited but those named: craft=(version, speed)."""
    known = {craft: (1, None)} | dict(limits)
    told = tuple(Limit(*known.get(mate, (0, None))) for mate in TEAM)
    return ReferenceWord(TEAM.index(craft), t_s, hold_s, lag_s, told, asks)


# -- the plan as time ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("plan_s", [-10.0, 0.0, 399.0, 400.0, 500.0, 604.2, 5000.0])
def test_plan_time_and_progress_are_each_others_inverse(plan_s):
    """Progress at a plan time, taken back to time, is that time, before and after the plan too."""
    assert TIME.at(TIME.progress(plan_s)) == pytest.approx(plan_s)


def test_the_plan_as_time():
    """A leg of 400 m takes 400 s; on the arc the outer craft goes faster, and each is where its plan is."""
    assert TIME.number(399.9) == 0
    assert TIME.number(400.1) == 1
    assert TIME.speed("c", 100.0) == pytest.approx(1.0)
    assert TIME.speed("b", 500.0) == pytest.approx((6.0**2 + 90.0**2) ** 0.5 / 65.0)
    assert TIME.point("b", 100.0) == pytest.approx((94.0, -25.0))


# -- yielding -----------------------------------------------------------------------------------------------------


def test_without_a_word_it_is_the_clock():
    """Nobody heard, nothing held: plan time is mission time, at the rate of the plan."""
    reference = copy()
    reference.advance(321.5)
    assert (reference.plan_s, reference.hold_s, reference.rate) == (321.5, 0.0, 1.0)


def test_a_mate_that_cannot_keep_up():
    """From a word of 0.8 m/s on the reference runs at 0.8, and the hold grows 0.2 s a second; then at 1 again."""
    reference = copy()
    reference.advance(100.0)
    reference.take("c", word("c", 100.0, limits={"c": (2, 0.8)}))
    assert reference.rate == pytest.approx(0.8)
    reference.advance(150.0)
    assert reference.hold_s == pytest.approx(10.0)
    reference.take("c", word("c", 150.0, 10.0, limits={"c": (3, None)}))
    reference.advance(200.0)
    assert reference.hold_s == pytest.approx(10.0)
    assert reference.rate == pytest.approx(1.0)


def test_a_limit_is_a_speed_not_a_share():
    """On an arc, where the outer craft needs 1.39 m/s, the same limit makes the reference slower."""
    reference = copy()
    reference.advance(395.0)
    reference.take("b", word("b", 395.0, limits={"b": (2, 0.8)}))
    reference.advance(450.0)
    assert reference.rate == pytest.approx(0.8 * 65.0 / (6.0**2 + 90.0**2) ** 0.5)


def test_a_word_that_is_late_counts_from_its_time():
    """What a mate said 10 s ago holds the reference back for those 10 s, too."""
    reference = copy(yield_gain_per_s=100.0, yield_min=0.0)
    reference.advance(100.0)
    reference.take("c", word("c", 90.0, 0.0, -4.0, {"c": (2, 0.8)}))
    reference.advance(110.0)
    assert reference.hold_s == pytest.approx(4.0 + 20 * 0.2, abs=0.01)


def test_a_mate_behind_is_waited_for_not_too_abruptly():
    """For a mate 10 s behind the reference falls back, never slower than yield_min, and then stays."""
    reference = copy()
    reference.advance(100.0)
    reference.take("c", word("c", 100.0, 0.0, -10.0))
    rates = []
    for second in range(101, 161):
        before = reference.plan_s
        reference.advance(float(second))
        rates.append(reference.plan_s - before)
    assert min(rates) == pytest.approx(0.3)
    assert reference.hold_s == pytest.approx(10.0, abs=0.01)
    assert rates[-1] == pytest.approx(1.0, abs=0.01)


def test_within_the_deadband_nobody_waits():
    """A mate 0.9 s behind does not ask for anything; one 1.1 s behind does."""
    for lag_s, hold_s in ((-0.9, 0.0), (-1.1, 1.1)):
        reference = copy()
        reference.take("c", word("c", 0.0, 0.0, lag_s))
        reference.advance(60.0)
        assert reference.hold_s == pytest.approx(hold_s, abs=0.01)


def test_copies_agree_on_the_greatest_hold():
    """Of two copies the one that is ahead falls back to the other's, and the other one does not move."""
    ahead, behind = copy("a"), copy("b")
    ahead.take("b", word("b", 0.0, 7.0))
    behind.take("a", word("a", 0.0, 0.0))
    for reference in (ahead, behind):
        reference.advance(60.0)
    assert ahead.hold_s == pytest.approx(7.0, abs=0.01)
    assert behind.hold_s == 0.0


def test_a_newer_word_takes_back_what_the_older_asked_for():
    """A mate that has caught up by itself is not waited for any longer; what was held stays held."""
    reference = copy()
    reference.take("c", word("c", 0.0, 0.0, -30.0))
    reference.advance(10.0)
    held_s = reference.hold_s
    assert held_s == pytest.approx(7.0)
    reference.take("c", word("c", 10.0, 0.0, 0.0))
    reference.advance(60.0)
    assert reference.hold_s == pytest.approx(held_s)


def test_words_out_of_order():
    """An older word that arrives after a newer one changes nothing."""
    reference = copy()
    reference.take("c", word("c", 30.0, limits={"c": (3, None)}))
    reference.take("c", word("c", 0.0, 0.0, -20.0, {"c": (2, 0.5)}))
    reference.advance(60.0)
    assert reference.hold_s == 0.0


# -- relays, silence, return --------------------------------------------------------------------------------------


def test_a_limit_is_relayed():
    """What b says of c holds for a, who has not heard c; an older version does not replace a newer one."""
    reference = copy()
    reference.take("b", word("b", 0.0, limits={"c": (2, 0.8)}))
    assert reference.rate == pytest.approx(0.8)
    reference.take("c", word("c", 10.0, limits={"c": (3, None)}))
    reference.take("b", word("b", 20.0, limits={"c": (2, 0.8)}))
    assert reference.rate == 1.0


def test_nobody_tells_a_craft_of_itself():
    """The own limit is what the craft itself has said, and not an echo of it."""
    reference = copy("a")
    reference.take("b", word("b", 0.0, limits={"a": (2, 0.5)}))
    assert reference.limit("a") == Limit()
    assert reference.rate == 1.0


def test_a_mate_silent_for_long_is_not_waited_for():
    """After silence_s a limit holds no longer; what it has held so far stays, and Θ goes on from there."""
    reference = copy(silence_s=100.0)
    reference.take("c", word("c", 0.0, limits={"c": (2, 0.5)}))
    reference.take("b", word("b", 0.0))
    reference.advance(90.0)
    reference.take("b", word("b", 90.0, 45.0))
    reference.advance(150.0)
    assert reference.hold_s == pytest.approx(50.0, abs=1.0)
    assert reference.mates == ["b"]


def test_a_mate_that_returns_is_waited_for_smoothly():
    """After an hour of silence the return of a mate that is far behind makes no jump: the reference slows down."""
    reference = copy(silence_s=100.0)
    reference.take("c", word("c", 0.0))
    reference.advance(3600.0)
    assert reference.told("c").behind_s == pytest.approx(reference.hold_s)
    before = reference.plan_s
    reference.take("c", word("c", 3600.0, 0.0, -50.0))
    assert reference.plan_s == before
    reference.advance(3601.0)
    assert reference.plan_s - before == pytest.approx(0.3)


def test_alone_a_craft_does_not_wait_for_itself():
    """As long as no mate is heard the own limit and lag do not hold the own copy back; then they do."""
    reference = copy("a")
    reference.take("a", word("a", 0.0, 0.0, -5.0, {"a": (2, 0.5)}))
    reference.advance(30.0)
    assert reference.hold_s == 0.0
    reference.take("b", word("b", 30.0))
    assert reference.rate < 1.0


def test_where_a_mate_is_thought_to_be():
    """A mate that keeps up closes its lag, one that does not is carried on at its limit."""
    reference = copy("a", yield_gain_per_s=1e-6)
    reference.take("b", word("b", 0.0, 0.0, 0.9))
    reference.take("c", word("c", 0.0, 0.0, -0.9, {"c": (2, 0.8)}))
    reference.advance(60.0)
    assert reference.told("b").behind_s == pytest.approx(reference.hold_s, abs=0.01)
    assert reference.told("c").behind_s == pytest.approx(0.9 + 60 * 0.2, abs=0.01)
