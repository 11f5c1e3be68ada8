"""MAVLink messages over the line to one autopilot; nothing of it blocks.

A line that breaks is a state: it is tried again every second. On UDP the peers are those from whom the autopilot is
heard: one that was started anew speaks from another port, and the old one is forgotten.
"""

from grex_agent.frontseat.address import Address
from grex_agent.frontseat.dialect import Codec, Mavlink
from grex_agent.frontseat.lines import LineError, Peer, make_line
from grex_link import clock, log
from grex_link.errors import ConfigError

_RETRY_S = 1.0
#: A peer from whom the autopilot has not been heard for so long gets nothing any more.
_PEER_S = 5.0


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
        self._line = make_line(address)
        self._codec = codec
        self._waits = address.kind == "tcp"
        self._open = False
        self._retry_at_s = 0.0
        self._peers: dict[Peer, float] = {}
        #: Why the line is not open; empty when it is.
        self.trouble = ""
        #: System id of the autopilot, once it is known: who brings its messages is a peer.
        self.target: int | None = None

    @property
    def garbage(self) -> int:
        """Pieces so far that were no message."""
        return self._codec.garbage

    @property
    def unsigned(self) -> int:
        """Messages so far that were not signed with our key."""
        return self._codec.unsigned

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
            self.trouble = str(error)
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
        except LineError as error:
            self.trouble = str(error)
            return False
        self._open, self.trouble = True, ""
        log.info("the line to the autopilot is open")
        return True

    def _lost(self, error: LineError) -> None:
        log.warn("the line to the autopilot is gone; it is tried again every second", error=str(error))
        self.trouble = str(error)
        self._line.close()
        self._codec.forget(None)
        self._open = False
        self._retry_at_s = clock.monotonic_s() + _RETRY_S
