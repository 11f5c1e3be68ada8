"""Links that are not under water: cable and radio between chosen craft, beside whatever medium there is."""

import heapq
from itertools import count

from grex_link import draws
from grex_link.config import Scenario
from grex_link.link_config import LandConfig
from grex_link.medium import Due, Medium
from grex_link.messages import BROADCAST, LinkEvent, Received, Request, Transmit, Truth, TxEvent
from grex_link.units import NS


class WaterAndLand:
    """A medium with land links beside it: requests by land take these, all others the water.

    Parameters
    ----------
    scenario : Scenario
        The links and the seed.
    water : Medium
        For everything else.
    """

    def __init__(self, scenario: Scenario, water: Medium) -> None:
        self._water = water
        self._seed = scenario.link_seed
        self._places = {craft: place for place, craft in enumerate(scenario.craft)}
        self._links: dict[str, list[tuple[str, LandConfig]]] = {craft: [] for craft in scenario.craft}
        for link in scenario.link.land:
            first, second = link.between
            self._links[first].append((second, link))
            self._links[second].append((first, link))
        self._order = count()
        self._now_ns = 0
        self._requests: list[tuple[int, int, int, int, Transmit, str]] = []
        self._events: list[tuple[int, int, int, Due]] = []
        self._log: list[tuple[int, int, int, LinkEvent]] = []
        fastest_s = min((link.latency_s for link in scenario.link.land), default=0.0)
        self.lookahead_ns = min(water.lookahead_ns, round(fastest_s * NS))

    def place(self, truth: Truth) -> None:
        """Take note of the true poses."""
        self._water.place(truth)

    def request(self, source: str, request: Request, start_ns: int) -> None:
        """Accept a request."""
        if not (isinstance(request, Transmit) and request.by_land):
            self._water.request(source, request, start_ns)
            return
        begin_ns = max(start_ns, self._now_ns)
        entry = (begin_ns, self._places[source], request.seq, next(self._order), request, source)
        heapq.heappush(self._requests, entry)

    def advance(self, until_ns: int) -> None:
        """Work through everything before a time."""
        self._water.advance(until_ns)
        while self._requests and self._requests[0][0] < until_ns:
            begin_ns, _, _, _, request, source = heapq.heappop(self._requests)
            self._begin(source, request, begin_ns)
        self._now_ns = max(self._now_ns, until_ns)

    def events(self, before_ns: int) -> list[Due]:
        """Take the modem events before a time."""
        taken = self._water.events(before_ns)
        if not self._events or self._events[0][0] >= before_ns:
            return taken
        while self._events and self._events[0][0] < before_ns:
            taken.append(heapq.heappop(self._events)[-1])
        return sorted(taken, key=lambda due: (due[0], self._places[due[1]]))

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Take the log lines before a time."""
        lines = self._water.log(before_ns)
        if not self._log or self._log[0][0] >= before_ns:
            return lines
        while self._log and self._log[0][0] < before_ns:
            lines.append(heapq.heappop(self._log)[-1])
        return sorted(lines, key=lambda line: line.t_ns)

    def next_event_ns(self) -> int | None:
        """Next time at which anything happens."""
        times = [queue[0][0] for queue in (self._requests, self._events) if queue]
        if (water_ns := self._water.next_event_ns()) is not None:
            times.append(water_ns)
        return min(times, default=None)

    def _begin(self, source: str, request: Transmit, t_ns: int) -> None:
        status = TxEvent(request.seq, "SENT")
        links = [each for each in self._links[source] if request.destination in {BROADCAST, each[0]}]
        for destination, link in links:
            self._send(source, destination, link, request, t_ns)
        if not links:
            size = len(request.payload)
            self._note(LinkEvent(t_ns, "refused", source, request.seq, "", size, "address", "land"))
            status = TxEvent(request.seq, "FAILED", "address")
        self._announce(t_ns + self.lookahead_ns, source, status)

    def _send(self, source: str, destination: str, link: LandConfig, request: Transmit, t_ns: int) -> None:
        size = len(request.payload)
        airtime_ns = round(8.0 * size / link.rate_bps * NS)
        arrival_ns = t_ns + round(link.latency_s * NS) + airtime_ns
        self._note(LinkEvent(t_ns, "started", source, request.seq, destination, size, "", "land", "", airtime_ns))
        if draws.uniform(self._seed, "land", source, request.seq, destination) < link.loss:
            self._note(LinkEvent(arrival_ns, "lost", source, request.seq, destination, size, "lost_land", "land"))
            return
        self._note(
            LinkEvent(arrival_ns, "delivered", source, request.seq, destination, size, "", "land", "",
                      arrival_ns - t_ns))  # fmt: skip
        self._announce(arrival_ns, destination, Received(source, request.payload, request.destination))

    def _announce(self, t_ns: int, craft: str, event: Received | TxEvent) -> None:
        heapq.heappush(self._events, (t_ns, self._places[craft], next(self._order), (t_ns, craft, event)))

    def _note(self, event: LinkEvent) -> None:
        heapq.heappush(self._log, (event.t_ns, self._places[event.source], next(self._order), event))
