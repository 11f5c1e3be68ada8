"""Openings: each taken once, whatever windows are asked for and however the clock is set."""

import pytest

from grex_agent.modem.openings import Openings
from grex_link.mac import PureAlohaMac
from grex_link.tdma import Schedule, Slot
from grex_link.units import NS

#: auv1 has the third second of every ten.
MAC = Schedule((Slot("auv1", 2 * NS, NS), Slot("auv2", 5 * NS, NS)), 10 * NS)


def take(openings: Openings, now_s: float, before_s: float) -> list[float]:
    return [t_ns / NS for t_ns in openings.take(round(now_s * NS), round(before_s * NS))]


def test_every_opening_once() -> None:
    """Windows side by side give all openings, each in its window."""
    openings = Openings(MAC, "auv1")
    found = {tick: take(openings, tick, tick + 1) for tick in range(35)}
    assert {tick: times for tick, times in found.items() if times} == {2: [2.0], 12: [12.0], 22: [22.0], 32: [32.0]}
    assert openings.owned == 4


def test_windows_that_overlap() -> None:
    """An opening within two windows is taken in the first; one at the end of a window belongs to the next."""
    openings = Openings(MAC, "auv1")
    assert take(openings, 0.0, 2.0) == []
    assert take(openings, 1.0, 2.5) == [2.0]
    assert take(openings, 1.5, 3.0) == []


def test_set_back() -> None:
    """A clock set back a little brings no opening a second time."""
    openings = Openings(MAC, "auv1")
    assert take(openings, 0.0, 13.0) == [2.0, 12.0]
    assert take(openings, 1.0, 13.0) == []
    assert take(openings, 13.0, 23.0) == [22.0]


def test_set_back_far() -> None:
    """A clock set back by more than a minute begins anew: the craft is not silent until it has caught up."""
    openings = Openings(MAC, "auv1")
    take(openings, 1000.0, 1001.0)
    assert take(openings, 1.0, 3.0) == [2.0]


def test_missed() -> None:
    """Openings that have passed are counted and not taken, unless it is by a hundredth of a second or less."""
    openings = Openings(MAC, "auv1")
    take(openings, 0.0, 1.0)
    assert take(openings, 12.01, 12.1) == [12.0]
    assert openings.owned == 2
    assert take(openings, 22.02, 22.1) == []
    assert openings.owned == 3


def test_set_forward_far() -> None:
    """A clock set forward by years takes no time and counts nothing that nobody could have used."""
    openings = Openings(MAC, "auv1")
    take(openings, 0.0, 3.0)
    assert take(openings, 1e9, 1e9 + 3.0) == [1e9 + 2.0]
    assert openings.owned == 2


def test_begins_where_it_is_asked_first() -> None:
    """An agent started in the middle of a mission has missed nothing."""
    openings = Openings(MAC, "auv1")
    assert take(openings, 502.005, 502.5) == []
    assert openings.owned == 0


@pytest.mark.parametrize("step_s", [0.1, 0.7, 3.0, 40.0])
def test_no_opening_before_next(step_s: float) -> None:
    """No opening comes before what is said to be the next, at random openings and any step."""
    mac = PureAlohaMac(0.2, 64, seed=3)
    openings, now_s, found = Openings(mac, "auv1"), 0.0, []
    while now_s < 400.0:
        promised_ns = openings.next_ns
        times = openings.take(round(now_s * NS), round((now_s + step_s) * NS))
        assert not times or times[0] >= promised_ns
        found += times
        now_s += step_s
    assert found == mac.openings("auv1", 0, round(now_s * NS))
    assert len(found) > 40


def test_set_back_again_and_again() -> None:
    """What counts is how far the clock has been set back in all: beyond a minute it begins anew."""
    openings = Openings(MAC, "auv1")
    assert take(openings, 202.0, 203.0) == [202.0]
    assert take(openings, 151.0, 153.0) == []
    assert take(openings, 101.0, 103.0) == [102.0]
