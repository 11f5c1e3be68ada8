"""Who takes part in a run, whether it is alive, and whether it says as much as the table of topics wants."""

from collections import Counter, deque
from collections.abc import Mapping, Sequence
from typing import Any

from grex_link.config import Scenario
from grex_link.topics import TOPICS, craft_of, frontseat_place, modem_place

_RATE_OVER_S = 5.0


class Health:
    """The health table.

    Wall times come in as arguments. A participant that goes before the run is over is lost; one that goes afterwards
    has ended.
    """

    def __init__(self) -> None:
        self._seen: dict[str, bool] = {}
        self._state: dict[str, str] = {}
        self._heard_at: dict[str, float] = {}
        self._counts: Counter[tuple[str, str]] = Counter()
        self._marks: deque[tuple[float, Counter[tuple[str, str]]]] = deque()
        self.over = False

    def on_presence(self, who: str, *, alive: bool) -> None:
        """Take that somebody has come or gone."""
        if alive:
            self._state[who] = "alive"
        elif self._state.get(who) != "lost":
            self._state[who] = "ended" if self.over else "lost"

    def on_fault(self, who: str) -> None:
        """Take that it was this one who broke off the run."""
        self._state[who] = "lost"

    def everybody_gone(self) -> None:
        """Take that the bus itself is gone: whoever was alive has ended, or is out of sight."""
        for who, state in self._state.items():
            if state == "alive":
                self._state[who] = "ended" if self.over else "unseen"

    def heard(self, topic: str, craft: str, wall_s: float) -> None:
        """Count a message."""
        self._counts[topic, craft] += 1
        self._heard_at[craft if topic in _SAID_BY_AGENT else _writer(topic)] = wall_s

    def rates(self, wall_s: float) -> dict[tuple[str, str], float]:
        """Return messages a wall second by topic and craft, over the last few seconds."""
        if not self._marks or wall_s - self._marks[-1][0] >= 0.5:
            self._marks.append((wall_s, self._counts.copy()))
        while len(self._marks) > 2 and wall_s - self._marks[1][0] >= _RATE_OVER_S:
            self._marks.popleft()
        then_s, before = self._marks[0]
        lasting_s = wall_s - then_s
        if lasting_s <= 0.0:
            return {}
        return {name: (count - before[name]) / lasting_s for name, count in self._counts.items()}

    def table(
        self, scenario: Scenario, everybody: Sequence[str], wall_s: float, notes: Mapping[str, dict[str, Any]]
    ) -> list[dict[str, Any]]:
        """Return one row a participant.

        Parameters
        ----------
        scenario : Scenario
            Its pace and tick say how often a topic of every tick should come.
        everybody : sequence of str
            Places of who should be there.
        wall_s : float
            Now.
        notes : mapping
            Counters by place.
        """
        rates = self.rates(wall_s)
        clock = scenario.clock
        wanted_hz = None if clock.lockstep else clock.factor / clock.tick_s
        rows = []
        for who in ["sim", *everybody]:
            heard_at = self._heard_at.get(who)
            said: dict[str, float] = {}
            for (name, craft), hz in rates.items():
                if _said_by(who, name, craft) and (hz > 0.0 or TOPICS[name].rate == "tick"):
                    said[name] = min(hz, said.get(name, hz))  # of all craft, the one that gets least
            rows.append(
                {
                    "who": who,
                    "role": _role(who),
                    "state": self._state.get(who, "missing"),
                    "silent_s": None if heard_at is None else round(max(0.0, wall_s - heard_at), 1),
                    "rates": {
                        name: [round(hz, 2), wanted_hz if TOPICS[name].rate == "tick" else None]
                        for name, hz in sorted(said.items())
                    },
                    "notes": notes.get(who, {}),
                }
            )
        return rows


_SAID_BY_AGENT = frozenset(name for name, topic in TOPICS.items() if "agent" in topic.writers)


def _writer(topic: str) -> str:
    return "link" if "link" in TOPICS[topic].writers else "sim"


def _said_by(who: str, topic: str, craft: str) -> bool:
    writers = TOPICS[topic].writers
    if who in {"sim", "link"}:
        return who in writers
    return craft == craft_of(who) and _role(who) in writers


def _role(who: str) -> str:
    if who in {"sim", "link"}:
        return who
    craft = craft_of(who)
    return "modem" if who == modem_place(craft) else "frontseat" if who == frontseat_place(craft) else "agent"
