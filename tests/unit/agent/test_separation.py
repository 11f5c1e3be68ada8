"""The guard that keeps craft apart."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.capabilities import check_capabilities
from grex_agent.mission import plan_mission
from grex_agent.separation import SeparationGuard
from grex_link.errors import ConfigError
from grex_link.messages import Fix, MateBelief
from grex_link.profile import load_profile
from grex_link.scenario import decode


def scenario(least_m=8.0, below_m=0.0):
    """Two craft on one line north, auv2 20 m behind."""
    return decode(
        {
            "mission": {
                "type": "lawnmower",
                "formation_m": {"auv1": [0.0, 0.0, 0.0], "auv2": [-20.0, 0.0, below_m]},
                "legs": 1,
                "leg_length_m": 400.0,
            },
            "craft": {"auv1": {}, "auv2": {}},
            "team": {"separation_min_m": least_m, "separation_horizon_s": 30.0},
        }
    )


def guard(craft="auv2", speed_mps=1.0, **more):
    """The guard of a craft that has been ordered north."""
    made = scenario(**more)
    built = SeparationGuard(made.team, craft, plan_mission(made))
    built.ordered(speed_mps, 0.0)
    return built


def fix(north_m, east_m=0.0, down_m=0.0):
    """Where the own craft is."""
    return Fix(1, 1, north_m, east_m, down_m, 0.0, 0.0, 0.0, 1.0, 0.1)


def mate(north_m, progress, sigma_m=0.5, craft="auv1"):
    """Where a mate is believed to be."""
    return MateBelief(craft, north_m, 0.0, progress, sigma_m, 10.0)


def test_the_one_behind_slows():
    """A craft 30 m behind at twice the speed would run into its mate within 30 s: it slows to the least speed."""
    assert guard(speed_mps=2.0).speed(2.0, fix(0.0), 0.0, [mate(30.0, 0.1)]) == 0.3


def test_the_one_ahead_goes_on():
    """The mate that is caught up with is not slowed by it."""
    assert guard("auv1").speed(1.0, fix(30.0), 0.1, [mate(20.0, 0.05, craft="auv2")]) == 1.0


def test_crossing_the_one_less_far_yields():
    """Where each has the other ahead, the one less far in the plan yields, and of two equal ones the later one."""
    for craft, other, progress, slows in [
        ("auv2", "auv1", 0.2, True),
        ("auv2", "auv1", 0.1, True),
        ("auv2", "auv1", 0.05, False),
        ("auv1", "auv2", 0.1, False),
    ]:
        built = guard(craft)
        built.ordered(1.0, math.pi)  # southward, towards a mate that goes north
        assert built.speed(1.0, fix(20.0), 0.1, [mate(0.0, progress, craft=other)]) == (0.3 if slows else 1.0)


def test_formation_is_let_alone():
    """Craft that keep their distance are not slowed; doubt about the mate's place is added to the least distance."""
    assert guard().speed(1.0, fix(0.0), 0.0, [mate(20.0, 0.05, sigma_m=1.0)]) == 1.0
    assert guard().speed(1.0, fix(0.0), 0.0, [mate(20.0, 0.05, sigma_m=13.0)]) == 0.3


def test_beyond_the_horizon_is_later():
    """What would happen after the horizon does not count yet."""
    assert guard(speed_mps=1.2).speed(1.2, fix(0.0), 0.0, [mate(30.0, 0.1)]) == 1.2


def test_depth_separates():
    """A craft deep below its mate passes it."""
    assert guard(speed_mps=2.0, below_m=40.0).speed(2.0, fix(0.0, down_m=40.0), 0.0, [mate(30.0, 0.1)]) == 2.0


def test_without_a_minimum_there_is_no_guard():
    """A scenario without a minimum has no guard."""
    assert guard(least_m=None, speed_mps=2.0).speed(2.0, fix(0.0), 0.0, [mate(1.0, 0.1)]) == 2.0


NUMBERS = st.floats(-500.0, 500.0)


@given(NUMBERS, NUMBERS, st.floats(-1.0, 3.0), st.floats(0.0, 100.0), st.floats(0.0, 3.0), st.floats(-7.0, 7.0))
def test_never_faster(north, east, progress, sigma, speed, course):
    """Wherever everybody is, the guard gives the speed ordered or the least speed, never more."""
    built = guard()
    built.ordered(speed, course)
    given_mps = built.speed(speed, fix(north, east), progress, [mate(east, progress / 2.0, sigma)])
    assert given_mps in {speed, 0.3}
    assert given_mps <= speed
    assert math.isfinite(given_mps)


def test_a_plan_too_narrow_is_refused():
    """A plan that brings two craft nearer than the minimum is refused, with the distance."""
    made = scenario(least_m=25.0)
    with pytest.raises(ConfigError, match=r"separation_min_m: the plan itself brings two craft within 20\.0 m"):
        check_capabilities(made, plan_mission(made), load_profile(made.link.profile))
