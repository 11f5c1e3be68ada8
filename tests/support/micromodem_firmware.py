"""The other end of a Micro-Modem's serial line: firmware that speaks its NMEA interface, on a pty, in our water.

Nothing here is taken from the driver: sentences are read and written anew, so that a mistake cannot be its own remedy.
"""

import fcntl
import os
import select
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import reduce
from operator import xor

from grex_link.config import Scenario
from grex_link.medium import make_medium
from grex_link.messages import (
    BadFrame,
    Happening,
    ModemStatus,
    Pose,
    RangeRequest,
    RangeResult,
    Received,
    Transmit,
    Truth,
    TxEvent,
)

BROADCAST = 15
FRAME_BYTES = {0: 32, 1: 64, 2: 64, 3: 256, 4: 256, 5: 256, 6: 32}
NS = 1_000_000_000


@dataclass
class Cycle:
    """A packet that the host has announced."""

    destination: int
    rate: int
    acknowledge: int
    count: int
    frames: list[bytes] = field(default_factory=list)


class Firmware:
    """One modem: takes commands, says sentences, and is deaf and dumb while it is off.

    Parameters
    ----------
    water : Water
        Where it hangs.
    craft : str
        Below whom.

    Attributes
    ----------
    said : bytearray
        What it has said and nobody has taken yet.
    heard : list of str
        Every command, without checksum.
    unknown_settings : set of str
        Settings this firmware does not have.
    hung : bool
        Whether it does not answer any more.
    """

    def __init__(self, water: "Water", craft: str) -> None:
        self.said = bytearray()
        self.heard: list[str] = []
        self.unknown_settings: set[str] = set()
        self.hung = self.off = False
        self.address = 0
        self._water = water
        self._craft = craft
        self._line = b""
        self._settings = {"SRC": "0"}
        self._cycle: Cycle | None = None
        self._sending: Cycle | None = None

    def say(self, *fields: object) -> None:
        """Say a sentence."""
        body = ",".join(map(str, fields))
        if not self.off and not self.hung:
            self.said += f"${body}*{reduce(xor, body.encode()):02X}\r\n".encode()

    def on_bytes(self, data: bytes) -> None:
        """Take what the host has written."""
        *lines, self._line = (self._line + data).split(b"\r\n")
        for line in lines:
            body, star, digits = line.decode("ascii").removeprefix("$").partition("*")
            assert star, f"the host has written {line!r}, which has no checksum"
            assert int(digits, 16) == reduce(xor, body.encode()), f"wrong checksum in {line!r}"
            self.heard.append(body)
            if not self.off and not self.hung:
                kind, *fields = body.split(",")
                getattr(self, f"_{kind.lower()}", self._not_understood)(*fields)

    def _not_understood(self, *fields: str) -> None:
        self.say("CAERR", "000100", "NMEA", 5, "unknown command")

    # -- commands -----------------------------------------------------------------------------------------------

    def _cccfg(self, key: str, value: str) -> None:
        if key in self.unknown_settings:
            self.say("CAERR", "000100", "NMEA", 5, "unknown setting")
            return
        self._settings[key] = value
        self.address = int(self._settings["SRC"])
        self.say("CACFG", key, value)

    def _cccfq(self, key: str) -> None:
        self.say("CACFG", key, self._settings.get(key, 0))

    def _cccyc(self, command: str, source: str, destination: str, rate: str, acknowledge: str, count: str) -> None:
        assert int(source) == self.address
        assert self._sending is None, "the host announces a packet while another one is on the air"
        self._cycle = Cycle(int(destination), int(rate), int(acknowledge), int(count))
        self.say("CACYC", command, source, destination, rate, acknowledge, count)
        if not self._cycle.rate:
            self.say("CATXP", 0)
            self.say("CATXF", 0)
        self._ask(self._cycle)

    def _ask(self, cycle: Cycle) -> None:
        room = FRAME_BYTES[cycle.rate]
        number = len(cycle.frames) + 1
        self.say("CADRQ", "000100", self.address, cycle.destination, cycle.acknowledge, room, number)

    def _cctxd(self, source: str, destination: str, acknowledge: str, data: str) -> None:
        cycle = self._cycle
        if cycle is None:
            return
        frame = bytes.fromhex(data)
        assert len(frame) <= FRAME_BYTES[cycle.rate]
        self.say("CATXD", source, destination, acknowledge, len(frame))
        cycle.frames.append(frame.ljust(FRAME_BYTES[cycle.rate], b"\0"))
        if len(cycle.frames) < cycle.count:
            self._ask(cycle)
            return
        self._cycle, self._sending = None, cycle
        payload = b"".join(cycle.frames)
        self.say("CATXP", len(payload))
        self._water.send(self, cycle, payload)

    def _ccmpc(self, source: str, destination: str) -> None:
        self.say("CAMPC", source, destination)
        self.say("CATXP", 0)
        self._water.ping(self._craft, int(destination))

    # -- what the water brings ----------------------------------------------------------------------------------

    def on_event(self, event: Happening) -> None:
        """Say what the medium has let happen."""
        if isinstance(event, ModemStatus):
            self._on_status(event)
        elif isinstance(event, TxEvent):
            self._on_transmission(event.status)
        elif isinstance(event, Received):
            self._on_received(event)
        elif isinstance(event, BadFrame):
            self.say("CARXP", 0)
            self.say("CAMSG", "BAD_CRC", 1)
            self._statistics(1, 1, -1, BROADCAST, 150.0)
        elif isinstance(event, RangeResult) and event.range_m is not None:
            there = self._water.address(event.destination)
            self.say("CAMPR", there, self.address, f"{event.range_m / self._water.nominal_mps:.4f}")

    def pinged(self, by: int) -> None:
        """Say that it has answered a ping."""
        self.say("CARXP", 0)
        self.say("CAMPA", by, self.address)

    def _on_status(self, event: ModemStatus) -> None:
        self.off = event.state == "off"
        self._cycle = self._sending = None
        if event.state == "rebooted":
            self.say("CAREV", "000000", "INIT", "0.94.0.00")
            self.say("CAREV", "000001", "AUV", "0.94.0.00")

    def _on_transmission(self, status: str) -> None:
        cycle = self._sending
        if cycle is None:
            return
        if status == "SENT":
            self.say("CATXF", sum(map(len, cycle.frames)))
            self._transmit_statistics(cycle, 0)
        elif status == "DELIVERED":
            for number in range(1, cycle.count + 1):
                self.say("CAACK", cycle.destination, self.address, number, 1)
        if status != "SENT" or not cycle.acknowledge:
            self._sending = None

    def _on_received(self, event: Received) -> None:
        source = self._water.address(event.source)
        destination = BROADCAST if not event.destination else self._water.address(event.destination)
        cycle = self._water.last_sent[event.source]
        self.say("CARXP", 0 if cycle.rate == 0 else 1)
        self.say("CACYC", 0, source, destination, cycle.rate, cycle.acknowledge, cycle.count)
        if cycle.rate == 0:
            self._statistics(0, 2, source, destination, event.rssi_db or 0.0)
        size = FRAME_BYTES[cycle.rate]
        for number in range(1, cycle.count + 1):
            data = event.payload[size * (number - 1) : size * number].hex().upper()
            self.say("CARXD", source, destination, cycle.acknowledge, number, data)
        self._statistics(0, 1 if cycle.rate == 0 else 3, source, destination, event.rssi_db or 0.0)

    def _statistics(self, mode: int, kind: int, source: int, destination: int, level_db: float) -> None:
        received = (mode, "000100.0000", 0, 1440, 25, "0175", f"{round(level_db):04d}", 75, "01", "01", "01", "03")
        packet = (1, f"{source:03d}", f"{destination:03d}", 0, kind, 1, int(mode > 0))
        equalizer = (146, 12, 11, -100, -1, "000", -1.2, 45, 25000, 4000)
        self.say("CACST", *received, *packet, *equalizer)

    def _transmit_statistics(self, cycle: Cycle, mode: int) -> None:
        self.say("CAXST", 20110914, "204459.0000", 1, mode, 40, 4000, 25120, cycle.rate, self.address,
                 cycle.destination, cycle.acknowledge, cycle.count, cycle.count, 1, 32)  # fmt: skip


