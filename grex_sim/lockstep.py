"""Lockstep by synchronous dataflow: a tick is complete when everybody knows that it has all its inputs.

One tick::

    hub    Fix k (with the number of modem events to wait for) ─────────► every agent
    agent  waits for those events, steps, ─ Transmit…, Setpoint k (with the number of transmissions) ─► hub
    hub    has all Setpoints k: moves the craft, and hands the complete ticks to the link in windows
    link   waits for the transmissions counted, runs the medium, ─ ModemEvents ─► agents, ─ LinkReport ─► hub

A transmission at t causes no modem event before t + lookahead (`Medium.lookahead_ns`), so the hub may run D ticks ahead
of the link, D·tick < lookahead; the link is off the critical path. Nothing here reads a clock to decide anything: any
scheduling of any number of processes gives the same result.
"""

import heapq

from grex_agent.mission import TeamPlan
from grex_link import clock
from grex_link.config import Scenario
from grex_link.errors import FaultError
from grex_link.medium import make_medium
from grex_link.messages import Advance, Clock, LinkReport, Setpoint, Step
from grex_link.node import Outlet
from grex_sim.hub import Hub, Progress
from grex_sim.logbook import Logbook


class LockstepHub(Hub):
    """The simulator's node in lockstep; see the module's docstring and `Hub`."""

    def __init__(
        self, scenario: Scenario, plan: TeamPlan, outlet: Outlet, logbook: Logbook, progress: Progress
    ) -> None:
        super().__init__(scenario, plan, outlet, logbook, progress)
        self._ahead = max(0, -(-make_medium(scenario).lookahead_ns // self._tick_ns) - 1)
        self._window = max(1, (self._ahead + 1) // 2)
        self._setpoints: dict[str, Setpoint] = {}
        self._steps: list[Step] = []
        self._reported_through = -1
        self._due_ns: list[list[int]] = [[] for _ in self._team]
        self._due_counts = [0] * len(self._team)
        self._waiting_for_link = False
        self._heard_at = 0.0

    def _start(self) -> None:
        for who in self._everybody:
            self._outlet.put("clock", who, Clock("start"))
        self._logbook.truth(self._sea.truth)
        self._publish()

    def _on_setpoint(self, craft: str, message: Setpoint) -> None:
        if message.tick != self._sea.tick:
            raise FaultError(f"agent {craft}", f"answered tick {message.tick} at tick {self._sea.tick}", self.now_s)
        self._setpoints[craft] = message
        if len(self._setpoints) == len(self._team):
            self._complete_tick()

    def _complete_tick(self) -> None:
        setpoints = {craft: self._setpoints[craft] for craft in self._team}
        self._setpoints = {}
        self._steps.append(Step(self._sea.truth, [setpoint.transmissions for setpoint in setpoints.values()]))
        self._sea.advance(setpoints)
        over = self._sea.tick >= self._last_tick
        self._go_on()
        # The agents are at work now: the time for the link, and to take things down.
        if len(self._steps) >= self._window or over:
            self._outlet.put("advance", "", Advance(self._steps))
            self._steps = []
        self._logbook.setpoints(setpoints, self._team)
        self._logbook.adrift(self._sea.adrift)
        self._logbook.truth(self._sea.truth)
        self._write_and_tell()
        if over:
            self._finish_if_reported()

    def _go_on(self) -> None:
        """Publish the present tick, unless the link has still to say what arrives in it."""
        tick = self._sea.tick
        if tick >= self._last_tick:
            return
        self._waiting_for_link = self._reported_through < tick - 1 - self._ahead
        if not self._waiting_for_link:
            self._publish()

    def _publish(self) -> None:
        """Publish the fixes of this tick, each with the number of modem events that are due by now."""
        now_ns = self._sea.truth.t_ns
        for place, times in enumerate(self._due_ns):
            while times and times[0] <= now_ns:
                heapq.heappop(times)
                self._due_counts[place] += 1
        self._heard_at = clock.monotonic_s()
        self._publish_fixes(self._due_counts)

    def _on_report(self, report: LinkReport) -> None:
        self._heard_at = clock.monotonic_s()
        self._reported_through = max(self._reported_through, report.through_tick)
        for heap, times in zip(self._due_ns, report.modem_events, strict=True):
            for t_ns in times:
                heapq.heappush(heap, t_ns)
        self._logbook.link_events(report.log)
        if self._waiting_for_link:
            self._go_on()
        self._finish_if_reported()

    def _finish_if_reported(self) -> None:
        if self._sea.tick >= self._last_tick and self._reported_through >= self._last_tick - 1 and not self.done:
            self.say_goodbye()

    def _wall_s_to_next(self) -> float | None:
        # Not the exact time left, which would cost a look at the clock at every message.
        return self._config.barrier_timeout_s

    def _on_time(self) -> None:
        if clock.monotonic_s() - self._heard_at < self._config.barrier_timeout_s:
            return
        waiting = self._waiting_for_link or self._sea.tick >= self._last_tick
        silent = ["link"] if waiting else [f"agent {craft}" for craft in self._team if craft not in self._setpoints]
        raise FaultError(
            ", ".join(silent),
            f"has not answered for {self._config.barrier_timeout_s:g} s of wall time",
            self.now_s,
        )
