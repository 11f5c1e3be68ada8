"""The books of the water: what became of every transmission, how long it took, how old the newest news is (§5).

All sums are whole nanoseconds, so that the same events give the same ledger to the last bit, whoever does the sums and
however often he is asked in between.
"""

from bisect import bisect_right
from collections.abc import Mapping, Sequence

from grex_link.messages import LinkEvent, LinkLedger, PathLedger, PortLedger, SourceLedger
from grex_link.units import NS

_EDGES_NS = tuple(NS // 10 << k for k in range(13))
#: Edges of the bins of latency and of age: 0.1, 0.2, 0.4 … 409.6 s. Bin 0 lies below the first edge, the last bin is
#: open; a value that is an edge belongs to the bin above it.
EDGES_S = tuple(edge / NS for edge in _EDGES_NS)
BINS = len(EDGES_S) + 1
#: Sound is heard or gone long before: what is on its way for longer has been forgotten.
FORGOTTEN_S = 600.0

_LOWER_NS = (0, *_EDGES_NS)
_NEWS = frozenset({"data", "land"})
#: What tells a transmission from all others of its source: number of the request, purpose, who asked for it.
_Flight = tuple[int, str, str]


class Ledger:
    """Counts the lines of the medium's log.

    Parameters
    ----------
    team : sequence of str
        All craft, in their order.
    """

    def __init__(self, team: Sequence[str]) -> None:
        self._senders = {
            craft: _Sender(craft, {mate: _Path(1 << place) for place, mate in enumerate(team) if mate != craft})
            for craft in team
        }

    def note(self, event: LinkEvent) -> None:
        """Count one line; lines come in the order of time.

        Raises
        ------
        KeyError
            If it is of a craft that is not of the team.
        """
        sender = self._senders[event.source]
        kind = event.kind
        if kind == "started":
            sender.start(event)
        elif kind == "refused":
            sender.refused[event.reason] = sender.refused.get(event.reason, 0) + 1
        else:
            path = sender.paths[event.destination]
            flight = (event.seq, event.purpose, event.asked_by)
            entry = sender.flying.get(flight)
            if entry is not None:
                entry[0] &= ~path.bit
                if not entry[0]:
                    del sender.flying[flight]
            if kind == "delivered":
                path.deliver(event)
            elif kind == "lost":
                path.lost[event.reason] = path.lost.get(event.reason, 0) + 1
            else:
                path.overheard += 1

    def snapshot(self, t_ns: int) -> LinkLedger:
        """Draw up the ledger at a mission time that is not before any line noted."""
        senders = self._senders.values()
        return LinkLedger(
            t_ns,
            [sender.ledger(t_ns) for sender in senders],
            [path.ledger(sender, mate, t_ns) for sender in senders for mate, path in sender.paths.items()],
        )


class _Sender:
    """One craft's transmissions, and which of them have not yet had their outcome everywhere."""

    def __init__(self, craft: str, paths: dict[str, "_Path"]) -> None:
        self.craft = craft
        self.paths = paths
        self.everybody = sum(path.bit for path in paths.values())
        self.flying: dict[_Flight, list[int]] = {}
        """Transmission → receivers that are still to come (bits), start."""
        self.purposes: dict[str, int] = {}
        self.refused: dict[str, int] = {}
        self.airtime_ns = self.bytes_sent = self.by_land = self.land_requests = 0
        self._land_seq = -1

    def start(self, event: LinkEvent) -> None:
        flight = (event.seq, event.purpose, event.asked_by)
        if event.purpose != "land":
            self.purposes[event.purpose] = self.purposes.get(event.purpose, 0) + 1
            self.airtime_ns += event.lasting_ns
            self.bytes_sent += event.size_bytes
            if self.everybody:
                self.flying[flight] = [self.everybody, event.t_ns]
            return
        path = self.paths[event.destination]
        path.by_land += 1
        self.by_land += 1
        if event.seq != self._land_seq:  # the lines of one request follow each other
            self._land_seq = event.seq
            self.land_requests += 1
        self.flying.setdefault(flight, [0, event.t_ns])[0] |= path.bit

    def ledger(self, t_ns: int) -> SourceLedger:
        oldest_ns = min((start_ns for _, start_ns in self.flying.values()), default=t_ns)
        return SourceLedger(
            self.craft,
            started=sum(self.purposes.values()),
            refused=dict(sorted(self.refused.items())),
            airtime_s=self.airtime_ns / NS,
            bytes_sent=self.bytes_sent,
            purposes=dict(sorted(self.purposes.items())),
            by_land=self.by_land,
            land_requests=self.land_requests,
            oldest_on_the_way_s=(t_ns - oldest_ns) / NS,
        )


class _Path:
    """One directed link.

    Age of information, the time since the newest datagram that has arrived was sent, is a saw: it falls to the
    datagram's latency and grows with time from there. Of each tooth only its two ends are kept, one added, one taken
    away, in the bin where it lies; all seconds in a bin follow from these (`_seconds`). A tooth thus costs the same
    however many bins it crosses, and nothing is sampled.
    """

    __slots__ = ("area_ns2", "bit", "by_land", "delivered", "ends", "latency_counts", "latency_ns", "lost",
                 "newest_ns", "overheard", "sums_ns")  # fmt: skip

    def __init__(self, bit: int) -> None:
        self.bit = bit
        self.delivered = self.overheard = self.by_land = self.latency_ns = 0
        self.lost: dict[str, int] = {}
        self.latency_counts = [0] * BINS
        self.newest_ns: int | None = None
        """When the newest datagram that has arrived was sent."""
        self.ends = [0] * BINS
        """Upper ends of teeth less lower ends of teeth, by bin; one tooth is open."""
        self.sums_ns = [0] * BINS
        """Sum of the ages at upper ends less sum of those at lower ends."""
        self.area_ns2 = 0
        """The same of their squares: twice the integral of age over time."""

    def deliver(self, event: LinkEvent) -> None:
        t_ns, latency_ns = event.t_ns, event.lasting_ns
        place = bisect_right(_EDGES_NS, latency_ns)
        self.delivered += 1
        self.latency_counts[place] += 1
        self.latency_ns += latency_ns
        if event.purpose not in _NEWS:
            return
        sent_ns, newest_ns, ends, sums_ns = t_ns - latency_ns, self.newest_ns, self.ends, self.sums_ns
        if newest_ns is not None:
            if sent_ns <= newest_ns:
                return
            age_ns = t_ns - newest_ns
            end = bisect_right(_EDGES_NS, age_ns)
            ends[end] += 1
            sums_ns[end] += age_ns
            self.area_ns2 += age_ns * age_ns
        self.newest_ns = sent_ns
        ends[place] -= 1
        sums_ns[place] -= latency_ns
        self.area_ns2 -= latency_ns * latency_ns

    def ledger(self, sender: _Sender, mate: str, t_ns: int) -> PathLedger:
        ends, sums_ns, area_ns2 = [*self.ends], [*self.sums_ns], self.area_ns2
        if self.newest_ns is not None:
            age_ns = t_ns - self.newest_ns
            end = bisect_right(_EDGES_NS, age_ns)
            ends[end] += 1
            sums_ns[end] += age_ns
            area_ns2 += age_ns * age_ns
        heard_ns = sum(sums_ns)
        return PathLedger(
            sender.craft,
            mate,
            delivered=self.delivered,
            overheard=self.overheard,
            lost=dict(sorted(self.lost.items())),
            on_the_way=sum(bool(waiting & self.bit) for waiting, _ in sender.flying.values()),
            latency_counts=[*self.latency_counts],
            latency_mean_s=self.latency_ns / (self.delivered * NS) if self.delivered else -1.0,
            age_seconds=_seconds(ends, sums_ns),
            age_mean_s=area_ns2 / (2 * heard_ns * NS) if heard_ns else -1.0,
            sent=sum(sender.purposes.values()) + self.by_land,
        )


def _seconds(ends: Sequence[int], sums_ns: Sequence[int]) -> list[float]:
    """Time in each bin: a tooth that ends above a bin at either end adds or takes the bin's whole width."""
    seconds = [0.0] * BINS
    above = 0
    for place in reversed(range(BINS)):
        lower_ns = _LOWER_NS[place]
        width_ns = _LOWER_NS[place + 1] - lower_ns if place + 1 < BINS else 0
        seconds[place] = (sums_ns[place] - ends[place] * lower_ns + above * width_ns) / NS
        above += ends[place]
    return seconds


def faults(ledger: LinkLedger, ports: Mapping[str, PortLedger], in_hand: int | None = 1) -> list[str]:
    """Say what does not add up; nothing is what should come out.

    Parameters
    ----------
    ledger : LinkLedger
        Of the water.
    ports : mapping of str to PortLedger
        Of those craft of which it is known.
    in_hand : int or None
        How many requests a modem may have been handed that it has not begun with, at most. None: the ledgers are not of
        the same time, and ports are not compared with the water.

    Returns
    -------
    list of str
        One line for each identity that is broken.
    """
    sources = {source.craft: source for source in ledger.sources}
    found = [line for path in ledger.paths for line in _path_faults(path, sources[path.source])]
    for source in ledger.sources:
        if source.oldest_on_the_way_s > FORGOTTEN_S:
            found.append(f"{source.craft}: a transmission has had no outcome for {source.oldest_on_the_way_s:.0f} s")
        by_land = sum(path.sent - source.started for path in ledger.paths if path.source == source.craft)
        if by_land != source.by_land and len(ledger.sources) > 1:
            found.append(f"{source.craft}: sent {source.by_land} by land, {by_land} on its links")
    whole = not any(port.reassembled or port.abandoned for port in ports.values())
    for craft, port in ports.items():
        found += _port_faults(craft, port)
        if craft in sources and in_hand is not None:
            found += _handover_faults(port, sources[craft], in_hand, whole=whole)
    return found


def begun(source: SourceLedger) -> int:
    """How many requests of a craft its modem has begun with or refused: its own answers are no requests."""
    own = source.purposes.get("data", 0) + source.purposes.get("ping", 0)
    return own + source.land_requests + sum(source.refused.values())


def _path_faults(path: PathLedger, source: SourceLedger) -> list[str]:
    name = f"{source.craft}>{path.destination}"
    lost = sum(path.lost.values())
    found = []
    if path.sent != path.delivered + path.overheard + lost + path.on_the_way:
        found.append(
            f"{name}: sent {path.sent}, but {path.delivered} delivered, {path.overheard} overheard, {lost} lost and "
            f"{path.on_the_way} on the way"
        )
    if sum(path.latency_counts) != path.delivered:
        found.append(f"{name}: {path.delivered} delivered, {sum(path.latency_counts)} latencies")
    return found


def _port_faults(craft: str, port: PortLedger) -> list[str]:
    refused = sum(port.refused.values())
    if port.requested == refused + port.superseded + port.expired + port.queued + port.started:
        return []
    fates = f"{refused} refused, {port.superseded} superseded, {port.expired} expired, {port.queued} queued"
    return [f"{craft}: requested {port.requested}, but {fates} and {port.started} started"]


def _handover_faults(port: PortLedger, source: SourceLedger, in_hand: int, *, whole: bool) -> list[str]:
    """Compare what a port has handed over with what the modem has begun: a payload may be several datagrams."""
    modem = begun(source)
    if port.started - modem > in_hand or (whole and modem > port.started):
        return [f"{source.craft}: its port has started {port.started}, its modem has begun {modem}"]
    return []
