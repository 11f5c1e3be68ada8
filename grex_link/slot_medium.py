"""The paper's channel: a message takes a fixed time, one craft speaks at a time, all hear it or lose it.

Distance plays no part in it. A transmission that begins while another is on the air is refused.
"""

import heapq
from itertools import count

from grex_link.channel_loss import ChannelLoss
from grex_link.config import Scenario
from grex_link.medium import Due
from grex_link.messages import (
    Happening,
    LinkEvent,
    ModemStatus,
    Received,
    Request,
    Transmit,
    Truth,
    TxEvent,
)
from grex_link.modem_rules import refusal
from grex_link.profile import ModemProfile
from grex_link.units import NS


class SlotMedium:
    """See the module's docstring and `Medium`.

    Parameters
    ----------
    scenario : Scenario
        Team, losses and seed.
    profile : ModemProfile
        Airtime and payload limit.
    """

    def __init__(self, scenario: Scenario, profile: ModemProfile) -> None:
        self._profile = profile
        self._team = list(scenario.craft)
        self._places = {craft: place for place, craft in enumerate(self._team)}
        self._loss = ChannelLoss(scenario.link, scenario.link_seed)
        self._busy_until_ns = 0
        self._now_ns = 0
        self._order = count()
        self._requests: list[tuple[int, int, int, int, Request]] = []
        self._events: list[tuple[int, int, int, int, Due]] = []
        self._log: list[tuple[int, int, int, LinkEvent]] = []
        self.lookahead_ns = profile.airtime_ns(0)
        self._outages: dict[str, list[tuple[int, int]]] = {craft: [] for craft in self._team}
        for outage in scenario.link.outages:
            start_ns, end_ns = round(outage.start_s * NS), round(outage.end_s * NS)
            self._outages[outage.craft].append((start_ns, end_ns))
            self._announce(start_ns, outage.craft, outage.craft, ModemStatus("off"))
            self._announce(end_ns, outage.craft, outage.craft, ModemStatus("rebooted"))

    def place(self, truth: Truth) -> None:
        """Nothing depends on the poses here."""

    def request(self, source: str, request: Request, start_ns: int) -> None:
        """Accept a request."""
        # Nothing comes of a request before its airtime is over, so one that is a little late still begins in time.
        begin_ns = max(start_ns, self._now_ns - self.lookahead_ns)
        heapq.heappush(self._requests, (begin_ns, self._places[source], request.seq, next(self._order), request))

    def advance(self, until_ns: int) -> None:
        """Put what begins before a time on the air, or refuse it."""
        while self._requests and self._requests[0][0] < until_ns:
            start_ns, place, _, _, request = heapq.heappop(self._requests)
            self._begin(self._team[place], request, start_ns)
        self._now_ns = max(self._now_ns, until_ns)

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
        """Next time at which anything happens."""
        times = [queue[0][0] for queue in (self._requests, self._events) if queue]
        return min(times, default=None)

    # -- inside -------------------------------------------------------------------------------------------------

    def _begin(self, source: str, request: Request, start_ns: int) -> None:
        size = len(request.payload) if isinstance(request, Transmit) else 0
        end_ns = start_ns + self._profile.airtime_ns(size)
        reason = self._refusal(source, request, start_ns)
        if reason:
            self._note(LinkEvent(start_ns, "refused", source, request.seq, "", size, reason))
            self._announce(end_ns, source, source, TxEvent(request.seq, "FAILED", reason))
            return
        assert isinstance(request, Transmit)  # noqa: S101 - this modem measures no ranges: refused
        self._note(LinkEvent(start_ns, "started", source, request.seq, "", size, lasting_ns=end_ns - start_ns))
        cut = self._off(source, start_ns, end_ns)
        status = TxEvent(request.seq, "FAILED", "off") if cut else TxEvent(request.seq, "SENT")
        self._announce(end_ns, source, source, status)
        self._busy_until_ns = end_ns
        for receiver in self._team:
            if receiver != source:
                self._arrive(end_ns, source, receiver, request, end_ns - start_ns, cut=cut)

    def _refusal(self, source: str, request: Request, start_ns: int) -> str:
        if self._off(source, start_ns, start_ns + 1):
            return "off"
        reason = refusal(self._profile, request, source, self._places)
        return reason or ("busy" if start_ns < self._busy_until_ns else "")

    def _arrive(self, t_ns: int, source: str, receiver: str, request: Transmit, lasting_ns: int, *, cut: bool) -> None:
        size = len(request.payload)
        reason = "lost_cut" if cut else self._loss.reason(source, receiver, t_ns, request.seq)
        if self._off(receiver, t_ns - lasting_ns, t_ns):
            reason = "missed_off"
        if reason:
            self._note(LinkEvent(t_ns, "lost", source, request.seq, receiver, size, reason))
        elif request.destination not in {"", receiver}:
            self._note(LinkEvent(t_ns, "overheard", source, request.seq, receiver, size))
        else:
            self._note(LinkEvent(t_ns, "delivered", source, request.seq, receiver, size, lasting_ns=lasting_ns))
            self._announce(t_ns, receiver, source, Received(source, request.payload, request.destination))

    def _off(self, craft: str, from_ns: int, before_ns: int) -> bool:
        """Whether a craft's modem is off at any time of an interval."""
        return any(start_ns < before_ns and from_ns < end_ns for start_ns, end_ns in self._outages[craft])

    def _announce(self, t_ns: int, craft: str, source: str, event: Happening) -> None:
        order = (t_ns, self._places[craft], self._places[source], next(self._order))
        heapq.heappush(self._events, (*order, (t_ns, craft, event)))

    def _note(self, event: LinkEvent) -> None:
        heapq.heappush(self._log, (event.t_ns, self._places[event.source], next(self._order), event))
