"""One request to a Micro-Modem from its first sentence to its end: a packet of data, a minipacket, or a ping."""

import math
from typing import Protocol

from grex_agent.modem.micromodem_rates import BROADCAST_ADDRESS, Setup
from grex_agent.modem.nmea import Sentence, encode
from grex_link.messages import Happening, RangeRequest, RangeResult, Request, Transmit, TxEvent
from grex_link.units import NS

#: The modem answers its host within this; Goby gives it as much.
HOST_NS = 5 * NS


class Failed(Exception):  # noqa: N818 - it is how a request ends
    """A request that has failed.

    Parameters
    ----------
    reason : str
        One of `TxEvent`'s.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Talk(Protocol):
    """A request under way."""

    @property
    def request(self) -> Request:
        """What it is about."""

    @property
    def until_ns(self) -> int:
        """When the present step has taken too long."""

    @property
    def over(self) -> bool:
        """Whether it has ended."""

    @property
    def unechoed(self) -> bool:
        """Whether the modem has not yet confirmed the command."""

    @property
    def takes(self) -> frozenset[str]:
        """The sentences it is interested in."""

    def begin(self, now_ns: int) -> bytes:
        """Return the first command."""

    def on_sentence(self, sentence: Sentence, now_ns: int) -> list[bytes | Happening]:
        """Take an answer; raises `Failed` if that is the end of it, ValueError if it makes no sense."""

    def on_timeout(self, now_ns: int) -> list[bytes | Happening]:
        """End, or go on, because the present step has taken too long."""


def make_talk(request: Request, setup: Setup) -> Talk:
    """Check a request and begin to talk about it.

    Raises
    ------
    Failed
        If the modem cannot do this: size, address, error.
    """
    if isinstance(request, RangeRequest):
        if not setup.two_way:
            raise Failed("error")
        return _Ping(request, _address(request.destination, setup), setup)
    frames = setup.rate.split(request.payload) if len(request.payload) <= setup.payload_max_bytes else None
    if frames is None:
        raise Failed("size")
    if request.by_land or (request.acknowledge and not request.destination):
        raise Failed("address")
    if request.acknowledge and not setup.acknowledges:
        raise Failed("error")
    address = _address(request.destination, setup) if request.destination else BROADCAST_ADDRESS
    if setup.rate.mini:
        return _Minipacket(request, address, setup)
    return _Packet(request, address, frames, setup)


def _address(destination: str, setup: Setup) -> int:
    address = setup.addresses.get(destination)
    if address is None or destination == setup.craft:
        raise Failed("address")
    return address


class _Packet:
    """Data: announced, asked for frame by frame, sent, and perhaps acknowledged."""

    takes = frozenset({"CACYC", "CADRQ", "CATXD", "CATXF", "CATXP", "CAXST", "CAACK"})

    def __init__(self, request: Transmit, address: int, frames: list[bytes], setup: Setup) -> None:
        self.request = request
        self.until_ns = 0
        self.over = False
        self._address = address
        self._frames = frames
        self._setup = setup
        self._step = "announce"
        self._given = 0
        self._unacknowledged = set(range(1, len(frames) + 1))

    @property
    def unechoed(self) -> bool:
        """Whether the modem has not yet confirmed the command."""
        return self._step == "announce"

    def begin(self, now_ns: int) -> bytes:
        """``$CCCYC,CMD,ADR1,ADR2,Packet Type,ACK,Npkt``."""
        self.until_ns = now_ns + HOST_NS
        acknowledge = int(self.request.acknowledge)
        return encode("CCCYC", 0, self._setup.own, self._address, self._setup.rate.number, acknowledge,
                      len(self._frames))  # fmt: skip

    def on_sentence(self, sentence: Sentence, now_ns: int) -> list[bytes | Happening]:
        """See `Talk`."""
        kind, fields = sentence.kind, sentence.fields
        if kind == "CAXST":
            if _transmit_mode(fields):
                raise Failed("error")
        elif kind == "CACYC":
            if self._step == "announce" and int(fields[2]) == self._address:
                self._go("give", now_ns + self._setup.airtime_ns + HOST_NS)
        elif kind == "CADRQ":
            return [self._frame(fields, now_ns)]
        elif kind == "CATXD":
            self._accepted(now_ns)
        elif kind == "CATXF":
            return self._sent(now_ns)
        elif kind == "CAACK":
            return self._acknowledged(fields)
        return []

    def on_timeout(self, now_ns: int) -> list[bytes | Happening]:
        """Fail: a step has taken too long."""
        del now_ns
        raise Failed("no_ack" if self._step == "acknowledge" else "error")

    def _go(self, step: str, until_ns: int) -> None:
        self._step = step
        self.until_ns = until_ns

    def _frame(self, fields: tuple[str, ...], now_ns: int) -> bytes:
        """Answer ``$CADRQ,HHMMSS,SRC,DEST,ACK,N,F#``, which also shows that the announcement was understood."""
        source, destination, _, room, number = map(int, fields[1:6])
        frames = self._frames
        if (source, destination) != (self._setup.own, self._address) or not 1 <= number <= len(frames):
            return encode("CCTXD", source, destination, 0, "")
        if room < len(frames[number - 1]):
            raise Failed("error")
        self._go("give", now_ns + self._setup.airtime_ns + HOST_NS)
        self._given = number
        return encode("CCTXD", source, destination, int(self.request.acknowledge), frames[number - 1].hex().upper())

    def _accepted(self, now_ns: int) -> None:
        if self._step == "give" and self._given == len(self._frames):
            self._go("transmit", now_ns + self._setup.airtime_ns + HOST_NS)

    def _sent(self, now_ns: int) -> list[bytes | Happening]:
        # At rate 0 the announcement ends like this, too, before the frame is asked for.
        if self._step != "transmit":
            return []
        self.over = not self.request.acknowledge
        self._go("acknowledge", now_ns + self._setup.answer_ns + HOST_NS)
        return [TxEvent(self.request.seq, "SENT")]

    def _acknowledged(self, fields: tuple[str, ...]) -> list[bytes | Happening]:
        """``$CAACK,SRC,DEST,F#,ACK``: the other one has a frame."""
        source, destination, number = map(int, fields[:3])
        if self._step == "acknowledge" and (source, destination) == (self._address, self._setup.own):
            self._unacknowledged.discard(number)
            if not self._unacknowledged:
                self.over = True
                return [TxEvent(self.request.seq, "DELIVERED")]
        return []


