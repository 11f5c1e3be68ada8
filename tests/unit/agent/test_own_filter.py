"""The navigation filter of the own state."""

import math

import numpy as np
import pytest
from core_steps import fix

from grex_agent.own_filter import OwnFilter
from grex_link.config import OwnFilterConfig, SpeedModelConfig

SPEED = SpeedModelConfig()
CONFIG = OwnFilterConfig()


def sail(config=CONFIG, *, seconds=600, sigma=1.0, bias=0.0, current=(0.0, 0.0), seed=1, silent=range(0)):
    """A craft that turns by 90° every 150 s at an ordered 1 m/s; returns the filter and the true position."""
    draw = np.random.default_rng(seed)
    own = OwnFilter(config, SPEED, (0.0, 0.0))
    north = east = 0.0
    speed, gain = 1.0, 1.0 - math.exp(-1.0 / SPEED.lag_s)
    for now in range(seconds + 1):
        heading = math.pi / 2.0 * (now // 150 % 4)
        if now:
            faster = speed + gain * ((1.0 + bias) - speed)
            north += (speed + faster) / 2.0 * math.cos(middle(heading, now)) + current[0]
            east += (speed + faster) / 2.0 * math.sin(middle(heading, now)) + current[1]
            speed = faster
        noise = sigma * draw.normal(size=2)
        seen = fix(now, north + noise[0], east + noise[1], heading_rad=heading, speed_mps=speed, sigma_m=sigma)
        own.step(float(now), None if now in silent else seen, 1.0)
    return own, (north, east)


def middle(heading, now):
    """Mean heading of the step that ends now."""
    return heading - math.pi / 4.0 if now % 150 == 0 else heading


def test_nothing_before_the_first_fix():
    """Without a fix there is no state; the current is the known one and the position unknown."""
    own = OwnFilter(CONFIG, SPEED, (0.1, 0.2))
    own.step(12.0, None, 1.0)
    assert (own.state, own.covariance, own.current, own.sigma_m) == (None, None, (0.1, 0.2), math.inf)


def test_noise_is_filtered():
    """Of 1 m white noise less than half is left, and the filter claims no less than that."""
    errors = []
    for seed in range(30):
        own, (north, east) = sail(seed=seed)
        errors += [own.state[0] - north, own.state[1] - east]
    rms = math.sqrt(sum(error**2 for error in errors) / len(errors))
    assert rms < 0.5
    assert rms < 1.2 * own.sigma_m


def test_speed_error_and_current_are_told_apart():
    """After turns the filter knows both, though on one course they look alike."""
    own, _ = sail(sigma=0.2, bias=0.05, current=(0.15, -0.10))
    assert own.state[3] == pytest.approx(0.05, abs=0.02)
    assert own.current == pytest.approx((0.15, -0.10), abs=0.02)
    straight, _ = sail(sigma=0.2, bias=0.05, current=(0.15, -0.10), seconds=140)
    turned, _ = sail(sigma=0.2, bias=0.05, current=(0.15, -0.10), seconds=290)
    assert turned.covariance[3, 3] < 0.5 * straight.covariance[3, 3]


def test_measured_speed_helps():
    """With a measured speed through the water the current is known before the first turn."""
    own, _ = sail(OwnFilterConfig(speed_sigma_mps=0.01), sigma=0.2, bias=0.05, current=(0.15, 0.0), seconds=140)
    assert own.current[0] == pytest.approx(0.15, abs=0.02)


def test_dead_reckons_without_fixes():
    """Without fixes the position goes on with what has been learned, and sigma grows."""
    own, (north, east) = sail(sigma=0.2, bias=0.05, seconds=440, silent=range(400, 441))
    heard, _ = sail(sigma=0.2, bias=0.05, seconds=399)
    assert (own.state[0], own.state[1]) == pytest.approx((north, east), abs=2.0)
    assert own.sigma_m > 2.0 * heard.sigma_m


def test_the_same_time_twice():
    """A step at the same time predicts nothing."""
    own, _ = sail(seconds=10)
    before = own.state
    own.step(10.0, None, 1.0)
    assert own.state == before


def test_consistent():
    """With errors drawn as the filter models them, NEES over position is in its 95 % band."""
    draw = np.random.default_rng(2008)
    total = sum(_normalised_error(draw) for _ in range(500))
    # χ² with 1000 degrees of freedom: 95 % lie between 914.3 and 1089.5.
    assert 914.3 < total < 1089.5


def _normalised_error(draw):
    """Position error of a minute's straight run, weighed with the covariance claimed."""
    own = OwnFilter(CONFIG, SPEED, (0.0, 0.0))
    gain, keep = 1.0 - math.exp(-1.0 / SPEED.lag_s), math.exp(-1.0 / SPEED.error_time_s)
    place, current = np.zeros(2), CONFIG.current_sigma_mps * draw.normal(size=2)
    error = SPEED.error_relative * draw.normal()
    speed = 1.0 + SPEED.error_relative * draw.normal()
    for now in range(61):
        if now:
            faster = speed + gain * ((1.0 + error) - speed) + SPEED.noise_mps * draw.normal()
            place = (
                place + np.array([(speed + faster) / 2.0, 0.0]) + current + CONFIG.place_noise_m * draw.normal(size=2)
            )
            speed = faster
            error = keep * error + SPEED.error_relative * math.sqrt(1.0 - keep * keep) * draw.normal()
            current = current + CONFIG.current_noise_mps * draw.normal(size=2)
        north, east = place + draw.normal(size=2)
        own.step(float(now), fix(now, north, east, speed_mps=1.0, sigma_m=1.0), 1.0)
    wrong = np.array(own.state[:2]) - place
    return float(wrong @ np.linalg.solve(own.covariance[:2, :2], wrong))
