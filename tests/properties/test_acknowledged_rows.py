"""A message that turns out not to have been heard is as if it had never left, for the mate that has not heard it."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.coordination import load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.acknowledgement import Acknowledgements
from grex_agent.team.along_track import AlongTrack
from grex_agent.team.interface import Own, Report, TeamContext
from grex_link import wire
from grex_link.scenario import decode

TEAM = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -8.0, 0.0]}
SCENARIO = decode(
    {
        "mission": {"type": "lawnmower", "formation_m": TEAM, "legs": 3, "leg_length_m": 30.0, "turn_radius_m": 10.0},
        "craft": {name: {} for name in TEAM},
        "team": {"estimator": "along_track", "gain_mps": 4.0},
    }
)
PLAN = plan_mission(SCENARIO)
CYCLE_S, SLOT_S, END_S = 10, 5, 75


def build(*, told=True):
    """An estimator aboard auv1; whether its mate tells it what it has heard."""
    acknowledgements = Acknowledgements("auv1", list(TEAM), float(CYCLE_S)) if told else None
    return AlongTrack(TeamContext("auv1", PLAN, SCENARIO, load_controller(SCENARIO.team), acknowledgements))


def said(craft, t_s, share, flags=wire.NAVIGATION_VALID):
    """What a craft near its plan says."""
    progress = t_s / 30.5 * share
    number = min(max(int(progress), 0), 4)
    north, east = PLAN.craft[craft].point(progress)
    theta = min(max(progress - number, 0.0), 1.0)
    return wire.TeamState(list(TEAM).index(craft), t_s, north, east, 0.0, share, 0.0, number, theta, 0.1, flags)


def fly(team, hears, shares, *, leaves=None):
    """Both speak in turn; say what is believed at each second: progress and sigma of the mate, and the own doubt.

    Parameters
    ----------
    team : AlongTrack
        Aboard auv1.
    hears : sequence of bool
        Whether auv2 hears each own message.
    shares : sequence of float
        Of the planned speed, at which each message is said.
    leaves : sequence of bool or None
        Whether each own message leaves at all, for what is known aboard; None: all do.
    """
    mate = Acknowledgements("auv2", list(TEAM), float(CYCLE_S))
    beliefs = []
    for now in range(END_S):
        sent, heard = [], []
        cycle, at = divmod(now, CYCLE_S)
        if at == 0 and (leaves is None or leaves[cycle]):
            sent = [said("auv1", float(now), shares[cycle])]
        if at == 0 and hears[cycle]:
            mate.hear("auv1", float(now))
        if at == SLOT_S:
            flags = wire.NAVIGATION_VALID | mate.flags(float(now))
            heard = [Report("auv2", said("auv2", float(now), shares[-1 - cycle], flags))]
        own = Own(now, 0.0, now / 30.5 + 0.05 * math.sin(now))
        (belief,) = team.step(float(now), own, sent, heard)
        beliefs.append((belief.progress, belief.sigma_m, team.doubt_m))
    return beliefs


SPEEDS = st.lists(st.floats(0.7, 1.3), min_size=16, max_size=16)
HEARS = st.lists(st.booleans(), min_size=8, max_size=8)


@settings(max_examples=25, deadline=None)
@given(hears=HEARS, shares=SPEEDS)
def test_from_the_answer_on_it_is_as_if_known_at_once(hears, shares):
    """From each answer on, beliefs are to 1e-9 those of a craft that knew at once what would be heard."""
    guessing, knowing = fly(build(), hears, shares), fly(build(), hears, shares, leaves=hears)
    for now in range(END_S):
        if now % CYCLE_S >= SLOT_S:
            assert guessing[now] == pytest.approx(knowing[now], abs=1e-9)


def test_what_was_not_heard_matters():
    """Where nothing is heard, the mate is believed elsewhere than where everything is, and to see oneself elsewhere."""
    shares = [1.2] * 16
    deaf, hearing = (fly(build(), [heard] * 8, shares) for heard in (False, True))
    assert abs(deaf[-1][0] - hearing[-1][0]) * 30.0 > 0.1
    assert abs(deaf[-1][2] - hearing[-1][2]) > 0.5


def test_heard_after_all():
    """A message that was still on its way when the mate spoke is worked in again when the mate has it."""
    hearing, wavering = build(), build()
    nothing = Acknowledgements("auv2", list(TEAM), float(CYCLE_S))
    mate = Acknowledgements("auv2", list(TEAM), float(CYCLE_S))
    mate.hear("auv1", 2.0)
    assert mate.flags(5.0) != nothing.flags(5.0)
    for now in range(30):
        own = Own(now, 0.0, now / 30.5)
        sent = [said("auv1", 2.0, 1.4)] if now == 2 else []
        reports = {5: nothing, 9: mate}
        for team in (hearing, wavering):
            heard = []
            if now in reports:
                who = mate if team is hearing else reports[now]
                flags = wire.NAVIGATION_VALID | who.flags(float(now))
                heard = [Report("auv2", said("auv2", float(now), 1.1, flags))]
            (belief,) = team.step(float(now), own, sent, heard)
            if team is hearing:
                expected = belief.progress, belief.sigma_m, team.doubt_m
        found = belief.progress, belief.sigma_m, wavering.doubt_m
        if 5 <= now < 9:
            assert found[2] != pytest.approx(expected[2], abs=0.1)
        else:
            assert found == pytest.approx(expected, abs=1e-9)


def test_without_acknowledgements_what_has_left_has_been_heard():
    """In a team whose messages have no room for it, what a mate's flags say is not looked at."""
    shares = [1.2] * 16
    assert fly(build(told=False), [False] * 8, shares) == fly(build(told=False), [True] * 8, shares)
