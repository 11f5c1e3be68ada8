"""The link process's node: feeds the medium with requests and poses, hands out what comes of them."""

from collections import deque
from typing import Any

from grex_link import log
from grex_link.clock import WallClock
from grex_link.config import Scenario
from grex_link.craft_clock import TeamClocks
from grex_link.errors import FaultError, GrexError
from grex_link.ledger import Ledger
from grex_link.medium import Due, make_medium
from grex_link.messages import Advance, Clock, LinkEvent, LinkReport, ModemEvent, Presence, Request, Step, Truth
from grex_link.node import Outlet
from grex_link.units import NS, tick_ns

#: Wall seconds; from a fix to the requests of an agent it takes a few milliseconds.
_BEHIND_S = 0.01


class Emulator:
    """The link as a node of the bus.

    In lockstep it works through complete ticks as the hub hands them over: it waits until it has every transmission
    that was counted, sorts them, and reports which modem events have become final. At the live paces it takes requests
    as they come and hands out events when their time has come. At every pace it publishes the ledger of the water every
    ``link.ledger_s`` of mission time, but not oftener than every tick, and at the end.

    Parameters
    ----------
    scenario : Scenario
        The run.
    outlet : Outlet
        The bus.
    """

    def __init__(self, scenario: Scenario, outlet: Outlet) -> None:
        self.done = self.started = False
        self._outlet = outlet
        self._medium = make_medium(scenario)
        self._clocks = TeamClocks(scenario)
        self._team = list(scenario.craft)
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._config = scenario.clock
        self._elsewhere = frozenset(scenario.serial_craft)
        self._requests: dict[str, dict[int, Request]] = {craft: {} for craft in self._team}
        self._taken = [0] * len(self._team)
        self._steps: list[Step] = []
        self._sent = dict.fromkeys(self._team, 0)
        self._clock: WallClock | None = None
        # At the live paces the water is a moment behind, so that a request for a slot that opens just now is in time.
        self._behind_ns = max(0, round(_BEHIND_S * NS * self._config.factor) - self._medium.lookahead_ns)
        self._truths: deque[Truth] = deque()
        self._ledger = Ledger(self._team)
        self._lines: deque[LinkEvent] = deque()
        """Reported, and not yet in the ledger."""
        self._final_ns = self._mission_ns = 0
        self._ledger_step_ns = max(self._tick_ns, round(scenario.link.ledger_s * NS))
        self._ledger_ns = 0
        """Time of the newest ledger."""

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message from the bus."""
        if topic == "modem_tx":
            self._request(craft, message)
        elif topic == "advance":
            self._advance(message)
        elif topic == "truth":
            if not self._config.lockstep:
                self._truths.append(message)
                self._mission_ns = message.t_ns
                if message.t_ns >= self._ledger_ns + self._ledger_step_ns:
                    self.on_deadline()
        elif topic == "clock":
            self._on_clock(message)
        elif topic == "presence":
            self._on_presence(message)

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until the next modem event is due; live paces only."""
        due_ns = self._medium.next_event_ns()
        return None if self._clock is None or due_ns is None else self._clock.wall_s_until(due_ns + self._behind_ns)

    def on_deadline(self) -> None:
        """Hand out the modem events whose time has come."""
        if self._clock is not None:
            self._work_until(self._clock.now_ns() - self._behind_ns + 1)

    def in_idle_time(self) -> bool:
        """Nothing here can wait."""
        return False

    # -- lockstep -----------------------------------------------------------------------------------------------

    def _advance(self, message: Advance) -> None:
        self._steps += message.steps
        self._work()

    def _work(self) -> None:
        """Work through every tick that is complete, and report once."""
        through = None
        while self._steps and self._complete(self._steps[0]):
            step = self._steps.pop(0)
            self._place(step.truth)
            for craft, request in self._taken_from(step):
                self._medium.request(craft, request, self._clocks.craft[craft].true_ns(request.t_ns))
            through = step.truth
            self._medium.advance(through.t_ns + self._tick_ns)
        if through is not None:
            next_tick_ns = through.t_ns + self._tick_ns
            self._hand_out(through.tick, next_tick_ns + self._medium.lookahead_ns, next_tick_ns)

    def _complete(self, step: Step) -> bool:
        return all(
            seq in self._requests[craft]
            for craft, taken, total in zip(self._team, self._taken, step.transmissions, strict=True)
            for seq in range(taken, total)
        )

    def _taken_from(self, step: Step) -> list[tuple[str, Request]]:
        """Take the requests a tick counts; the medium puts them in order."""
        requests = []
        for place, (craft, total) in enumerate(zip(self._team, step.transmissions, strict=True)):
            requests += [(craft, self._requests[craft].pop(seq)) for seq in range(self._taken[place], total)]
            self._taken[place] = total
        return requests

    # -- both ---------------------------------------------------------------------------------------------------

    def _request(self, craft: str, request: Request) -> None:
        if craft not in self._requests:
            log.warn("a transmission of a craft that is not in the scenario was dropped", craft=craft)
        elif craft in self._elsewhere:
            return
        elif self._config.lockstep:
            self._requests[craft][request.seq] = request
            self._work()
        else:
            self._medium.request(craft, request, self._clocks.craft[craft].true_ns(request.t_ns))
            self.on_deadline()

    def _work_until(self, until_ns: int) -> None:
        """Live paces: work through the water up to a time, with the poses of each moment, and hand out what came."""
        while self._truths and self._truths[0].t_ns < until_ns:
            self._place(self._truths.popleft())
        self._medium.advance(until_ns)
        self._hand_out(-1, until_ns, until_ns)

    def _place(self, truth: Truth) -> None:
        self._clocks.see(truth)
        self._medium.advance(truth.t_ns)
        self._medium.place(truth)

    def _hand_out(self, tick: int, events_before_ns: int, log_before_ns: int) -> None:
        events = self._medium.events(events_before_ns)
        lines = self._medium.log(log_before_ns)
        times: list[list[int]] = [[] for _ in self._team]
        for t_ns, craft, event in events:
            if craft in self._elsewhere:
                continue
            self._publish((t_ns, craft, event))
            times[self._team.index(craft)].append(t_ns)
        if tick >= 0 or lines or events:
            self._outlet.put("report", "", LinkReport(tick, times, lines))
        self._final_ns = log_before_ns
        self._lines += lines
        # The wall clock may have left a mission behind that is late, or over.
        until_ns = log_before_ns if self._clock is None else min(log_before_ns, self._mission_ns)
        while self._ledger_ns + self._ledger_step_ns <= until_ns:
            self._publish_ledger(self._ledger_ns + self._ledger_step_ns)

    def _publish_ledger(self, t_ns: int) -> None:
        """Publish what had happened before a time, whatever has been reported since."""
        while self._lines and self._lines[0].t_ns < t_ns:
            self._ledger.note(self._lines.popleft())
        self._outlet.put("ledger", "", self._ledger.snapshot(t_ns))
        self._ledger_ns = t_ns

    def _publish(self, due: Due) -> None:
        t_ns, craft, event = due
        local_ns = self._clocks.craft[craft].local_ns(t_ns)
        self._outlet.put("modem_rx", craft, ModemEvent(self._sent[craft], local_ns, event))
        self._sent[craft] += 1

    def _on_clock(self, message: Clock) -> None:
        if message.phase == "bye":
            self.done = True
            self._close_ledger(message.t_ns)
            if message.reason:
                raise GrexError(f"sim ended the run: {message.reason}")
            return
        self.started = True
        if not self._config.lockstep:
            self._clock = WallClock(self._config.factor, message.epoch_unix_ns)

    def _close_ledger(self, end_ns: int) -> None:
        """Publish the last ledger: of what is final in lockstep, else of what there was until the mission was over."""
        if self._clock is not None:
            self._work_until(end_ns)
        end_ns = self._final_ns
        if end_ns > self._ledger_ns:
            self._publish_ledger(end_ns)

    def _on_presence(self, message: Presence) -> None:
        if message.who == "sim" and not message.alive and not self.done:
            raise FaultError("sim", "left the bus without saying goodbye", self._now_s())

    def _now_s(self) -> float | None:
        return None if self._clock is None else self._clock.now_ns() / NS
