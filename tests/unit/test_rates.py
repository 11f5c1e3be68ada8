"""How often messages come, from when they came."""

import pytest

from grex_sim.rates import Intervals


def test_rate_and_spread() -> None:
    """Mean rate, shortest, longest and standard deviation of the intervals are those of the times."""
    intervals = Intervals()
    for time_s in (1e6, 1e6 + 1.0, 1e6 + 1.5, 1e6 + 3.0):
        intervals.add(time_s)
    rate = intervals.rate
    assert rate.messages == 4
    assert rate.hz == pytest.approx(1.0)
    assert (rate.min_s, rate.max_s) == pytest.approx((0.5, 1.5))
    assert rate.std_s == pytest.approx((1.0 / 6.0) ** 0.5)


def test_of_one_message_nothing_can_be_said() -> None:
    """One message has no rate, none neither."""
    intervals = Intervals()
    assert intervals.rate == (0, None, None, None, None)
    intervals.add(5.0)
    assert intervals.rate == (1, None, None, None, None)
