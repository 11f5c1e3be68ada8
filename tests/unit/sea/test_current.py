"""Sea-current compensation, by hand (Fig. 6); the properties are in tests/properties."""

import math

import pytest

from grex_sim.current import compensate


def steering(course_rad, speed_mps, current, pitch_rad=0.0, least=0.0, most=2.0):
    """Compensate with surge between 0 and 2 m/s."""
    return compensate(course_rad, pitch_rad, speed_mps, current, least, most)


def test_still_water():
    """Without a current a craft points where it goes."""
    assert steering(0.7, 1.2, (0.0, 0.0, 0.0), pitch_rad=-0.3) == pytest.approx((0.7, -0.3, 1.2, 1.2, True))


@pytest.mark.parametrize(
    ("current", "heading", "surge"),
    [
        ((0.5, 0.0, 0.0), 0.0, 0.5),
        ((-0.5, 0.0, 0.0), 0.0, 1.5),
        ((0.0, 0.75, 0.0), -math.atan2(0.75, 1.0), 1.25),
        ((1.5, 0.0, 0.0), math.pi, 0.5),
    ],
)
def test_by_hand(current, heading, surge):
    """Going north at 1 m/s: slower with the current, faster against it, upstream across it, astern of a fast one."""
    found = steering(0.0, 1.0, current)
    assert (abs(found.heading_rad), found.surge_mps) == pytest.approx((abs(heading), surge))
    assert math.sin(found.heading_rad) == pytest.approx(math.sin(heading))
    assert (found.pitch_rad, found.ground_mps, found.holdable) == (0.0, 1.0, True)


def test_upward_current():
    """Against water that rises a craft points its bow down."""
    found = steering(0.0, 1.0, (0.0, 0.0, -0.75))
    assert (found.heading_rad, found.pitch_rad) == pytest.approx((0.0, -math.atan2(0.75, 1.0)))
    assert (found.surge_mps, found.ground_mps) == pytest.approx((1.25, 1.0))


def test_too_fast():
    """If the wanted speed needs more surge than there is, the course is kept at the speed that is left."""
    found = steering(0.0, 9.0, (0.0, 1.2, 0.0))
    assert (found.surge_mps, found.ground_mps, found.holdable) == (2.0, pytest.approx(1.6), True)
    assert found.heading_rad == pytest.approx(-math.asin(0.6))


def test_too_slow():
    """If the wanted speed needs less surge than the least, the course is kept at the speed the least gives."""
    found = steering(0.0, 0.1, (0.0, 0.3, 0.0), least=0.5)
    assert (found.surge_mps, found.ground_mps, found.holdable) == (0.5, pytest.approx(0.4), True)
    assert found.heading_rad == pytest.approx(-math.asin(0.6))


def test_current_across_too_strong():
    """If the current across is stronger than the craft, it points straight against it, and says so."""
    found = steering(0.0, 1.0, (0.4, 3.0, 0.0))
    assert found == pytest.approx((-math.pi / 2.0, 0.0, 2.0, 0.4, False))


def test_current_along_too_strong():
    """If the craft can only be set back along its course, it keeps the course as slowly as can be, and says so."""
    found = steering(0.0, 1.0, (-3.0, 0.0, 0.0))
    assert found == pytest.approx((0.0, 0.0, 2.0, -1.0, False))
    slanted = steering(0.0, 1.0, (-3.0, 1.2, 0.0))
    assert slanted == pytest.approx((-math.asin(0.6), 0.0, 2.0, -1.4, False))


def test_no_direction_left():
    """Where nothing need be steered the wanted direction stands in for it."""
    assert steering(0.7, 0.0, (0.0, 0.0, 0.0)) == (0.7, 0.0, 0.0, 0.0, True)
    assert steering(0.0, 1.0, (1.0, 0.0, 0.0)) == (0.0, 0.0, 0.0, 1.0, True)
    straight_down = steering(0.7, 0.0, (0.0, 0.0, -1.0))
    assert straight_down == pytest.approx((0.7, -math.pi / 2.0, 1.0, 0.0, True))


@pytest.mark.parametrize(("current", "least", "reached"), [(1.5, 0.3, 0.5), (0.55, 0.3, 0.25)])
def test_a_craft_told_to_wait_points_against_a_following_current(current, least, reached):
    """Of two speeds over ground that can be reached, the one nearer to the wanted is taken: nobody is pushed on."""
    steering = compensate(0.0, 0.0, 0.3, (current, 0.0, 0.0), least, 1.0)
    assert steering.ground_mps == pytest.approx(reached)
    assert abs(steering.heading_rad) == pytest.approx(math.pi)
    assert steering.holdable
