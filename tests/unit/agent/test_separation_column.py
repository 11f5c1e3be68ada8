"""The guard in a column: what it makes of the guards of the mates, of jumps, and of craft on tasks."""

import math

import pytest

from grex_agent.mission import plan_mission
from grex_agent.plan_time import PlanTime
from grex_agent.separation import load_guard
from grex_agent.separation_pace import MatePace
from grex_link.messages import MateBelief
from grex_link.scenario import loads
from grex_link.wire import NAVIGATION_VALID, ON_TASK, TeamState

COLUMN = loads("""
[fleet]
count = 3
[team]
separation_min_m = 8.0
[mission]
type = "lawnmower"
legs = 3
[mission.formation]
type = "astern"
spacing_m = 12.0
""")
PLAN = plan_mission(COLUMN)


def guard(craft):
    """Build the guard of a craft."""
    return load_guard(COLUMN, craft, PLAN)


def progress(craft, north):
    """Progress of a craft on the first leg."""
    return (north - PLAN.craft[craft].start[0]) / 400.0


def belief(craft, north, age=1.0):
    """What is believed of a craft on the first leg."""
    return MateBelief(craft, north, 0.0, progress(craft, north), 0.0, age)


def follow(seconds, *beliefs, craft="auv3"):
    """Let a craft run after mates as long as it may; mates are (craft, north, speed), silent. Where it gets."""
    own, north, limited_mps = guard(craft), 100.0, 1.0
    for second in range(seconds):
        mates = [belief(name, start + speed * second, float(second)) for name, start, speed in beliefs]
        limited_mps, _ = own.limit(float(second), 1.0, limited_mps, (north, 0.0, 0.0), progress(craft, north), mates)
        north += limited_mps
    return north


def test_a_mate_is_held_back_by_its_own_guard():
    """A slow craft two places ahead slows one down, though the mate between is still believed to run on."""
    between, slow = ("auv2", 112.0, 1.0), ("auv1", 124.0, 0.6)
    assert follow(60, between) == 160.0
    assert follow(60, between, slow) < 124.0 + 60 * 0.6 - 2 * 7.0


def test_one_that_is_believed_to_run_through_is_behind_all_the_same():
    """The foremost is not held up by a follower that is believed to have run past it: its guard keeps that back."""
    assert follow(60, ("auv2", 90.0, 1.8), craft="auv1") == 160.0


def test_a_mate_goes_as_fast_as_believed_from_step_to_step():
    """A mate believed to go at 0.8 m/s is followed at 0.8 m/s, at the minimum."""
    assert follow(100, ("auv2", 112.0, 0.8)) == pytest.approx(112.0 + 0.8 * 100 - 8.0, abs=0.5)


def pace(*rates, age_s=30, jump=lambda _: 0.0):
    """Let a belief go at some rates, a second each, and be corrected by messages now and then."""
    mate, plan_s = MatePace(PlanTime(PLAN)), 0.0
    for second, rate in enumerate(rates):
        heard = second % age_s == 0 and second > 0
        plan_s += rate + (jump(second) if heard else 0.0)
        mate.see(float(second), MateBelief("auv1", 0.0, 0.0, plan_s / 400.0, 0.0, float(second % age_s)))
        mate.held(mate.rate)
    return mate


