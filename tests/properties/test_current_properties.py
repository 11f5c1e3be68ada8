"""Sea-current compensation in any current: the ground velocity really is what `Steering` says (Fig. 6)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_sim.current import compensate

component = st.floats(-2.5, 2.5)
cases = given(
    course=st.floats(-math.pi, math.pi),
    pitch=st.floats(-1.4, 1.4),
    speed=st.floats(0.05, 4.0),
    current=st.tuples(component, component, component),
    limits=st.tuples(st.floats(0.0, 0.8), st.floats(0.8, 3.0)),
)


def direction(heading, pitch):
    """Unit vector, NED."""
    return np.array([math.cos(pitch) * math.cos(heading), math.cos(pitch) * math.sin(heading), -math.sin(pitch)])


def ground(found, current):
    """Velocity over ground that comes of steering so."""
    return found.surge_mps * direction(found.heading_rad, found.pitch_rad) + np.array(current)


@cases
def test_a_course_that_can_be_held_is_made_good(course, pitch, speed, current, limits):
    """If the course can be held, the ground velocity points along it, at the speed the steering says, forward."""
    found = compensate(course, pitch, speed, current, *limits)
    if found.holdable:
        assert ground(found, current) == pytest.approx(found.ground_mps * direction(course, pitch), abs=1e-7)
        assert found.ground_mps > 0.0


@cases
def test_surge_is_within_its_limits(course, pitch, speed, current, limits):
    """Surge never leaves its limits; where it need not be limited the wanted speed over ground is made good."""
    found = compensate(course, pitch, speed, current, *limits)
    assert all(map(math.isfinite, found))
    assert limits[0] - 1e-9 <= found.surge_mps <= limits[1] + 1e-9
    needed = np.linalg.norm(speed * direction(course, pitch) - np.array(current))
    if limits[0] <= needed <= limits[1]:
        assert (found.holdable, found.ground_mps) == (True, speed)
        assert found.surge_mps == pytest.approx(needed)
    else:
        assert min(abs(found.surge_mps - limit) for limit in limits) <= 1e-9


@cases
def test_the_two_ways_of_not_holding(course, pitch, speed, current, limits):
    """A course is given up only against too strong a current: across it, or along it; each is steered as promised."""
    found = compensate(course, pitch, speed, current, *limits)
    v0, over_ground = direction(course, pitch), ground(found, current)
    along = float(np.dot(v0, current))
    across = np.array(current) - along * v0
    if found.holdable:
        assert np.linalg.norm(across) <= limits[1] + 1e-6
        return
    assert found.surge_mps == limits[1]
    if np.linalg.norm(across) > limits[1]:
        # Straight against the current across: what is left of it is as little as can be.
        assert found.ground_mps == pytest.approx(along, abs=1e-6)
        left = across * (1.0 - limits[1] / np.linalg.norm(across))
        assert over_ground == pytest.approx(along * v0 + left, abs=1e-7)
    else:
        # Set back along the course: of the two speeds the sphere allows the higher one.
        assert found.ground_mps <= 0.0
        assert over_ground == pytest.approx(found.ground_mps * v0, abs=1e-7)
        assert found.ground_mps >= along


@cases
def test_still_water_is_no_special_case(course, pitch, speed, current, limits):
    """Without a current a craft is steered as in one that can hardly be felt."""
    still = compensate(course, pitch, speed, (0.0, 0.0, 0.0), *limits)
    felt = compensate(course, pitch, speed, tuple(1e-9 * part for part in current), *limits)
    assert still[2:] == pytest.approx(felt[2:], abs=1e-7)
    assert ground(still, (0.0, 0.0, 0.0)) == pytest.approx(ground(felt, (0.0, 0.0, 0.0)), abs=1e-7)


@cases
def test_compensation_turns_with_the_compass(course, pitch, speed, current, limits):
    """Turning course and current by a quarter turns the heading by a quarter and changes nothing else."""
    found = compensate(course, pitch, speed, current, *limits)
    turned = compensate(course + math.pi / 2.0, pitch, speed, (-current[1], current[0], current[2]), *limits)
    assert (turned.surge_mps, turned.ground_mps) == pytest.approx((found.surge_mps, found.ground_mps), abs=1e-6)
    assert turned.surge_mps * direction(turned.heading_rad - math.pi / 2.0, turned.pitch_rad) == pytest.approx(
        found.surge_mps * direction(found.heading_rad, found.pitch_rad), abs=1e-6
    )