class _Minipacket:
    """13 bits in a packet of their own, for which there is no announcement."""

    takes = frozenset({"CAMUC", "CAMUR", "CATXF", "CATXP", "CAXST"})

    def __init__(self, request: Transmit, address: int, setup: Setup) -> None:
        self.request = request
        self.until_ns = 0
        self.over = False
        self.unechoed = True
        self._address = address
        self._setup = setup
        self._sent = False

    def begin(self, now_ns: int) -> bytes:
        """``$CCMUC,SRC,DEST,HHHH``."""
        self.until_ns = now_ns + HOST_NS
        return encode("CCMUC", self._setup.own, self._address, self.request.payload.hex().upper())

    def on_sentence(self, sentence: Sentence, now_ns: int) -> list[bytes | Happening]:
        """See `Talk`."""
        if sentence.kind == "CAXST" and _transmit_mode(sentence.fields):
            raise Failed("error")
        if sentence.kind == "CAMUC":
            self.unechoed = False
            # Not every firmware prints the end of a minipacket: its airtime will do.
            self.until_ns = now_ns + self._setup.airtime_ns
        elif sentence.kind == "CATXF" and not self.unechoed:
            return self._end(now_ns)
        elif sentence.kind == "CAMUR" and int(sentence.fields[0]) == self._address and self.request.acknowledge:
            self.over = True
            sent = [] if self._sent else [TxEvent(self.request.seq, "SENT")]
            return [*sent, TxEvent(self.request.seq, "DELIVERED")]
        return []

    def on_timeout(self, now_ns: int) -> list[bytes | Happening]:
        """Fail, unless the modem has taken it: then it has left."""
        if self.unechoed or self._sent:
            raise Failed("no_ack" if self._sent else "error")
        return self._end(now_ns)

    def _end(self, now_ns: int) -> list[bytes | Happening]:
        if self._sent:
            return []
        self._sent = True
        self.over = not self.request.acknowledge
        self.until_ns = now_ns + self._setup.answer_ns + HOST_NS
        return [TxEvent(self.request.seq, "SENT")]


class _Ping:
    """A two-way range."""

    takes = frozenset({"CAMPC", "CAMPR", "CAXST"})

    def __init__(self, request: RangeRequest, address: int, setup: Setup) -> None:
        self.request = request
        self.until_ns = 0
        self.over = False
        self.unechoed = True
        self._address = address
        self._setup = setup

    def begin(self, now_ns: int) -> bytes:
        """``$CCMPC,SRC,DEST``."""
        self.until_ns = now_ns + HOST_NS
        return encode("CCMPC", self._setup.own, self._address)

    def on_sentence(self, sentence: Sentence, now_ns: int) -> list[bytes | Happening]:
        """See `Talk`."""
        if sentence.kind == "CAXST" and _transmit_mode(sentence.fields):
            raise Failed("error")
        if sentence.kind == "CAMPC":
            self.unechoed = False
            self.until_ns = now_ns + self._setup.answer_ns + HOST_NS
        elif sentence.kind == "CAMPR":
            return self._answered(sentence.fields)
        return []

    def on_timeout(self, now_ns: int) -> list[bytes | Happening]:
        """Say that nobody has answered, or that the modem has not taken the command."""
        del now_ns
        if self.unechoed:
            raise Failed("error")
        return self._result(None)

    def _answered(self, fields: tuple[str, ...]) -> list[bytes | Happening]:
        """``$CAMPR,SRC,DEST,travel time``: seconds one way; firmware differs in who comes first."""
        if {int(fields[0]), int(fields[1])} != {self._address, self._setup.own}:
            return []
        travel_s = float(fields[2]) if len(fields) > 2 and fields[2] else math.nan
        return self._result(travel_s * self._setup.nominal_mps if 0.0 <= travel_s < 60.0 else None)

    def _result(self, range_m: float | None) -> list[bytes | Happening]:
        self.over = True
        return [RangeResult(self.request.seq, self.request.destination, range_m)]


def _transmit_mode(fields: tuple[str, ...]) -> int:
    """Mode of ``$CAXST``: 0 when all went well, else fets too hot, no sync pulse, inhibited, no data.

    Without a version the first field is the date; later firmware prints a version before it.
    """
    return int(fields[3 if int(fields[0]) > 19_700_000 else 4])
