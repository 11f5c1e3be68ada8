"""Messages that come twice, because the network does it or there are two ways: the second one counts for nothing. Pure.

Late ones would look like a second autopilot with the same system id. Only messages with a time in them are asked about:
others may well be the same again and again.
"""

from collections import deque

from grex_agent.frontseat.dialect import Mavlink

#: So many messages are remembered; their numbers begin anew after 256.
_REMEMBERED = 100


class Echoes:
    """Remembers what has been heard; see the module's docstring."""

    def __init__(self) -> None:
        self._marks: deque[tuple[int, int, int]] = deque(maxlen=_REMEMBERED)

    def is_one(self, message: Mavlink) -> bool:
        """Whether this very message has just been heard before."""
        mark = message.get_msgId(), message.get_seq(), message.get_crc()
        if mark in self._marks:
            return True
        self._marks.append(mark)
        return False
