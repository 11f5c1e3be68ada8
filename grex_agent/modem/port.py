"""The aboard end of a modem, the same for an emulated and a real one (acoustic-link §4).

What the agent wants sent gets a *ticket* and waits for an own slot. At the opening of a slot the access to the water is
granted first, then the newest own state is pulled. Every ticket has one end: `TxEvent` ``SENT`` (``DELIVERED`` if an
acknowledgement was asked for, with ``SENT`` before), `RangeResult`, or ``FAILED`` with a reason, see `outbox`.

A payload too long for the modem goes in fragments, in one slot or several. What has begun is finished: it is neither
superseded nor expired. It is ``SENT`` or ``DELIVERED`` when all fragments are, and ``FAILED`` when the first one is.
"""

import sys
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from typing import Any

from grex_agent.modem.abilities import Abilities, Capabilities
from grex_agent.modem.books import port_ledger
from grex_agent.modem.inbox import Inbox
from grex_agent.modem.openings import Openings
from grex_agent.modem.outbox import Outbox
from grex_agent.modem.queue import Item, latest_ns
from grex_link.mac import Mac
from grex_link.messages import (
    BROADCAST,
    BadFrame,
    Happening,
    ModemEvent,
    PortLedger,
    RangeResult,
    Received,
    Request,
    TxEvent,
)
from grex_link.profile import ModemProfile

#: Gives the newest payload of at most so many bytes, or None if there is nothing to tell.
Pull = Callable[[int], bytes | None]

#: A ranging goes before the own state, unless something else is said.
RANGING_PRIORITY = 1


