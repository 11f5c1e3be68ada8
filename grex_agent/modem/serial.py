"""The driver's process: a modem on a serial port takes the place of the emulator for one craft.

The port is read without blocking whenever the bus is quiet, so that there is no thread to leave behind. A device that
vanishes is a state: the agent is told, and the port is tried again until it is back. The only module that knows
pyserial.
"""

import errno
import select
import termios
from typing import Any, Protocol

import serial

from grex_agent.modem.micromodem import MicroModem, Output
from grex_agent.modem.micromodem_rates import plan_setup
from grex_link import clock, log
from grex_link.clock import WallClock
from grex_link.config import Scenario, SerialModem
from grex_link.craft_clock import CraftClock
from grex_link.errors import ConfigError, FaultError, GrexError
from grex_link.messages import Clock, Happening, ModemEvent, ModemStatus, Presence, Request
from grex_link.node import Outlet
from grex_link.profile import load_profile
from grex_link.units import NS

#: The port is looked at this often, wall seconds: a character at 19200 baud takes half a millisecond.
_POLL_S = 0.01
_RETRY_S = 1.0
_CHUNK = 4096
_OUTBOX_MAX = 65536
_NO_DEVICE = "there is no such device; ls /dev/serial/by-id shows which there are"
_TAKEN = "another program has that device; close it"
_WHAT_TO_DO: dict[Any, str] = {
    errno.ENOENT: _NO_DEVICE,
    errno.ENXIO: _NO_DEVICE,
    errno.ENODEV: _NO_DEVICE,
    errno.EACCES: "permission denied; join the group dialout (sudo usermod -aG dialout $USER) and log in again",
    errno.EBUSY: _TAKEN,
    errno.EAGAIN: _TAKEN,
}


class PortError(Exception):
    """The port cannot be opened, or is gone."""


class Port(Protocol):
    """What the driver needs of a port; nothing of it blocks."""

    def open(self) -> None:
        """Open it; raises `PortError`."""

    def read(self) -> bytes:
        """Take what has come; raises `PortError`."""

    def write(self, data: bytes) -> int:
        """Write as much as goes now and return how much that was; raises `PortError`."""

    def close(self) -> None:
        """Let go of it."""


class SerialPort:
    """A serial port.

    Parameters
    ----------
    device : str
        For instance ``/dev/ttyUSB0``.
    baud : int
        Bits a second.
    rts : bool
        Whether RTS is up. A Micro-Modem 2 garbles what it says while it is.
    """

    def __init__(self, device: str, baud: int, *, rts: bool = False) -> None:
        self._serial = serial.Serial(None, baud, timeout=0, write_timeout=0, exclusive=True)
        self._serial.port = device
        self._serial.rts = rts

    def open(self) -> None:
        """Open it for this process alone."""
        try:
            self._serial.open()
            self._serial.reset_input_buffer()
        except (OSError, ValueError, termios.error) as error:
            self._serial.close()
            raise PortError(_what_to_do(error)) from None

    def read(self) -> bytes:
        """Take what has come."""
        try:
            return bytes(self._serial.read(_CHUNK))
        except (OSError, TypeError, termios.error) as error:
            raise PortError(_one_line(error)) from None

    def write(self, data: bytes) -> int:
        """Write as much as goes now."""
        try:
            # With no room left pyserial would try again and again.
            _, room, _ = select.select([], [self._serial], [], 0.0)
            return (self._serial.write(data) or 0) if room else 0
        except (OSError, ValueError, termios.error) as error:
            raise PortError(_one_line(error)) from None

    def close(self) -> None:
        """Let go of it."""
        self._serial.close()


