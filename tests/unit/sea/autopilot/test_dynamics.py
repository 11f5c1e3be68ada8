"""Behaviours 3 and 6: its own time, its limits, and how its craft moves."""

import math

import pytest
from autopilots import Bench

from grex_sim.autopilot.shell import Pace


def test_a_rover_is_fast_after_three_seconds():
    """Asked for 2 m/s a Rover has 1.8 after 3 s and 1.99 to 2.01 in the end, on the heading asked for."""
    bench = Bench().guided().drive(3.0, 2.0, 0.0)
    assert 1.6 < bench.speed < 1.95
    bench.drive(6.0, 2.0, 0.0)
    assert bench.speed == pytest.approx(2.0, abs=0.01)
    assert bench.heading_deg == pytest.approx(0.0, abs=0.5)


def test_a_quarter_turn_takes_three_seconds():
    """From north to east a Rover needs between 2 and 5 s."""
    bench = Bench().guided().drive(8.0, 2.0, 0.0).drive(2.0, 0.0, 2.0)
    assert 45.0 < bench.heading_deg < 85.0
    bench.drive(3.0, 0.0, 2.0)
    assert bench.heading_deg == pytest.approx(90.0, abs=3.0)


def test_a_sub_gives_four_fifths():
    """Asked for 0.5 m/s a Sub makes 0.4 and not more; depth rates are obeyed."""
    bench = Bench("sub").guided().drive(15.0, 0.5, 0.0, 0.2)
    assert bench.speed == pytest.approx(0.4, abs=0.02)
    assert bench.truth.down_m == pytest.approx(15.0 * 0.2, abs=0.5)


def test_px4_wobbles():
    """Asked for 2 m/s a PX4 makes between 1.7 and 2.65, and not always the same."""
    bench = Bench("px4").guided().drive(5.0, 2.0, 0.0)
    speeds = []
    bench.run(bench.now + 40.0, 0.2, lambda: (bench.velocity(2.0, 0.0), speeds.append(bench.speed)))
    assert min(speeds) > 1.7
    assert max(speeds) < 2.65
    assert max(speeds) - min(speeds) > 0.3


@pytest.mark.parametrize(("family", "asked", "got"), [("rover", 20.0, 5.0), ("px4", 9.0, 2.6)])
def test_speed_is_limited(family, asked, got):
    """Whatever is asked for, no more than the family's limit is made."""
    assert Bench(family).guided().drive(15.0, asked, 0.0).speed == pytest.approx(got, abs=0.05)


def test_a_parameter_limits_the_speed():
    """WP_SPEED of 1.5 m/s is obeyed while it drives."""
    bench = Bench().guided()
    bench.set_parameter("WP_SPEED", 1.5)
    assert bench.drive(10.0, 4.0, 0.0).speed == pytest.approx(1.5, abs=0.02)


def test_yaw_wins_on_a_rover():
    """A Rover told v = (2, 0) and yaw 90 deg goes east at 2 m/s; with vx < 0 it goes astern."""
    bench = Bench().guided().drive(10.0, 2.0, 0.0, mask=0x09C7, yaw=1.5708)
    assert bench.heading_deg == pytest.approx(90.0, abs=1.0)
    assert bench.pilot.brain.craft.velocity[1] == pytest.approx(2.0, abs=0.05)
    bench.drive(10.0, -1.0, 0.0, mask=0x09C7, yaw=1.5708)
    assert bench.pilot.brain.craft.velocity[1] == pytest.approx(-1.0, abs=0.05)


def test_a_sub_goes_sideways():
    """A Sub told to look east while going north does both."""
    bench = Bench("sub").guided().drive(10.0, 0.5, 0.0, mask=0x09C7, yaw=1.5708)
    assert bench.heading_deg == pytest.approx(90.0, abs=1.0)
    assert bench.pilot.brain.craft.velocity[0] == pytest.approx(0.4, abs=0.02)


def test_a_sub_that_is_told_no_heading_keeps_its_own():
    """Without a yaw in its set-points a Sub goes east with its bow where it was told to look last."""
    bench = Bench("sub").guided().drive(10.0, 0.0, 0.5)
    assert bench.heading_deg == pytest.approx(0.0, abs=1.0)
    assert bench.pilot.brain.craft.velocity[1] == pytest.approx(0.4, abs=0.02)
    bench.drive(8.0, 0.5, 0.0, mask=0x09C7, yaw=0.6).drive(10.0, 0.0, 0.5)
    assert bench.heading_deg == pytest.approx(math.degrees(0.6), abs=1.0)


def test_px4_ignores_yaw():
    """A PX4's heading is that of its velocity, whatever yaw says."""
    bench = Bench("px4").guided().drive(8.0, 2.0, 0.0, mask=0x09C7, yaw=1.5708)
    assert bench.heading_deg == pytest.approx(0.0, abs=1.0)


def test_a_turn_rate_is_kept():
    """Vx and a yaw rate of 0.2 rad/s turn a Rover by about two radians in ten seconds."""
    bench = Bench().guided()
    turned = []
    bench.run(
        bench.now + 10.0,
        0.1,
        lambda: (
            bench.velocity(1.0, 0.0, mask=0x05C7, yaw_rate=0.2),
            turned.append(bench.pilot.brain.craft.yaw_rate),
        ),
    )
    assert sum(turned[30:]) / len(turned[30:]) == pytest.approx(0.2, abs=0.03)


def test_it_holds_its_course_in_a_current():
    """With a current across of 0.5 m/s the course over ground is still north, at the speed asked for."""
    bench = Bench(current_ned_mps=(0.0, 0.5, 0.0)).guided().drive(15.0, 2.0, 0.0)
    north, east, _ = bench.pilot.brain.craft.velocity
    assert north == pytest.approx(2.0, abs=0.05)
    assert east == pytest.approx(0.0, abs=0.05)


def test_it_drifts_while_disarmed():
    """The wind drives a disarmed craft 0.1 m/s north; armed it does not."""
    bench = Bench(wind_ned_mps=(0.1, 0.0)).run(20.0)
    assert bench.truth.north_m == pytest.approx(2.0, abs=0.05)


def test_its_clock_is_its_own():
    """Ten times as fast and 400 ppm slow: 100 wall seconds are 999.6 of its own."""
    pace = Pace(10.0, -400.0, 50.0)
    for n in range(1, 1001):
        now = pace.advance(50.0 + n * 0.1)
    assert now == pytest.approx(999.6, abs=1e-6)


def test_a_stopped_process_does_not_run_after_its_time():
    """After a minute of standstill half a second has passed, and a clock set back stops it only for a moment."""
    pace = Pace(1.0, 0.0, 0.0)
    assert pace.advance(60.0) == pytest.approx(0.5)
    assert pace.advance(10.0) == pytest.approx(0.5)
    assert pace.advance(10.1) == pytest.approx(0.6)
