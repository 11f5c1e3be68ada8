"""Mission time runs with the wall clock, as fast as the pace says."""

import pytest

from grex_link import clock
from grex_link.units import NS, tick_ns

HOUR = 3600 * NS


@pytest.mark.parametrize("pace", [0.5, 1.0, 4.0, 1000.0])
def test_mission_time(pace: float) -> None:
    """Mission time is the wall time since the epoch times the pace."""
    epoch = clock.unix_ns() - 12 * NS
    wall = clock.WallClock(pace, epoch)
    before, now, after = clock.unix_ns(), wall.now_ns(), clock.unix_ns()
    assert (before - epoch) * pace - 1 <= now <= (after - epoch) * pace
    assert now >= 12 * NS * pace


def test_wall_time_until() -> None:
    """At pace 4 an hour of mission time is a quarter of an hour on the wall."""
    wall = clock.WallClock(4.0, clock.unix_ns())
    t_ns = wall.now_ns() + HOUR
    assert 890.0 < wall.wall_s_until(t_ns) <= 900.0


def test_nothing_to_wait_for() -> None:
    """There is no waiting for a time that has passed."""
    wall = clock.WallClock(1.0, clock.unix_ns() - 12 * NS)
    assert wall.wall_s_until(5 * NS) == 0.0


def test_before_the_epoch() -> None:
    """Before the mission starts, mission time is negative and the start is waited for."""
    wall = clock.WallClock(1.0, clock.unix_ns() + HOUR)
    assert wall.now_ns() < 0
    assert 3500.0 < wall.wall_s_until(0) <= 3600.0


def test_monotonic() -> None:
    """The clock for timeouts never runs backwards, and no sleep is shorter than asked for."""
    before = clock.monotonic_s()
    clock.sleep_s(0.001)
    assert clock.monotonic_s() >= before + 0.001


@pytest.mark.parametrize(("tick_s", "length_ns"), [(1.0, NS), (0.1, 100_000_000), (0.01, 10_000_000), (0.3, 3 * 10**8)])
def test_tick(tick_s: float, length_ns: int) -> None:
    """A tick is a whole number of nanoseconds, free of binary fractions."""
    assert tick_ns(tick_s) == length_ns
