"""The line to one autopilot: UDP, TCP or serial; nothing of it blocks.

A line that breaks is a state: it is tried again every second. On UDP the peers are those from whom the autopilot is
heard: one that was started anew speaks from another port, and the old one is forgotten.
"""

import contextlib
import socket
from collections.abc import Iterable
from typing import Any, Protocol

from grex_agent.frontseat.address import Address
from grex_agent.frontseat.dialect import Codec, Mavlink
from grex_agent.modem.serial import PortError, SerialPort
from grex_link import clock, log
from grex_link.errors import ConfigError

_RETRY_S = 1.0
#: A peer from whom the autopilot has not been heard for so long gets nothing any more.
_PEER_S = 5.0
_DATAGRAM = 65535
_DATAGRAMS_AT_ONCE = 200
_OUTBOX_MAX = 65536

#: Whatever the line calls it.
Peer = Any


class LineError(Exception):
    """The line cannot be opened, or is gone."""


class Line(Protocol):
    """What carries bytes; nothing of it blocks, all of it raises `LineError`."""

    def open(self) -> None:
        """Open it."""

    def read(self) -> list[tuple[bytes, Peer]]:
        """Take what has come, and from whom."""

    def write(self, data: bytes, peers: Iterable[Peer]) -> None:
        """Send to peers."""

    def close(self) -> None:
        """Let go of it."""


