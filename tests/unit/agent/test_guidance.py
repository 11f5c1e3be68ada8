"""Guidance: course on a track, and keeping of a place."""

import math

import pytest

from grex_agent.guidance import PlaceKeeping, TrackKeeping
from grex_agent.path import Arc, Line, Place
from grex_link.config import GuidanceConfig

NORTH = Line((0.0, 0.0), (100.0, 0.0), 1.0, 0.0)
KEEPING = TrackKeeping(GuidanceConfig())


@pytest.mark.parametrize(
    ("xte_m", "course"),
    [(0.0, 0.0), (4.0, -0.2), (-4.0, 0.2), (15.9, -0.795), (16.1, -0.8), (-16.1, 0.8), (1e9, -0.8)],
)
def test_correction_by_hand(xte_m, course):
    """The course is corrected by 0.05 rad a metre towards the track, by 0.8 rad at most."""
    assert KEEPING.course(NORTH, Place(0.5, xte_m, 0.0)) == pytest.approx(course, abs=1e-12)


@pytest.mark.parametrize(("turn", "lead"), [(math.pi, 2.0 * 0.9 / 30.0), (-math.pi, -2.0 * 0.9 / 30.0)])
def test_the_heading_lag_is_led_on_arcs(turn, lead):
    """On an arc the course leads by T_ψ·v'/radius to the side of the turn."""
    arc = Arc((0.0, 0.0), (0.0, math.copysign(30.0, turn)), turn, 0.9, 0.0)
    assert KEEPING.course(arc, Place(0.0, 0.0, 0.0)) == pytest.approx(lead)
    half = TrackKeeping(GuidanceConfig(curvature_feedforward=0.5))
    assert half.course(arc, Place(0.0, 0.0, 0.0)) == pytest.approx(lead / 2.0)


def test_course_is_wrapped():
    """A correction across south comes out in [-π, π)."""
    south = Line((0.0, 0.0), (-100.0, 0.0), 1.0, 0.0)
    assert KEEPING.course(south, Place(0.5, -4.0, math.pi)) == pytest.approx(0.2 - math.pi)


def test_course_leads_back_to_the_track():
    """Off the track on either side, the ordered course has a part towards the track, whatever the track's course."""
    for degrees in range(0, 360, 15):
        course = math.radians(degrees)
        track = Line((0.0, 0.0), (100.0 * math.cos(course), 100.0 * math.sin(course)), 1.0, 0.0)
        for xte_m in (-5.0, 5.0):
            ordered = KEEPING.course(track, Place(0.5, xte_m, course))
            assert math.sin(ordered - course) * xte_m < 0.0


@pytest.mark.parametrize(
    ("position", "steering"),
    [
        ((0.0, 0.0), (math.atan2(40.0, 30.0), 3.0)),
        ((30.0, 50.0), (-math.pi / 2.0, 1.0)),
        ((27.9, 40.0), (0.0, 0.21)),
        ((30.0, 42.0), None),
        ((30.0, 40.0), None),
    ],
)
def test_place_keeping_by_hand(position, steering):
    """A place is steered for at 0.1 m/s a metre, at 3 m/s at most, and not at all within 2 m of it."""
    assert PlaceKeeping(GuidanceConfig(), 3.0).steer(*position, (30.0, 40.0)) == (steering and pytest.approx(steering))
