"""Between names with fields and MAVLink's bytes; the only user of pymavlink in the simulator."""

import math
import struct
from collections.abc import Iterator
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as dialect

from grex_sim.autopilot.framing import Framer
from grex_sim.autopilot.message import Message

_FLOAT_MAX = 3.4e38
_EVENT, _EVENT_CRC, _EVENT_ARGUMENTS = 410, 160, 40


class Codec:
    """One autopilot's end of one link.

    Parameters
    ----------
    system : int
        Its system id; its component is 1.
    key : bytes or None
        MAVLink 2 signing key, 32 bytes: everything is signed, and what is not is not heard.
    unix_s : float
        Date now, for the signatures.

    """

    def __init__(self, system: int, key: bytes | None = None, unix_s: float = 0.0) -> None:
        self._system, self._key, self._unix_s = system, key, unix_s
        self._out = self._new()
        self._senders: dict[Any, tuple[Framer, Any]] = {}

    def pack(self, message: Message) -> bytes:
        """Make bytes of a message; fields it does not name are 0."""
        if message.name == "EVENT":
            return self._pack_event(message)
        kind = _KINDS[message.name]
        values = {
            name: _value(message.fields.get(name), kind_name, length)
            for name, kind_name, length in zip(kind.fieldnames, kind.fieldtypes, _lengths(kind), strict=True)
        }
        return bytes(kind(**values).pack(self._out))

    @property
    def garbage(self) -> int:
        """How many bytes belonged to no message."""
        return sum(framer.dropped for framer, _ in self._senders.values())

    def read(self, data: bytes, sender: Any = None, *, datagram: bool = False) -> Iterator[Message]:
        """Take bytes of one sender and return the messages that are complete.

        Parameters
        ----------
        data : bytes
            What came; garbage is counted and passed over.
        sender : object
            Whose bytes these are.
        datagram : bool
            Whether only whole messages come.
        """
        if sender not in self._senders:
            self._senders[sender] = Framer(), self._new()
        framer, parser = self._senders[sender]
        yield from framer.cut(data, lambda frame: _decode(parser, frame))
        if datagram:
            framer.end()

    def _new(self) -> Any:
        link = dialect.MAVLink(None, srcSystem=self._system, srcComponent=1)
        if self._key is not None:
            link.signing.secret_key = self._key
            link.signing.sign_outgoing = True
            # Signatures count tens of microseconds since 2015.
            link.signing.timestamp = int((self._unix_s - 1420070400) * 1e5)
        return link

    def _pack_event(self, message: Message) -> bytes:
        """EVENT is in no dialect of pymavlink 2.4.50, which is the point of sending it."""
        kind = dialect.MAVLink_message(_EVENT, "EVENT")
        payload = int(message["id"]).to_bytes(4, "little") + int(message["event_time_boot_ms"]).to_bytes(4, "little")
        return bytes(kind._pack(self._out, _EVENT_CRC, payload + bytes([0] * 4 + [0x33] + [1] * _EVENT_ARGUMENTS)))  # noqa: SLF001


_KINDS: dict[str, Any] = {kind.msgname: kind for kind in dialect.mavlink_map.values()}


def _decode(parser: Any, frame: bytes) -> Message | None:
    """Check and decode one frame; None if it is none, or not signed as it must be."""
    try:
        found = parser.decode(bytearray(frame))
    except (dialect.MAVError, struct.error, UnicodeDecodeError):
        return None
    if found.get_msgId() not in dialect.mavlink_map:
        # pymavlink cannot check what it does not know: garbage would pass for it, with good messages inside.
        return None
    fields = found.to_dict()
    fields.pop("mavpackettype", None)
    return Message(found.get_type(), fields, found.get_srcSystem(), found.get_srcComponent())


def _lengths(kind: Any) -> list[int]:
    """Array lengths in the order of the fields' names; pymavlink keeps them in the order of the wire."""
    by_name = dict(zip(kind.ordered_fieldnames, kind.array_lengths, strict=True))
    return [by_name[name] for name in kind.fieldnames]


def _value(given: Any, kind: str, length: int) -> Any:
    if kind == "char":
        return str(given or "").encode() if length else bytes(1)
    if given is None:
        return [0] * length if length else 0
    return [_number(one, kind) for one in given] if length else _number(given, kind)


def _number(given: float, kind: str) -> float:
    """Keep a number within its type, as a cast in C would not."""
    if kind in {"float", "double"}:
        return given if kind == "double" or not abs(given) > _FLOAT_MAX else math.copysign(math.inf, given)
    bits = int(kind.strip("uint_"))
    most: int = 2**bits - 1 if kind.startswith("u") else 2 ** (bits - 1) - 1
    least = 0 if kind.startswith("u") else -most - 1
    return min(max(int(given), least), most)
