"""The guard: the one behind yields, nobody else, and never a whole team."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.closest import closest_approach, greatest_distance_m
from grex_agent.mission import plan_mission
from grex_agent.separation import check_separation, load_guard
from grex_link.errors import ConfigError
from grex_link.messages import MateBelief
from grex_link.scenario import loads

FLEET = """
[fleet]
count = 3
[team]
separation_min_m = 10.0
[mission]
type = "lawnmower"
legs = 3
[mission.formation]
type = "abreast"
spacing_m = 20.0
"""
SCENARIO = loads(FLEET)
PLAN = plan_mission(SCENARIO)
TEAM = list(PLAN.craft)


def guard(craft):
    """Build the guard of a craft."""
    return load_guard(SCENARIO, craft, PLAN)


def belief(craft, north, east, progress=None, sigma=0.0):
    """What is believed of a craft on the first leg."""
    return MateBelief(craft, north, east, north / 400.0 if progress is None else progress, sigma, 1.0)


def yields(craft, place, mates, ordered=1.2):
    """Whether a craft at a place on the first leg yields."""
    return guard(craft).limit(0.0, ordered, 0.0, (*place, 0.0), place[0] / 400.0, mates)[1]


def test_no_guard_unless_asked_for():
    """Without a minimum there is no guard."""
    assert load_guard(loads(FLEET.replace("separation_min_m = 10.0", "")), "auv1", PLAN) is None


def test_in_formation_nobody_yields():
    """Craft at their places, a little apart in progress, go as ordered."""
    assert not yields("auv1", (100.0, -20.0), [belief("auv2", 101.0, 0.0), belief("auv3", 99.0, 20.0)])


@pytest.mark.parametrize(("apart_m", "limit_mps"), [(14.0, 1.0 + 4.0 / 30.0), (10.0, 1.0), (4.0, 0.8), (-0.5, None)])
def test_who_catches_up_yields_as_far_as_it_has_to(apart_m, limit_mps):
    """Behind a mate in the same lane: as fast as brings the two to the minimum in 30 s, and never below the least."""
    mate = belief("auv2", 100.0 + apart_m, 0.0)
    limited_mps, does = guard("auv1").limit(0.0, 1.2, 0.0, (100.0, 0.0, 0.0), 0.25, [mate])
    if limit_mps is None:
        assert (limited_mps, does) == (1.2, False)
    else:
        assert does
        assert limited_mps == pytest.approx(limit_mps, abs=0.01)


def test_who_has_to_wait_goes_on():
    """Behind a mate that is believed to stand still, a craft slows down to the least speed, and no further."""
    own, mate = guard("auv1"), [belief("auv2", 112.0, 0.0)]
    limits = [own.limit(second, 1.0, 0.0, (100.0, 0.0, 0.0), 0.25, mate)[0] for second in range(40)]
    assert limits[0] == 1.0
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] == SCENARIO.team.speed_min_mps


def test_who_is_ahead_goes_on():
    """The one in front is not held up by whoever comes from behind."""
    assert not yields("auv2", (112.0, 0.0), [belief("auv1", 100.0, 0.0)])


def test_who_is_far_goes_on():
    """A mate in front that is not reached within the time looked ahead is no matter."""
    assert not yields("auv1", (100.0, 0.0), [belief("auv2", 130.0, 0.0)])
    assert yields("auv1", (100.0, 0.0), [belief("auv2", 130.0, 0.0)], ordered=2.0)


def test_depth_separates():
    """A mate far enough below is not in the way."""
    deep = (100.0, 0.0, 30.0)
    assert not guard("auv1").limit(0.0, 1.2, 0.0, deep, 0.25, [belief("auv2", 105.0, 0.0)])[1]


def test_who_is_unsure_keeps_more_distance():
    """The minimum grows with what is not known of a mate, by half of what the plan leaves and no further."""
    assert not yields("auv1", (100.0, 0.0), [belief("auv2", 114.9, 0.0)], ordered=1.0)
    assert yields("auv1", (100.0, 0.0), [belief("auv2", 114.9, 0.0, sigma=3.0)], ordered=1.0)
    assert not yields("auv1", (100.0, 0.0), [belief("auv2", 115.1, 0.0, sigma=1e6)], ordered=1.0)


def test_equals_go_by_the_order_of_the_team():
    """Side by side and too near, with equal progress, the later one in the team yields, and only that."""
    assert yields("auv2", (100.0, 5.0), [belief("auv1", 100.0, 0.0)])
    assert not yields("auv1", (100.0, 0.0), [belief("auv2", 100.0, 5.0)])


def test_progress_is_not_what_counts_in_a_line_astern():
    """Who runs into the mate in front yields, though it has come further on its own tracks."""
    astern = belief("auv1", 100.0, 0.0, 0.3), belief("auv2", 112.0, 0.0, 0.25)
    assert guard("auv1").limit(0.0, 1.2, 0.0, (100.0, 0.0, 0.0), 0.3, astern[1:])[1]
    assert not guard("auv2").limit(0.0, 1.2, 0.0, (112.0, 0.0, 0.0), 0.25, astern[:1])[1]


def test_without_a_common_course_progress_counts():
    """On opposite legs the one with less progress yields."""
    here, there = (400.0 - 5.0, 120.0, 0.0), belief("auv2", 400.0, 120.0, 2.1)
    assert guard("auv1").limit(0.0, 1.2, 0.0, here, 0.98, [there])[1]
    back = belief("auv1", here[0], here[1], 0.98)
    assert not guard("auv2").limit(0.0, 1.2, 0.0, (400.0, 120.0, 0.0), 2.1, [back])[1]


def test_a_craft_faster_than_ordered():
    """Whoever is faster than it should be is taken to go on like that."""
    mate = [belief("auv2", 125.0, 0.0)]
    assert not guard("auv1").limit(0.0, 1.0, 1.0, (100.0, 0.0, 0.0), 0.25, mate)[1]
    assert guard("auv1").limit(0.0, 1.0, 1.6, (100.0, 0.0, 0.0), 0.25, mate)[1]


def test_across_the_end_of_a_track():
    """A mate beyond the corner is seen coming as one before it: looked ahead along the plan, not straight on."""
    plan = PLAN.craft["auv1"]
    near = plan.point(1.02)
    assert guard("auv1").limit(
        0.0, 2.5, 0.0, (*plan.point(0.98), 0.0), 0.98, [MateBelief("auv2", *near, 1.02, 0.0, 1.0)]
    )[1]


@pytest.mark.parametrize("north", [math.nan, math.inf])
def test_a_belief_that_is_no_number(north):
    """Of a mate of whom nothing finite is believed, nothing follows."""
    assert guard("auv1").limit(0.0, 1.2, 0.0, (100.0, 0.0, 0.0), 0.25, [belief("auv2", north, 0.0, 0.3)]) == (
        1.2,
        False,
    )


def test_what_it_makes_more_than_ordered_is_taken_off():
    """A craft that makes 1.4 times what it is ordered is ordered less, until what it makes is what it may."""
    own, speed_mps = guard("auv1"), 1.4
    for second in range(100):
        ordered_mps, _ = own.limit(float(second), 1.2, speed_mps, (100.0, 0.0, 0.0), 0.25, [belief_going(second)])
        speed_mps += 0.4 * (1.4 * ordered_mps - speed_mps)
    assert speed_mps == pytest.approx(1.0, abs=0.03)


def belief_going(second):
    """A mate that goes at planned speed through the minimum, seen from one that goes with it."""
    return MateBelief("auv2", 110.0, 0.0, 0.275 + second / 400.0, 0.0, float(second))


numbers = st.floats(-50.0, 450.0)


@settings(deadline=None)
@given(st.lists(st.tuples(numbers, st.floats(-60.0, 60.0), st.floats(0.0, 4.999), st.floats(0.0, 100.0)), min_size=3,
                max_size=3), st.floats(0.3, 3.0))  # fmt: skip
def test_never_faster_and_never_all(team, ordered):
    """No guard raises a speed, or makes it no number; and of a team that sees itself alike one is left alone."""
    beliefs = [
        MateBelief(craft, north, east, progress, sigma, 1.0)
        for craft, (north, east, progress, sigma) in zip(TEAM, team, strict=True)
    ]
    yielding = []
    for craft, (north, east, progress, _) in zip(TEAM, team, strict=True):
        mates = [each for each in beliefs if each.craft != craft]
        speed, does = guard(craft).limit(0.0, ordered, 0.0, (north, east, 0.0), progress, mates)
        assert SCENARIO.team.speed_min_mps <= speed <= ordered
        yielding.append(does)
    assert not all(yielding)


def test_a_plan_that_comes_too_near_is_refused():
    """A plan nearer than the minimum is refused with one line that names two craft and the distance."""
    close = loads(FLEET, ["team.separation_min_m=20.5"])
    with pytest.raises(ConfigError, match=r"^\$.team.separation_min_m: auv1 and auv2 .* 20\.0 m"):
        check_separation(close, plan_mission(close))
    check_separation(SCENARIO, PLAN)
    exact = loads(FLEET, ["team.separation_min_m=20.0"])
    check_separation(exact, plan_mission(exact))


def test_crossing_tracks_are_refused():
    """Two tracks that cross at the same time are refused, though both their ends are far apart."""
    crossing = loads("""
