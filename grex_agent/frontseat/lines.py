"""Lines to an autopilot: UDP, TCP or serial. They carry bytes, and nothing of them blocks."""

import contextlib
import errno
import socket
from collections.abc import Iterable
from typing import Any, Protocol

from grex_agent.frontseat.address import Address
from grex_agent.modem.serial import PortError, SerialPort

_CONNECT_S = 1.0
_DATAGRAM = 65535
_DATAGRAMS_AT_ONCE = 200
_OUTBOX_MAX = 65536

_WHAT_TO_DO = {
    errno.EADDRINUSE: "another program (QGroundControl, MAVProxy?) has that port; close it, or take another port",
    errno.EADDRNOTAVAIL: "that is no address of this computer; 0.0.0.0 listens on all that it has",
    errno.EACCES: "permission denied; take a port above 1023",
    errno.ECONNREFUSED: "connection refused: nothing listens there",
}
#: Whatever the line calls it.
Peer = Any


class LineError(Exception):
    """The line cannot be opened, or is gone."""


def _what_to_do(error: OSError) -> str:
    """Say why a line over the network cannot be opened, and what to do."""
    if isinstance(error, socket.gaierror):
        return "there is no host of that name; write its address in numbers, or correct the name"
    if isinstance(error, TimeoutError):
        return "no answer from that host; is it on, and in this network?"
    return _WHAT_TO_DO.get(error.errno or 0, error.strerror or str(error))


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
            raise LineError(_what_to_do(error)) from None

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
            self._socket = socket.create_connection((self._address.place, self._address.number), timeout=_CONNECT_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.setblocking(False)  # noqa: FBT003
        except OSError as error:
            self.close()
            raise LineError(_what_to_do(error)) from None

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


def make_line(address: Address) -> Line:
    """Make the line that an address asks for; it is not open yet."""
    if address.kind == "serial":
        return Serial(address)
    return Tcp(address) if address.kind == "tcp" else Udp(address)
