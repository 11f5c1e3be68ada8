"""The error of a craft's own navigation: offset, drift and white noise (Fig. 4)."""

import numpy as np
import pytest

from grex_link.config import NavigationConfig
from grex_link.messages import Pose
from grex_sim.navigation import Navigation

NS = 1_000_000_000
POSE = Pose("auv1", 100.0, -50.0, 8.0, 0.01, 0.02, 0.5, 1.2)


def errors(config, craft="auv1", seed=1, ticks=2000):
    """Errors north and east of many fixes, shape (ticks, 2)."""
    navigation = Navigation(craft, config, seed)
    fixes = [navigation.fix(POSE, tick, tick * NS, 0) for tick in range(ticks)]
    return np.array([(fix.north_m - 100.0, fix.east_m + 50.0) for fix in fixes])


def test_perfect_navigation():
    """Without errors a fix is the pose, and claims so."""
    fix = Navigation("auv1", NavigationConfig(), 1).fix(POSE, 12, 12 * NS, 3)
    assert (fix.north_m, fix.east_m, fix.down_m, fix.heading_rad, fix.speed_mps) == (100.0, -50.0, 8.0, 0.5, 1.2)
    assert (fix.tick, fix.t_ns, fix.sigma_m, fix.valid, fix.modem_events) == (12, 12 * NS, 0.0, True, 3)


def test_offset_and_drift():
    """The fixed offset and the error that grows with time add up, on all three axes."""
    config = NavigationConfig(offset_ned_m=(0.5, -0.4, 0.2), drift_ned_mps=(0.01, 0.02, -0.03))
    fix = Navigation("auv1", config, 1).fix(POSE, 12, 12 * NS, 0)
    assert (fix.north_m, fix.east_m, fix.down_m) == pytest.approx((100.62, -50.16, 7.84))
    assert fix.sigma_m == pytest.approx(((0.62**2 + 0.16**2) / 2.0) ** 0.5)


def test_white_noise():
    """White noise has the deviation asked for on both axes, no mean, and no memory or likeness of the axes."""
    noise = errors(NavigationConfig(white_m=1.5))
    assert noise.std(axis=0) == pytest.approx([1.5, 1.5], rel=0.06)
    assert noise.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.15)
    assert abs(np.corrcoef(noise.T)[0, 1]) < 0.1
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.1


def test_noise_is_a_function_of_its_purpose():
    """A fix's noise depends on seed, craft and tick, and on nothing that happened before."""
    config = NavigationConfig(white_m=1.5)
    whole = errors(config, ticks=30)
    assert Navigation("auv1", config, 1).fix(POSE, 29, 29 * NS, 0).north_m == 100.0 + whole[29, 0]
    assert not np.isin(errors(config, craft="auv2", ticks=30), whole).any()
    assert not np.isin(errors(config, seed=2, ticks=30), whole).any()


def test_sigma_claims_noise_and_bias():
    """The claimed deviation is that of noise and bias together."""
    fix = Navigation("auv1", NavigationConfig(white_m=0.3, offset_ned_m=(0.4, 0.4, 9.0)), 1).fix(POSE, 0, 0, 0)
    assert fix.sigma_m == pytest.approx(0.5)
