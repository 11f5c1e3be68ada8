"""Two benches for the same contract: the emulator, and the Micro-Modem's driver on ptys, both in our water.

Time is the bench's own and jumps from event to event; a pty is waited for until every byte has come out of it.
"""

import time
from collections import defaultdict
from collections.abc import Sequence

from micromodem_firmware import NS, Line, Water, still

from grex_agent.modem.serial import ModemDriver, SerialPort
from grex_link.clock import WallClock
from grex_link.emulator import Emulator
from grex_link.messages import Advance, Clock, Message, ModemEvent, Request, Step, Truth
from grex_link.scenario import loads

Positions = dict[str, tuple[float, float, float]]


class Outlet:
    """Keeps the modem events of each craft."""

    def __init__(self) -> None:
        self.events: dict[str, list[ModemEvent]] = defaultdict(list)

    def put(self, topic: str, craft: str, message: Message) -> None:
        """See `grex_link.node.Outlet`."""
        if topic == "modem_rx":
            self.events[craft].append(message)


class EmulatedBench:
    """The emulator in lockstep.

    Parameters
    ----------
    text : str
        The scenario.
    positions : dict
        Where the craft lie.
    """

    def __init__(self, text: str, positions: Positions) -> None:
        scenario = loads(text)
        self._outlet = Outlet()
        self._emulator = Emulator(scenario, self._outlet)
        self._emulator.handle("clock", "", Clock("start"))
        self._counts = dict.fromkeys(scenario.craft, 0)
        self._positions = positions
        self._tick = 0
        self.events = self._outlet.events

    def send(self, craft: str, request: Request) -> None:
        """Put a request on ``modem/tx``."""
        self._counts[craft] += 1
        self._emulator.handle("modem_tx", craft, request)

    def run(self, until_s: int) -> None:
        """Let mission time pass."""
        while self._tick < until_s:
            truth = Truth(self._tick, self._tick * NS, still(self._positions).poses)
            self._emulator.handle("advance", "", Advance([Step(truth, list(self._counts.values()))]))
            self._tick += 1

    def close(self) -> None:
        """Nothing is left behind."""


class BenchTime(WallClock):
    """Time that passes when the bench says so."""

    def __init__(self) -> None:
        super().__init__(1.0, 0)
        self.t_ns = 0

    def now_ns(self) -> int:
        """Time, nanoseconds."""
        return self.t_ns


class CountingPort(SerialPort):
    """A port that knows how many bytes have passed."""

    bytes_in = bytes_out = 0

    def read(self) -> bytes:
        """See `SerialPort`."""
        data = super().read()
        self.bytes_in += len(data)
        return data

    def write(self, data: bytes) -> int:
        """See `SerialPort`."""
        count = super().write(data)
        self.bytes_out += count
        return count


class SerialBench:
    """A driver for each craft, each on a pty, with firmware at the other end.

    Parameters
    ----------
    text : str
        The scenario.
    positions : dict
        Where the craft lie.
    """

    def __init__(self, text: str, positions: Positions) -> None:
        scenario = loads(text)
        self.water = Water(scenario, positions)
        self.lines = {craft: Line(modem) for craft, modem in self.water.modems.items()}
        self.drivers: dict[str, ModemDriver] = {}
        self._ports: dict[str, CountingPort] = {}
        self._outlet = Outlet()
        self._time = BenchTime()
        self.events = self._outlet.events
        self.water.advance(0)
        for craft, line in self.lines.items():
            port = self._ports[craft] = CountingPort(line.device, 19200)
            port.open()
            self.drivers[craft] = ModemDriver(scenario, craft, self._outlet, port, self._time)
            self.drivers[craft].handle("clock", craft, Clock("start"))
        self._settle()

    def send(self, craft: str, request: Request) -> None:
        """Put a request on ``modem/tx``."""
        self.drivers[craft].handle("modem_tx", craft, request)
        self._settle()

    def run(self, until_s: int) -> None:
        """Let mission time pass."""
        end_ns = until_s * NS
        while self._time.t_ns < end_ns:
            self._time.t_ns = min([end_ns, *self._deadlines()])
            self.water.advance(self._time.t_ns)
            self._settle()

    def close(self) -> None:
        """Close all ports."""
        for craft, port in self._ports.items():
            port.close()
            self.lines[craft].unplug()

    def _deadlines(self) -> Sequence[int]:
        times = [driver._modem.next_deadline_ns for driver in self.drivers.values()]
        return [t_ns for t_ns in [*times, self.water.next_event_ns] if t_ns is not None]

    def _settle(self) -> None:
        """Work until nobody has anything more to say at this time, and every byte has arrived."""
        give_up_at = time.monotonic() + 20.0
        while True:
            before = self._passed()
            for craft, driver in self.drivers.items():
                self.lines[craft].pump()
                driver.on_deadline()
            self.water.advance(self._time.t_ns)
            if before == self._passed() and self._arrived() and min(self._deadlines()) > self._time.t_ns:
                return
            assert time.monotonic() < give_up_at, "the ptys do not come to rest"

    def _passed(self) -> list[int]:
        ends = [*self._ports.values(), *self.lines.values()]
        return [count for end in ends for count in (end.bytes_in, end.bytes_out)]

    def _arrived(self) -> bool:
        return all(
            (port.bytes_in, port.bytes_out) == (self.lines[craft].bytes_out, self.lines[craft].bytes_in)
            and not self.water.modems[craft].said
            for craft, port in self._ports.items()
        )
