"""Links as MAVLink users write them; nothing here blocks, and a peer that goes is a state."""

import os
import pty
import socket
import termios
import tty
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from grex_link.errors import ConfigError

_CHUNK = 65536
_RETRY_S = 1.0
FORMS = "udpout:HOST:PORT, udpin:HOST:PORT, tcpin:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD or pty:[NAME]"
"""Port 0 of a link that listens is any that is free."""

Piece = tuple[object, bytes]
"""Who sent it, and what."""


class Link(Protocol):
    """One link."""

    where: str
    """What to tell a user."""
    datagrams: bool
    """Whether it carries whole messages only."""

    def files(self) -> Iterable[int]:
        """File descriptors to wait for."""

    def receive(self, now_s: float) -> list[Piece]:
        """Take what has come."""

    def send(self, data: bytes) -> None:
        """Send to everybody on it, if it can."""

    def close(self) -> None:
        """Let go of it."""


class Udp:
    """UDP: ``udpout`` talks to one address, ``udpin`` waits and then talks to everybody it has heard."""

    datagrams = True

    def __init__(self, host: str, port: int, *, listens: bool) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)  # noqa: FBT003
        self._peers: dict[tuple[str, int], None] = {} if listens else {(host, port): None}
        self._listens = listens
        try:
            self._socket.bind((host, port) if listens else ("", 0))
        except OSError:
            self._socket.close()
            raise
        port = self._socket.getsockname()[1] if listens else port
        self.where = f"udp{'in' if listens else 'out'}:{host}:{port}"

    def files(self) -> list[int]:
        """File descriptors to wait for."""
        return [self._socket.fileno()]

    def receive(self, now_s: float) -> list[Piece]:
        """Take the datagrams that have come."""
        del now_s
        pieces: list[Piece] = []
        while True:
            try:
                data, peer = self._socket.recvfrom(_CHUNK)
            except BlockingIOError:
                return pieces
            except ConnectionError:
                # Nobody is there yet, or any more: the system tells us of a datagram that was not wanted.
                continue
            if self._listens:
                self._peers[peer] = None
            pieces.append((peer, data))

    def send(self, data: bytes) -> None:
        """Send one datagram to each peer."""
        for peer in self._peers:
            with suppress(OSError):
                self._socket.sendto(data, peer)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class TcpIn:
    """TCP server: several clients, who may come and go."""

    datagrams = False

    def __init__(self, host: str, port: int) -> None:
        self._server = socket.create_server((host, port), backlog=4)
        self._server.setblocking(False)  # noqa: FBT003
        self._clients: dict[socket.socket, bytearray] = {}
        self.where = f"tcpin:{host}:{self._server.getsockname()[1]}"

    def files(self) -> list[int]:
        """File descriptors to wait for."""
        return [self._server.fileno(), *(client.fileno() for client in self._clients)]

    def receive(self, now_s: float) -> list[Piece]:
        """Take new clients, and what has come from all."""
        del now_s
        with suppress(OSError):
            client, _ = self._server.accept()
            client.setblocking(False)  # noqa: FBT003
            self._clients[client] = bytearray()
        pieces = [(client, _receive(client)) for client in list(self._clients)]
        for client, data in pieces:
            if data is None:
                self._drop(client)
        return [(id(client), data) for client, data in pieces if data]

    def send(self, data: bytes) -> None:
        """Send to every client; one that does not read is dropped."""
        for client, waiting in list(self._clients.items()):
            if not _send(client, waiting, data):
                self._drop(client)

    def close(self) -> None:
        """Close all sockets."""
        for client in list(self._clients):
            self._drop(client)
        self._server.close()

    def _drop(self, client: socket.socket) -> None:
        del self._clients[client]
        client.close()


