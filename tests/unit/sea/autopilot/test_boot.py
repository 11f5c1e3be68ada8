"""Behaviour 1: an autopilot comes up in phases, and says the wrong things first."""

import pytest
from autopilots import ARM, Bench

from grex_sim.autopilot.message import Message

NO_POSITION, GOOD = 0xA7, 0x33F


def test_console_text_comes_before_the_first_heartbeat():
    """A booting Rover puts nine lines of text on the link, then its first heartbeat at 1 s, initialising."""
    bench = Bench(ready_s=None).run(0.95)
    assert [type(m) for _, _, m in bench.heard] == [bytes] * 9
    bench.run(1.1)
    assert bench.last("HEARTBEAT")["custom_mode"] == 16
    assert bench.run(2.1).shown == 0


@pytest.mark.parametrize(("family", "first_s"), [("rover", 1.0), ("sub", 1.0), ("px4", 1.4)])
def test_nothing_is_said_before_the_heartbeat(family, first_s):
    """No message of any kind comes before the family's first heartbeat is due."""
    bench = Bench(family, ready_s=None).run(first_s - 0.02, 0.02)
    assert not [m for _, _, m in bench.heard if isinstance(m, Message)]
    assert bench.run(first_s + 0.04, 0.02).said("HEARTBEAT")


def test_a_rover_is_at_zero_zero_at_first():
    """For 7.5 s a Rover's global position is 0, 0, and its date is 0 until 9.7 s."""
    bench = Bench(ready_s=None).run(7.4)
    assert {(m["lat"], m["lon"]) for m in bench.said("GLOBAL_POSITION_INT")} == {(0, 0)}
    assert {m["time_unix_usec"] for m in bench.said("SYSTEM_TIME")} == {0}
    bench.run(10.8)
    assert abs(bench.last("GLOBAL_POSITION_INT")["lat"] - 543_700_000) < 1000
    assert [m["time_unix_usec"] > 0 for m in bench.said("SYSTEM_TIME", 8.0)] == [False, True]


def test_a_sub_is_at_home_at_first():
    """Before it has an origin a Sub tells where home was set, not where it is."""
    bench = Bench("sub", ready_s=None, wind_ned_mps=(1.0, 0.0)).run(30.0)
    assert {(m["lat"], m["lon"]) for m in bench.said("GLOBAL_POSITION_INT")} == {(543_700_000, 101_600_000)}
    assert bench.truth.north_m == pytest.approx(30.0, abs=0.1)


@pytest.mark.parametrize(("family", "ready_s"), [("rover", 42.0), ("sub", 40.0)])
def test_the_estimator_is_ready_after_forty_seconds(family, ready_s):
    """The flags go from 0xa7 to 0x33f at the measured time, and not before."""
    bench = Bench(family, ready_s=None).run(ready_s - 0.1)
    assert {m["flags"] for m in bench.said("EKF_STATUS_REPORT")} == {NO_POSITION}
    assert bench.run(ready_s + 1.2).last("EKF_STATUS_REPORT")["flags"] == GOOD


def test_arming_fails_with_changing_reasons_until_it_is_ready():
    """A Rover in GUIDED, asked every second, refuses until 42 s, for at least four different reasons."""
    bench = Bench(ready_s=None).run(2.0)
    assert bench.mode("GUIDED") == 0
    results = []
    while bench.now < 44.0:
        results.append((bench.now, bench.command(ARM, 1)))
        bench.run(bench.now + 0.9)
    assert {result for at_s, result in results if at_s < 42.0} == {4}
    assert {result for at_s, result in results if at_s > 42.1} == {0}
    assert len({text for text in bench.texts() if text.startswith("Arm:")}) >= 4


def test_manual_arms_without_a_position():
    """In MANUAL a Rover arms at 23 s though it has no position, and says CRITICAL."""
    bench = Bench(ready_s=None).run(22.8)
    assert bench.command(ARM, 1) == 4
    bench.run(23.2)
    assert bench.command(ARM, 1) == 0
    bench.run(25.0)
    assert bench.last("EKF_STATUS_REPORT")["flags"] == NO_POSITION
    assert bench.last("HEARTBEAT")["system_status"] == 5


def test_a_short_boot_is_the_same_in_small():
    """`ready_s` of 4.2 is a tenth of everything: heartbeat at 0.1 s, place at 0.75 s, position at 4.2 s."""
    bench = Bench(ready_s=4.2).run(0.14, 0.02)
    assert bench.said("HEARTBEAT")
    bench.run(2.2)
    assert bench.command(ARM, 1) == 4
    bench.run(3.9)
    assert bench.command(ARM, 1) == 0
    assert not bench.run(4.18).pilot.brain.estimator.aiding
    bench.run(4.24)
    assert bench.pilot.brain.estimator.aiding
