"""Ranges without noise: they pull towards the truth, and the covariance stays one."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.gaussian import Gaussian
from grex_agent.range_update import Range, surprise, work_in

METRES = st.floats(-200.0, 200.0)
SIGMA = st.floats(0.05, 5.0)


@st.composite
def doubts(draw):
    """A covariance of a position, with all directions of doubt."""
    angle, long, short = draw(st.floats(0.0, math.pi)), draw(SIGMA), draw(SIGMA)
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return turned @ np.diag((long**2, short**2)) @ turned.T


@given(METRES, METRES, st.floats(-50.0, 50.0), doubts(), st.floats(0.0, 1.0), st.floats(0.05, 2.0))
def test_covariance_stays_one(north, east, down, doubt, told, sigma):
    """After a range the covariance is symmetric, has no negative eigenvalue, and none is greater than before."""
    x = Gaussian((north, east), doubt)
    after = work_in(x, surprise(x, Range(0.0, 0.0, "boat", 50.0, 0.0, 0.0, 0.0, told), down, sigma)).covariance
    assert np.allclose(after, after.T, atol=1e-9)
    assert np.linalg.eigvalsh(after).min() > -1e-9
    assert np.linalg.eigvalsh(doubt - after).min() > -1e-9


@given(
    st.floats(0.0, 2.0 * math.pi), st.floats(20.0, 300.0), METRES, METRES, st.floats(0.0, 40.0), st.floats(0.05, 2.0)
)
def test_true_ranges_pull_towards_the_truth(bearing, distance, wrong_north, wrong_east, down, sigma):
    """A range without error, along the error's own line of sight, never makes a position with equal doubts worse."""
    boat = np.array([distance * math.cos(bearing), distance * math.sin(bearing)])
    share = 0.02 * distance / 300.0
    believed = np.array([wrong_north, wrong_east]) * share
    x = Gaussian((believed[0], believed[1]), np.eye(2) * 0.01)
    slant = math.hypot(distance, down)
    after = work_in(x, surprise(x, Range(0.0, 0.0, "boat", slant, *boat, 0.0, 0.0), down, sigma))
    before_m = abs(math.hypot(*(believed - boat)) - distance)
    after_m = abs(math.hypot(*(np.array(after.mean) - boat)) - distance)
    # The curvature that is expected and is not there: half the variance over the distance.
    assert after_m <= before_m + 0.01 / distance
