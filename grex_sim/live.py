"""The live and scaled paces: mission time runs with the wall clock, and nothing waits for anyone.

What does not keep up is counted and reported, never hidden: ticks of the sea that came late, and setpoints that came
after the tick they were for.
"""

from typing import Any

from grex_agent.mission import TeamPlan
from grex_link import clock
from grex_link.clock import WallClock
from grex_link.config import Scenario
from grex_link.messages import Clock, LinkReport, Setpoint
from grex_link.node import Outlet
from grex_sim.hub import Hub, Progress
from grex_sim.logbook import Logbook

_LEAD_NS = 300_000_000


class LiveHub(Hub):
    """The simulator's node at a pace bound to the wall clock; see the module's docstring and `Hub`."""

    def __init__(
        self, scenario: Scenario, plan: TeamPlan, outlet: Outlet, logbook: Logbook, progress: Progress
    ) -> None:
        super().__init__(scenario, plan, outlet, logbook, progress)
        self._pace = scenario.clock.factor
        self._clock: WallClock | None = None
        self._setpoints: dict[str, Setpoint] = {}
        self._stale_after = max(1, round(scenario.team.fix_timeout_s / scenario.clock.tick_s))
        self._due_tick = 0

    def _start(self) -> None:
        # A moment ahead, so that everybody knows the time before it begins.
        epoch = clock.unix_ns() + _LEAD_NS
        self._clock = WallClock(self._pace, epoch)
        for who in self._everybody:
            self._outlet.put("clock", who, Clock("start", epoch))

    def _on_setpoint(self, craft: str, message: Setpoint) -> None:
        if message.tick < self._sea.tick:
            self._logbook.late_setpoints += 1
        newest = self._setpoints.get(craft)
        if newest is None or message.tick >= newest.tick:
            self._setpoints[craft] = message

    def _wall_s_to_next(self) -> float | None:
        return None if self._clock is None else self._clock.wall_s_until(self._due_tick * self._tick_ns)

    def _on_time(self) -> None:
        if self._clock is None:
            return
        behind_ns = self._clock.now_ns() - self._due_tick * self._tick_ns
        if behind_ns < 0:
            return
        if behind_ns > self._tick_ns // 2:
            self._logbook.late_ticks += 1
        if self._due_tick:
            fresh = {
                craft: setpoint
                for craft, setpoint in self._setpoints.items()
                if self._sea.tick - setpoint.tick < self._stale_after
            }
            self._sea.advance(fresh)
            self._logbook.setpoints(fresh, self._team)
            self._logbook.adrift(self._sea.adrift)
        self._logbook.truth(self._sea.truth)
        self._due_tick += 1
        if self._sea.tick >= self._last_tick:
            self.say_goodbye()
            return
        self._outlet.put("truth", "", self._sea.truth)
        self._publish_fixes([0] * len(self._team))
        self._write_and_tell()

    def _on_report(self, report: LinkReport) -> None:
        end_ns = self._last_tick * self._tick_ns
        self._logbook.link_events([event for event in report.log if event.t_ns < end_ns])

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message; a tick that is due comes first."""
        super().handle(topic, craft, message)
        if self.started and not self.done and self._wall_s_to_next() == 0.0:
            self._on_time()
