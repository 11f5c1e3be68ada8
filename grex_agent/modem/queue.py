"""What waits to be transmitted: the highest priority first, then the oldest; nothing is lost silently."""

from bisect import insort
from collections.abc import Hashable, Iterator

import msgspec

from grex_link.units import NS

#: A ttl of this or more is none.
FOREVER_S = 1e9


class Item(msgspec.Struct, eq=False, kw_only=True):
    """One request of the agent, and how far it has come."""

    ticket: int
    frames: tuple[bytes, ...]
    """Goes to the modem one by one; a ranging has one, which is empty."""
    destination: str
    priority: int = 0
    until_ns: int | None = None
    """Latest time at which its transmission may start."""
    key: Hashable = None
    """Of waiting items with the same key only the newest remains; None for none."""
    acknowledge: bool = False
    ranging: bool = False
    by_land: bool = False
    order: int = 0
    """Among equals the lowest goes first."""
    handed: int = 0
    """Frames that the modem has been asked to send."""
    sent: int = 0
    """Frames that have left."""
    finished: int = 0
    """Frames of which nothing more is to be heard."""
    final: bool = False
    """Whether the agent has been told what became of it."""

    @property
    def answered(self) -> bool:
        """Whether the modem waits for an answer after it; what is sent meanwhile makes it deaf to that."""
        return self.acknowledge or self.ranging

    @property
    def place(self) -> tuple[int, int]:
        """Where it stands in the queue."""
        return -self.priority, self.order


class PayloadQueue:
    """See the module's docstring. What has begun – a fragment is on its way – is finished, and no longer *waits*.

    Parameters
    ----------
    items_max : int
        How many items there is room for.
    """

    def __init__(self, items_max: int) -> None:
        self._items_max = items_max
        self._items: list[Item] = []

    def __len__(self) -> int:
        return len(self._items)

    @property
    def waiting(self) -> int:
        """How many items have not begun."""
        return sum(1 for _ in self._not_begun())

    @property
    def until_ns(self) -> int | None:
        """Earliest time after which one of those that wait may no longer start; None for none."""
        return min((item.until_ns for item in self._not_begun() if item.until_ns is not None), default=None)

    def add(self, item: Item) -> tuple[list[Item], list[Item]]:
        """Put an item in.

        Returns
        -------
        superseded, overflown : list of Item
            What is out: an older item with the same key, whose place this one takes; and for want of room the lowest
            priority and of these the newest, which may be this one.
        """
        older = [each for each in self._not_begun() if item.key is not None and each.key == item.key]
        for each in older:
            item.order = each.order
            self._items.remove(each)
        insort(self._items, item, key=lambda each: each.place)
        if len(self._items) <= self._items_max:
            return older, []
        loser = [each for each in self._items if not each.handed][-1]
        self._items.remove(loser)
        return older, [loser]

    def remove(self, item: Item) -> None:
        """Take an item out, if it is in."""
        if item in self._items:
            self._items.remove(item)

    def best(self, above: int | None = None, *, unanswered: bool = False) -> Item | None:
        """Find the next item; one with a priority above a limit, or one that the modem waits for no answer after."""
        for item in self._items:
            if above is not None and item.priority <= above:
                return None
            if not (unanswered and item.answered):
                return item
        return None

    def expired(self, start_ns: int) -> list[Item]:
        """Find the waiting items that may no longer start at a time."""
        return [item for item in self._not_begun() if item.until_ns is not None and item.until_ns < start_ns]

    def _not_begun(self) -> Iterator[Item]:
        return (item for item in self._items if not item.handed)


def latest_ns(now_ns: int, ttl_s: float | None) -> int | None:
    """Latest time at which something may start that may wait for a ttl, seconds; None for no limit."""
    return now_ns + round(max(ttl_s, 0.0) * NS) if ttl_s is not None and ttl_s < FOREVER_S else None
