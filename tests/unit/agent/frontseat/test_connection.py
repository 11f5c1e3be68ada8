"""Lines to an autopilot over real loopback sockets and a pty; no waiting for clocks."""

import errno
import os
import socket
import time
import tty

import pytest

from grex_agent.frontseat.address import Address
from grex_agent.frontseat.connection import Connection
from grex_agent.frontseat.dialect import Codec, mavlink
from grex_link.errors import ConfigError


def heartbeat(system: int = 1) -> bytes:
    return Codec(system, 1).encode(mavlink.MAVLink_heartbeat_message(11, 3, 0, 15, 4, 3))


def ping() -> object:
    return mavlink.MAVLink_timesync_message(0, 1)


def receive(connection: Connection, count: int = 1) -> list:
    """Receive until so many messages are there."""
    messages: list = []
    deadline = time.monotonic() + 5.0
    while len(messages) < count and time.monotonic() < deadline:
        messages += connection.receive()
        time.sleep(0.001)
    return messages


@pytest.fixture
def boat():
    with socket.socket(type=socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        peer.settimeout(5.0)
        yield peer


@pytest.fixture
def listening():
    """A connection that waits on a port, and that port."""
    with socket.socket(type=socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    connection = Connection(Address("udpin", "127.0.0.1", port), Codec(255, 191))
    connection.open("$.url")
    yield connection, ("127.0.0.1", port)
    connection.close()


def test_udpin_answers_whoever_speaks(boat, listening):
    """On a port of our own the autopilot is answered where it speaks from; before that nobody is sent anything."""
    connection, address = listening
    connection.send(ping())
    boat.sendto(heartbeat(), address)
    assert [message.get_type() for message in receive(connection)] == ["HEARTBEAT"]
    connection.send(ping())
    assert Codec(1, 1).decode(boat.recv(1000))[0].get_type() == "TIMESYNC"


def test_others_on_the_port_are_not_answered(boat, listening):
    """Once the autopilot is known, what another vehicle's port sends does not make it a peer."""
    connection, address = listening
    connection.target = 1
    with socket.socket(type=socket.SOCK_DGRAM) as other:
        other.settimeout(0.2)
        other.sendto(heartbeat(system=2), address)
        boat.sendto(heartbeat(), address)
        assert len(receive(connection, 2)) == 2
        connection.send(ping())
        assert boat.recv(1000)
        with pytest.raises(TimeoutError):
            other.recv(1000)


def test_an_autopilot_that_comes_from_another_port(boat, listening, monkeypatch):
    """An autopilot that was started anew speaks from another port: that one is answered, the dead one forgotten."""
    connection, address = listening
    boat.sendto(heartbeat(), address)
    receive(connection)
    now = time.monotonic()
    monkeypatch.setattr("grex_agent.frontseat.connection.clock.monotonic_s", lambda: now + 6.0)
    with socket.socket(type=socket.SOCK_DGRAM) as again:
        again.settimeout(5.0)
        again.sendto(heartbeat(), address)
        receive(connection)
        connection.send(ping())
        assert again.recv(1000)
        boat.settimeout(0.2)
        with pytest.raises(TimeoutError):
            boat.recv(1000)


def test_udpout_speaks_first(boat):
    """Towards an address we speak first, and hear what comes back."""
    connection = Connection(Address("udpout", *boat.getsockname()), Codec(255, 191))
    connection.open("$.url")
    connection.send(ping())
    _, us = boat.recvfrom(1000)
    boat.sendto(heartbeat(), us)
    assert len(receive(connection)) == 1
    connection.close()


def test_tcp_comes_back(monkeypatch):
    """A TCP server that is not there yet, or goes away, is tried again; each is a line in the log, and why is told."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = server.getsockname()
    now = time.monotonic()
    said: list[str] = []
    for level in ("info", "warn"):
        monkeypatch.setattr(f"grex_agent.frontseat.connection.log.{level}", lambda text, **_: said.append(text))
    connection = Connection(Address("tcp", *address), Codec(255, 191))
    connection.open("$.url")
    assert connection.receive() == []
    assert connection.trouble == "connection refused: nothing listens there"
    for later in (10.0, 20.0):
        monkeypatch.setattr("grex_agent.frontseat.connection.clock.monotonic_s", lambda later=later: now + later)
        with socket.create_server(address) as server:
            connection.receive()
            peer, _ = server.accept()
            with peer:
                assert connection.trouble == ""
                peer.sendall(heartbeat())
                assert len(receive(connection)) == 1
                connection.send(ping())
                assert peer.recv(1000)
        for _ in range(100):
            connection.receive()
            time.sleep(0.001)
    connection.close()
    back, gone = (
        "the line to the autopilot is open",
        "the line to the autopilot is gone; it is tried again every second",
    )
    assert said == [back, gone, back, gone]


def test_serial(tmp_path):
    """A serial line carries both ways; a device that is not there is an error with the path of its url."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    connection = Connection(Address("serial", os.ttyname(theirs), 115200), Codec(255, 191))
    connection.open("$.url")
    os.write(ours, b"console text\r\n" + heartbeat())
    assert len(receive(connection)) == 1
    assert connection.garbage > 0
    connection.send(ping())
    assert Codec(1, 1).decode(os.read(ours, 1000))[0].get_type() == "TIMESYNC"
    connection.close()
    os.close(ours)
    os.close(theirs)
    missing = Connection(Address("serial", str(tmp_path / "tty"), 115200), Codec(255, 191))
    assert complaint(missing) == "there is no such device; ls /dev/serial/by-id shows which there are"


def complaint(connection: Connection) -> str:
    """Return what is said of a line that cannot be opened, but for its path."""
    with pytest.raises(ConfigError) as caught:
        connection.open("$.url")
    before, words = str(caught.value).split(": ", 1)[0], str(caught.value).partition("autopilot: ")[2]
    assert before == "$.url"
    return words


def test_a_port_in_use(boat):
    """A UDP port that somebody else has is an error that says who it may be and what to do."""
    connection = Connection(Address("udpin", *boat.getsockname()), Codec(255, 191))
    what_to_do = "another program (QGroundControl, MAVProxy?) has that port; close it, or take another port"
    assert complaint(connection) == what_to_do


def test_an_address_of_another_computer():
    """To listen on an address that is not ours is an error that says on which one can."""
    connection = Connection(Address("udpin", "192.0.2.9", 14550), Codec(255, 191))
    assert complaint(connection) == "that is no address of this computer; 0.0.0.0 listens on all that it has"


def test_a_device_in_use():
    """A serial device that another program holds is an error that says so."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    address = Address("serial", os.ttyname(theirs), 115200)
    first = Connection(address, Codec(255, 191))
    first.open("$.url")
    assert complaint(Connection(address, Codec(255, 191))) == "another program has that device; close it"
    first.close()
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("kind", ["serial", "udpin"])
def test_permission_denied(monkeypatch, kind: str):
    """Whoever may not open a device is told which group may; a port, from which number on."""

    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("serial.serialposix.os.open", refuse)
    monkeypatch.setattr("grex_agent.frontseat.lines.socket.socket", refuse)
    words = complaint(Connection(Address(kind, "/dev/ttyUSB0" if kind == "serial" else "127.0.0.1", 80), Codec(1, 1)))
    assert words.startswith("permission denied; ")
    assert ("dialout" if kind == "serial" else "take a port above 1023") in words
