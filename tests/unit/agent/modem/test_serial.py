"""The driver as a node of the bus, on a port by hand; and serial ports on ptys."""

import os
import tty

import pytest

from grex_agent.modem import serial
from grex_agent.modem.nmea import encode
from grex_agent.modem.serial import ModemDriver, PortError, SerialPort, open_port
from grex_link.clock import WallClock
from grex_link.errors import ConfigError, FaultError, GrexError
from grex_link.messages import Clock, ModemEvent, ModemStatus, Presence, RangeRequest, Received, Transmit, TxEvent
from grex_link.scenario import loads
from grex_link.units import NS

SCENARIO = """
[clock]
pace = "live"
[link]
profile = "umodem_fsk0"
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 40, 0]
[craft.auv1]
modem = { type = "serial", port = "/dev/nowhere" }
[craft.auv1.clock]
offset_s = 0.5
[craft.auv2]
"""
READY = b"".join(
    encode("CACFG", key, value)
    for key, value in (("SRC", 1), ("ASD", 0), ("REV", 1), ("RXD", 1), ("TXF", 1), ("CST", 1), ("SNV", 0))
)


class Wire:
    """A port that a test holds in its hands."""

    def __init__(self) -> None:
        self.to_driver = b""
        self.from_driver = b""
        self.room = 1000
        self.gone = False
        self.tries = 0

    def open(self) -> None:
        self.tries += 1
        if self.gone:
            raise PortError("no such device")

    def read(self) -> bytes:
        if self.gone:
            raise PortError("device disconnected")
        data, self.to_driver = self.to_driver, b""
        return data

    def write(self, data: bytes) -> int:
        if self.gone:
            raise PortError("device disconnected")
        self.from_driver += data[: self.room]
        return min(len(data), self.room)

    def close(self) -> None:
        pass


class ByHand(WallClock):
    """Mission time by hand; the driver's own clock was started 5 s before the mission."""

    def __init__(self) -> None:
        super().__init__(1.0, -5 * NS)
        self.mission_s = -5.0

    def now_ns(self) -> int:
        return round((self.mission_s + 5.0) * NS)


class Bench:
    def __init__(self, monkeypatch) -> None:
        self.wire, self.time, self.events, self.warnings = Wire(), ByHand(), [], []
        self.wall_s = 0.0
        monkeypatch.setattr(serial.clock, "monotonic_s", lambda: self.wall_s)
        for level in ("warn", "info"):
            monkeypatch.setattr(serial.log, level, lambda event, **fields: self.warnings.append((event, fields)))
        self.driver = ModemDriver(loads(SCENARIO), "auv1", self, self.wire, self.time)

    def put(self, topic: str, craft: str, message: ModemEvent) -> None:
        assert (topic, craft) == ("modem_rx", "auv1")
        self.events.append(message)

    def say(self, data: bytes) -> None:
        self.wire.to_driver += data
        self.driver.on_deadline()

    def start(self) -> None:
        self.time.mission_s = -0.25
        self.driver.handle("clock", "", Clock("start", 0))
        self.time.mission_s = 10.0


@pytest.fixture
def bench(monkeypatch):
    return Bench(monkeypatch)


def test_the_modem_is_set_up_before_the_mission(bench):
    """Setting up does not wait for the mission; what happened before it counts as of its beginning."""
    assert bench.wire.from_driver == encode("CCCFG", "SRC", 1)
    bench.say(READY)
    assert bench.events == []
    assert not bench.driver.started
    bench.start()
    # The craft's clock is half a second ahead.
    assert bench.events == [ModemEvent(0, round(0.25 * NS), ModemStatus("ready"))]


def test_nothing_happens_before_the_mission(bench):
    """By the modem's own clock the mission may not have begun; its events have no time before zero, nor run back."""
    bench.say(READY)
    bench.time.mission_s = -2.0
    bench.driver.handle("clock", "", Clock("start", 0))
    for mission_s in (-1.0, 5.0, 4.0):
        bench.time.mission_s = mission_s
        bench.say(encode("CAMUA", 2, 1, "1fab"))
    assert [event.t_ns for event in bench.events] == [0, 0, round(5.5 * NS), round(5.5 * NS)]


