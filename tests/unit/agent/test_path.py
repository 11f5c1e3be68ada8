"""Tracks: degree of execution, cross-track error and course on lines and arcs (paper, Fig. 2)."""

import math

import pytest

from grex_agent.path import Arc, Line, wrap

PI = math.pi
LINE = Line((0.0, 0.0), (30.0, 40.0), 1.0, 5.0)
STARBOARD = Arc((0.0, 0.0), (0.0, 10.0), PI, 1.0, 5.0)
PORT = Arc((0.0, 0.0), (0.0, -10.0), -PI, 1.0, 5.0)


def test_line_by_hand():
    """Θ is the foot's share of the line and XTE its signed distance: 2 m to starboard of the middle is (0.5, +2)."""
    place = LINE.locate(15.0 - 2.0 * 0.8, 20.0 + 2.0 * 0.6)
    assert place.theta == pytest.approx(0.5, abs=1e-12)
    assert place.xte_m == pytest.approx(2.0, abs=1e-12)
    assert place.course_rad == pytest.approx(math.atan2(40.0, 30.0), abs=1e-12)
    assert (LINE.length_m, LINE.curvature, LINE.speed_mps, LINE.depth_m) == (50.0, 0.0, 1.0, 5.0)


@pytest.mark.parametrize(
    ("end", "starboard"),
    [((9.0, 0.0), (0.0, 3.0)), ((0.0, 9.0), (-3.0, 0.0)), ((-9.0, 0.0), (0.0, -3.0)), ((0.0, -9.0), (3.0, 0.0))],
)
def test_starboard_is_positive(end, starboard):
    """Whatever the course, a craft to starboard of its line has a positive XTE, one to port a negative."""
    line = Line((0.0, 0.0), end, 1.0, 0.0)
    assert line.locate(*starboard).xte_m == pytest.approx(3.0)
    assert line.locate(-starboard[0], -starboard[1]).xte_m == pytest.approx(-3.0)


@pytest.mark.parametrize("theta", [-3.0, -0.5, 0.0, 1.0, 1.5, 40.0])
def test_line_goes_on(theta):
    """A line has no ends: Θ grows on along it, before the start and behind the end."""
    assert LINE.point(theta) == pytest.approx((30.0 * theta, 40.0 * theta))
    assert LINE.locate(30.0 * theta, 40.0 * theta).theta == pytest.approx(theta)


@pytest.mark.parametrize(
    ("arc", "theta", "point", "course"),
    [
        (STARBOARD, 0.0, (0.0, 0.0), 0.0),
        (STARBOARD, 0.5, (10.0, 10.0), PI / 2),
        (STARBOARD, 1.0, (0.0, 20.0), PI),
        (PORT, 0.0, (0.0, 0.0), 0.0),
        (PORT, 0.5, (10.0, -10.0), -PI / 2),
        (PORT, 1.0, (0.0, -20.0), -PI),
    ],
)
def test_half_circles_by_hand(arc, theta, point, course):
    """A half circle turns to its side: north, then abeam, then south, at Θ = 0, ½ and 1."""
    assert arc.point(theta) == pytest.approx(point, abs=1e-12)
    place = arc.locate(*point)
    assert place.theta == pytest.approx(theta, abs=1e-12)
    assert place.xte_m == pytest.approx(0.0, abs=1e-12)
    assert math.cos(place.course_rad - course) == pytest.approx(1.0)


def test_xte_on_arcs():
    """Outside a turn to starboard is port of the track, outside a turn to port is starboard of it."""
    assert STARBOARD.locate(13.0, 10.0).xte_m == pytest.approx(-3.0)
    assert STARBOARD.locate(8.0, 10.0).xte_m == pytest.approx(2.0)
    assert PORT.locate(13.0, -10.0).xte_m == pytest.approx(3.0)
    assert PORT.locate(8.0, -10.0).xte_m == pytest.approx(-2.0)
    assert STARBOARD.locate(0.0, 10.0).xte_m == pytest.approx(10.0)


def test_arc_measures():
    """An arc's length is radius times angle; its curvature is 1/radius, positive to starboard."""
    quarter = Arc((0.0, 0.0), (0.0, -20.0), -PI / 2, 1.5, 7.0)
    assert quarter.length_m == pytest.approx(10.0 * PI)
    assert quarter.curvature == pytest.approx(-0.05)
    assert STARBOARD.curvature == pytest.approx(0.1)
    assert (quarter.speed_mps, quarter.depth_m) == (1.5, 7.0)


@pytest.mark.parametrize("arc", [STARBOARD, PORT])
def test_arc_is_continuous_beyond_both_ends(arc):
    """On a half circle Θ runs without a jump from -0.5 to 1.5, so noise at the ends cannot throw it a turn off."""
    for step in range(-499, 1500):
        theta = step / 1000.0
        assert arc.locate(*arc.point(theta)).theta == pytest.approx(theta, abs=1e-9)


def test_course_turns_with_the_arc():
    """Half-way along a half circle's first half the course has turned by 45 degrees."""
    assert STARBOARD.locate(*STARBOARD.point(0.25)).course_rad == pytest.approx(PI / 4)
    assert PORT.locate(*PORT.point(0.25)).course_rad == pytest.approx(-PI / 4)


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.0, 0.0), (PI, -PI), (-PI, -PI), (3.5, 3.5 - 2 * PI), (-3.5, 2 * PI - 3.5), (20 * PI + 1.0, 1.0)],
)
def test_wrap(angle, wrapped):
    """An angle comes back as the same direction in [-π, π)."""
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-12)
