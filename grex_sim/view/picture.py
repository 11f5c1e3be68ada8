"""What there is to see of a run at a moment: messages go in, frames for the page come out.

A frame holds everything for its moment, so that one that is left out leaves no gap behind.
"""

import math
from collections.abc import Mapping
from typing import Any

from grex_agent.mission import plan_mission
from grex_link.config import Scenario
from grex_link.messages import (
    AgentState,
    Fix,
    LinkEvent,
    LinkLedger,
    Message,
    PortLedger,
    Truth,
)
from grex_link.units import NS
from grex_sim.view.formation import Formation
from grex_sim.view.history import History
from grex_sim.view.scene import scene
from grex_sim.view.sounds import Sounds

#: With more pairs than this the charts show only the worst age each craft has of any mate.
_PAIRS_MAX = 132

Frame = dict[str, Any]


class Picture:
    """Puts a run's messages together; the newest counts, the past is thinned.

    Parameters
    ----------
    scenario : Scenario
        What is run.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        plan = plan_mission(scenario)
        self.scene = scene(scenario, plan)
        self.names = list(scenario.craft)
        #: Those who have a part in the formation: only they are judged.
        self._members = list(plan.craft)
        self.history = History()
        self.sounds = Sounds()
        self._formation = Formation(plan, scenario.score)
        self._entered = False
        self._truth: Truth | None = None
        self._judged: tuple[int, tuple[float, float, float, float]] = (-1, (math.nan,) * 4)
        self._fixes: dict[str, Fix] = {}
        self._states: dict[str, AgentState] = {}
        self._ports: dict[str, PortLedger] = {}
        self._ledger: LinkLedger | None = None
        self.scene["pairs"] = self.pairs

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Who knows whom: the columns of the ages; empty where there are too many."""
        pairs = [(own, mate) for own in self.names for mate in self.names if own != mate]
        return pairs if len(pairs) <= _PAIRS_MAX else []

    @property
    def truth(self) -> Truth | None:
        """The newest true poses."""
        return self._truth

    @property
    def now_s(self) -> float:
        """Mission time of the newest true poses, seconds."""
        return 0.0 if self._truth is None else self._truth.t_ns / NS

    @property
    def places(self) -> dict[str, tuple[float, float]]:
        """Where the craft are, north and east, metres."""
        truth = self._truth
        return {} if truth is None else {pose.craft: (pose.north_m, pose.east_m) for pose in truth.poses}

    def take(self, craft: str, message: Message) -> None:
        """Take a message of one of the kinds that are drawn; others are no matter."""
        if isinstance(message, Truth):
            self._truth = message
        elif isinstance(message, Fix):
            self._fixes[craft] = message
        elif isinstance(message, AgentState):
            self._states[craft] = message
        elif isinstance(message, LinkEvent):
            self.sounds.on_event(message, self.places)
        elif isinstance(message, LinkLedger):
            self._ledger = message
        elif isinstance(message, PortLedger):
            self._ports[craft] = message

    def frame(self, since_s: float | None = None) -> Frame:
        """Return what there is to see now, and remember it for the charts.

        Parameters
        ----------
        since_s : float or None
            Messages that have ended since this mission time are in it.
        """
        fd = self._deviation()
        now_s = self.now_s
        craft = {name: self._craft(name) for name in self.names}
        row = self._row(fd)
        if self._truth is not None:
            self.history.add(now_s, row)
        return {"t": now_s, "fd": fd, "craft": craft, "row": row, "sounds": self.sounds.shown(now_s, since_s)}

    def past(self) -> dict[str, Any]:
        """Return the history for the charts: names of the columns, and the columns, that of time first."""
        return {"names": self.columns(), "columns": self.history.columns()}

    def notes(self) -> dict[str, dict[str, Any]]:
        """Return counters for the health table, by place on the bus."""
        notes: dict[str, dict[str, Any]] = {name: self._agent_notes(name) for name in self.names}
        notes["link"] = {name: count for name, count in self.sounds.counts.items() if count}
        if self._ledger is not None:
            notes["link"] = {
                "sent": sum(source.started + source.by_land for source in self._ledger.sources),
                "delivered": sum(path.delivered for path in self._ledger.paths),
                "lost": sum(sum(path.lost.values()) for path in self._ledger.paths),
            }
        return notes

    def columns(self) -> list[str]:
        """Return the names of the history's columns, after that of time."""
        ages = [f"age/{own}/{mate}" for own, mate in self.pairs] or [f"age/{name}" for name in self.names]
        return [
            "fd", "fd/distance", "fd/angle", "fd/cross-track",
            *(f"theta/{name}" for name in self.names), *(f"xte/{name}" for name in self.names), *ages,
            *(f"{axis}/{name}" for name in self.names for axis in ("north", "east")),
        ]  # fmt: skip

    # -- inside -----------------------------------------------------------------------------------------------------

    def _deviation(self) -> tuple[float, float, float, float]:
        truth = self._truth
        if truth is None or [pose.craft for pose in truth.poses] != self.names:
            return (math.nan,) * 4
        if truth.tick != self._judged[0]:
            if not self._entered and truth.tick > 0:
                if not self._states.keys() >= set(self._members):
                    return (math.nan,) * 4  # who comes later must first be told on which tracks they are
                self._formation.take_up([self._states[name].track for name in self._members])
            self._entered = True
            poses = {pose.craft: pose for pose in truth.poses}
            places = [(poses[name].north_m, poses[name].east_m) for name in self._members]
            self._judged = truth.tick, self._formation.deviation(places)
        return self._judged[1]

    def _craft(self, name: str) -> dict[str, Any]:
        """Describe a craft; beliefs are of the agent, ``true`` is of the sea."""
        shown: dict[str, Any] = {}
        if self._truth is not None:
            for pose in self._truth.poses:
                if pose.craft == name:
                    shown["true"] = _short(pose.north_m, pose.east_m, pose.down_m, pose.heading_rad, pose.surge_mps)
        if fix := self._fixes.get(name):
            shown["own"] = _short(fix.north_m, fix.east_m, fix.sigma_m)
            shown["fix"] = "" if fix.valid else fix.reason or "not valid"
        if state := self._states.get(name):
            shown.update(
                track=state.track,
                theta=_round(state.theta),
                xte=_round(state.xte_m),
                planned=_round(state.planned_mps),
                ordered=_round(state.ordered_mps),
                health=state.health,
                mates={
                    mate.craft: _short(mate.north_m, mate.east_m, mate.progress, mate.sigma_m, mate.age_s)
                    for mate in state.mates
                },
            )
        return shown

    def _row(self, fd: tuple[float, ...]) -> list[float]:
        """Return the history's columns at this moment; see `columns`."""
        states = [self._states.get(name) for name in self.names]
        progress = [math.nan if state is None else state.track + state.theta for state in states]
        known = [value for value in progress if not math.isnan(value)]
        mean = sum(known) / len(known) if known else math.nan
        ages = {
            name: {mate.craft: mate.age_s for mate in state.mates if mate.age_s >= 0.0}
            for name, state in self._states.items()
        }
        return [
            *map(_round, fd),
            *(_round(value - mean) for value in progress),
            *(math.nan if state is None else _round(state.xte_m) for state in states),
            *self._ages(ages),
            *(_round(value) for name in self.names for value in self.places.get(name, (math.nan, math.nan))),
        ]

    def _ages(self, ages: Mapping[str, Mapping[str, float]]) -> list[float]:
        if pairs := self.pairs:
            return [_round(ages.get(own, {}).get(mate, math.nan)) for own, mate in pairs]
        return [_round(max(ages.get(name, {}).values(), default=math.nan)) for name in self.names]

    def _agent_notes(self, name: str) -> dict[str, Any]:
        notes: dict[str, Any] = {}
        if state := self._states.get(name):
            if state.health:
                notes["health"] = ", ".join(state.health)
            if state.bad_frames:
                notes["bad frames"] = state.bad_frames
        if port := self._ports.get(name):
            notes["sent"] = port.started
            notes["refused"] = sum(port.refused.values()) + sum(port.failed.values())
        return notes


def _round(value: float) -> float:
    """Leave out digits that nobody can see; what is no number stays none."""
    return round(value, 4) if math.isfinite(value) else math.nan


def _short(*values: float) -> list[float]:
    return [_round(value) for value in values]