def test_pace_of_a_mate_that_keeps_up():
    """A mate that goes as believed, with the noise of its fixes in the jumps, is neither slow nor lags."""
    mate = pace(*[1.0] * 125, jump=lambda second: 0.5 * (-1.0) ** (second // 30))
    assert mate.rate == pytest.approx(1.0)
    assert mate.lag_s == 0.0


def test_pace_by_jumps():
    """Of a mate that is believed to keep up, and falls back at every message, the jumps tell the speed, and it lags."""
    mate = pace(*[1.0] * 125, jump=lambda _: -6.0)
    assert mate.rate == pytest.approx(0.8)
    # Heard at 120 s, it has been believed to run at full speed for 5 s since.
    assert mate.lag_s == pytest.approx(0.2 * 5.0, abs=0.25)


def test_jumps_are_no_steps():
    """A jump by a message is no speed from step to step."""
    assert pace(*[1.0] * 62, jump=lambda _: -0.4).rate == pytest.approx(1.0)


def test_what_the_belief_knows_is_no_lag():
    """When a message has told how slow a mate is, the way since then is in the belief, and not taken off again."""
    mate = pace(*[1.0] * 30)
    for second in range(30, 40):
        mate.see(float(second), MateBelief("auv1", 0.0, 0.0, (29.0 + 0.5 * (second - 29)) / 400.0, 0.0, second - 25.0))
        mate.held(0.5)
    assert mate.lag_s == 0.0


def test_a_message_that_comes_late_tells_of_the_time_since():
    """What a jump tells of the speed of a mate holds from when it was heard on, not only from when the message came."""
    mate = pace(*[1.0] * 31)
    for second in range(31, 62):
        plan_s = second + 1.0 - 6.0 * (second >= 60)
        age_s = second - (50.0 if second >= 60 else 20.0)
        mate.see(float(second), MateBelief("auv1", 0.0, 0.0, plan_s / 400.0, 0.0, age_s))
        mate.held(mate.rate)
    assert mate.lag_s == pytest.approx(0.2 * 10.0, abs=0.5)


def test_what_was_before_it_was_heard_is_no_lag():
    """A lag counts from the moment on of which a mate has told last."""
    mate = MatePace(PlanTime(PLAN))
    for second in range(50):
        mate.see(float(second), MateBelief("auv1", 0.0, 0.0, second / 400.0, 0.0, min(float(second), 20.0)))
        mate.held(0.5)
    assert mate.lag_s == pytest.approx(0.5 * 20.0)


def told(north, east, heading_deg, speed, time_s=0.0, flags=NAVIGATION_VALID | ON_TASK, form="full"):
    """Tell a state."""
    return TeamState(0, time_s, north, east, 0.0, speed, math.radians(heading_deg), 0, 0.0, 0.0, flags, form)


def limit(now_s, state, mates=(), on_task=("auv1",)):
    """Limit a craft at 100 m on the first leg that has heard a state of a mate on a task."""
    own = guard("auv2")
    if state is not None:
        own.hear("auv1", state)
    return own.limit(now_s, 1.0, 1.0, (100.0, 0.0, 0.0), progress("auv2", 100.0), list(mates), on_task)[1]


def test_nobody_yields_to_the_phantom_of_a_mate_on_a_task():
    """Where a mate on a task would be on its plan, it is not."""
    phantom = belief("auv1", 106.0)
    assert limit(0.0, None, [phantom], on_task=())
    assert not limit(0.0, None, [phantom])


def test_yields_to_a_mate_on_a_task_where_it_is():
    """A mate on a task is taken to go straight on from where it said it was: across the bows it is yielded to."""
    assert limit(0.0, told(120.0, -20.0, 90.0, 1.0))
    assert not limit(0.0, told(120.0, -60.0, 90.0, 1.0))
    assert limit(40.0, told(120.0, -60.0, 90.0, 1.0))


def test_a_mate_on_a_task_behind_is_no_matter():
    """Who is on a task and behind is not waited for."""
    assert not limit(0.0, told(95.0, -3.0, 0.0, 1.0))


def test_what_is_known_of_a_mate_on_a_task_grows_old():
    """After a minute, or where no heading was told, nobody knows where a mate on a task is."""
    assert limit(59.0, told(90.0, 0.0, 0.0, 0.3))
    assert not limit(61.0, told(90.0, 0.0, 0.0, 0.3))
    assert not limit(59.0, told(90.0, 0.0, 0.0, 0.3, form="short"))


def test_an_older_state_does_not_count():
    """Of two states the later one counts, in whatever order they come."""
    own = guard("auv2")
    own.hear("auv1", told(500.0, 0.0, 0.0, 1.0, time_s=5.0))
    own.hear("auv1", told(103.0, 0.0, 0.0, 1.0, time_s=1.0))
    assert not own.limit(5.0, 1.0, 1.0, (100.0, 0.0, 0.0), progress("auv2", 100.0), [], ["auv1"])[1]


def on_task(course_deg, *mates, speed=1.0):
    """Limit a craft on a task, at 100 m north and 20 m east of the column."""
    return guard("auv3").limit_on_task(0.0, speed, math.radians(course_deg), (100.0, 20.0, 0.0), mates)


def test_on_a_task_it_yields_to_who_is_ahead_on_its_own_course():
    """A craft on a task that runs across the column lets a mate pass, and goes on if nobody is there."""
    limited_mps, yields = on_task(270.0, belief("auv2", 85.0))
    assert yields
    assert COLUMN.team.speed_min_mps <= limited_mps < 1.0
    assert on_task(270.0, belief("auv2", 40.0)) == (1.0, False)
    assert on_task(90.0, belief("auv2", 100.0)) == (1.0, False)
    assert on_task(270.0) == (1.0, False)


def test_on_a_task_it_goes_on_before_who_is_behind():
    """A craft on a task does not slow down for a mate that is near and behind it on its own course."""
    assert guard("auv3").limit_on_task(0.0, 1.0, 0.0, (100.0, 4.0, 0.0), [belief("auv2", 94.0)]) == (1.0, False)
    assert guard("auv3").limit_on_task(0.0, 1.0, 0.0, (100.0, 4.0, 0.0), [belief("auv2", 106.0)])[1]


def test_who_holds_at_its_end_is_taken_to_stay():
    """A mate at the end of its tracks, where it holds, is not taken to go on."""
    for at_end, yields in (("hold", True), ("continue", False)):
        scenario = loads(ASTERN_END, [f'mission.at_end="{at_end}"'])
        plan = plan_mission(scenario)
        end = plan.craft["auv1"].point(1.0)
        mate = [MateBelief("auv1", *end, 1.0, 0.0, 1.0)]
        place, progress = (end[0] - 30.0, end[1], 0.0), 1.0 - 18.0 / 400.0
        assert load_guard(scenario, "auv2", plan).limit(0.0, 1.0, 1.0, place, progress, mate)[1] == yields


ASTERN_END = """
[fleet]
count = 2
[team]
separation_min_m = 14.0
[mission]
type = "lawnmower"
legs = 1
[mission.formation]
type = "astern"
spacing_m = 12.0
"""


def test_on_a_task_that_holds_it_holds():
    """Of a craft that holds, the speed stays 0."""
    assert on_task(270.0, belief("auv2", 100.0), speed=0.0) == (0.0, False)
