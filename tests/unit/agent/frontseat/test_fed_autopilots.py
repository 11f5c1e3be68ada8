"""Positions fed through the whole adapter, on literal time."""

import math

import pytest
from mavlink_bench import MavlinkBench
from mavlink_duet import Duet

from grex_link.messages import Fix


def test_a_px4_that_has_learned_our_clock_is_fed_on():
    """A PX4 takes vision before and after it has learned our clock, 50 s of TIMESYNC later."""
    duet = Duet("px4", adapter={"feed": "vision"}, parameters={"EKF2_EV_CTRL": 1}, wind_ned_mps=(0.0, 0.0))
    for _ in range(65):
        duet.navigate(Fix(0, 0, 12.0, -7.0, 0.0, 0.0, 0.0, 0.4))
        duet.run(1.0)
    brain = duet.pilot.brain
    assert brain.stamps[0].answers >= 500
    assert brain.estimator.lost_for is None
    assert (brain.estimator.belief.north_m, brain.estimator.belief.east_m) == pytest.approx((12.0, -7.0), abs=0.5)


def test_a_fed_velocity_is_in_the_autopilots_seconds():
    """An autopilot whose clock runs five times as fast is told metres per second of its own."""
    bench = MavlinkBench("sub", feed="gps_input", pace=5.0).run(1.0)
    for k in range(20):
        bench.take(bench.core.on_navigation(Fix(0, 0, 0.5 * k, 0.25 * k, 0.0, 0.0, 1.0, 0.4), bench.now_ns))
        bench.run(0.1, 0.01)
    told = bench.said("GPS_INPUT")[-1]
    assert (told.vn, told.ve) == pytest.approx((1.0, 0.5), abs=0.05)
    assert told.speed_accuracy == pytest.approx(math.hypot(0.04, 0.04, 0.1), rel=0.3)
