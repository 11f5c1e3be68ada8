"""A recorded run as frames for the page, in pieces that are fetched as the slider needs them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError
from grex_link.messages import AgentState, Fix, LinkEvent, LinkLedger, PortLedger, Truth
from grex_link.recording import Entry, Recording
from grex_link.units import NS
from grex_sim.view.picture import Frame, Picture

_FRAMES_MAX = 3600
_FRAMES_A_PIECE = 60
_TOPICS = {"fix", "state", "truth", "port", "ledger", "link_event"}


class RecordedPage:
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

    Raises
    ------
    ConfigError
        If it is no recording of a run, or of a version of GREX that this one does not understand.
    """

    def __init__(self, run: Path) -> None:
        recording = Recording(run)
        scenario = recording.scenario
        self._picture = Picture(scenario)
        self._tick_s = scenario.clock.tick_s
        ticks = (scenario.duration_s or plan_mission(scenario).duration_s) / self._tick_s
        self._stride = max(1, -(-int(ticks + 1) // _FRAMES_MAX))
        frames = list(self._frames(recording))
        if not frames:
            raise ConfigError(str(recording.path), "holds no true positions: the run broke off before its first tick")
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

    def _frames(self, recording: Recording) -> Iterator[Frame]:
        """Look at the picture every so many ticks; of the ticks between nothing is kept.

        The log of the water is written a little later than the ticks it belongs to, so all of it is read first.
        """
        by_tick: dict[int, list[Entry]] = {}
        events: list[tuple[float, Entry]] = []
        for entry in recording.entries(_TOPICS):
            message = entry.message
            if isinstance(message, Fix | AgentState | Truth):
                if message.tick % self._stride == 0:
                    by_tick.setdefault(message.tick, []).append(entry)
            elif isinstance(message, PortLedger | LinkLedger | LinkEvent):
                events.append((message.t_ns / NS, entry))
        events.sort(key=lambda event: event[0])
        shown_s = max(self._picture.sounds.lasting_s, 2.0 * self._stride * self._tick_s)
        place = 0
        for tick in sorted(by_tick):
            for entry in by_tick.pop(tick):
                self._picture.take(entry.craft, entry.message)
            now_s = self._picture.now_s
            while place < len(events) and events[place][0] <= now_s:
                entry = events[place][1]
                self._picture.take(entry.craft, entry.message)
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
