"""What one range says of a position."""

import math

import numpy as np
import pytest

from grex_agent.gaussian import Gaussian
from grex_agent.range_update import Range, surprise, with_free_offset, work_in


def heard(range_m, *, north=0.0, east=0.0, down=0.0, sigma=0.0):
    """A range to a place, of the present."""
    return Range(12.0, 12.0, "boat", range_m, north, east, down, sigma)


def at(north, east, variance=1.0, size=2):
    """A position with the same variance in every component."""
    return Gaussian((north, east, *[0.0] * (size - 2)), variance * np.eye(size))


def test_the_depth_is_taken_out():
    """At 30 m horizontally and 40 m deeper the range is 50 m; it says less of the horizontal, and nothing is off."""
    seen = surprise(at(30.0, 0.0, 1e-9), heard(50.0, down=0.0), 40.0, 0.1)
    assert seen.innovation_m == pytest.approx(0.0, abs=1e-9)
    assert seen.row == pytest.approx([0.6, 0.0])
    assert seen.variance_m2 == pytest.approx(0.01, rel=1e-6)


def test_only_the_line_of_sight_is_corrected():
    """A range to a place in the north, 1 m too long, moves the position south by half as trust is equal; east stays."""
    after = work_in(at(-100.0, 0.0), surprise(at(-100.0, 0.0, 1e-9), heard(101.0), 0.0, 1.0))
    assert after.mean == pytest.approx((-100.5, 0.0), abs=1e-6)
    assert np.diag(after.covariance) == pytest.approx([0.5, 1.0], abs=1e-6)


def test_the_others_uncertainty_counts():
    """The position told has a sigma: it adds to the noise of the range."""
    sure, unsure = (surprise(at(-100.0, 0.0, 1e-9), heard(100.0, sigma=sigma), 0.0, 0.3) for sigma in (0.0, 0.4))
    assert sure.noise_m2 == pytest.approx(0.09, rel=1e-6)
    assert unsure.noise_m2 == pytest.approx(0.25, rel=1e-6)


def test_the_curvature_is_no_news():
    """With 2 m of doubt across a line of sight of 10 m, ranges are 0.2 m longer on average: as much is expected."""
    draw = np.random.default_rng(5)
    places = np.array([10.0, 0.0]) + np.array([1e-6, 2.0]) * draw.normal(size=(20000, 2))
    ranges = np.hypot(*places.T)
    x = Gaussian((10.0, 0.0), np.diag((1e-12, 4.0)))
    seen = surprise(x, heard(10.0), 0.0, 1e-6)
    assert 10.0 - seen.innovation_m == pytest.approx(ranges.mean(), abs=0.02)
    assert math.sqrt(seen.variance_m2) == pytest.approx(ranges.std(), rel=0.1)


def test_the_way_since_the_state():
    """A range of a moment later is compared with where the craft is by then."""
    seen = surprise(at(100.0, 0.0, 1e-9), heard(101.0), 0.0, 0.1, (1.0, 0.0))
    assert seen.innovation_m == pytest.approx(0.0, abs=1e-6)


def test_at_the_same_place():
    """A range to a craft at the very place has no direction, and says nothing; no number breaks."""
    seen = surprise(at(0.0, 0.0), heard(0.0), 0.0, 0.1)
    after = work_in(at(0.0, 0.0), seen)
    assert np.isfinite(after.covariance).all()
    assert after.mean == (0.0, 0.0)


def test_a_free_offset_leaves_the_sum():
    """Set free, position and offset may be wrong by 25 m² more each, and their sum by nothing."""
    freed = with_free_offset(at(0.0, 0.0, 0.01, size=4), 2, 25.0).covariance
    assert freed[0, 0] == freed[2, 2] == pytest.approx(25.01)
    assert freed[0, 0] + freed[2, 2] + 2.0 * freed[0, 2] == pytest.approx(0.02)
    assert freed[1, 1] + freed[3, 3] + 2.0 * freed[1, 3] == pytest.approx(0.02)
