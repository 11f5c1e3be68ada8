"""A recorded run as frames for the page, in pieces that are fetched as the slider needs them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError, GrexError
from grex_link.messages import AgentState, Fix, LinkEvent, LinkLedger, PortLedger, Truth
from grex_link.recorder import Recorded, read_scenario, stream_messages
from grex_link.recording import RECORDING_FILE
from grex_link.scenario import decode
from grex_link.units import NS
from grex_sim.view.picture import Frame, Picture

_FRAMES_MAX = 3600
_FRAMES_A_PIECE = 60
_EVERY_TICK = {"fix": Fix, "state": AgentState, "truth": Truth}
_ON_EVENT = {"port": PortLedger, "ledger": LinkLedger, "event": LinkEvent}


class _Tick(msgspec.Struct):
    tick: int


class Recording:
    """What the page gets of a recording; reads all of it at once.

    Parameters
    ----------
    run : Path
        The run's folder, or its recording; one that was cut off will do.

    Attributes
    ----------
    scene, past : dict
        See `grex_sim.view.scene` and `Picture.past`.
    pieces : list of bytes
        Frames as JSON, so many in each.
    bad_payloads : int
        Messages that did not decode.

    Raises
    ------
    ConfigError
        If it is no recording of a run, or of a version of GREX that this one does not understand.
    """

    def __init__(self, run: Path) -> None:
        path = run / RECORDING_FILE if run.is_dir() else run
        self.bad_payloads = 0
        try:
            scenario = decode(msgspec.json.decode(read_scenario(path)))
            self._picture = Picture(scenario)
        except ConfigError as error:
            if error.path.startswith("$"):
                raise ConfigError(str(path), f"is of another version of GREX: {error}") from None
            raise
        except (GrexError, msgspec.DecodeError) as error:
            raise ConfigError(str(path), f"holds no scenario that this version of GREX knows: {error}") from None
        self._tick_s = scenario.clock.tick_s
        ticks = (scenario.duration_s or plan_mission(scenario).duration_s) / self._tick_s
        self._stride = max(1, -(-int(ticks + 1) // _FRAMES_MAX))
        frames = list(self._frames(path))
        if not frames:
            raise ConfigError(str(path), "holds no true positions: the run broke off before its first tick")
        self.scene: dict[str, Any] = {
            **self._picture.scene,
            "mode": "recorded",
            "name": run.name,
            "frames": len(frames),
            "frames_a_piece": _FRAMES_A_PIECE,
            "times": [frame["t"] for frame in frames],
        }
        self.past = self._picture.past()
        starts = range(0, len(frames), _FRAMES_A_PIECE)
        self.pieces = [msgspec.json.encode(frames[start : start + _FRAMES_A_PIECE]) for start in starts]

    def _frames(self, path: Path) -> Iterator[Frame]:
        """Look at the picture every so many ticks.

        The log of the water is written a little later than the ticks it belongs to, so all of it is read first.
        """
        by_tick: dict[int, list[tuple[str, str, bytes]]] = {}
        events: list[tuple[float, str, Any]] = []
        for recorded in stream_messages(path):
            craft, kind = _named(recorded.topic)
            if kind in _EVERY_TICK:
                tick = self._decoded(recorded, _Tick)
                if tick is not None and tick.tick % self._stride == 0:
                    by_tick.setdefault(tick.tick, []).append((craft, kind, recorded.data))
            elif kind in _ON_EVENT and (message := self._decoded(recorded, _ON_EVENT[kind])) is not None:
                events.append((message.t_ns / NS, craft, message))
        events.sort(key=lambda event: event[0])
        shown_s = max(self._picture.sounds.lasting_s, 2.0 * self._stride * self._tick_s)
        place = 0
        for tick in sorted(by_tick):
            for craft, kind, data in by_tick.pop(tick):
                message = self._decoded(Recorded(kind, 0, data), _EVERY_TICK[kind])
                if message is not None:
                    self._picture.take(craft, message)
            now_s = self._picture.now_s
            while place < len(events) and events[place][0] <= now_s:
                self._picture.take(*events[place][1:])
                place += 1
            frame = self._picture.frame(now_s - shown_s)
            yield {**frame, "shown_s": shown_s, "health": self._table()}

    def _table(self) -> list[dict[str, Any]]:
        notes = self._picture.notes()
        return [
            {
                "who": who,
                "role": "link" if who == "link" else "agent",
                "state": "recorded",
                "silent_s": None,
                "rates": {},
                "notes": notes.get(who, {}),
            }
            for who in ["link", *self._picture.names]
        ]

    def _decoded(self, recorded: Recorded, kind: Any) -> Any:
        """Decode a message; JSON has no NaN, and where a number should be, null stands for it."""
        try:
            return msgspec.json.decode(recorded.data, type=kind)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            pass
        try:
            return msgspec.convert(_with_nan(msgspec.json.decode(recorded.data)), kind)
        except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError, RecursionError):
            self.bad_payloads += 1
            return None


def _named(topic: str) -> tuple[str, str]:
    """Craft and kind of message of a recorded topic, for instance ``/auv1/fix``."""
    craft, _, kind = topic.strip("/").rpartition("/")
    return craft, kind


def _with_nan(value: Any) -> Any:
    if value is None:
        return float("nan")
    if isinstance(value, dict):
        return {name: _with_nan(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_with_nan(entry) for entry in value]
    return value
