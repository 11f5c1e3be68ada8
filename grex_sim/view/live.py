"""A run as it is heard on the bus: keeps the picture of it, and of who is there.

Of what comes between two looks only the newest of each key is decoded; events of the water are all. In lockstep the
messages of every tick are left to those who need them: true poses and agents' states come in bundles.
"""

from collections.abc import Sequence
from typing import Any

import msgspec

from grex_link.bus import DEFAULT_ENDPOINTS, Heard, Listener
from grex_link.errors import GrexError
from grex_link.messages import RunStatus, Truth
from grex_link.scenario import decode
from grex_link.topics import TOPICS, place_of, who_of
from grex_sim.view.health import Health
from grex_sim.view.picture import Frame, Picture

_ALWAYS = ("status", "clock", "state", "port", "ledger", "report", "truth")
_LOCKSTEP = ("advance",)
_LIVE = ("fix", "setpoint", "modem_tx", "modem_rx")
_NEWEST = frozenset({"state", "port", "ledger", "truth", "advance", "fix"})
_DECODERS: dict[str, msgspec.msgpack.Decoder[Any]] = {
    name: msgspec.msgpack.Decoder(topic.type) for name, topic in TOPICS.items()
}
#: Messages that have ended are shown for so many seconds: of the mission, or of the wall when that is longer …
_SHOWN_S, _SHOWN_WALL_S = 4.0, 1.5
#: … but never so many of the mission, or the sea would be full.
_SHOWN_MOST_S = 60.0
#: Messages taken in one go: a tenth of a second's work at most.
_AT_ONCE = 5000


