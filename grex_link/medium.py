"""The water as a pure core: transmissions go in, events with their times come out.

A medium is deterministic in integer nanoseconds: the same seed and the same requests, handed over in the order of
(start, place in the team, number), give the same events.
"""

import heapq
from collections.abc import Sequence
from itertools import count
from typing import Protocol

from grex_link import draws
from grex_link.messages import LinkEvent, Received, Transmit, Truth, TxEvent
from grex_link.profile import ModemProfile

#: A modem event on its way: (mission time ns, craft it is for, what it sees).
Due = tuple[int, str, Received | TxEvent]


class Medium(Protocol):
    """What the link process drives; the physics lives behind it.

    Attributes
    ----------
    lookahead_ns : int
        A transmission that starts at t causes no modem event before t + lookahead. The hub may run that far ahead.
    """

    lookahead_ns: int

    def place(self, truth: Truth) -> None:
        """Take note of the true poses at the beginning of a tick."""

    def transmit(self, source: str, request: Transmit) -> None:
        """Accept a request whose start is not before the tick last placed."""

    def events(self, before_ns: int) -> list[Due]:
        """Take the modem events before a time, in the order of (time, receiver, source, number)."""

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Take the log lines before a time, in the same order."""

    def next_event_ns(self) -> int | None:
        """Time of the next modem event, if one is on its way."""


class SlotMedium:
    """The paper's channel: a message takes a fixed time, one craft speaks at a time, all hear it or lose it.

    Distance plays no part in it. A transmission that begins while another is on the air is refused.

    Parameters
    ----------
    profile : ModemProfile
        Airtime and payload limit.
    team : sequence of str
        The craft, in their order.
    loss : float
        Probability that one receiver loses a datagram.
    seed : int
        Seed of the losses.
    """

    def __init__(self, profile: ModemProfile, team: Sequence[str], loss: float, seed: int) -> None:
        self._profile = profile
        self._team = list(team)
        self._loss = loss
        self._seed = seed
        self._busy_until_ns = 0
        self._order = count()
        self._events: list[tuple[int, int, int, int, Due]] = []
        self._log: list[tuple[int, int, int, LinkEvent]] = []
        self.lookahead_ns = profile.airtime_ns(0)

    def place(self, truth: Truth) -> None:
        """Nothing depends on the poses here."""

    def transmit(self, source: str, request: Transmit) -> None:
        """Put a datagram on the air, or refuse it."""
        size = len(request.payload)
        end_ns = request.t_ns + self._profile.airtime_ns(size)
        refused = self._refusal(request)
        self._note(request.t_ns, LinkEvent(
            request.t_ns, "refused" if refused else "started", source, request.seq, "", size, refused))  # fmt: skip
        status = TxEvent(request.seq, "FAILED" if refused else "SENT", refused)
        self._announce(end_ns, source, source, status)
        if refused:
            return
        self._busy_until_ns = end_ns
        for receiver in self._team:
            if receiver != source:
                self._arrive(end_ns, source, receiver, request)

    def events(self, before_ns: int) -> list[Due]:
        """Take the modem events before a time."""
        taken = []
        while self._events and self._events[0][0] < before_ns:
            taken.append(heapq.heappop(self._events)[-1])
        return taken

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Take the log lines before a time."""
        taken = []
        while self._log and self._log[0][0] < before_ns:
            taken.append(heapq.heappop(self._log)[-1])
        return taken

    def next_event_ns(self) -> int | None:
        """Time of the next modem event, if one is on its way."""
        return self._events[0][0] if self._events else None

    def _refusal(self, request: Transmit) -> str:
        if len(request.payload) > self._profile.payload_max_bytes:
            return "size"
        return "busy" if request.t_ns < self._busy_until_ns else ""

    def _arrive(self, t_ns: int, source: str, receiver: str, request: Transmit) -> None:
        lost = draws.uniform(self._seed, "loss", source, request.seq, receiver) < self._loss
        self._note(t_ns, LinkEvent(
            t_ns, "lost" if lost else "delivered", source, request.seq, receiver, len(request.payload),
            "loss" if lost else ""))  # fmt: skip
        if not lost:
            self._announce(t_ns, receiver, source, Received(source, request.payload))

    def _announce(self, t_ns: int, craft: str, source: str, event: Received | TxEvent) -> None:
        order = (t_ns, self._team.index(craft), self._team.index(source), next(self._order))
        heapq.heappush(self._events, (*order, (t_ns, craft, event)))

    def _note(self, t_ns: int, event: LinkEvent) -> None:
        heapq.heappush(self._log, (t_ns, self._team.index(event.source), next(self._order), event))
