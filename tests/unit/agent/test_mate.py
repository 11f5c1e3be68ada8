"""One mate's filter: messages that come late are worked in where they belong (eq. 11)."""

import math
from itertools import permutations

import pytest

from grex_agent.coordination import ThetaP
from grex_agent.guidance import TrackKeeping
from grex_agent.mission import plan_mission
from grex_agent.team.mate import MateFilter
from grex_agent.team.planar import Follower, PlanarMate
from grex_link.scenario import decode
from grex_link.wire import TeamState

# Legs of 100 s and half circles of 63 s, so that messages meet track changes.
SCENARIO = decode(
    {
        "mission": {
            "type": "lawnmower",
            "formation_m": {"auv1": [-6.0, -10.0, 0.0]},
            "legs": 4,
            "leg_length_m": 100.0,
            "turn_radius_m": 20.0,
        },
        "craft": {"auv1": {}},
    }
)
PLAN = plan_mission(SCENARIO).craft["auv1"]


def mate(memory_s=300.0, tick_s=1.0):
    """Build the filter of a mate at the start of its plan."""
    keeping, controller = TrackKeeping(SCENARIO.guidance), ThetaP(SCENARIO.team)
    return MateFilter(PlanarMate(PLAN, Follower(PLAN, keeping, controller), SCENARIO.team.kalman), memory_s, tick_s)


def message(t_s, north_m, east_m, track=0, theta=0.0):
    """A mate's message, valid at a time."""
    return TeamState(0, t_s, north_m, east_m, 0.0, 1.0, 0.0, track, theta, 0.1)


def reports(*times_s, rate=1.03):
    """Messages of a mate that runs a little faster than planned, off its track by half a metre."""
    made = []
    for t_s in times_s:
        progress = min(rate * t_s / 100.0, 0.99) if t_s < 100.0 else 1.0 + (rate * t_s - 100.0) / (math.pi * 20.0)
        north, east = PLAN.point(progress)
        made.append(message(t_s, north, east + 0.5, int(progress), progress % 1.0))
    return made


def others(tick):
    """Progress of two others at a tick, changing from tick to tick."""
    return [0.01 * tick + 0.02 * math.sin(tick), 0.01 * tick - 0.03]


def run(until_s, arrivals, tick_s=1.0, memory_s=300.0):
    """Step a filter to a time; arrivals are (time, message), worked in at the first step from then on."""
    filtered = mate(memory_s, tick_s)
    waiting = sorted(arrivals, key=lambda arrival: arrival[0])
    tick = 0
    while tick * tick_s < until_s:
        tick += 1
        filtered.advance(tick * tick_s)
        while waiting and waiting[0][0] <= tick * tick_s + 1e-9:
            assert filtered.correct(waiting.pop(0)[1])
        filtered.drive(others(tick))
    return filtered


def run_in_order(until_s, messages):
    """Step a filter that has every message at the very moment it speaks of."""
    filtered = mate()
    waiting = sorted(messages, key=lambda state: state.t_s)
    for tick in range(1, int(until_s) + 1):
        while waiting and waiting[0].t_s < tick - 1e-6:
            filtered.advance(waiting[0].t_s)
            assert filtered.correct(waiting.pop(0))
        filtered.advance(float(tick))
        if waiting and waiting[0].t_s <= tick + 1e-6:
            assert filtered.correct(waiting.pop(0))
        filtered.drive(others(tick))
    return filtered


def numbers(filtered):
    """Mean and covariance of a filter: north, east, both velocities, and the three numbers of the covariance."""
    x = filtered.state.x
    return x.north, x.east, x.v_north, x.v_east, x.pp, x.pv, x.vv


def age_s(filtered, now_s):
    """Age of what a filter has heard."""
    return filtered.belief("auv1", now_s).age_s


def assert_same(one, other):
    """Hold two filters against each other."""
    assert numbers(one) == pytest.approx(numbers(other), abs=1e-9)
    assert one.progress == pytest.approx(other.progress, abs=1e-9)


# -- KF 1 alone ---------------------------------------------------------------------------------------------------


def test_starts_where_the_plan_starts():
    """Before anything is heard the mate is believed at its start, at its planned speed."""
    filtered = mate()
    assert numbers(filtered)[:4] == pytest.approx((-6.0, -10.0, 1.0, 0.0))
    assert filtered.progress == pytest.approx(0.0)
    assert age_s(filtered, 12.0) == -1.0


