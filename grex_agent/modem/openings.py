"""The own openings, each taken once, whatever windows are asked for and however the clock is set."""

import sys
from collections import deque

from grex_link.mac import Mac
from grex_link.units import NS

#: Openings are asked of the MAC this far ahead.
_AHEAD_NS = 10 * NS
_JUMP_NS = 60 * NS
#: An opening so little before it was looked at is still used; the guard has room for as much.
LATE_NS = NS // 100


class Openings:
    """See the module's docstring.

    A clock set back by up to a minute makes the craft silent until it has caught up; one set forward so far makes it
    miss what has passed. A clock that jumps by more begins anew.

    Parameters
    ----------
    mac : Mac
        Who knows them.
    craft : str
        Whose they are.

    Attributes
    ----------
    owned : int
        Openings so far, those that were missed included.
    next_ns : int
        There is no opening to take before this.
    restart_ns : int
        A window that ends before this means that the clock has been set back far.
    """

    def __init__(self, mac: Mac, craft: str) -> None:
        self._mac, self._craft = mac, craft
        self._ahead: deque[int] = deque()
        self._looked_ns = self._covered_ns = -sys.maxsize
        self.owned = 0
        self.next_ns = self.restart_ns = -sys.maxsize

    def take(self, now_ns: int, before_ns: int) -> list[int]:
        """Take the openings before a time that have not been taken yet, in order; those that have passed are missed.

        Parameters
        ----------
        now_ns, before_ns : int
            The window that is looked at.
        """
        if before_ns <= self.restart_ns or now_ns > self._covered_ns + _JUMP_NS:
            self._ahead.clear()
            self._looked_ns = self._covered_ns = now_ns
        if before_ns > self._looked_ns:
            until_ns = before_ns + _AHEAD_NS
            self._ahead += self._mac.openings(self._craft, self._looked_ns, until_ns)
            self._looked_ns = until_ns
        taken = []
        while self._ahead and self._ahead[0] < before_ns:
            opening_ns = self._ahead.popleft()
            self.owned += 1
            if opening_ns >= now_ns - LATE_NS:
                taken.append(opening_ns)
        self._covered_ns = max(self._covered_ns, before_ns)
        self.restart_ns = self._covered_ns - _JUMP_NS
        self.next_ns = self._ahead[0] if self._ahead else self._looked_ns
        return taken