def test_requests_begin_by_the_crafts_clock(bench):
    """A request for 12 s by a clock that is half a second ahead begins 11.5 s into the mission."""
    bench.say(READY)
    bench.start()
    bench.wire.from_driver = b""
    bench.driver.handle("modem_tx", "auv1", Transmit(0, 12 * NS, b"x"))
    assert bench.driver.wall_s_to_deadline() == 0.01
    bench.time.mission_s = 11.499
    assert bench.driver.wall_s_to_deadline() == pytest.approx(0.001)
    bench.driver.on_deadline()
    assert bench.wire.from_driver == b""
    bench.time.mission_s = 11.5
    bench.driver.on_deadline()
    assert bench.wire.from_driver == encode("CCCYC", 0, 1, 15, 0, 0, 1)


def test_what_is_heard_is_stamped_by_the_crafts_clock(bench):
    """A reception gets the next number and the time of the craft's clock."""
    bench.say(READY)
    bench.start()
    bench.say(encode("CAMUA", 2, 1, "1fab"))
    assert bench.events[1] == ModemEvent(1, round(10.5 * NS), Received("auv2", b"\x1f\xab", "auv1"))


def test_a_port_that_takes_little_at_a_time(bench):
    """What does not fit into the port now is written later, in order."""
    bench.say(READY)
    bench.start()
    bench.wire.from_driver, bench.wire.room = b"", 5
    bench.driver.handle("modem_tx", "auv1", RangeRequest(0, 0, "auv2"))
    for _ in range(5):
        bench.driver.on_deadline()
    assert bench.wire.from_driver == encode("CCMPC", 1, 2)


def test_a_port_that_takes_nothing(bench, monkeypatch):
    """A port that takes nothing for ever is as good as gone."""
    monkeypatch.setattr(serial, "_OUTBOX_MAX", 50)
    bench.say(READY)
    bench.start()
    bench.wire.room = 0
    for frame in range(1, 6):
        bench.say(encode("CADRQ", "000000", 1, 15, 0, 32, frame))
    assert bench.events[-1].event.state == "error"


def test_an_unplugged_modem_comes_back(bench):
    """One status and one line when it goes, a try every second, set up anew and ready when it is back."""
    bench.say(READY)
    bench.start()
    bench.driver.handle("modem_tx", "auv1", RangeRequest(0, 0, "auv2"))
    bench.wire.gone = True
    for wall_s in (0.0, 0.5, 1.0, 1.5, 2.5, 3.6):
        bench.wall_s = wall_s
        bench.driver.on_deadline()
    status = bench.events[-1].event
    assert status == ModemStatus("error", "the port is gone: device disconnected")
    assert TxEvent(0, "FAILED", "error") in [event.event for event in bench.events]
    assert len(bench.warnings) == 1
    assert bench.wire.tries == 3
    bench.driver.handle("modem_tx", "auv1", Transmit(1, 0, b"x"))
    assert bench.events[-1].event == TxEvent(1, "FAILED", "off")
    bench.wire.gone, bench.wire.from_driver, bench.wall_s = False, b"", 5.0
    bench.driver.on_deadline()
    assert bench.wire.from_driver == encode("CCCFG", "SRC", 1)
    bench.say(READY)
    assert bench.events[-1].event == ModemStatus("ready")
    assert len(bench.warnings) == 2
    assert [event.seq for event in bench.events] == list(range(len(bench.events)))


def test_a_port_that_is_lost_while_writing(bench):
    """A port that is found gone while writing is lost once, and what was to be sent has failed."""
    bench.say(READY)
    bench.start()
    bench.wire.gone = True
    bench.driver.handle("modem_tx", "auv1", RangeRequest(0, 0, "auv2"))
    assert [type(event.event).__name__ for event in bench.events[1:]] == ["TxEvent", "ModemStatus"]
    assert len(bench.warnings) == 1


