"""The aboard end of a modem, the same for an emulated and a real one (acoustic-link §4).

What the agent wants sent gets a *ticket* and waits for an own slot. At the opening of a slot the access to the water is
granted first, then the newest own state is pulled. Every ticket has one end: `TxEvent` ``SENT`` (``DELIVERED`` if an
acknowledgement was asked for, with ``SENT`` before), `RangeResult`, or ``FAILED`` with a reason:

``size``        longer than all its fragments could be, or empty
``address``     nobody in the team, the craft itself, or everybody where the modem has no broadcast or is to acknowledge
``error``       this modem does not acknowledge or measure ranges; or it never said what became of the request
``overflow``    the queue was full: the lowest priority goes, and of these the newest
``superseded``  a newer payload with the same key came before it began
``expired``     it could not begin within its ttl
others          the modem's own

A payload too long for the modem goes in fragments, in one slot or several. What has begun is finished: it is neither
superseded nor expired. It is ``SENT`` or ``DELIVERED`` when all fragments are, and ``FAILED`` when the first one is.
"""

import sys
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import msgspec

from grex_agent.modem.fragments import FRAGMENTS_MAX, Reassembly, data_bytes, split
from grex_agent.modem.openings import Openings
from grex_agent.modem.outbox import Outbox
from grex_agent.modem.queue import Item
from grex_link.mac import Mac
from grex_link.messages import (
    BROADCAST,
    BadFrame,
    Happening,
    ModemEvent,
    ModemStatus,
    PortLedger,
    RangeResult,
    Received,
    Request,
    TxEvent,
)
from grex_link.profile import ModemProfile
from grex_link.units import NS

#: Gives the newest payload of at most so many bytes, or None if there is nothing to tell.
Pull = Callable[[int], bytes | None]

