"""Tracks and plans, whatever they are: `point` and `locate` undo each other, formations are rigid."""

import math
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.mission import plan_mission
from grex_agent.path import Arc, Line, wrap
from grex_link.scenario import decode

coordinates = st.floats(-1e4, 1e4)
angles = st.floats(-math.pi, math.pi)


@given(coordinates, coordinates, angles, st.floats(1.0, 1e4), st.floats(-3.0, 4.0), st.floats(-1e3, 1e3))
def test_line_locates_what_it_points_to(north, east, course, length, theta, xte):
    """A position at any Θ and XTE of any line is located there."""
    end = north + length * math.cos(course), east + length * math.sin(course)
    line = Line((north, east), end, 1.0, 0.0)
    on_north, on_east = line.point(theta)
    place = line.locate(on_north - xte * math.sin(course), on_east + xte * math.cos(course))
    assert place.theta * length == pytest.approx(theta * length, abs=1e-6)
    assert place.xte_m == pytest.approx(xte, abs=1e-6)
    assert math.cos(place.course_rad - course) == pytest.approx(1.0)


@given(
    coordinates,
    coordinates,
    angles,
    st.floats(1.0, 1e3),
    st.floats(1.0, 350.0),
    st.sampled_from([-1.0, 1.0]),
    st.floats(-0.98, 0.98),
    st.floats(-1.0, 0.9),
)
def test_arc_locates_what_it_points_to(north, east, first, radius, turn_deg, side, along, inward):
    """A position within half a circle of any arc's middle, inside or outside, is located there."""
    start = north + radius * math.cos(first), east + radius * math.sin(first)
    turn = math.radians(turn_deg)
    arc = Arc(start, (north, east), side * turn, 1.0, 0.0)
    theta = 0.5 + along * math.pi / turn
    on_north, on_east = arc.point(theta)
    shrink = 1.0 - inward
    place = arc.locate(north + (on_north - north) * shrink, east + (on_east - east) * shrink)
    assert place.theta * turn == pytest.approx(theta * turn, abs=1e-6)
    assert place.xte_m == pytest.approx(side * radius * inward, abs=1e-6)
    later = arc.point(theta + 1e-4 / turn)
    moved = later[0] - on_north, later[1] - on_east
    ahead = moved[0] * math.cos(place.course_rad) + moved[1] * math.sin(place.course_rad)
    assert ahead == pytest.approx(1e-4 * radius, rel=1e-3)


@given(st.floats(-1e3, 1e3))
def test_wrap_keeps_the_direction(angle):
    """A wrapped angle points the same way and lies within half a turn; wrapping it again changes nothing."""
    wrapped = wrap(angle)
    assert abs(wrapped) <= math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1.0)
    assert wrap(wrapped) == pytest.approx(wrapped, abs=1e-9) or abs(wrapped) == pytest.approx(math.pi)


places = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.just(0.0))


@given(
    st.lists(places, min_size=2, max_size=5, unique_by=lambda place: (round(place[0], 2), round(place[1], 2))),
    st.floats(60.0, 200.0),
    st.floats(-360.0, 360.0),
    st.sampled_from(["port", "starboard"]),
    st.lists(st.floats(-0.4, 5.4), min_size=5, max_size=5),
)
def test_any_formation_is_rigid(formation, radius, heading_deg, first_turn, progresses):
    """Whatever the formation and the turn: at equal progress all distances are those of the formation."""
    named = {f"c{number}": place for number, place in enumerate(formation)}
    mission = {
        "type": "lawnmower",
        "formation_m": named,
        "legs": 3,
        "turn_radius_m": radius,
        "heading_deg": heading_deg,
        "first_turn": first_turn,
    }
    team = plan_mission(decode({"mission": mission, "craft": {name: {} for name in named}}))
    for progress in progresses:
        for one, other in combinations(named, 2):
            apart = math.dist(team.craft[one].point(progress), team.craft[other].point(progress))
            assert apart == pytest.approx(math.dist(named[one], named[other]), abs=1e-9)
