"""Replay: whenever messages come, the filter ends where one ends that had each at its own time (eq. 11)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.coordination import ThetaP
from grex_agent.guidance import TrackKeeping
from grex_agent.mission import plan_mission
from grex_agent.team.mate import MateFilter
from grex_agent.team.planar import Follower, PlanarMate
from grex_link.scenario import decode
from grex_link.wire import TeamState

END = 90
# Legs of 30 m and half circles of 31 m, so that a message's age spans track changes.
SCENARIO = decode(
    {
        "mission": {
            "type": "lawnmower",
            "formation_m": {"auv1": [2.0, -3.0, 0.0]},
            "legs": 3,
            "leg_length_m": 30.0,
            "turn_radius_m": 10.0,
        },
        "craft": {"auv1": {}},
    }
)
PLAN = plan_mission(SCENARIO).craft["auv1"]


@st.composite
def messages(draw):
    """(message, delay): near the plan, at the times a modem can tell, up to 40 s late."""
    steps = draw(st.lists(st.integers(1, 60 * 20), unique=True, min_size=1, max_size=6))
    made = []
    for step in steps:
        t_s = step * 0.05
        progress = t_s / 30.5 * draw(st.floats(0.8, 1.2))
        north, east = PLAN.point(progress)
        north, east = north + draw(st.floats(-3.0, 3.0)), east + draw(st.floats(-3.0, 3.0))
        state = TeamState(0, t_s, north, east, 0.0, 1.0, 0.0, int(progress), progress % 1.0, 0.1)
        made.append((state, draw(st.floats(0.0, 28.0))))
    return made


def new_filter():
    """A filter of the mate at its start."""
    keeping, controller = TrackKeeping(SCENARIO.guidance), ThetaP(SCENARIO.team)
    return MateFilter(PlanarMate(PLAN, Follower(PLAN, keeping, controller), SCENARIO.team.kalman), 300.0, 1.0)


def drive(filtered, tick):
    """Tell the mate's model how far two others are."""
    filtered.drive([tick / 30.0 + 0.1 * math.sin(tick), tick / 31.0])


def late(arrivals):
    """A filter that steps each second and is given each message at the first step after its arrival, in that order."""
    filtered = new_filter()
    for tick in range(1, END + 1):
        filtered.advance(float(tick))
        for state, arrived in arrivals:
            if tick - 1.0 < arrived <= tick:
                assert filtered.correct(state)
        drive(filtered, tick)
    return filtered


def prompt(states):
    """A filter that has every message at the moment it speaks of."""
    filtered = new_filter()
    for tick in range(1, END + 1):
        for state in sorted(states, key=lambda state: state.t_s):
            if tick - 1.0 + 1e-6 < state.t_s < tick + 1e-6:
                filtered.advance(min(state.t_s, float(tick)))
                assert filtered.correct(state)
        filtered.advance(float(tick))
        drive(filtered, tick)
    return filtered


def numbers(filtered):
    """All that a filter believes."""
    x = filtered.state.x
    belief = filtered.belief("auv1", END)
    return x.north, x.east, x.v_north, x.v_east, x.pp, x.pv, x.vv, belief.progress, belief.age_s


def assert_same(one, other):
    """Hold two filters against each other."""
    assert numbers(one) == pytest.approx(numbers(other), abs=1e-9)


@given(messages())
def test_replay_is_the_in_order_filter(said):
    """However late each message is, mean, covariance and progress are those of a filter that heard all in time."""
    assert_same(late([(state, state.t_s + delay) for state, delay in said]), prompt([state for state, _ in said]))


@given(messages(), st.randoms(use_true_random=False))
def test_order_of_arrival_is_no_matter(said, random):
    """Messages that come at one time give the same in any order."""
    arrivals = [(state, 70.0) for state, _ in said]
    shuffled = random.sample(arrivals, len(arrivals))
    assert_same(late(shuffled), late(arrivals))


@given(messages())
def test_the_filter_stays_sound(said):
    """Whatever is heard, nothing becomes NaN, variances stay positive and the covariance stays definite."""
    filtered = late([(state, state.t_s + delay) for state, delay in said])
    state = filtered.state.x
    assert all(map(math.isfinite, numbers(filtered)))
    assert state.pp > 0.0
    assert state.vv > 0.0
    assert state.pp * state.vv > state.pv**2