class Water:
    """The medium of a scenario with a firmware below each craft.

    Parameters
    ----------
    scenario : Scenario
        Team, profile, and all that the water does.
    positions : dict
        Where the craft lie, north, east, down, metres.
    """

    def __init__(self, scenario: Scenario, positions: dict[str, tuple[float, float, float]]) -> None:
        self.nominal_mps = scenario.link.water.nominal_sound_speed_mps
        self.last_sent: dict[str, Cycle] = {}
        self.modems = {craft: Firmware(self, craft) for craft in scenario.craft}
        self._medium = make_medium(scenario)
        self._medium.place(still(positions))
        self._seq = dict.fromkeys(scenario.craft, 0)
        self._now_ns = 0

    def advance(self, now_ns: int) -> None:
        """Let everything happen up to a time, that included."""
        self._now_ns = now_ns
        self._medium.advance(now_ns + 1)
        for line in self._medium.log(now_ns + 1):
            if line.kind == "delivered" and line.purpose == "ping":
                self.modems[line.destination].pinged(self.address(line.source))
        for _, craft, event in self._medium.events(now_ns + 1):
            self.modems[craft].on_event(event)

    @property
    def next_event_ns(self) -> int | None:
        """When something happens."""
        return self._medium.next_event_ns()

    def address(self, craft: str) -> int:
        """Address that a craft's modem has now."""
        return self.modems[craft].address

    def send(self, modem: Firmware, cycle: Cycle, payload: bytes) -> None:
        """Transmit now."""
        craft = next(craft for craft, other in self.modems.items() if other is modem)
        self.last_sent[craft] = cycle
        to = "" if cycle.destination == BROADCAST else self._craft(cycle.destination)
        seq = self._next(craft)
        self._medium.request(craft, Transmit(seq, 0, payload, to, bool(cycle.acknowledge)), self._now_ns)

    def ping(self, craft: str, address: int) -> None:
        """Ask the craft with an address to answer."""
        self._medium.request(craft, RangeRequest(self._next(craft), 0, self._craft(address)), self._now_ns)

    def _craft(self, address: int) -> str:
        # A modem that has been off from the beginning has no address yet; it does not hear anything either.
        silent = [craft for craft, modem in self.modems.items() if modem.address == 0]
        return next((craft for craft, modem in self.modems.items() if modem.address == address), (silent or [""])[0])

    def _next(self, craft: str) -> int:
        self._seq[craft] += 1
        return self._seq[craft] - 1


