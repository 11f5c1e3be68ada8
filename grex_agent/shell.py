"""The agent as a node of the bus: collects what a step needs, then lets the core do it."""

from typing import Any

from grex_agent.base import BaseCore
from grex_agent.core import AgentCore
from grex_agent.team.interface import needs_oracle
from grex_link.clock import WallClock
from grex_link.config import Scenario
from grex_link.errors import FaultError, GrexError
from grex_link.messages import AgentState, AgentStates, Clock, Fix, ModemEvent, Presence, TaskNews, TaskOrder, Truth
from grex_link.node import Outlet
from grex_link.units import NS

#: In lockstep a bundle lasts milliseconds, and a message less a step is a tenth of the whole cost.
_BUNDLE = 10


class Agent:
    """One craft's agent on the bus.

    In lockstep a step is done when the fix, every modem event it counts and, for the ideal estimator, the truth of
    that tick are here, in whatever order they come. At the live paces it is done when a fix comes or is overdue.

    Parameters
    ----------
    scenario : Scenario
        The run.
    craft : str
        Which craft this is.
    outlet : Outlet
        The bus.
    """

    def __init__(self, scenario: Scenario, craft: str, outlet: Outlet) -> None:
        self.done = self.started = False
        self._core = (AgentCore if scenario.craft[craft].base is None else BaseCore)(scenario, craft)
        self._craft = craft
        self._outlet = outlet
        self._lockstep = scenario.clock.lockstep
        self._pace = scenario.clock.factor
        self._needs_truth = needs_oracle(scenario)
        self._fix: Fix | None = None
        self._truth: Truth | None = None
        self._events: dict[int, ModemEvent] = {}
        self._events_taken = 0
        self._states: list[AgentState] = []
        self._bundle = _BUNDLE if self._lockstep else 1
        self._clock: WallClock | None = None
        #: How far the craft's clock is ahead of the wall's, as the last fix showed.
        self._ahead_ns = 0
        self._overdue_ns = round(scenario.team.fix_timeout_s * NS)
        self._next_alarm_ns = self._overdue_ns
        self._tick = -1
        self._now_ns: int | None = None

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message from the bus."""
        del craft
        if topic == "fix":
            self._fix = message
            self._step_if_complete()
        elif topic == "modem_rx":
            self._events[message.seq] = message
            self._step_if_complete()
        elif topic == "oracle":
            self._truth = message
            self._step_if_complete()
        elif topic == "task":
            self._on_order(message)
        elif topic == "clock":
            self._on_clock(message)
        elif topic == "presence":
            self._on_presence(message)

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until the next fix is overdue; live paces only."""
        return None if self._clock is None else self._clock.wall_s_until(self._next_alarm_ns)

    def on_deadline(self) -> None:
        """Step without a fix: the core holds the craft and says so."""
        if self._clock is not None and (now_ns := self._clock.now_ns()) >= self._next_alarm_ns:
            self._tick += 1
            self._step(self._tick, now_ns + self._ahead_ns)

    def in_idle_time(self) -> bool:
        """Nothing here can wait."""
        return False

    def _step_if_complete(self) -> None:
        fix = self._fix
        if fix is None or (self._needs_truth and (self._truth is None or self._truth.tick != fix.tick)):
            return
        if self._lockstep and any(seq not in self._events for seq in range(self._events_taken, fix.modem_events)):
            return
        for seq in range(self._events_taken, fix.modem_events) if self._lockstep else sorted(self._events):
            self._core.on_modem(self._events.pop(seq))
        self._events_taken = fix.modem_events
        if self._needs_truth and self._truth is not None:
            self._core.on_truth(self._truth)
        self._core.on_fix(fix)
        self._fix = None
        if self._clock is not None:
            self._ahead_ns = fix.t_ns - self._clock.now_ns()
        self._step(fix.tick, fix.t_ns)

    def _step(self, tick: int, now_ns: int) -> None:
        """Let the core step at a time by the craft's clock; the alarm for the next fix is by the wall clock."""
        self._tick, self._now_ns = tick, now_ns
        if self._clock is not None:
            self._next_alarm_ns = self._clock.now_ns() + self._overdue_ns
        for topic, message in self._core.step(tick, now_ns):
            if isinstance(message, AgentState):
                self._states.append(message)
                if len(self._states) >= self._bundle:
                    self._send_states()
            else:
                self._outlet.put(topic, self._craft, message)

    def _send_states(self) -> None:
        if self._states:
            self._outlet.put("state", self._craft, AgentStates(self._states))
            self._states = []

    def _on_order(self, order: TaskOrder) -> None:
        """Take an order of the operator, or refuse it."""
        if self._lockstep:  # where it would come at no certain step
            why = "this run is in lockstep; run it at a pace of the wall clock, or put an event into the scenario"
        elif isinstance(self._core, BaseCore):
            why = f"{self._craft} is a base, which takes no orders; give it to a craft"
        elif not self._core.takes_orders:
            why = "with the shared reference nobody can leave the formation; run it with controller theta_p"
        else:
            self._core.on_order(order)
            return
        news = TaskNews(self._now_ns or 0, order.order, order.craft, order.task, "refused", why)
        self._outlet.put("task_news", self._craft, news)

    def _on_clock(self, message: Clock) -> None:
        if message.phase == "bye":
            self._send_states()
            if self._now_ns is not None:
                self._outlet.put("port", self._craft, self._core.ledger(self._now_ns))
            self.done = True
            if message.reason:
                raise GrexError(f"sim ended the run: {message.reason}")
            return
        self.started = True
        if not self._lockstep:
            self._clock = WallClock(self._pace, message.epoch_unix_ns)

    def _on_presence(self, message: Presence) -> None:
        """Without the simulator a lockstep run is over; at a live pace the craft goes on and its fixes become stale."""
        if message.who == "sim" and not message.alive and self._lockstep and not self.done:
            now_s = None if self._now_ns is None else self._now_ns / NS
            raise FaultError("sim", "left the bus without saying goodbye", now_s)