class Live:
    """See the module's docstring.

    Wall times are arguments, seconds on any clock that never jumps.

    Parameters
    ----------
    endpoints : sequence of str
        Where the simulator listens.

    Attributes
    ----------
    picture : Picture or None
        None as long as it is not known what is run.
    run : int
        Counts the runs seen; another number means another team, plan and past.
    bad_payloads : int
        Messages that did not decode.
    """

    def __init__(self, endpoints: Sequence[str] = DEFAULT_ENDPOINTS) -> None:
        self.endpoints = endpoints
        self.picture: Picture | None = None
        self.run = 0
        self.bad_payloads = 0
        self._listener: Listener | None = None
        self._start_afresh()

    def _start_afresh(self) -> None:
        self._health = Health()
        self._phase, self._reason = "waiting", ""
        self._everybody: list[str] = []
        self._status: RunStatus | None = None
        self._newest: dict[tuple[str, str], bytes] = {}
        self._ended = False
        self._fresh = True
        self._mark: tuple[float, float] | None = None
        self._speed = 0.0

    def connect(self) -> None:
        """Go on the bus, once.

        Raises
        ------
        BusError
            If nobody is there.
        """
        listener = Listener(self.endpoints)
        for name in _ALWAYS:
            listener.hear(_everywhere(name))
        listener.hear_presence()
        self._listener = listener

    @property
    def connected(self) -> bool:
        """Whether it has been on the bus; the bus itself comes back by itself."""
        return self._listener is not None

    def close(self) -> None:
        """Leave the bus."""
        if self._listener is not None:
            self._listener.close()

    def listen(self, wall_s: float) -> bool:
        """Take everything that has come since the last time; whether there is something new to see."""
        if self._listener is None:
            return False
        before = self._phase, self.run, len(self._everybody)
        gone: list[str] = []
        news = False
        for _ in range(_AT_ONCE):
            heard = self._listener.take(0.0)
            if heard is None:
                break
            if heard.alive is None:
                news |= self._on_message(heard, wall_s)
            else:
                self._on_presence(heard, gone)
                news = True
        self._see_off(gone)
        self._decode_newest()
        self._measure(wall_s)
        return news or before != (self._phase, self.run, len(self._everybody))

    def frame(self, wall_s: float) -> Frame:
        """Return what there is to see now."""
        frame: Frame = {"run": self.run, "phase": self._phase, "reason": self._reason, "bad": self.bad_payloads}
        frame["dropped"] = 0 if self._listener is None else self._listener.dropped
        if self.picture is None:
            return frame
        shown_s = min(max(_SHOWN_S, _SHOWN_WALL_S * self._speed), _SHOWN_MOST_S)
        frame.update(self.picture.frame(self.picture.now_s - shown_s))
        frame.update(
            speed=round(self._speed, 2),
            shown_s=shown_s,
            health=self._health.table(self.picture.scenario, self._everybody, wall_s, self._notes(self.picture)),
        )
        return frame

    @property
    def truth(self) -> Truth | None:
        """The newest true poses."""
        return None if self.picture is None else self.picture.truth

    # -- what is heard ----------------------------------------------------------------------------------------------

    def _on_message(self, heard: Heard, wall_s: float) -> bool:
        place = place_of(heard.key)
        if place is None:
            return False
        name, craft = place.topic.name, place.craft
        self._health.heard(name, craft, wall_s)
        if name in _NEWEST:
            self._newest[name, craft] = heard.payload
            return name in {"truth", "advance", "state"}
        if name in {"status", "clock", "report"} and (message := self._decoded(name, heard.payload)) is not None:
            if name == "status":
                self._on_status(message)
            elif name == "clock":
                self._on_clock(message)
            elif self.picture is not None and message.log:  # most of them say only that nothing happened
                self._decode_newest()  # the poses first, where the sounds begin
                for event in message.log:
                    self.picture.take("", event)
        return name in {"clock", "report"}

    def _decoded(self, name: str, payload: bytes) -> Any:
        try:
            return _DECODERS[name].decode(payload)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            self.bad_payloads += 1
            return None

    def _decode_newest(self) -> None:
        if self.picture is None:
            return
        for (name, craft), payload in self._newest.items():
            message = self._decoded(name, payload)
            if name == "advance" and message is not None:
                message = message.steps[-1].truth if message.steps else None
            elif name == "state" and message is not None:
                message = message.states[-1] if message.states else None
            if message is not None:
                self.picture.take(craft, message)
        self._newest.clear()

    def _on_status(self, status: RunStatus) -> None:
        self._status = status
        if not self._fresh:
            return
        try:
            self.picture = Picture(decode(msgspec.json.decode(status.scenario)))
        except (GrexError, msgspec.DecodeError) as error:
            self._reason = f"this run is of another version of GREX: {error}"
            return
        self._fresh = False
        self.run += 1
        self._everybody = status.everybody
        self._phase = "running"
        if self._listener is not None:
            for name in _LOCKSTEP if self.picture.scenario.clock.lockstep else _LIVE:
                self._listener.hear(_everywhere(name))

    def _on_clock(self, message: Any) -> None:
        if message.phase != "bye":
            return
        self._health.over = True
        if self._phase != "over":
            self._phase, self._reason = "over", message.reason
        for who in self._everybody:
            if message.reason.startswith((f"agent {who} ", f"{who} ")):
                self._health.on_fault(who)

    def _on_presence(self, heard: Heard, gone: list[str]) -> None:
        _, who = who_of(heard.key)
        if not heard.alive:
            gone.append(who)
            return
        if self._ended:
            self._start_afresh()
        self._health.on_presence(who, alive=True)

    def _see_off(self, gone: Sequence[str]) -> None:
        """Take note of who has gone; without the simulator the bus is gone, and with it the sight of all others."""
        for who in gone:
            self._health.on_presence(who, alive=False)
        if "sim" in gone:
            self._ended = True
            self._health.everybody_gone()
            if self._phase != "over":
                self._phase, self._reason = "lost", "the simulator left the bus without saying goodbye"

    def _measure(self, wall_s: float) -> None:
        """Measure how many mission seconds pass in a wall second."""
        if self.picture is None:
            return
        now_s = self.picture.now_s
        if self._mark is None or now_s < self._mark[1]:
            self._mark = wall_s, now_s
        elif wall_s - self._mark[0] >= 1.0:
            self._speed = (now_s - self._mark[1]) / (wall_s - self._mark[0])
            self._mark = wall_s, now_s

    def _notes(self, picture: Picture) -> dict[str, dict[str, Any]]:
        notes = picture.notes()
        if status := self._status:
            notes["sim"] = {"late ticks": status.late_ticks, "late setpoints": status.late_setpoints}
        return notes


def _everywhere(topic: str) -> str:
    """Key expression of a topic for all teams and craft."""
    return "grex/*/" + TOPICS[topic].key.replace("{craft}", "*")
