"""Messages that come twice, because the network does it or there are two ways: the second one counts for nothing. Pure.

Late ones would look like a second autopilot with the same system id.
"""

from collections import deque

from grex_agent.frontseat.dialect import Mavlink

#: The same message within this time, seconds of ours, is one.
_TWICE_S = 1.0
_Mark = tuple[int, int, int]


class Echoes:
    """Remembers what has been heard; see the module's docstring."""

    def __init__(self) -> None:
        self._order: deque[tuple[float, _Mark]] = deque()
        self._marks: set[_Mark] = set()

    def is_one(self, message: Mavlink, now_s: float) -> bool:
        """Whether this very message has just been heard before."""
        while self._order and now_s - self._order[0][0] > _TWICE_S:
            self._marks.discard(self._order.popleft()[1])
        mark = message.get_msgId(), message.get_seq(), message.get_crc()
        if mark in self._marks:
            return True
        self._marks.add(mark)
        self._order.append((now_s, mark))
        return False