class ModemPort:
    """See the module's docstring. Times are by the craft's clock, integer nanoseconds.

    Parameters
    ----------
    craft : str
        Whose port this is.
    team : sequence of str
        All craft. Of two that have no broadcast, what is for everybody is sent to the other.
    profile : ModemProfile
        The modem.
    mac : Mac
        When the craft may speak, and how much.
    queue_max : int
        How many requests may wait.
    reassembly_timeout_s : float
        See `Reassembly`.
    pull_priority : int
        Of the state that is pulled. Among equals it goes first: where a slot has room for one message, only what has a
        higher priority gets through beside it.

    Attributes
    ----------
    next_ticket : int
        Ticket of the next request; during a pull that of the payload pulled.
    """

    def __init__(
        self,
        craft: str,
        team: Sequence[str],
        profile: ModemProfile,
        mac: Mac,
        *,
        queue_max: int = 16,
        reassembly_timeout_s: float = 120.0,
        pull_priority: int = 0,
    ) -> None:
        self._abilities = Abilities(profile, [mate for mate in team if mate != craft], mac.message_bytes)
        self._pull_priority = pull_priority
        self._outbox = Outbox(profile, mac.messages_per_slot, queue_max)
        self._openings = Openings(mac, craft)
        self._inbox = Inbox(reassembly_timeout_s, fragments=self._abilities.fragments)
        self._restart_ns = self._wake_ns = -sys.maxsize
        self._slots_used = 0
        self.next_ticket = 0

    @property
    def transmissions(self) -> int:
        """Requests to the modem so far."""
        return self._outbox.transmissions

    @property
    def strays(self) -> int:
        """Modem events about requests that had had their end, or had never been."""
        return self._outbox.strays

    def capabilities(self) -> Capabilities:
        """Say what can be asked of this port."""
        return self._abilities.capabilities()

    # -- what the agent wants -------------------------------------------------------------------------------------

    def send(
        self,
        payload: bytes,
        now_ns: int,
        destination: str = BROADCAST,
        *,
        priority: int = 0,
        ttl_s: float | None = None,
        supersede_key: Hashable = None,
        acknowledge: bool = False,
    ) -> int:
        """Have a payload sent in an own slot; return the ticket.

        Parameters
        ----------
        payload : bytes
            Any length up to `Capabilities.message_max_bytes`.
        now_ns : int
            Time.
        destination : str
            A team mate, or everybody.
        priority : int
            The highest goes first.
        ttl_s : float or None
            How long it may wait before its transmission starts; None for ever.
        supersede_key : hashable
            Of those waiting with the same key only the newest stays; it takes the place of the older.
        acknowledge : bool
            Ask the destination to acknowledge.
        """
        item = self._item(
            self._abilities.frames(payload, now_ns),
            destination,
            priority=priority,
            until_ns=latest_ns(now_ns, ttl_s),
            key=supersede_key,
            acknowledge=acknowledge,
        )
        return self._add(item)

    def range(
        self, destination: str, now_ns: int, *, priority: int = RANGING_PRIORITY, ttl_s: float | None = None
    ) -> int:
        """Have the distance to a mate measured in an own slot, as the last thing in it; return the ticket."""
        until_ns = latest_ns(now_ns, ttl_s)
        return self._add(self._item((b"",), destination, priority=priority, until_ns=until_ns, ranging=True))

    def send_by_land(self, payload: bytes, now_ns: int, destination: str = BROADCAST) -> Request | None:
        """Send at once over cable and radio, to one or all craft linked so; None if it is refused for its size."""
        item = self._item(self._abilities.land_frame(payload, now_ns), destination, by_land=True)
        if item.frames:
            return self._outbox.begin(item, now_ns)
        self._outbox.refuse(item, "size")
        return None

    def open_slots(self, now_ns: int, before_ns: int, pull: Pull) -> list[Request]:
        """Return requests that fill the own slots that open within [now, before); give up what has waited too long.

        To be called at every step, whether there is anything to tell or not. Each slot is filled once.

        Parameters
        ----------
        now_ns, before_ns : int
            The step.
        pull : callable
            Called when a slot has been granted to the own state: gives its bytes, at most so many, or None.
        """
        if self._restart_ns < before_ns <= self._wake_ns:
            return []
        self._outbox.give_up(now_ns)
        self._inbox.reassembly.expire(now_ns)
        own_state = partial(self._pulled, pull, now_ns)
        requests: list[Request] = []
        for opening_ns in self._openings.take(now_ns, before_ns):
            filled = self._outbox.fill(opening_ns, own_state, self._pull_priority)
            self._slots_used += bool(filled)
            requests += filled
        self._restart_ns = self._openings.restart_ns
        self._wake_ns = self._openings.next_ns
        self._wake_by(self._outbox.until_ns)
        self._wake_by(self._inbox.reassembly.until_ns)
        return requests

    # -- what has happened ----------------------------------------------------------------------------------------

    def on_event(self, event: ModemEvent) -> list[Happening]:
        """Take a modem event; return what it means to the agent, with tickets for the modem's numbers."""
        happening = event.event
        if isinstance(happening, Received):
            heard = self._inbox.on_received(happening, event.t_ns)
            self._wake_by(self._inbox.reassembly.until_ns)
            return heard
        if isinstance(happening, TxEvent):
            return self._outbox.on_status(happening)
        if isinstance(happening, RangeResult):
            return self._outbox.on_range(happening)
        if isinstance(happening, BadFrame):
            return self._inbox.on_bad_frame(happening)
        if happening.state == "rebooted":
            self._outbox.reboot(event.t_ns)
            self._wake_by(self._outbox.until_ns)
        return [happening]

    def take_events(self) -> list[Happening]:
        """Take what the port itself has to say since the last time: ``QUEUED``, ``IN_PROGRESS`` and ``FAILED``."""
        events, self._outbox.events = self._outbox.events, []
        return events

    def ledger(self, now_ns: int) -> PortLedger:
        """Count what has become of all requests since the start."""
        return port_ledger(now_ns, self._outbox, self._inbox, self._openings.owned, self._slots_used)

    # -- inside ---------------------------------------------------------------------------------------------------

    def _item(self, frames: tuple[bytes, ...], destination: str, **more: Any) -> Item:
        ticket = self.next_ticket
        self.next_ticket += 1
        destination = self._abilities.addressed(destination)
        return Item(ticket=ticket, order=ticket, frames=frames, destination=destination, **more)

    def _add(self, item: Item) -> int:
        refusal = self._abilities.refusal(item)
        if refusal:
            self._outbox.refuse(item, refusal)
        else:
            self._outbox.add(item)
            self._wake_by(item.until_ns)
        return item.ticket

    def _wake_by(self, t_ns: int | None) -> None:
        """Have `open_slots` look at what waits when a time has come."""
        if t_ns is not None and t_ns < self._wake_ns:
            self._wake_ns = t_ns

    def _pulled(self, pull: Pull, now_ns: int) -> Item | None:
        """Make a request of the own state, which is never sent in fragments."""
        payload = pull(self._abilities.frame_max_bytes)
        if payload is None:
            return None
        item = self._item(self._abilities.frames(payload, now_ns), BROADCAST)
        refusal = self._abilities.refusal(item) or ("size" if len(item.frames) > 1 else "")
        if refusal:
            self._outbox.refuse(item, refusal)
        return None if refusal else item
