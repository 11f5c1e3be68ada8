"""What a sound carries, and the draws that belong to it."""

from collections.abc import Sequence
from typing import Literal

from grex_link import draws
from grex_link.sound_field import Key

Purpose = Literal["data", "ping", "answer", "ack"]


class Packet:
    """One packet of one modem; nodes are places in the team.

    Parameters
    ----------
    names : sequence of str
        The nodes.
    source : int
        Who sends it.
    seq : int
        Number of the request that caused it.
    purpose : str
        ``data`` and ``ping`` are requested; ``answer`` and ``ack`` a modem sends by itself.
    size : int
        Bytes, as far as airtime and errors go.
    payload : bytes
        What it says.
    destination : int or None
        None for everyone.
    asker : int or None
        Whose request an answer answers.
    acknowledge : bool
        Whether it asks for an acknowledgement.
    """

    __slots__ = (
        "acknowledge",
        "asked_by",
        "asker",
        "clock_error_ns",
        "destination",
        "key",
        "name",
        "payload",
        "purpose",
        "seq",
        "size",
        "source",
    )

    def __init__(
        self,
        names: Sequence[str],
        source: int,
        seq: int,
        purpose: Purpose,
        size: int,
        payload: bytes = b"",
        destination: int | None = None,
        asker: int | None = None,
        *,
        acknowledge: bool = False,
    ) -> None:
        self.source = source
        self.name = names[source]
        self.asked_by = "" if asker is None else names[asker]
        self.seq = seq
        self.purpose = purpose
        self.size = size
        self.payload = payload
        self.destination = destination
        self.asker = asker
        self.acknowledge = acknowledge
        #: Place among the sounds of the same time.
        self.key: Key = (source, seq, 0, 0) if asker is None else (source, seq, 1, asker)
        #: Error of the sender's clock as it left.
        self.clock_error_ns = 0

    def is_for(self, node: int) -> bool:
        """Whether a node is meant."""
        return self.destination is None or self.destination == node


class Draws:
    """Draws that are a hash of what they are for (acoustic-link §3): seed, purpose, source, number, receiver.

    Parameters
    ----------
    seed : int
        Seed of the link.
    names : sequence of str
        The nodes.
    """

    def __init__(self, seed: int, names: Sequence[str]) -> None:
        self.seed = seed
        self._names = names

    def which(self, packet: Packet) -> tuple[object, ...]:
        """Tell a packet from all others of its source."""
        if packet.asker is None:
            return (packet.seq,)
        return packet.seq, packet.purpose, packet.asked_by

    def uniform(self, purpose: str, packet: Packet, node: int | None = None) -> float:
        """Draw from [0, 1)."""
        return draws.uniform(self.seed, *self._what(purpose, packet, node))

    def normal(self, purpose: str, packet: Packet, node: int | None = None) -> tuple[float, float]:
        """Draw two independent standard normals."""
        return draws.normal(self.seed, *self._what(purpose, packet, node))

    def happens(self, probability: float, purpose: str, packet: Packet, node: int | None = None) -> bool:
        """Let something happen with a probability; certainty costs no draw."""
        if probability <= 0.0:
            return False
        return probability >= 1.0 or self.uniform(purpose, packet, node) < probability

    def _what(self, purpose: str, packet: Packet, node: int | None) -> tuple[object, ...]:
        receiver = () if node is None else (self._names[node],)
        return (purpose, packet.name, *self.which(packet), *receiver)