def still(positions: dict[str, tuple[float, float, float]]) -> Truth:
    """Poses of craft that do not move."""
    return Truth(0, 0, [Pose(craft, *place, 0.0, 0.0, 0.0, 0.0) for craft, place in positions.items()])


class Line:
    """A pty: the firmware's end, and the device that the driver opens.

    Parameters
    ----------
    modem : Firmware
        Who sits at the firmware's end.
    """

    def __init__(self, modem: Firmware) -> None:
        self._modem = modem
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.device = os.ttyname(self._slave)
        self.bytes_in = self.bytes_out = 0

    def fileno(self) -> int:
        """For `select`."""
        return self._master

    def pump(self) -> None:
        """Carry bytes both ways, as far as they go."""
        waiting = fcntl.ioctl(self._master, termios.FIONREAD, b"\0\0\0\0")
        if size := int.from_bytes(waiting, "little"):
            data = os.read(self._master, size)
            self.bytes_in += len(data)
            self._modem.on_bytes(data)
        while self._modem.said:
            try:
                count = os.write(self._master, self._modem.said[:1024])
            except BlockingIOError:
                return
            self.bytes_out += count
            del self._modem.said[:count]

    def unplug(self) -> None:
        """Take the device away."""
        for end in (self._master, self._slave):
            os.close(end)


@contextmanager
def running(water: Water, lines: dict[str, Line], pace: float) -> Iterator[Callable[[str], None]]:
    """Run all firmware in a thread, `pace` times as fast as the wall clock; yields a function that unplugs one."""
    over = threading.Event()
    lock = threading.Lock()
    started = time.monotonic()
    failures: list[BaseException] = []

    def loop() -> None:
        try:
            while not over.is_set():
                select.select(list(lines.values()), [], [], 0.002)
                with lock:
                    water.advance(round((time.monotonic() - started) * pace * NS))
                    for line in lines.values():
                        line.pump()
        except BaseException as error:  # noqa: BLE001 - told to the test
            failures.append(error)

    def unplug(craft: str) -> None:
        with lock:
            lines.pop(craft).unplug()

    thread = threading.Thread(target=loop)
    thread.start()
    try:
        yield unplug
    finally:
        over.set()
        thread.join()
        for line in lines.values():
            line.unplug()
    if failures:
        raise failures[0]