class TcpOut:
    """TCP client: tries again every second."""

    datagrams = False

    def __init__(self, host: str, port: int) -> None:
        self._address = host, port
        self._socket: socket.socket | None = None
        self._waiting = bytearray()
        self._retry_s = 0.0
        self.where = f"tcp:{host}:{port}"

    def files(self) -> list[int]:
        """File descriptors to wait for."""
        return [] if self._socket is None else [self._socket.fileno()]

    def receive(self, now_s: float) -> list[Piece]:
        """Take what has come; connect if there is no connection."""
        if self._socket is None:
            self._connect(now_s)
            return []
        data = _receive(self._socket)
        if data is None:
            self._drop()
        return [(self.where, data)] if data else []

    def send(self, data: bytes) -> None:
        """Send, if connected."""
        if self._socket is not None and not _send(self._socket, self._waiting, data):
            self._drop()

    def close(self) -> None:
        """Close the socket."""
        self._drop()

    def _connect(self, now_s: float) -> None:
        if now_s < self._retry_s:
            return
        self._retry_s = now_s + _RETRY_S
        with suppress(OSError):
            self._socket = socket.create_connection(self._address, timeout=0.2)
            self._socket.setblocking(False)  # noqa: FBT003

    def _drop(self) -> None:
        if self._socket is not None:
            self._socket.close()
        self._socket = None
        self._waiting.clear()


class Tty:
    """A serial port, or a pseudo-terminal of our own with a name for the other side."""

    datagrams = False

    def __init__(self, path: str, baud: int | None) -> None:
        self._name: Path | None = None
        self._slave: int | None = None
        if baud is None:
            self._file, self._slave = pty.openpty()
            device = os.ttyname(self._slave)
            tty.setraw(self._slave)
            self._link_to(device, path)
            self.where = f"serial port {device}" + (f" = {path}" if path else "")
        else:
            self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._file)
            _set_baud(self._file, baud)
            self.where = f"serial:{path}:{baud}"
        os.set_blocking(self._file, False)

    def files(self) -> list[int]:
        """File descriptors to wait for."""
        return [self._file]

    def receive(self, now_s: float) -> list[Piece]:
        """Take what has come; a port that is gone gives nothing."""
        del now_s
        with suppress(OSError):
            data = os.read(self._file, _CHUNK)
            return [(self.where, data)] if data else []
        return []

    def send(self, data: bytes) -> None:
        """Send; what does not fit on the line is lost, as on a real one."""
        with suppress(OSError):
            os.write(self._file, data)

    def close(self) -> None:
        """Close it, and take its name away."""
        for file in (self._file, self._slave):
            if file is not None:
                os.close(file)
        if self._name is not None:
            self._name.unlink(missing_ok=True)

    def _link_to(self, device: str, path: str) -> None:
        if path:
            name = Path(path)
            if name.is_symlink():
                name.unlink()
            name.symlink_to(device)
            self._name = name


def open_link(url: str) -> Link:
    """Open a link.

    Parameters
    ----------
    url : str
        One of `FORMS`.

    Raises
    ------
    ConfigError
        If the form is unknown, or the link cannot be opened.
    """
    kind, _, rest = url.partition(":")
    try:
        return _open(kind, rest, url)
    except (OSError, termios.error) as error:
        raise ConfigError("--url", f"{url}: {getattr(error, 'strerror', None) or error}") from None


def _open(kind: str, rest: str, url: str) -> Link:
    if kind == "pty":
        return Tty(rest, None)
    name, _, number = rest.rpartition(":")
    if not name or not number.isdigit() or kind not in {"udpin", "udpout", "tcpin", "tcp", "serial"}:
        raise ConfigError("--url", f"{url!r} is no link; write {FORMS}")
    if kind == "serial":
        return Tty(name, int(number))
    least = 0 if kind in {"udpin", "tcpin"} else 1
    if not least <= int(number) < 65536:
        raise ConfigError("--url", f"{url!r}: a port is a number from 1 to 65535")
    if kind.startswith("udp"):
        return Udp(name, int(number), listens=kind == "udpin")
    return TcpIn(name, int(number)) if kind == "tcpin" else TcpOut(name, int(number))


def _receive(connection: socket.socket) -> bytes | None:
    """Take what has come; None if the other side is gone."""
    try:
        return connection.recv(_CHUNK) or None
    except BlockingIOError:
        return b""
    except OSError:
        return None


def _send(connection: socket.socket, waiting: bytearray, data: bytes) -> bool:
    """Send what goes; False if the other side is gone, or has not read for long."""
    waiting += data
    try:
        del waiting[: connection.send(waiting)]
    except BlockingIOError:
        return len(waiting) < 4 * _CHUNK
    except OSError:
        return False
    return True


def _set_baud(file: int, baud: int) -> None:
    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise OSError(None, f"this system knows no {baud} baud")
    attributes = termios.tcgetattr(file)
    attributes[4] = attributes[5] = speed
    termios.tcsetattr(file, termios.TCSANOW, attributes)
