"""The adapter as a node of the bus: between ``setpoint`` and ``fix`` on one side and the line to the autopilot.

One thread, one loop: the line is looked at whenever the bus is quiet, so heartbeats come from the loop that does the
work, and stop when it does. Fixes are those of the ticks of mission time, carried there from when they were measured.
"""

from typing import Any

from grex_agent.frontseat.connection import Connection
from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.outputs import Note, Output
from grex_link import clock, log
from grex_link.bus import ZenohBus
from grex_link.clock import WallClock
from grex_link.config import Scenario
from grex_link.craft_clock import CraftClock
from grex_link.errors import FaultError, GrexError
from grex_link.messages import Clock, Fix, Presence
from grex_link.node import Outlet
from grex_link.units import NS, tick_ns

#: The line is looked at this often, wall seconds.
_POLL_S = 0.01
#: Wall seconds the autopilot has to say that it holds.
_HAND_BACK_S = 2.2
_SPARE_S = 1.0
#: Whoever waits for an autopilot says so this often, wall seconds.
_CALL_S = 10.0


class Frontseat:
    """One craft's adapter on the bus: reads ``setpoint`` and ``nav``, writes ``fix``.

    Parameters
    ----------
    scenario : Scenario
        The run.
    craft : str
        Which craft this is.
    outlet : Outlet
        The bus.
    connection : Connection
        The line to the autopilot; open.
    core : FrontseatCore
        What knows MAVLink.
    """

    def __init__(
        self, scenario: Scenario, craft: str, outlet: Outlet, connection: Connection, core: FrontseatCore
    ) -> None:
        self.done = self.started = False
        self._craft = craft
        self._outlet = outlet
        self._connection = connection
        self._core = core
        self._url = scenario.mavlink_craft[craft].url
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._pace = scenario.clock.factor
        self._craft_clock = CraftClock(scenario.craft[craft].clock)
        self._clock: WallClock | None = None
        self._tick = -1
        self._bye: Clock | None = None

    @property
    def waits_for(self) -> str:
        """What is missing before the mission may start; empty when nothing is."""
        missing = self._core.waits_for(_now_ns())
        if self._core.peer is not None or self._core.fault:
            return missing
        if self._connection.unsigned:
            return "messages come, but none is signed with our key; is signing_key_file the autopilot's?"
        if self._connection.trouble:
            return f"no autopilot on {self._url}: {self._connection.trouble}"
        return missing

    @property
    def calls(self) -> str:
        """Whom it waits for while nobody has answered, for the log; empty once an autopilot has been heard."""
        if self._core.peer is not None:
            return ""
        trouble = self._connection.trouble
        return f"waiting for an autopilot on {self._url}" + (f": {trouble}" if trouble else "")

    @property
    def may_come(self) -> bool:
        """Whether what is missing may come with time; a datum does not move."""
        return self._core.peer is None or not self._core.peer.navigation.misplaced

    @property
    def fault(self) -> str:
        """Why this can never work; empty when all is well."""
        return self._core.fault or (self._core.peer.muted if self._core.peer else "")

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message from the bus."""
        del craft
        if topic == "setpoint":
            self._take(self._core.on_setpoint(message, _now_ns()))
        elif topic == "nav":
            self._take(self._core.on_navigation(message, _now_ns()))
        elif topic == "clock":
            self._on_clock(message)
        elif topic == "presence":
            self._on_presence(message)
        self.on_deadline()

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until the line is looked at again."""
        if self._clock is None:
            return _POLL_S
        return min(_POLL_S, self._clock.wall_s_until((self._tick + 1) * self._tick_ns))

    def on_deadline(self) -> None:
        """Read, do what is due, and tell the agent where the craft is when a tick has come."""
        self.exchange()
        if self._clock is not None and self._bye is None:
            now_ns = self._clock.now_ns()
            if (tick := now_ns // self._tick_ns) > self._tick:
                self._publish(tick, (now_ns - tick * self._tick_ns) / (self._pace * NS))
        if self._bye is not None:
            self._end(self._bye)

    def in_idle_time(self) -> bool:
        """Nothing here can wait."""
        return False

    def exchange(self) -> None:
        """Read what the autopilot has said, and say what is due."""
        for message in self._connection.receive():
            self._take(self._core.on_message(message, _now_ns()))
        self._connection.target = self._core.target_system
        self._take(self._core.on_time(_now_ns()))

    def hand_back(self) -> None:
        """Give the craft back to its autopilot, holding, and wait for it to say so; at once if it has been done."""
        if self._core.released:
            return
        self._take(self._core.release(_now_ns()))
        give_up_s = clock.monotonic_s() + _HAND_BACK_S
        while not self._core.released and clock.monotonic_s() < give_up_s:
            clock.sleep_s(_POLL_S)
            self.exchange()
        self._say_how_it_ended()

    # -- the line -----------------------------------------------------------------------------------------------

    def _take(self, out: list[Output]) -> None:
        for item in out:
            if isinstance(item, Note):
                (log.warn if item.level == "warn" else log.info)(item.text)
            else:
                self._connection.send(item)

    # -- the bus ------------------------------------------------------------------------------------------------

    def _publish(self, tick: int, late_s: float) -> None:
        self._tick = tick
        now_ns = _now_ns()
        found = self._core.estimate(now_ns - round(late_s * NS), now_ns)
        true_ns = tick * self._tick_ns
        self._craft_clock.see(true_ns, found.down_m)
        fix = Fix(
            tick,
            self._craft_clock.local_ns(true_ns),
            found.north_m,
            found.east_m,
            found.down_m,
            found.heading_rad,
            found.speed_mps,
            found.sigma_m,
            valid=found.valid,
            reason=found.reason,
        )
        self._outlet.put("fix", self._craft, fix)

    def _on_clock(self, message: Clock) -> None:
        if message.phase == "bye":
            self._bye = message
            return
        self.started = True
        self._clock = WallClock(self._pace, message.epoch_unix_ns)
        # The agent has spoken for the first tick before that has come; the next word is due a tick later.
        first_s = self._clock.wall_s_until(self._tick_ns)
        self._take(self._core.on_start(_now_ns() + round(first_s * NS)))
        # The bench wants to know where the craft is before the first tick.
        self._publish(0, 0.0)

    def _end(self, bye: Clock) -> None:
        self.hand_back()
        self.done = True
        if bye.reason:
            raise GrexError(f"sim ended the run: {bye.reason}")

    def _on_presence(self, message: Presence) -> None:
        if message.who == "sim" and not message.alive and not self.done and self._bye is None:
            now_s = None if self._clock is None else self._clock.now_ns() / NS
            raise FaultError("sim", "left the bus without saying goodbye", now_s)

    def _say_how_it_ended(self) -> None:
        peer = self._core.peer
        if peer is None:
            return
        mode = peer.family.mode_name(peer.control.mode)
        state = "armed" if peer.control.armed else "disarmed"
        if self._core.released:
            log.info(f"the craft is with its autopilot, in {mode}, {state}")
        else:
            log.warn(f"the autopilot has not said that it holds; it was last in {mode}, {state}: look after it")


def prepare(bus: ZenohBus, node: Frontseat, patience_s: float) -> None:
    """Let the autopilot get ready: heard, position valid and, where that is allowed, in its mode and armed.

    Parameters
    ----------
    bus : ZenohBus
        Where the run may be called off meanwhile.
    node : Frontseat
        The adapter.
    patience_s : float
        Wall seconds it may take.

    Raises
    ------
    GrexError
        Says what is missing when the time is over, or what will never do.
    """
    call_at_s = clock.monotonic_s()
    give_up_s = call_at_s + max(patience_s - _SPARE_S, _SPARE_S)
    while (missing := node.waits_for) and not node.done:
        if node.fault:
            raise GrexError(node.fault)
        if clock.monotonic_s() >= call_at_s and (words := node.calls):
            call_at_s += _CALL_S
            log.info(words)
        if clock.monotonic_s() > give_up_s:
            more = "; or raise start_timeout_s" if node.may_come else ""
            raise GrexError(f"the autopilot is not ready after {patience_s:g} s: {missing}{more}")
        envelope = bus.take(node.wall_s_to_deadline())
        if envelope is None:
            node.on_deadline()
        else:
            node.handle(*envelope)


def _now_ns() -> int:
    return round(clock.monotonic_s() * NS)
