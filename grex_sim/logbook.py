"""The memory of a run: what is recorded, counted, and hashed into its digest."""

import hashlib
from array import array
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from grex_link import log
from grex_link.errors import RecordingError
from grex_link.messages import (
    AgentState,
    AgentStates,
    LinkEvent,
    LinkLedger,
    Message,
    PortLedger,
    Setpoint,
    TaskNews,
    Truth,
)
from grex_link.recorder import Recorder
from grex_sim.cables import Cable, CableWatch
from grex_sim.navigation_errors import BelievedPlaces

if TYPE_CHECKING:
    from grex_sim.foxglove_scene import FoxgloveScene

#: Messages that are written in one go when there is time, and that may wait for it.
_SOME = 4
_PILE = 2000
_WRITE_S = 0.5


class Logbook:
    """Takes down everything the bench wants to know of a run.

    Parameters
    ----------
    recorder : Recorder or None
        Where messages are recorded; None records nothing.
    scene : FoxgloveScene or None
        Turns true poses into what viewers draw, to be recorded beside them.
    watch : CableWatch or None
        Measures the cables, if there are any.

    Attributes
    ----------
    messages_sent, bytes_sent, delivered, overheard, lost, refused : int
        What happened in the water, and over land links.
    sent_by_land : int
        Of the messages sent, those over cable or radio: each goes to one craft only.
    ledger : LinkLedger or None
        The newest ledger of the water.
    ports : dict of str to PortLedger
        The newest ledger of each craft's modem port.
    task_news : list of (str, TaskNews)
        Who said what of which task.
    late_ticks, late_setpoints : int
        Live paces: what did not keep up.
    places : BelievedPlaces
        Where the agents took themselves and others to be.
    """

    def __init__(
        self,
        recorder: Recorder | None = None,
        scene: "FoxgloveScene | None" = None,
        watch: CableWatch | None = None,
        *,
        stop_when_full: bool = True,
    ) -> None:
        self._recorder = recorder
        self._scene = scene
        self._watch = watch
        self._written_ns = 0
        self._stop_when_full = stop_when_full
        #: Why nothing more is recorded; empty as long as it is.
        self.recording_fault = ""
        self._encode = msgspec.msgpack.Encoder().encode
        self._hashes = {name: hashlib.sha256() for name in ("truth", "link", "setpoints")}
        self._positions = array("d")
        self._depths = array("d")
        self._unwritten: deque[tuple[str, str, Any]] = deque()
        self._write_at = 0.0
        self._craft = 0
        self.messages_sent = self.bytes_sent = self.sent_by_land = self.refused = 0
        self.delivered = self.overheard = self.lost = 0
        self.ledger: LinkLedger | None = None
        self.ports: dict[str, PortLedger] = {}
        self.task_news: list[tuple[str, TaskNews]] = []
        self.late_ticks = self.late_setpoints = 0
        self.bad_frames: dict[str, int] = {}
        self.adrift_steps: dict[str, int] = {}
        self.unhealthy_steps: dict[str, dict[str, int]] = {}
        self.places = BelievedPlaces()

    def truth(self, truth: Truth) -> None:
        """Take down the true poses of a tick."""
        self._craft = len(truth.poses)
        if self._watch is not None:
            self._watch.see(truth)
        for pose in truth.poses:
            self._positions.append(pose.north_m)
            self._positions.append(pose.east_m)
            self._depths.append(pose.down_m)
        self._hashes["truth"].update(self._encode(truth))
        self._unwritten.append(("truth", "", truth))

    def setpoints(self, setpoints: Mapping[str, Setpoint], team: Sequence[str]) -> None:
        """Take down the setpoints a tick was moved under, in the order of the team."""
        for craft in team:
            if craft in setpoints:
                self._hashes["setpoints"].update(self._encode(setpoints[craft]))

    def adrift(self, craft: Sequence[str]) -> None:
        """Count a step in which craft could not make good their course against the current."""
        for name in craft:
            self.adrift_steps[name] = self.adrift_steps.get(name, 0) + 1

    def link_events(self, events: Sequence[LinkEvent]) -> None:
        """Take down lines of the medium's log."""
        for event in events:
            self._hashes["link"].update(self._encode(event))
            self._unwritten.append(("link_event", "", event))
            if event.kind == "started":
                self.messages_sent += 1
                self.bytes_sent += event.size_bytes
                self.sent_by_land += event.purpose == "land"
            elif event.kind == "delivered":
                self.delivered += 1
            elif event.kind == "overheard":
                self.overheard += 1
            elif event.kind == "lost":
                self.lost += 1
            else:
                self.refused += 1

    def in_flight(self, craft: int) -> int:
        """How many receptions are still to come, in a team of so many craft."""
        under_water = (self.messages_sent - self.sent_by_land) * (craft - 1)
        return under_water + self.sent_by_land - self.delivered - self.overheard - self.lost

    def message(self, topic: str, craft: str, message: Message) -> None:
        """Take down a message that passed on the bus."""
        if isinstance(message, AgentStates):
            for state in message.states:
                self._unwritten.append((topic, craft, state))
                self._note_health(craft, state)
                self.places.note(craft, state)
        else:
            self._unwritten.append((topic, craft, message))
            if isinstance(message, LinkLedger):
                self.ledger = message
            elif isinstance(message, PortLedger):
                self.ports[craft] = message
            elif isinstance(message, TaskNews):
                self.task_news.append((craft, message))

    def write_some(self) -> bool:
        """Write a few of the messages that have piled up; False if there are none."""
        unwritten = self._unwritten
        for _ in range(min(_SOME, len(unwritten))):
            self._write(*unwritten.popleft())
        return bool(unwritten)

    def write_if_due(self, now_s: float) -> None:
        """Write everything if much has piled up, and put it on disk if half a second of wall time has passed."""
        due = now_s >= self._write_at
        if due or len(self._unwritten) > _PILE:
            self._write_all()
        if due:
            self._write_at = now_s + _WRITE_S
            self._record(Recorder.flush)

    def close(self) -> None:
        """Close the recording."""
        self._write_all()
        for encoded in self._scene.end(self._written_ns) if self._scene is not None else ():
            self._record(Recorder.write_encoded, *encoded)
        self._record(Recorder.close)

    def _write_all(self) -> None:
        while self._unwritten:
            self._write(*self._unwritten.popleft())

    def _write(self, topic: str, craft: str, message: Any) -> None:
        self._record(Recorder.write, topic, craft, message.t_ns, message)
        if self._scene is not None and self._recorder is not None and topic == "truth":
            self._written_ns = message.t_ns
            for encoded in self._scene.at(message):
                self._record(Recorder.write_encoded, *encoded)

    def _record(self, deed: Callable[..., None], *arguments: Any) -> None:
        """Do something to the recording, if there is one; when the disk is full there is none any more."""
        if self._recorder is None:
            return
        try:
            deed(self._recorder, *arguments)
        except RecordingError as error:
            self._recorder.abandon()
            self._recorder = None
            self.recording_fault = str(error)
            if self._stop_when_full:
                raise
            log.warn(self.recording_fault)

    def _note_health(self, craft: str, state: AgentState) -> None:
        if state.bad_frames:
            self.bad_frames[craft] = state.bad_frames
        for word in state.health:
            words = self.unhealthy_steps.setdefault(craft, {})
            words[word] = words.get(word, 0) + 1

    @property
    def cables(self) -> list[Cable]:
        """Every cable as measured so far."""
        return [] if self._watch is None else self._watch.cables

    @property
    def positions(self) -> NDArray[np.float64]:
        """True positions, shape (ticks, craft, 2): north and east, metres."""
        return np.array(self._positions).reshape(-1, self._craft or 1, 2)

    @property
    def positions_ned(self) -> NDArray[np.float64]:
        """True positions, shape (ticks, craft, 3): north, east and down, metres."""
        depths = np.array(self._depths).reshape(-1, self._craft or 1, 1)
        return np.concatenate((self.positions, depths), axis=2)

    @property
    def digest(self) -> str:
        """SHA-256 of truth trajectory, link event log and setpoints so far."""
        whole = hashlib.sha256()
        for name in ("truth", "link", "setpoints"):
            whole.update(self._hashes[name].digest())
        return whole.hexdigest()
