"""The filters of all mates as rows of arrays are the filters of one mate at a time."""

import math

import pytest
from along_track_one import OneByOne, OneByOneFirst
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.coordination import ThetaP, load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.along_track import AlongTrack, AlongTrackFirst
from grex_agent.team.interface import Own, Report, TeamContext
from grex_link.scenario import decode
from grex_link.wire import TeamState

TEAM = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -8.0, 0.0], "auv3": [-3.0, 5.0, 0.0], "auv4": [-9.0, 2.0, 0.0]}
SCENARIO = decode(
    {
        "mission": {
            "type": "lawnmower",
            "formation_m": TEAM,
            "legs": 3,
            "leg_length_m": 30.0,
            "turn_radius_m": 10.0,
        },
        "craft": {name: {} for name in TEAM},
        "team": {"estimator": "along_track", "gain_mps": 4.0, "kalman": {"memory_s": 40.0}},
    }
)
PLAN = plan_mission(SCENARIO)
PAIRS = {"first": (AlongTrackFirst, OneByOneFirst), "second": (AlongTrack, OneByOne)}


class LonelyP:
    """The law of eq. (2) as somebody's own law, which knows nothing of many craft."""

    def __init__(self, law):
        self.speed = law.speed


def said(craft, t_s, progress, speed_mps):
    """What a craft near its plan says."""
    number = min(max(int(progress), 0), 4)
    north, east = PLAN.craft[craft].point(progress)
    return TeamState(
        list(TEAM).index(craft),
        t_s,
        north,
        east,
        0.0,
        speed_mps,
        0.0,
        number,
        min(max(progress - number, 0.0), 1.0),
        0.1,
    )


@st.composite
def talk(draw):
    """(when it is worked in, message): at whole seconds and between, in time, late, too late, and twice."""
    made = []
    for _ in range(draw(st.integers(0, 12))):
        t_s = draw(st.one_of(st.integers(0, 70).map(float), st.floats(0.0, 70.0).map(lambda t: round(t, 2))))
        craft = draw(st.sampled_from(list(TEAM)))
        progress = t_s / 30.5 * draw(st.floats(0.7, 1.3))
        delay = draw(st.integers(0, 50))
        state = said(craft, t_s, progress, draw(st.floats(0.3, 2.0)))
        made.append((math.ceil(t_s) + delay, state))
    return made


@pytest.mark.parametrize("level", list(PAIRS))
@pytest.mark.parametrize("law", [ThetaP, LonelyP])
@settings(max_examples=15, deadline=None)
@given(made=talk(), prepared=st.sampled_from([None, 1.0, 0.7, 1.3]), tick=st.sampled_from([1.0, 2.5]))
def test_rows_are_the_single_filters(level, law, made, prepared, tick):
    """Any messages, in time, late or out of order, and predictions made in advance: the same to 1e-9."""
    controller = load_controller(SCENARIO.team)
    controller = controller if law is ThetaP else LonelyP(controller)
    context = TeamContext("auv1", PLAN, SCENARIO, controller)
    teams = [build(context) for build in PAIRS[level]]
    now = 0.0
    while now < 75.0:
        before, now = now, now + tick
        arrived = [state for at, state in made if before < at <= now]
        heard = [Report(list(TEAM)[state.source], state) for state in arrived if state.source]
        sent = [state for state in arrived if not state.source]
        own = Own(now, 0.0, now / 30.5 + 0.05 * math.sin(now))
        rows, singles = (team.step(now, own, sent, heard) for team in teams)
        assert [belief.craft for belief in rows] == [belief.craft for belief in singles]
        for row, single in zip(rows, singles, strict=True):
            assert row.age_s == single.age_s
            numbers = (row.north_m, row.east_m, row.progress, row.sigma_m)
            assert numbers == pytest.approx((single.north_m, single.east_m, single.progress, single.sigma_m), abs=1e-9)
        if prepared:
            for team in teams:
                team.prepare(now + prepared)
