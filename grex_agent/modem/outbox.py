"""From a request of the agent to its one end: the queue, the slot, the modem's word on it, and the count of it all.

A request fails because of

``size``        it is longer than all its fragments could be, or empty
``address``     it is for nobody in the team, for the craft itself, or for all where that cannot be: the modem has no
                broadcast, or all cannot acknowledge or answer
``error``       this modem does not acknowledge or measure ranges; or it never said what became of the request
``overflow``    the queue was full: the lowest priority goes, and of these the newest
``superseded``  a newer payload with the same key came before it began
``expired``     it could not begin within its ttl
others          the modem says so

A ranging that nobody answers ends with a `RangeResult` without a range; one that is refused fails like the rest.
"""

from collections import Counter
from collections.abc import Callable

from grex_agent.modem.flights import Flights
from grex_agent.modem.queue import Item, PayloadQueue
from grex_link.messages import Happening, RangeRequest, RangeResult, Request, Transmit, TxEvent
from grex_link.profile import ModemProfile
from grex_link.units import NS

#: Craft that come nearer at up to 7 m/s hear what follows a message too early by this share of its airtime, while they
#: still listen to the message: a ping waits so much longer.
NEARER = 0.005


class Outbox:
    """See the module's docstring.

    Parameters
    ----------
    profile : ModemProfile
        The modem.
    messages_per_slot : int
        How many messages there is time for in a slot.
    queue_max : int
        How many requests may wait.

    Attributes
    ----------
    events : list of Happening
        What has not been told to the agent.
    transmissions : int
        Requests to the modem.
    requested, superseded, expired, started, strays : int
        Counts of requests; strays are modem events about nothing that is under way.
    refused, failed : Counter
        Of requests by reason: before they began, and after.
    """

    def __init__(self, profile: ModemProfile, messages_per_slot: int, queue_max: int) -> None:
        self._profile = profile
        self._messages_per_slot = messages_per_slot
        self._turnaround_ns = round(profile.turnaround_s * NS)
        self._queue = PayloadQueue(queue_max)
        self._flights = Flights()
        self.events: list[Happening] = []
        self.transmissions = self.requested = self.superseded = self.expired = self.started = self.strays = 0
        self.refused: Counter[str] = Counter()
        self.failed: Counter[str] = Counter()

    @property
    def queued(self) -> int:
        """How many requests have not begun."""
        return self._queue.waiting

    @property
    def until_ns(self) -> int | None:
        """When `give_up` has something to do; None for not before something happens."""
        times = (self._queue.until_ns, self._flights.until_ns)
        return min((time for time in times if time is not None), default=None)

    # -- before it begins -----------------------------------------------------------------------------------------

    def refuse(self, item: Item, reason: str) -> None:
        """Refuse a request at once."""
        self.requested += 1
        self._fail(item, reason)

    def add(self, item: Item) -> None:
        """Put a request in the queue."""
        self.requested += 1
        self.events.append(TxEvent(item.ticket, "QUEUED"))
        superseded, overflown = self._queue.add(item)
        for older in superseded:
            self._fail(older, "superseded")
        for loser in overflown:
            self._fail(loser, "overflow")

    def give_up(self, now_ns: int) -> None:
        """Give up what has waited for too long: for a slot, or for the modem's word."""
        self._expire(now_ns)
        for item in self._flights.overdue(now_ns):
            self._fail(item, "error")

    # -- in the slot ----------------------------------------------------------------------------------------------

    def fill(self, opening_ns: int, pull: Callable[[], Item | None], pull_priority: int) -> list[Request]:
        """Fill a slot; the messages follow each other by airtime and turnaround.

        One request whose answer the modem waits for is all a slot has, and its last: the rest of the slot is for the
        answer, and what is sent meanwhile makes deaf to it.

        Parameters
        ----------
        opening_ns : int
            When the slot opens.
        pull : callable
            Gives the own state as a request, or None; called once at most.
        pull_priority : int
            Of the own state, which goes first among equals.
        """
        requests: list[Request] = []
        start_ns, room, pulled, last = opening_ns, self._messages_per_slot, False, None
        while room:
            self._expire(start_ns)
            item = self._queue.best(None if pulled else pull_priority, unanswered=last is not None)
            if item is None and pulled:
                break
            if item is None:
                pulled, item = True, pull()
                if item is None:
                    continue
                self.requested += 1
            room -= 1
            if item.answered:
                last = item
                continue
            requests.append(self._hand(item, start_ns))
            start_ns += self._profile.airtime_ns(len(item.frames[item.handed - 1])) + self._turnaround_ns
        if last is not None:
            start_ns += round(NEARER * (start_ns - opening_ns))
            self._expire(start_ns)
            requests += [] if last.final else [self._hand(last, start_ns)]
        return requests

    def begin(self, item: Item, start_ns: int) -> Request:
        """Have a request begin without any queue or slot."""
        self.requested += 1
        return self._hand(item, start_ns)

    def _hand(self, item: Item, start_ns: int) -> Request:
        if not item.handed:
            self.started += 1
            self.events.append(TxEvent(item.ticket, "IN_PROGRESS"))
        frame, seq = item.frames[item.handed], self.transmissions
        item.handed += 1
        self.transmissions += 1
        if item.handed == len(item.frames):
            self._queue.remove(item)
        self._flights.begin(seq, item, start_ns)
        if item.ranging:
            return RangeRequest(seq, start_ns, item.destination)
        return Transmit(seq, start_ns, frame, item.destination, item.acknowledge, item.by_land)

    def _expire(self, start_ns: int) -> None:
        for item in self._queue.expired(start_ns):
            self._fail(item, "expired")

    # -- what the modem says --------------------------------------------------------------------------------------

    def on_status(self, event: TxEvent) -> list[Happening]:
        """Take what became of a frame, or of a ranging that was refused; return what that means to the agent."""
        item = self._flights.item(event.ticket)
        if item is None:
            self.strays += 1
            return []
        if event.status == "FAILED":
            self._fail(item, event.reason or "error")
            return [self.events.pop()]
        if item.ranging or event.status not in {"SENT", "DELIVERED"}:
            return []
        if item.acknowledge and event.status == "SENT":
            news = self._flights.sent(event.ticket)
            item.sent += news
            return [TxEvent(item.ticket, "SENT")] if news and item.sent == len(item.frames) else []
        self._flights.end(event.ticket)
        item.finished += 1
        if item.finished < len(item.frames):
            return []
        item.final = True
        return [TxEvent(item.ticket, "DELIVERED" if item.acknowledge else "SENT")]

    def on_range(self, event: RangeResult) -> list[Happening]:
        """Take a measured range, or that there was no answer; return it with the agent's ticket."""
        item = self._flights.item(event.ticket)
        if item is None or not item.ranging:
            self.strays += 1
            return []
        self._flights.end(event.ticket)
        item.final = True
        if event.range_m is None:
            self.failed["no_ack"] += 1
        return [RangeResult(item.ticket, event.destination, event.range_m)]

    def reboot(self, t_ns: int) -> None:
        """Take note that the modem has been restarted: it may have forgotten what it was doing."""
        self._flights.reboot(t_ns)

    def _fail(self, item: Item, reason: str) -> None:
        item.final = True
        if item.handed:
            self.failed[reason] += 1
        elif reason == "superseded":
            self.superseded += 1
        elif reason == "expired":
            self.expired += 1
        else:
            self.refused[reason] += 1
        self._queue.remove(item)
        self._flights.drop(item)
        self.events.append(TxEvent(item.ticket, "FAILED", reason))
