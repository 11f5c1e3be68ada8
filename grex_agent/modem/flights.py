"""What the modem has been asked to do and has not said the end of."""

from dataclasses import dataclass

from grex_agent.modem.queue import Item
from grex_link.units import NS

#: A request of which nothing is heard for this long after its start is given up: no modem takes as long.
ANSWER_NS = 120 * NS
#: After a reboot the modem has this long to say what became of what it was doing.
REBOOT_NS = 5 * NS


@dataclass(slots=True)
class _Flight:
    item: Item
    start_ns: int
    until_ns: int
    sent: bool = False


class Flights:
    """See the module's docstring. Requests are known by the number the modem has for them."""

    def __init__(self) -> None:
        self._flights: dict[int, _Flight] = {}

    def begin(self, seq: int, item: Item, start_ns: int) -> None:
        """Take note of a request that starts at a time."""
        self._flights[seq] = _Flight(item, start_ns, start_ns + ANSWER_NS)

    def item(self, seq: int) -> Item | None:
        """Say whose request it is; None if its end is known, or there never was one."""
        flight = self._flights.get(seq)
        return None if flight is None else flight.item

    def sent(self, seq: int) -> bool:
        """Take note that it has left; return whether that is news."""
        flight = self._flights[seq]
        news, flight.sent = not flight.sent, True
        return news

    def end(self, seq: int) -> None:
        """Take note that nothing more is to be heard of it."""
        del self._flights[seq]

    def drop(self, item: Item) -> None:
        """Forget all requests of an item."""
        for seq in [seq for seq, flight in self._flights.items() if flight.item is item]:
            del self._flights[seq]

    def reboot(self, t_ns: int) -> None:
        """Wait no longer than `REBOOT_NS` for what had started before a time."""
        for flight in self._flights.values():
            if flight.start_ns <= t_ns:
                flight.until_ns = min(flight.until_ns, t_ns + REBOOT_NS)

    @property
    def until_ns(self) -> int | None:
        """When the next one is given up; None if there is none."""
        return min((flight.until_ns for flight in self._flights.values()), default=None)

    def overdue(self, now_ns: int) -> list[Item]:
        """Find the items of which nothing has been heard for too long; each once."""
        found = {flight.item.ticket: flight.item for flight in self._flights.values() if flight.until_ns <= now_ns}
        return list(found.values())