class ModemDriver:
    """One craft's modem as a node of the bus: reads ``modem/tx``, writes ``modem/rx``.

    Parameters
    ----------
    scenario : Scenario
        The run.
    craft : str
        Whose modem this is.
    outlet : Outlet
        The bus.
    port : Port
        Where the modem is; open.
    time : WallClock
        Counts the driver's own time, at the pace of the run; the mission's is told by the hub.

    Raises
    ------
    ConfigError
        If the scenario does not suit a Micro-Modem.
    """

    def __init__(self, scenario: Scenario, craft: str, outlet: Outlet, port: Port, time: WallClock) -> None:
        self.done = self.started = False
        self._craft = craft
        self._outlet = outlet
        self._port = port
        self._time = time
        self._modem = MicroModem(plan_setup(scenario, craft, load_profile(scenario.link.profile)))
        # GPS at the surface is the hardware's business here, only offset and drift can be tried out.
        self._craft_clock = CraftClock(scenario.craft[craft].clock)
        self._mission_ns = 0
        self._early: list[Happening] = []
        self._events = 0
        self._last_ns = 0
        self._outbox = bytearray()
        self._open = True
        self._retry_at_s = 0.0
        self._take(self._modem.on_connect(time.now_ns()))

    @property
    def counts(self) -> dict[str, int]:
        """Everything that was out of order, see `MicroModem`."""
        return dict(self._modem.counts)

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message from the bus."""
        del craft
        if topic == "modem_tx":
            self._request(message)
        elif topic == "clock":
            self._on_clock(message)
        elif topic == "presence":
            self._on_presence(message)
        self.on_deadline()

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until the port is looked at again, or until the modem has been silent for too long."""
        due_ns = self._modem.next_deadline_ns
        return _POLL_S if due_ns is None else min(_POLL_S, self._time.wall_s_until(due_ns))

    def on_deadline(self) -> None:
        """Read, write, and do what is due."""
        try:
            self._exchange() if self._open else self._reopen()
        except PortError as error:
            self._lost(str(error))
        due_ns = self._modem.next_deadline_ns
        if due_ns is not None and due_ns <= (now_ns := self._time.now_ns()):
            self._take(self._modem.on_time(now_ns))

    def in_idle_time(self) -> bool:
        """Nothing here can wait."""
        return False

    # -- the port -----------------------------------------------------------------------------------------------

    def _exchange(self) -> None:
        if data := self._port.read():
            self._take(self._modem.on_bytes(data, self._time.now_ns()))
        self._flush()

    def _flush(self) -> None:
        if self._outbox:
            del self._outbox[: self._port.write(bytes(self._outbox))]
        if len(self._outbox) > _OUTBOX_MAX:
            raise PortError("it takes nothing any more")

    def _reopen(self) -> None:
        if clock.monotonic_s() < self._retry_at_s:
            return
        self._retry_at_s = clock.monotonic_s() + _RETRY_S
        try:
            self._port.open()
        except PortError:
            return
        self._open = True
        log.info("the modem's port is back")
        self._take(self._modem.on_connect(self._time.now_ns()))

    def _lost(self, why: str) -> None:
        log.warn("the modem's port is gone; it is tried again every second", error=why)
        self._port.close()
        self._open = False
        self._outbox.clear()
        self._retry_at_s = clock.monotonic_s() + _RETRY_S
        self._take(self._modem.on_disconnect(f"the port is gone: {why}", self._time.now_ns()))

    # -- the bus ------------------------------------------------------------------------------------------------

    def _request(self, request: Request) -> None:
        start_ns = self._craft_clock.true_ns(request.t_ns) - self._mission_ns
        self._take(self._modem.on_request(request, start_ns, self._time.now_ns()))

    def _take(self, out: list[Output]) -> None:
        for item in out:
            if isinstance(item, bytes):
                self._outbox += item
            elif self.started:
                self._publish(item)
            else:
                self._early.append(item)
            if isinstance(item, ModemStatus) and item.state == "error" and self._open:
                log.warn("the modem is of no use", why=item.detail)
        if self._open:
            try:
                self._flush()
            except PortError as error:
                self._lost(str(error))

    def _publish(self, event: Happening) -> None:
        local_ns = self._craft_clock.local_ns(self._time.now_ns() + self._mission_ns)
        # What happened before the mission counts as of its beginning.
        self._last_ns = max(self._last_ns, local_ns, 0)
        self._outlet.put("modem_rx", self._craft, ModemEvent(self._events, self._last_ns, event))
        self._events += 1

    def _on_clock(self, message: Clock) -> None:
        if message.phase == "bye":
            self.done = True
            if self._modem.counts:
                log.info("what was out of order at the modem", **self.counts)
            if message.reason:
                raise GrexError(f"sim ended the run: {message.reason}")
            return
        self.started = True
        self._mission_ns = int((self._time.epoch_unix_ns - message.epoch_unix_ns) * self._time.pace)
        early, self._early = self._early, []
        for event in early:
            self._publish(event)

    def _on_presence(self, message: Presence) -> None:
        if message.who == "sim" and not message.alive and not self.done:
            now_s = (self._time.now_ns() + self._mission_ns) / NS if self.started else None
            raise FaultError("sim", "left the bus without saying goodbye", now_s)


def open_port(scenario: Scenario, craft: str) -> SerialPort:
    """Open the port of a craft's modem.

    Raises
    ------
    ConfigError
        If that craft's modem is not serial, or its port cannot be opened.
    """
    config = scenario.craft[craft].modem
    if not isinstance(config, SerialModem):
        raise ConfigError(f"$.craft.{craft}.modem.type", "is not serial; the link emulates this craft's modem")
    port = SerialPort(config.port, config.baud)
    try:
        port.open()
    except PortError as error:
        raise ConfigError(f"$.craft.{craft}.modem.port", f"cannot open {config.port}: {error}") from None
    return port


def _what_to_do(error: BaseException) -> str:
    """Say why a port cannot be opened, and what to do; the library's own words name the device twice."""
    number = error.args[0] if error.args else None
    return _WHAT_TO_DO.get(number, _one_line(error))


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
