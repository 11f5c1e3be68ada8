"""Keeps a Micro-Modem as the driver needs it: settings after every start, a question after a long silence."""

from collections import deque

from grex_agent.modem.nmea import encode
from grex_link.messages import Happening, ModemStatus
from grex_link.units import NS

#: An echo that has not come after this is not coming.
ECHO_NS = 5 * NS
#: A command is sent this often.
TRIES = 3
#: After a reboot the modem is left alone for this long.
REST_NS = 2 * NS
#: After a silence this long the modem is asked whether it is there.
KEEPALIVE_NS = 60 * NS
#: One that does not answer is tried again after this time.
RETRY_NS = 10 * NS

#: Besides the address: no test data of its own, revision messages, frames, ends of transmissions, statistics.
_SETTINGS = (("ASD", "0"), ("REV", "1"), ("RXD", "1"), ("TXF", "1"), ("CST", "1"))


class Upkeep:
    """The modem as such. Methods return what to send, and what to tell the agent.

    Parameters
    ----------
    address : int
        The modem's own.

    Attributes
    ----------
    ready : bool
        Whether the modem is set up and takes requests. Whatever is under way when this becomes false has failed.
    until_ns : int or None
        When `on_time` wants to be called.
    version : str
        Of the firmware, once it has said so.
    synchronous : bool
        Whether the modem begins to transmit with the second of its clock (its owner's setting SNV); then, if the team
        does the same, the fraction of a second at which something arrives is its travel time.
    no_echo : int
        Commands that have not been answered.
    """

    def __init__(self, address: int) -> None:
        self.ready = False
        self.until_ns: int | None = None
        self.version = ""
        self.synchronous = False
        self.no_echo = 0
        self._address = str(address)
        self._commands: deque[tuple[str, ...]] = deque()
        self._tries = 0
        self._complained = False

    @property
    def configuring(self) -> bool:
        """Whether a setting waits for its echo."""
        return not self.ready and bool(self._commands)

    def configure(self, now_ns: int) -> list[bytes | Happening]:
        """Begin to set the modem up."""
        self.ready = False
        self._commands = deque(("CCCFG", *setting) for setting in (("SRC", self._address), *_SETTINGS))
        self._commands.append(("CCCFQ", "SNV"))
        return self._next(now_ns)

    def disconnected(self, why: str) -> list[bytes | Happening]:
        """Take note that there is no modem any more."""
        self._stop(None)
        return [ModemStatus("error", why)]

    def rebooted(self, now_ns: int) -> list[bytes | Happening]:
        """Take note that the modem has started anew; set it up after a rest."""
        self._stop(now_ns + REST_NS)
        return [ModemStatus("rebooted")]

    def alive(self, now_ns: int) -> None:
        """Take note that the modem has said something."""
        if self.ready:
            self._commands.clear()
            self.until_ns = now_ns + KEEPALIVE_NS

    def setting(self, key: str, value: str, now_ns: int) -> list[bytes | Happening]:
        """Take the modem's word for one of its settings."""
        if key == "SNV":
            self.synchronous = value == "1"
        if self.configuring and self._commands[0][1:] in {(key, value), (key,)}:
            self._commands.popleft()
            return self._next(now_ns)
        return self.configure(now_ns) if self.ready and key == "SRC" and value != self._address else []

    def rejected(self, now_ns: int) -> list[bytes | Happening]:
        """Do without a setting that the firmware does not have; a modem that cannot have its address is of no use."""
        if self.configuring and self._commands[0][1] != "SRC":
            self._commands.popleft()
            return self._next(now_ns)
        return self._give_up(now_ns)

    def on_time(self, now_ns: int) -> list[bytes | Happening]:
        """Ask a silent modem, ask again, and say at last that it does not answer."""
        if self.until_ns is None or now_ns < self.until_ns:
            return []
        if not self._commands:
            if not self.ready:
                return self.configure(now_ns)
            self._commands.append(("CCCFQ", "SRC"))
            self._tries = 0
            return self._send(now_ns)
        self.no_echo += 1
        return self._send(now_ns) if self._tries < TRIES else self.rejected(now_ns)

    def _next(self, now_ns: int) -> list[bytes | Happening]:
        self._tries = 0
        if self._commands:
            return self._send(now_ns)
        self.ready, self._complained = True, False
        self.until_ns = now_ns + KEEPALIVE_NS
        return [ModemStatus("ready", self.version)]

    def _send(self, now_ns: int) -> list[bytes | Happening]:
        self._tries += 1
        self.until_ns = now_ns + ECHO_NS
        return [encode(*self._commands[0])]

    def _give_up(self, now_ns: int) -> list[bytes | Happening]:
        self._stop(now_ns + RETRY_NS)
        if self._complained:
            return []
        self._complained = True
        return [ModemStatus("error", "the modem does not answer")]

    def _stop(self, until_ns: int | None) -> None:
        self.ready = False
        self._commands.clear()
        self.until_ns = until_ns
