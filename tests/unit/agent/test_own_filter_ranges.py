"""The filter of an inertial navigation that drifts, with ranges."""

import numpy as np
import pytest
from drifting import INERTIAL, Drifting

from grex_agent.range_update import Range

OFF = (0.4, -0.3), (0.015, 0.01)


def sail(craft, seconds, every=3):
    """Let a craft go on for some seconds, with a range every so often; 0 for none."""
    for _ in range(seconds):
        craft.step()
        if every and craft.now % every == 0:
            craft.filter.hear_range(craft.range())
    return craft


def test_the_first_fix():
    """At the first fix the position may be off by the offset, but the two together only by the noise of the fix."""
    craft = Drifting()
    craft.step()
    p = craft.filter.covariance
    assert p[0, 0] == pytest.approx(INERTIAL.offset_sigma_m**2 + INERTIAL.noise_m**2)
    assert p[0, 0] + p[6, 6] + 2.0 * p[0, 6] == pytest.approx(INERTIAL.noise_m**2)
    assert p[1, 1] + p[7, 7] + 2.0 * p[1, 7] == pytest.approx(INERTIAL.noise_m**2)


def test_without_ranges_the_drift_is_taken_for_truth():
    """Fixes alone cannot tell: the error grows with the drift, and sigma says so."""
    craft = sail(Drifting(*OFF), 300, every=0)
    assert np.hypot(*craft.error) == pytest.approx(np.hypot(0.4 + 0.015 * 299, -0.3 + 0.01 * 299), abs=1.0)
    assert craft.filter.sigma_m > 4.0
    assert len(craft.filter.state) == 10


def test_ranges_hold_the_position():
    """With ranges to one craft beside it, position and drift are found, as the bearing turns."""
    craft = sail(Drifting(*OFF), 300)
    assert np.hypot(*craft.error) < 0.15
    assert craft.filter.state[8:] == pytest.approx((0.015, 0.01), abs=0.002)
    assert craft.filter.sigma_m < 0.5


def test_on_one_course_only_the_line_of_sight_is_held():
    """As long as the bearing does not turn, the error across it grows, and the filter knows: it claims no less."""
    craft = sail(Drifting(*OFF), 58)
    assert abs(craft.error[1]) < 0.15
    assert abs(craft.error[0]) > 0.5
    north, east = np.sqrt(np.diag(craft.filter.covariance)[:2])
    assert north > 3.0 * east
    assert abs(craft.error[0]) < 2.0 * north


def test_a_late_range_counts_at_its_time():
    """A range that comes 7 s late leaves the filter where it would be had it come at once."""
    early, late = Drifting(*OFF), Drifting(*OFF)
    waiting = []
    for _ in range(100):
        for craft in (early, late):
            craft.step()
        if early.now % 10 == 0:
            early.filter.hear_range(early.range())
            waiting.append(late.range())
        if waiting and late.now == waiting[0].t_s + 7.0:
            assert late.filter.hear_range(waiting.pop(0))
    assert not waiting
    assert late.filter.state == pytest.approx(early.filter.state, abs=1e-12)
    assert late.filter.covariance == pytest.approx(early.filter.covariance, abs=1e-12)


def test_the_order_of_arrival_does_not_matter():
    """Two ranges that come in the wrong order leave the filter where they would in the right one."""
    found = []
    for order in (1, -1):
        craft = Drifting(*OFF)
        ranges = []
        for _ in range(30):
            craft.step()
            if craft.now in {12, 20}:
                ranges.append(craft.range())
        assert all(craft.filter.hear_range(heard) for heard in ranges[::order])
        found.append(craft.filter.state)
    assert found[0] == pytest.approx(found[1], abs=1e-12)


def test_too_late():
    """A range older than the memory, or before the first fix, changes nothing."""
    craft = Drifting(*OFF)
    early = Range(0.0, 0.0, "boat", 41.0, 0.0, 40.0, 0.0, 0.1)
    assert not craft.filter.hear_range(early)
    sail(craft, 80, every=0)
    before = craft.filter.state
    assert not craft.filter.hear_range(early)
    assert craft.filter.state == before


def test_an_outlier_is_left_out():
    """A range that is 30 m too long is rejected and changes nothing."""
    craft = sail(Drifting(*OFF), 200)
    before = craft.filter.state
    assert not craft.filter.hear_range(craft.range(extra=30.0))
    assert craft.filter.state == before


def test_a_start_that_is_far_off_is_found():
    """With 20 m of error at the start, where 0.5 m are claimed, ranges are rejected until the offset is set free."""
    craft, accepted = Drifting((20.0, -10.0), (0.01, 0.0)), []
    for _ in range(300):
        craft.step()
        if craft.now % 3 == 0:
            accepted.append(craft.filter.hear_range(craft.range()))
    assert not any(accepted[:5])
    assert all(accepted[-20:])
    assert np.hypot(*craft.error) < 1.0


def test_a_bad_mate_does_not_throw_the_own_position():
    """Ranges to a ship that tells a place 25 m off are left out, though it answers nine times as often as the boat."""
    craft = sail(Drifting(*OFF), 300)
    for _ in range(300):
        craft.step()
        there = craft.range()
        if craft.now % 30 == 0:
            craft.filter.hear_range(there)
        elif craft.now % 3 == 0:
            craft.filter.hear_range(there._replace(craft="ship", north_m=there.north_m + 25.0))
        assert np.hypot(*craft.error) < 1.0


def test_when_both_mates_disagree_it_is_the_own_position():
    """Two mates tell the truth, and the start is 22 m off: both are left out five times, and then believed."""
    craft, accepted = Drifting((20.0, -10.0), (0.01, 0.0)), []
    for _ in range(300):
        craft.step()
        if craft.now % 3 == 0:
            accepted.append(craft.filter.hear_range(craft.range()._replace(craft=("boat", "ship")[craft.now % 2])))
    assert not any(accepted[:10])
    assert all(accepted[-20:])
    assert np.hypot(*craft.error) < 1.0


def test_consistent_with_ranges():
    """With errors drawn as the filter models them, NEES over position is in its 95 % band, with late ranges."""
    draw = np.random.default_rng(2008)
    total = sum(_normalised_error(draw) for _ in range(100))
    # χ² with 200 degrees of freedom: 95 % lie between 162.7 and 241.1.
    assert 162.7 < total < 241.1


def _normalised_error(draw):
    """Position error after 100 s and a turn, weighed with the covariance claimed."""
    offset, drift = (sigma * draw.normal(size=2) for sigma in (INERTIAL.offset_sigma_m, INERTIAL.drift_sigma_mps))
    craft, late = Drifting(offset, drift, draw), []
    for _ in range(100):
        craft.step()
        late += [craft.range(sigma=0.2)] if craft.now % 4 == 0 else []
        if len(late) > 1:
            craft.filter.hear_range(late.pop(0))
    wrong = craft.error
    return float(wrong @ np.linalg.solve(craft.filter.covariance[:2, :2], wrong))