def test_a_modem_that_does_not_answer_is_logged(bench):
    """A modem that says nothing is one line in the log and one status."""
    bench.start()
    for mission_s in (0.0, 5.0, 10.0, 20.0, 25.0, 30.0, 35.0):
        bench.time.mission_s = mission_s
        bench.driver.on_deadline()
    assert [event.event for event in bench.events] == [ModemStatus("error", "the modem does not answer")]
    assert bench.warnings == [("the modem is of no use", {"why": "the modem does not answer"})]


def test_the_end(bench):
    """With the mission's end the driver is done, and says in one line what was out of order."""
    bench.say(READY + b"$CAXYZ,1*00\r\n")
    bench.start()
    assert bench.driver.in_idle_time() is False
    bench.driver.handle("clock", "", Clock("bye"))
    assert bench.driver.done
    assert bench.driver.counts == {"bad_checksum": 1}
    assert bench.warnings[-1][1] == {"bad_checksum": 1}
    with pytest.raises(GrexError, match="sim ended the run: agent auv2 is gone"):
        bench.driver.handle("clock", "", Clock("bye", reason="agent auv2 is gone"))


def test_without_the_simulator(bench):
    """A simulator that is gone without a word ends the driver, which says when."""
    bench.driver.handle("presence", "", Presence("auv2", alive=False, scenario=""))
    bench.start()
    with pytest.raises(FaultError, match=r"sim left the bus without saying goodbye at mission time 10.0 s"):
        bench.driver.handle("presence", "", Presence("sim", alive=False, scenario=""))


def test_only_serial_modems_have_ports():
    """A driver for an emulated modem, or for a port that is not there, is refused with the path."""
    scenario = loads(SCENARIO)
    with pytest.raises(ConfigError, match=r"^\$\.craft\.auv2\.modem\.type: is not serial"):
        open_port(scenario, "auv2")
    with pytest.raises(ConfigError, match=r"^\$\.craft\.auv1\.modem\.port: cannot open /dev/nowhere: there is no such"):
        open_port(scenario, "auv1")


@pytest.fixture
def pty():
    """A pty: (firmware's end, name of the device)."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    for end in (master, slave):
        try:
            os.close(end)
        except OSError:
            continue


def test_a_port_on_a_pty(pty):
    """Bytes go both ways as they are, all 256 of them; with nothing there, reading gives nothing at once."""
    master, device = pty
    port = SerialPort(device, 19200)
    port.open()
    assert port.read() == b""
    everything = bytes(range(256))
    assert port.write(everything) == 256
    assert os.read(master, 1000) == everything
    os.write(master, everything)
    heard = b""
    while len(heard) < 256:
        heard += port.read()
    assert heard == everything
    port.close()


def test_a_port_that_is_full_does_not_block(pty):
    """When the other end reads nothing, writing takes what goes and returns."""
    _, device = pty
    port = SerialPort(device, 19200)
    port.open()
    counts = [port.write(b"x" * 4096) for _ in range(50)]
    assert counts[0] > 0
    assert counts[-1] == 0
    port.close()


def test_a_port_has_one_owner(pty):
    """A second driver on the same device is refused."""
    _, device = pty
    first, second = SerialPort(device, 19200), SerialPort(device, 19200)
    first.open()
    with pytest.raises(PortError, match="another program has that device"):
        second.open()
    first.close()
    second.open()
    second.close()


def test_a_port_that_is_torn_off(pty):
    """A device that vanishes is a `PortError`, for reading, for writing and for opening."""
    master, device = pty
    port = SerialPort(device, 19200)
    port.open()
    os.close(master)
    with pytest.raises(PortError):
        port.read()
    with pytest.raises(PortError):
        port.write(b"x")
    port.close()
