"""The agent of a base: a modem at a fixed place that listens, ranges, and says where the craft it watches is.

To the bus it is an agent like any other, at every pace. It tells nobody anything, steers nothing, and has no part in
the formation.
"""

from collections.abc import Iterator

from grex_agent.capabilities import check_capabilities, state_form
from grex_agent.messenger import Messenger
from grex_agent.mission import plan_mission
from grex_agent.talk_policy import Periodic
from grex_agent.tell import TeamTalk
from grex_agent.watch import Watch
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import AgentState, Fix, Message, ModemEvent, PortLedger, Setpoint, Truth
from grex_link.profile import load_profile
from grex_link.units import NS, tick_ns
from grex_link.wire import BYTES


class BaseCore:
    """A base's agent, with the methods of `AgentCore`.

    Parameters
    ----------
    scenario : Scenario
        The run.
    craft : str
        Which base this is.

    Raises
    ------
    ConfigError
        If the mission or the slots cannot work, or the modem cannot do what the plan needs.
    """

    def __init__(self, scenario: Scenario, craft: str) -> None:
        config = scenario.craft[craft].base
        if config is None:
            raise ConfigError(f"$.craft.{craft}.base", "is missing: this is no base")
        plan = plan_mission(scenario)
        profile = load_profile(scenario.link.profile)
        check_capabilities(scenario, plan, profile)
        form = state_form(scenario, profile)
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._watched = config.watch
        self._depth_m = config.place_ned_m[2]
        self._watch = Watch(config, scenario.team.ranging, scenario.team.speed_model, plan.craft[config.watch])
        self._talk = TeamTalk(craft, plan, form)
        self._messenger = Messenger(scenario, craft, plan, profile, self._talk, Periodic(), BYTES[form])
        self._time_ns: int | None = None

    @property
    def bad_frames(self) -> int:
        """Datagrams so far that were no team state of a craft."""
        return self._talk.bad_frames

    def on_fix(self, fix: Fix) -> None:
        """Take note of a fix: nothing, for the base knows where it is."""

    def on_truth(self, truth: Truth) -> None:
        """Take note of the truth: nothing."""

    def on_modem(self, event: ModemEvent) -> None:
        """Take a modem event; it counts at the next step."""
        self._messenger.on_event(event)

    def step(self, tick: int, now_ns: int) -> Iterator[tuple[str, Message]]:
        """Do one step; see `AgentCore.step`."""
        self._time_ns = time_ns = now_ns if self._time_ns is None else max(self._time_ns, now_ns)
        _, heard = self._messenger.take(now_ns)
        self._messenger.mail.received.clear()  # orders for others, overheard
        for report in heard:
            if report.craft == self._watched:
                self._watch.hear(report.state)
        good = [self._watch.hear_range(heard) for heard in self._messenger.take_ranges()]
        for request in self._messenger.speak(now_ns, now_ns + self._tick_ns, lambda: None):
            yield "modem_tx", request
        yield "setpoint", Setpoint(tick, now_ns, "hold", 0.0, 0.0, self._depth_m, self._messenger.transmissions)
        yield "state", self._state(tick, now_ns, time_ns / NS, [] if all(good) else ["range_rejected"])
        if self._messenger.ledger_due(now_ns):
            yield "port", self.ledger(now_ns)

    def ledger(self, now_ns: int) -> PortLedger:
        """Count what has become of everything the modem was asked for, at a time."""
        return self._messenger.ledger(now_ns)

    def _state(self, tick: int, now_ns: int, now_s: float, health: list[str]) -> AgentState:
        belief = self._watch.belief(self._watched, now_s)
        mates, places = ([], []) if belief is None else ([belief[0]], [belief[1]])
        return AgentState(tick, now_ns, 0, 0.0, 0.0, 0.0, 0.0, 0.0, mates, health, self.bad_frames, places)