#: A slot that opened so little before it was looked at is still used; the guard has room for as much.
LATE_NS = NS // 100
#: A ranging goes before the own state, unless something else is said.
RANGING_PRIORITY = 1
LAND_BYTES_MAX = 65535
#: A ttl of this or more is none.
FOREVER_S = 1e9


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What can be asked of this port.

    Attributes
    ----------
    payload_max_bytes, payload_max_bits : int
        Longest payload that goes whole.
    message_max_bytes : int
        Longest payload in fragments.
    broadcast, acknowledges : bool
        Whether one transmission is for all; whether a destination can be asked to acknowledge.
    addresses_max : int or None
        How many modems can have an address.
    two_way_ranging, one_way_ranging : bool
        Whether ranges can be asked for; whether they come with what is received.
    """

    payload_max_bytes: int
    payload_max_bits: int
    message_max_bytes: int
    broadcast: bool
    acknowledges: bool
    addresses_max: int | None
    two_way_ranging: bool
    one_way_ranging: bool


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
        self._craft, self._mac, self._profile = craft, mac, profile
        self._mates = [mate for mate in team if mate != craft]
        self._frame_max_bytes = min(profile.payload_max_bytes, mac.message_bytes or sys.maxsize)
        # A modem with odd bits has payloads of a kind of its own, and no fragments.
        self._whole_bytes = profile.bits_max >= 8 * profile.payload_max_bytes
        self._pull_priority = pull_priority
        self._outbox = Outbox(profile, mac.messages_per_slot, queue_max)
        self._openings = Openings(mac, craft)
        self._reassembly = Reassembly(reassembly_timeout_s)
        self._restart_ns = self._wake_ns = -sys.maxsize
        self._message: int | None = None
        self._bad_frames = self._slots_owned = self._slots_used = 0
        self.next_ticket = 0
        self._takers: dict[type, Callable[..., list[Happening]]] = {
            Received: self._on_received,
            TxEvent: lambda event, _: self._outbox.on_status(event),
            RangeResult: lambda event, _: self._outbox.on_range(event),
            BadFrame: self._on_bad_frame,
            ModemStatus: self._on_modem_status,
        }

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
        profile, most = self._profile, self._frame_max_bytes
        return Capabilities(
            payload_max_bytes=most,
            payload_max_bits=min(profile.bits_max, 8 * most),
            message_max_bytes=max(most, FRAGMENTS_MAX * data_bytes(most) if self._whole_bytes else 0),
            broadcast=profile.broadcast,
            acknowledges=profile.acknowledges,
            addresses_max=profile.addresses_max,
            two_way_ranging=profile.ranging.two_way,
            one_way_ranging=profile.ranging.one_way,
        )

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
        """Have a payload sent in an own slot.

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
            How long its transmission may wait before it starts; None for ever.
        supersede_key : hashable
            Only the newest of those with the same key stays; it takes the place of the older.
        acknowledge : bool
            Ask the destination to acknowledge.

        Returns
        -------
        int
            Ticket.
        """
        item = self._item(
            self._frames(payload, now_ns),
            destination,
            priority=priority,
            until_ns=_until_ns(now_ns, ttl_s),
            key=supersede_key,
            acknowledge=acknowledge,
        )
        return self._add(item)

    def range(
        self, destination: str, now_ns: int, *, priority: int = RANGING_PRIORITY, ttl_s: float | None = None
    ) -> int:
        """Have the distance to a mate measured in an own slot, as the last thing in it; return the ticket."""
        until_ns = _until_ns(now_ns, ttl_s)
        return self._add(self._item((b"",), destination, priority=priority, until_ns=until_ns, ranging=True))

    def send_by_land(self, payload: bytes, now_ns: int) -> Request | None:
        """Send at once over cable and radio, to all craft linked so; None if the payload is refused for its size."""
        frames = self._numbered(payload, LAND_BYTES_MAX, now_ns) if self._whole_bytes else (payload,)
        item = self._item(frames, BROADCAST, by_land=True)
        if len(frames) == 1 and payload:
            return self._outbox.begin(item, now_ns)
        self._outbox.refuse(item, "size")
        return None

    def open_slots(self, now_ns: int, before_ns: int, pull: Pull) -> list[Request]:
        """Fill every own slot that opens within [now, before), and give up what has waited for too long.

        To be called at every step, whether there is anything to tell or not. Each slot is filled once.

        Parameters
        ----------
        now_ns, before_ns : int
            The step.
        pull : callable
            Called when a slot has been granted to the own state: gives its bytes, at most so many, or None.

        Returns
        -------
        list of Request
            For the modem, each with the time at which it shall start.
        """
        if self._restart_ns < before_ns <= self._wake_ns:
            return []
        self._outbox.give_up(now_ns)
        self._reassembly.expire(now_ns)
        own_state = partial(self._pulled, pull, now_ns)
        requests: list[Request] = []
        for opening_ns in self._openings.take(now_ns, before_ns):
            filled = (
                self._outbox.fill(opening_ns, own_state, self._pull_priority) if opening_ns >= now_ns - LATE_NS else []
            )
            self._slots_owned += 1
            self._slots_used += bool(filled)
            requests += filled
        self._restart_ns = self._openings.restart_ns
        until = (self._outbox.until_ns, self._reassembly.until_ns)
        self._wake_ns = min([self._openings.next_ns, *(time for time in until if time is not None)])
        return requests

    # -- what has happened ----------------------------------------------------------------------------------------

    def on_event(self, event: ModemEvent) -> list[Happening]:
        """Take a modem event; return what it means to the agent, with tickets for the modem's numbers."""
        taker = self._takers.get(type(event.event))
        return [] if taker is None else taker(event.event, event.t_ns)

    def take_events(self) -> list[Happening]:
        """Take what the port itself has to say since the last time: ``QUEUED``, ``IN_PROGRESS`` and ``FAILED``."""
        events, self._outbox.events = self._outbox.events, []
        return events

    def ledger(self, now_ns: int) -> PortLedger:
        """Count what has become of all requests since the start."""
        outbox, reassembly = self._outbox, self._reassembly
        return PortLedger(
            t_ns=now_ns,
            requested=outbox.requested,
            refused=dict(outbox.refused),
            superseded=outbox.superseded,
            expired=outbox.expired,
            queued=outbox.queued,
            started=outbox.started,
            failed=dict(outbox.failed),
            slots_owned=self._slots_owned,
            slots_used=self._slots_used,
            slots_skipped=self._slots_owned - self._slots_used,
            reassembled=reassembly.reassembled,
            abandoned=reassembly.abandoned,
            bad_frames=self._bad_frames + reassembly.bad,
        )

    # -- inside ---------------------------------------------------------------------------------------------------

    def _item(self, frames: tuple[bytes, ...], destination: str, **more: Any) -> Item:
        ticket = self.next_ticket
        self.next_ticket += 1
        if destination == BROADCAST and not self._profile.broadcast and len(self._mates) == 1:
            destination = self._mates[0]
        return Item(ticket=ticket, order=ticket, frames=frames, destination=destination, **more)

    def _add(self, item: Item) -> int:
        refusal = self._refusal(item)
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

    def _refusal(self, item: Item) -> str:
        profile = self._profile
        for_all = item.destination == BROADCAST
        if item.destination not in self._mates and not for_all:
            return "address"
        if for_all and (not profile.broadcast or item.answered):
            return "address"
        if (item.acknowledge and not profile.acknowledges) or (item.ranging and not profile.ranging.two_way):
            return "error"
        return "" if item.frames else "size"

    def _frames(self, payload: bytes, now_ns: int) -> tuple[bytes, ...]:
        """Make frames of a payload; none if it cannot be carried."""
        if self._whole_bytes:
            return self._numbered(payload, self._frame_max_bytes, now_ns) if payload else ()
        beyond = max(8 * len(payload) - self._profile.bits_max, 0)
        fits = 0 < len(payload) <= self._frame_max_bytes and not int.from_bytes(payload, "big") & ((1 << beyond) - 1)
        return (payload,) if fits else ()

    def _numbered(self, payload: bytes, frame_max_bytes: int, now_ns: int) -> tuple[bytes, ...]:
        """Make frames of a payload; numbers begin with the time, so that after a restart they are others."""
        number = now_ns // NS if self._message is None else self._message
        frames = split(payload, frame_max_bytes, number)
        if frames != (payload,):
            self._message = number + 1
        return frames

    def _pulled(self, pull: Pull, now_ns: int) -> Item | None:
        """Make a request of the own state, which is never sent in fragments."""
        payload = pull(self._frame_max_bytes)
        if payload is None:
            return None
        item = self._item(self._frames(payload, now_ns), BROADCAST)
        refusal = self._refusal(item) or ("size" if len(item.frames) > 1 else "")
        if not refusal:
            return item
        self._outbox.refuse(item, refusal)
        return None

    def _on_received(self, event: Received, t_ns: int) -> list[Happening]:
        if not self._whole_bytes:
            return [event]
        bad = self._reassembly.bad
        payload = self._reassembly.take(event.source, event.payload, t_ns)
        if payload is None:
            self._wake_by(self._reassembly.until_ns)
            return [BadFrame("fragment")] if self._reassembly.bad > bad else []
        return [event if payload is event.payload else msgspec.structs.replace(event, payload=payload)]

    def _on_bad_frame(self, event: BadFrame, t_ns: int) -> list[Happening]:
        del t_ns
        self._bad_frames += 1
        return [event]

    def _on_modem_status(self, event: ModemStatus, t_ns: int) -> list[Happening]:
        if event.state == "rebooted":
            self._outbox.reboot(t_ns)
            self._wake_by(self._outbox.until_ns)
        return [event]


def _until_ns(now_ns: int, ttl_s: float | None) -> int | None:
    return now_ns + round(ttl_s * NS) if ttl_s is not None and ttl_s < FOREVER_S else None