def test_follows_the_plan_unheard():
    """A mate never heard, in a team at equal progress, is believed on its plan, round the turn and all."""
    filtered = mate()
    for tick in range(1, 401):
        filtered.advance(float(tick))
        filtered.drive([filtered.progress, filtered.progress])
        north, east = PLAN.point(filtered.progress)
        assert math.hypot(filtered.state.x.north - north, filtered.state.x.east - east) < 1.0
    planned_s = 200.0 + math.pi * 40.0
    assert filtered.progress == pytest.approx(4.0 + (400.0 - planned_s) / 100.0, abs=0.05)


def test_is_driven_by_the_others():
    """The model of the mate speeds up and slows down by eq. (2) with the progress of the others."""
    ahead, behind = mate(), mate()
    ahead.drive([0.25, 0.25])
    behind.drive([-0.25, -0.25])
    for tick in range(1, 11):
        ahead.advance(float(tick))
        behind.advance(float(tick))
    # 1 m/s at first, then ±0.4 m/s less what has been caught up since.
    assert ahead.state.x.v_north == pytest.approx(
        1.4 - 1.6 * (ahead.progress - ahead.state.x.v_north / 100.0), abs=0.01
    )
    assert behind.state.x.v_north == pytest.approx(
        0.6 - 1.6 * (behind.progress - behind.state.x.v_north / 100.0), abs=0.01
    )


def test_grows_unsure_unheard():
    """While nothing is heard the claimed uncertainty grows."""
    filtered = mate()
    filtered.advance(10.0)
    after_10_s = filtered.state.x.pp
    filtered.advance(60.0)
    assert filtered.state.x.pp > after_10_s > SCENARIO.team.kalman.fix_sigma_m**2


def test_a_long_step_is_made_of_ticks():
    """A step that was missed is caught up with in ticks, as if none had been missed."""
    late, steady = mate(), mate()
    late.advance(20.6)
    for tick in range(1, 21):
        steady.advance(float(tick))
    steady.advance(20.6)
    assert_same(late, steady)


def test_the_same_time_twice_is_one_step():
    """Advancing to the time that it is changes nothing."""
    filtered = mate()
    filtered.advance(12.0)
    before = filtered.state
    filtered.advance(12.0)
    assert filtered.state == before


@pytest.mark.parametrize("t_s", [30.4, 98.9, 99.4, 99.9, 162.5])
def test_a_prediction_made_in_advance_is_taken_back(t_s):
    """A prediction made for a later time than that of the next step changes nothing, at track changes neither."""
    eager, patient = mate(), mate()
    for filtered in (eager, patient):
        filtered.advance(t_s - 0.9)
    eager.advance(t_s + 0.6)
    for tick in range(10):
        eager.advance(t_s + tick)
        patient.advance(t_s + tick)
        assert_same(eager, patient)


def test_a_prediction_taken_back_after_a_message():
    """A prediction that is taken back leaves the mate on the track that its message put it on."""
    eager, patient = run(115.0, []), run(115.0, [])
    for filtered in (eager, patient):
        assert filtered.correct(message(115.0, 80.0, -10.0, track=0))
    eager.advance(116.0)
    for filtered in (eager, patient):
        filtered.advance(115.4)
    assert_same(eager, patient)
    assert patient.progress < 0.95


# -- KF 2 ---------------------------------------------------------------------------------------------------------


def test_ten_seconds_late_is_as_if_in_time():
    """A message that took 10 s leaves the filter where it would be, had the message been there at its time."""
    said = reports(30.0)
    assert_same(run(60.0, [(40.0, said[0])]), run_in_order(60.0, said))


def test_late_messages_across_track_changes():
    """The same holds for a whole mission of messages, each 10 s late, some of them from before a track change."""
    said = reports(0.0, 30.0, 60.0, 90.0, 100.0, 120.0, 150.0)
    late = run(180.0, [(state.t_s + 10.0, state) for state in said])
    assert_same(late, run_in_order(180.0, said))
    assert late.progress > 2.0


def test_any_order_of_arrival():
    """Three messages that arrive together give the same, in whatever order they are worked in."""
    said = reports(20.0, 33.0, 47.5)
    wanted = run_in_order(60.0, said)
    for order in permutations(said):
        assert_same(run(60.0, [(55.0, state) for state in order]), wanted)


def test_last_message_first():
    """A message older than one already worked in still counts, and leaves the age as it was."""
    old, new = reports(20.0, 50.0)
    filtered = run(60.0, [(52.0, new), (58.0, old)])
    assert_same(filtered, run_in_order(60.0, [old, new]))
    assert age_s(filtered, 60.0) == 10.0