class Udp:
    """Datagrams: bound to a port and answering whoever speaks, or towards an address."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._socket: socket.socket | None = None
        self._there: Peer | None = None

    def open(self) -> None:
        """Bind, or find the address."""
        try:
            family, *_, there = socket.getaddrinfo(self._address.place, self._address.number, type=socket.SOCK_DGRAM)[0]
            opened = socket.socket(family, socket.SOCK_DGRAM)
            opened.setblocking(False)  # noqa: FBT003
            self._socket = opened
            if self._address.kind == "udpin":
                opened.bind(there)
            else:
                self._there = there
        except OSError as error:
            self.close()
            raise LineError(error.strerror or str(error)) from None

    def read(self) -> list[tuple[bytes, Peer]]:
        """Take the datagrams that have come."""
        found: list[tuple[bytes, Peer]] = []
        if self._socket is None:
            return found
        for _ in range(_DATAGRAMS_AT_ONCE):
            try:
                data, peer = self._socket.recvfrom(_DATAGRAM)
            except BlockingIOError:
                break
            except OSError:
                # Nobody was there for the last one: as good as lost.
                continue
            found.append((data, peer))
        return found

    def write(self, data: bytes, peers: Iterable[Peer]) -> None:
        """Send one datagram to each peer; one that does not go is as good as lost."""
        for peer in peers if self._there is None else [self._there]:
            if self._socket is not None:
                with contextlib.suppress(OSError):
                    self._socket.sendto(data, peer)

    def close(self) -> None:
        """Let go of it."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class Tcp:
    """A connection to a server."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._socket: socket.socket | None = None
        self._outbox = bytearray()

    def open(self) -> None:
        """Connect; on the loopback and on a quay's network that takes no time worth a thread."""
        try:
            self._socket = socket.create_connection((self._address.place, self._address.number), timeout=_RETRY_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.setblocking(False)  # noqa: FBT003
        except OSError as error:
            self.close()
            raise LineError(error.strerror or str(error)) from None

    def read(self) -> list[tuple[bytes, Peer]]:
        """Take the bytes that have come."""
        if self._socket is None:
            return []
        try:
            data = self._socket.recv(_DATAGRAM)
        except BlockingIOError:
            return []
        except OSError as error:
            raise LineError(error.strerror or str(error)) from None
        if not data:
            raise LineError("the other side has closed it")
        return [(data, None)]

    def write(self, data: bytes, peers: Iterable[Peer]) -> None:
        """Send as much as goes now, and keep the rest."""
        del peers
        self._outbox += data
        if self._socket is None:
            return
        try:
            del self._outbox[: self._socket.send(self._outbox)]
        except BlockingIOError:
            pass
        except OSError as error:
            raise LineError(error.strerror or str(error)) from None
        if len(self._outbox) > _OUTBOX_MAX:
            raise LineError("it takes nothing any more")

    def close(self) -> None:
        """Let go of it."""
        self._outbox.clear()
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class Serial:
    """A serial line."""

    def __init__(self, address: Address) -> None:
        # A telemetry radio with flow control gives nothing while RTS is down.
        self._port = SerialPort(address.place, address.number, rts=True)
        self._outbox = bytearray()

    def open(self) -> None:
        """Open it for this process alone."""
        try:
            self._port.open()
        except PortError as error:
            raise LineError(str(error)) from None

    def read(self) -> list[tuple[bytes, Peer]]:
        """Take the bytes that have come."""
        try:
            data = self._port.read()
        except PortError as error:
            raise LineError(str(error)) from None
        return [(data, None)] if data else []

    def write(self, data: bytes, peers: Iterable[Peer]) -> None:
        """Send as much as goes now, and keep the rest."""
        del peers
        self._outbox += data
        try:
            del self._outbox[: self._port.write(bytes(self._outbox))]
        except PortError as error:
            raise LineError(str(error)) from None
        if len(self._outbox) > _OUTBOX_MAX:
            raise LineError("it takes nothing any more")

    def close(self) -> None:
        """Let go of it."""
        self._outbox.clear()
        self._port.close()


class Connection:
    """MAVLink messages over a line that may break.

    Parameters
    ----------
    address : Address
        Where the autopilot is.
    codec : Codec
        Who we are.
    """

    def __init__(self, address: Address, codec: Codec) -> None:
        self._line: Line = {"tcp": Tcp, "serial": Serial}.get(address.kind, Udp)(address)  # type: ignore[assignment]
        self._codec = codec
        self._waits = address.kind == "tcp"
        self._open = False
        self._retry_at_s = 0.0
        self._peers: dict[Peer, float] = {}
        #: System id of the autopilot, once it is known: who brings its messages is a peer.
        self.target: int | None = None

    @property
    def garbage(self) -> int:
        """Pieces so far that were no message."""
        return self._codec.garbage

    @property
    def heard(self) -> bool:
        """Whether anything has come at all."""
        return bool(self._peers)

    def open(self, path: str) -> None:
        """Open the line; a TCP server that is not there yet is tried again later.

        Raises
        ------
        ConfigError
            If it cannot be opened.
        """
        try:
            self._line.open()
            self._open = True
        except LineError as error:
            if not self._waits:
                raise ConfigError(path, f"cannot open the line to the autopilot: {error}") from None
            self._retry_at_s = clock.monotonic_s() + _RETRY_S

    def receive(self) -> list[Mavlink]:
        """Take the messages that have come."""
        if not self._open and not self._reopen():
            return []
        try:
            pieces = self._line.read()
        except LineError as error:
            self._lost(error)
            return []
        now_s = clock.monotonic_s()
        messages: list[Mavlink] = []
        for data, peer in pieces:
            decoded = self._codec.decode(data, peer)
            if any(self.target in {None, message.get_srcSystem()} for message in decoded):
                self._peers[peer] = now_s
            messages += decoded
        return messages

    def send(self, message: Mavlink) -> None:
        """Send a message to whoever brings us the autopilot's."""
        data = self._codec.encode(message)
        if not self._open:
            return
        try:
            self._line.write(data, self._listening())
        except LineError as error:
            self._lost(error)

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()
        self._open = False

    def _listening(self) -> list[Peer]:
        now_s = clock.monotonic_s()
        if len(self._peers) > 1:
            newest = max(self._peers.values())
            for peer in [peer for peer, at_s in self._peers.items() if at_s < min(newest, now_s - _PEER_S)]:
                del self._peers[peer]
                self._codec.forget(peer)
        return list(self._peers)

    def _reopen(self) -> bool:
        now_s = clock.monotonic_s()
        if now_s < self._retry_at_s:
            return False
        self._retry_at_s = now_s + _RETRY_S
        try:
            self._line.open()
        except LineError:
            return False
        self._open = True
        log.info("the line to the autopilot is open")
        return True

    def _lost(self, error: LineError) -> None:
        log.warn("the line to the autopilot is gone; it is tried again every second", error=str(error))
        self._line.close()
        self._codec.forget(None)
        self._open = False
        self._retry_at_s = clock.monotonic_s() + _RETRY_S
