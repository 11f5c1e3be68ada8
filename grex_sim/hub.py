"""The simulator as a node of the bus, at every pace: waits for all, starts, takes everything down, ends."""

from collections.abc import Callable
from typing import Any

import msgspec

from grex_agent.mission import TeamPlan
from grex_agent.team.interface import needs_oracle
from grex_link import clock
from grex_link.config import Scenario
from grex_link.errors import BusError, FaultError
from grex_link.messages import Clock, Fix, LinkReport, Presence, RunStatus
from grex_link.node import Outlet
from grex_link.scenario import fingerprint
from grex_link.topics import craft_of, frontseat_place, modem_place
from grex_link.units import NS, tick_ns
from grex_sim.logbook import Logbook
from grex_sim.sea import Sea

#: Called now and then with the mission time, seconds.
Progress = Callable[[float], None]
_PROGRESS_S = 0.2
_STATUS_S = 1.0


class Hub:
    """Common part of the simulator's nodes; `LockstepHub` and `LiveHub` say when a tick happens.

    Parameters
    ----------
    scenario : Scenario
        The run.
    plan : TeamPlan
        The plan of the team.
    outlet : Outlet
        The bus.
    logbook : Logbook
        Where everything is taken down.
    progress : callable
        Told the mission time now and then.
    """

    def __init__(
        self, scenario: Scenario, plan: TeamPlan, outlet: Outlet, logbook: Logbook, progress: Progress
    ) -> None:
        self.done = False
        self.started_at: float | None = None
        self._outlet = outlet
        self._team = list(scenario.craft)
        modems = [modem_place(craft) for craft in scenario.serial_craft]
        frontseats = [frontseat_place(craft) for craft in scenario.mavlink_craft]
        self._everybody = [*self._team, *modems, *frontseats, "link"]
        self._fingerprint = fingerprint(scenario)
        self._present: set[str] = set()
        self._config = scenario.clock
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._last_tick = max(1, round((scenario.duration_s or plan.duration_s) / scenario.clock.tick_s))
        self._oracle = needs_oracle(scenario)
        self._sea = Sea(scenario, plan)
        self._simulated = self._sea.simulated
        self._logbook = logbook
        self._progress = progress
        self._progress_at = 0.0
        self._status_at = 0.0
        self._scenario = msgspec.json.encode(scenario).decode()
        self.opened_at = clock.monotonic_s()
        self._start_by = self.opened_at + scenario.clock.start_timeout_s

    @property
    def now_s(self) -> float:
        """Mission time, seconds."""
        return self._sea.truth.t_ns / NS

    @property
    def end_ns(self) -> int:
        """Mission time of the last tick, nanoseconds."""
        return self._last_tick * self._tick_ns

    @property
    def started(self) -> bool:
        """Whether the mission has started."""
        return self.started_at is not None

    @property
    def present(self) -> frozenset[str]:
        """Who is on the bus now."""
        return frozenset(self._present)

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message from the bus."""
        if topic == "presence":
            self._on_presence(message)
        elif topic == "report":
            if self.done:  # the link's last words
                self._logbook.link_events([event for event in message.log if event.t_ns < self.end_ns])
            else:
                self._on_report(message)
        elif topic == "ledger":
            self._logbook.message(topic, craft, message)
        elif topic == "fix":
            # Those of the simulated craft come from here.
            if craft in self._sea.external:
                self._on_external_fix(craft, message)
        elif craft in self._team:
            self._logbook.message(topic, craft, message)
            if topic == "setpoint" and not self.done:
                self._on_setpoint(craft, message)

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until `on_deadline` wants to be called."""
        if not self.started:
            return max(0.0, self._start_by - clock.monotonic_s())
        return self._wall_s_to_next()

    def on_deadline(self) -> None:
        """Name those who have not appeared, or let the pace do its part."""
        if self.started:
            self._on_time()
        elif clock.monotonic_s() >= self._start_by:
            missing = ", ".join(sorted(self._name(who) for who in set(self._everybody) - self._present))
            raise BusError(f"not everybody is on the bus after {self._config.start_timeout_s:g} s; missing: {missing}")

    def in_idle_time(self) -> bool:
        """Write some of what has been taken down."""
        return self._logbook.write_some()

    def say_goodbye(self, reason: str = "") -> None:
        """Tell everybody that the mission is over, and why if that is before its time."""
        for who in self._everybody:
            self._outlet.put("clock", who, Clock("bye", reason=reason, t_ns=self._sea.truth.t_ns))
        self.done = True

    # -- for the paces --------------------------------------------------------------------------------------------

    def _start(self) -> None:
        raise NotImplementedError

    def _on_setpoint(self, craft: str, message: Any) -> None:
        raise NotImplementedError

    def _wall_s_to_next(self) -> float | None:
        raise NotImplementedError

    def _on_time(self) -> None:
        raise NotImplementedError

    def _on_report(self, report: LinkReport) -> None:
        raise NotImplementedError

    def _publish_fixes(self, modem_events: list[int]) -> None:
        truth = self._sea.truth
        for craft in self._team if self._oracle else ():
            self._outlet.put("oracle", craft, truth)
        for craft, fix in zip(self._simulated, self._sea.fixes(modem_events), strict=True):
            self._outlet.put("fix", craft, fix)
            self._logbook.message("fix", craft, fix)

    def _on_external_fix(self, craft: str, fix: Fix) -> None:
        self._sea.external[craft].on_fix(fix, fix.tick * self._tick_ns)
        if not self.done:
            self._logbook.message("fix", craft, fix)

    def _write_and_tell(self) -> None:
        """Write what has passed and tell how far we are; done while the agents are busy with the next tick."""
        now = clock.monotonic_s()
        self._logbook.write_if_due(now)
        if now >= self._progress_at:
            self._progress_at = now + _PROGRESS_S
            self._progress(self.now_s)
        if now >= self._status_at:
            self._status_at = now + _STATUS_S
            self._tell_status()

    def _tell_status(self) -> None:
        """Tell whoever watches; nobody who takes part reads it."""
        late_ticks, late_setpoints = self._logbook.late_ticks, self._logbook.late_setpoints
        status = RunStatus(self._sea.truth.t_ns, self._scenario, self._everybody, late_ticks, late_setpoints)
        self._outlet.put("status", "", status)

    # -- presence -------------------------------------------------------------------------------------------------

    def _on_presence(self, presence: Presence) -> None:
        who = presence.who
        if who not in self._everybody:
            return
        if presence.alive:
            if presence.scenario != self._fingerprint:
                raise BusError(f"{self._name(who)} runs another scenario; start all with the same file and overrides")
            self._present.add(who)
            if not self.started and self._present == set(self._everybody):
                self.started_at = clock.monotonic_s()
                self._start()
            return
        self._present.discard(who)
        if self.started and not self.done:
            raise FaultError(self._name(who), "left the bus (killed, stopped or cut off)", self.now_s)

    @staticmethod
    def _name(who: str) -> str:
        if who == "link":
            return "link"
        craft = craft_of(who)
        role = "agent" if craft == who else "modem" if who == modem_place(craft) else "frontseat"
        return f"{role} {craft}"