@pytest.mark.parametrize("t_s", [30.25, 30.5, 30.95])
def test_between_two_ticks(t_s):
    """A message of a time between two steps is worked in at that time, not at a step."""
    said = reports(t_s)
    assert_same(run(60.0, [(41.0, said[0])]), run_in_order(60.0, said))


def test_a_message_pulls():
    """A fix 3 m ahead of the belief moves the belief ahead, at its time and after."""
    fix = message(50.0, run(50.0, []).state.x.north + 3.0, -10.0)
    unheard, heard = run(60.0, []), run(60.0, [(60.0, fix)])
    assert unheard.state.x.north + 1.5 < heard.state.x.north < unheard.state.x.north + 3.0


def test_without_news_replay_changes_nothing():
    """A message that says exactly what was believed leaves the mean where it was, and narrows it."""
    believed = run(50.0, []).state.x
    unheard = run(60.0, [])
    heard = run(60.0, [(60.0, message(50.0, believed.north, believed.east))])
    assert numbers(heard)[:4] == pytest.approx(numbers(unheard)[:4], abs=1e-9)
    assert heard.state.x.pp < unheard.state.x.pp


def test_comes_back_to_the_track_the_mate_is_on():
    """A belief that ran ahead onto the next track comes back to the track the mate says it is on."""
    filtered = run(115.0, [])
    assert filtered.progress > 1.0
    assert filtered.correct(message(112.0, 80.0, -10.0, track=0))
    theta = PLAN.tracks[0].locate(*numbers(filtered)[:2]).theta
    assert filtered.progress == pytest.approx(theta, abs=1e-12)
    assert theta < 0.95


def test_goes_on_to_the_track_the_mate_is_on():
    """Abeam of the first leg, on the way back, only the track number tells that the first leg is long done."""
    filtered = run(80.0, [])
    north, east = PLAN.point(2.5)
    assert PLAN.tracks[0].locate(north, east).theta < 1.0
    assert filtered.correct(message(80.0, north, east, track=2))
    assert filtered.progress == pytest.approx(2.5, abs=0.05)


def test_the_same_message_twice_counts_once():
    """A message that is delivered again changes nothing."""
    once, twice = run(60.0, []), run(60.0, [])
    said = message(50.0, 46.0, -9.0)
    assert once.correct(said)
    assert twice.correct(said)
    assert twice.correct(said)
    assert numbers(twice) == numbers(once)


def test_a_track_number_beyond_the_plan():
    """A track number that there is not is taken as the last track, and harms nothing."""
    filtered = run(20.0, [(20.0, message(15.0, 9.0, -10.0, track=255))])
    assert all(map(math.isfinite, numbers(filtered)))
    assert math.isfinite(filtered.progress)


def test_too_old_is_refused():
    """A message from before the filter's memory is refused and changes nothing."""
    filtered = run(60.0, [], memory_s=20.0)
    before = filtered.state
    assert not filtered.correct(message(39.0, 30.0, -10.0))
    assert not filtered.correct(message(-5.0, 30.0, -10.0))
    assert filtered.state == before
    assert age_s(filtered, 60.0) == -1.0
    assert filtered.correct(message(40.0, 30.0, -10.0))


def test_the_future_is_refused():
    """A message from more than a step ahead is refused; one a little ahead, by another clock, counts as of now."""
    filtered, wanted = run(60.0, []), run(60.0, [])
    assert not filtered.correct(message(61.5, 50.0, -10.0))
    assert age_s(filtered, 60.0) == -1.0
    assert filtered.correct(message(60.5, 50.0, -10.0))
    assert wanted.correct(message(60.0, 50.0, -10.0))
    assert_same(filtered, wanted)


def test_the_memory_is_bounded():
    """However long the mission and however many messages, only the memory's span of steps is kept."""
    said = reports(*[float(t_s) + 0.5 for t_s in range(0, 150, 3)])
    filtered = run(200.0, [(state.t_s + 9.5, state) for state in said], memory_s=20.0)
    assert len(filtered._history) <= 21
    filtered.advance(5000.0)
    assert len(filtered._history) <= 21


def test_other_ticks():
    """With steps of a quarter of a second late messages are worked in exactly, too."""
    said = reports(20.0, 30.0)
    late = run(40.0, [(30.0, said[0]), (40.0, said[1])], tick_s=0.25)
    prompt = run(40.0, [(20.0, said[0]), (30.0, said[1])], tick_s=0.25)
    assert_same(late, prompt)