[team]
separation_min_m = 5.0
[mission]
type = "tracks"
[mission.craft.a]
start_ned_m = [0.0, 0.0, 0.0]
tracks = [{ type = "line", to_ned_m = [1000.0, 1000.0, 0.0], speed_mps = 1.0 }]
[mission.craft.b]
start_ned_m = [1000.0, 0.0, 0.0]
tracks = [{ type = "line", to_ned_m = [0.0, 1000.0, 0.0], speed_mps = 1.0 }]
[craft.a]
[craft.b]
""")
    with pytest.raises(ConfigError, match=r"a and b .* 0\.0 m"):
        check_separation(crossing, plan_mission(crossing))


def test_who_yields_has_to_move():
    """A minimum speed of 0 is refused with a guard: two that yield to each other would stay for ever."""
    still = loads(FLEET, ["team.speed_min_mps=0.0"])
    with pytest.raises(ConfigError, match=r"^\$.team.speed_min_mps"):
        check_separation(still, PLAN)


def test_closest_between_moments():
    """Two craft that pass each other between two moments are seen where they are nearest."""
    places = np.array([[[0.0, 0.0], [10.0, 3.0], [50.0, 50.0]], [[10.0, 0.0], [0.0, 3.0], [50.0, 50.0]]])
    assert closest_approach(places) == pytest.approx((3.0, 0, 1, 0.5))
    assert greatest_distance_m(places) == pytest.approx(math.hypot(50.0, 50.0))
    assert closest_approach(places[:, :1]) is None
    assert closest_approach(places[:0]) is None
    assert greatest_distance_m(places[:, :1]) == 0.0
