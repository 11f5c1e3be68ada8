"""The queue: who goes first, who has to go, and what has begun stays."""

import math

import pytest

from grex_agent.modem.queue import FOREVER_S, Item, PayloadQueue, latest_ns


def item(ticket: int, priority: int = 0, **more) -> Item:
    return Item(ticket=ticket, order=ticket, frames=(b"x",), destination="", priority=priority, **more)


def tickets(queue: PayloadQueue) -> list[int]:
    order = []
    while best := queue.best():
        queue.remove(best)
        order.append(best.ticket)
    return order


def test_order() -> None:
    """The highest priority goes first, and among equals the oldest."""
    queue = PayloadQueue(9)
    for number, priority in enumerate([0, 2, 1, 2, 0, -1]):
        queue.add(item(number, priority))
    assert tickets(queue) == [1, 3, 2, 0, 4, 5]


def test_overflow() -> None:
    """Of a full queue the lowest priority goes, and of these the newest, be it the one just put in."""
    queue = PayloadQueue(2)
    queue.add(item(0))
    queue.add(item(1))
    assert [loser.ticket for loser in queue.add(item(2))[1]] == [2]
    assert [loser.ticket for loser in queue.add(item(3, 1))[1]] == [1]
    assert tickets(queue) == [3, 0]


def test_supersede_takes_the_place() -> None:
    """The newer takes the place of the older of the same key, so that a value often renewed gets its turn."""
    queue = PayloadQueue(3)
    for number, key in enumerate(["depth", None, None]):
        queue.add(item(number, key=key))
    superseded, overflown = queue.add(item(3, key="depth"))
    assert ([each.ticket for each in superseded], overflown) == ([0], [])
    assert tickets(queue) == [3, 1, 2]


def test_what_has_begun_stays() -> None:
    """What has begun is not superseded, not expired and not put out; it no longer waits, but has its room."""
    queue = PayloadQueue(1)
    begun = item(0, -9, key="k", until_ns=5)
    queue.add(begun)
    assert (queue.waiting, queue.until_ns) == (1, 5)
    begun.handed = 1
    superseded, overflown = queue.add(item(1, 9, key="k"))
    assert (superseded, [loser.ticket for loser in overflown]) == ([], [1])
    assert (queue.waiting, queue.until_ns, queue.expired(100), len(queue)) == (0, None, [], 1)


def test_expired() -> None:
    """What may start until a time may start at that time, and not after."""
    queue = PayloadQueue(3)
    queue.add(item(0, until_ns=10))
    assert queue.expired(10) == []
    assert [each.ticket for each in queue.expired(11)] == [0]


def test_best_above_and_unanswered() -> None:
    """Asked for a priority above a limit, or for what is not answered, the queue gives the first of these or none."""
    queue = PayloadQueue(4)
    queue.add(item(0, 2, ranging=True))
    queue.add(item(1, 1, acknowledge=True))
    queue.add(item(2, 0))
    assert queue.best(2) is None
    assert queue.best(1).ticket == 0
    assert queue.best(unanswered=True).ticket == 2
    assert queue.best(0, unanswered=True) is None


@pytest.mark.parametrize(
    ("ttl_s", "latest"),
    [(None, None), (math.inf, None), (FOREVER_S, None), (math.nan, None), (2.0, 12), (0.0, 10), (-math.inf, 10)],
)
def test_ttl(ttl_s: float | None, latest: int | None) -> None:
    """A ttl ends after its seconds, at once if it is negative, and never if it is none, endless or no number."""
    found = latest_ns(10 * 10**9, ttl_s)
    assert found == (None if latest is None else latest * 10**9)
