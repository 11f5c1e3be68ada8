"""The agent as a pure core: fixes and modem events go in, a setpoint, a state and transmissions come out.

At every step the manoeuvre processor finds where the craft stands, the estimator says where the mates stand, the
controller (eq. 2) orders the speed and the guidance the course. In the own slots a team state is transmitted.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Any, Literal

import msgspec

from grex_agent.cable import CableGuard
from grex_agent.capabilities import check_capabilities, state_form
from grex_agent.coordinating import coordinate
from grex_agent.coordination import quality
from grex_agent.guidance import PlaceKeeping, TrackKeeping
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.messenger import Messenger
from grex_agent.mission import plan_mission
from grex_agent.own_navigation import OwnNavigation
from grex_agent.separation import load_guard
from grex_agent.shared_reference import SharedReference
from grex_agent.tasks.activity import Steering
from grex_agent.tasks.office import TaskOffice
from grex_agent.team.interface import Own, Report
from grex_link import wire
from grex_link.config import Scenario
from grex_link.messages import (
    AgentState,
    Fix,
    MateBelief,
    Message,
    ModemEvent,
    PlaceBelief,
    PortLedger,
    Setpoint,
    TaskOrder,
    Truth,
)
from grex_link.profile import load_profile
from grex_link.units import NS, tick_ns

#: (topic, message)
Output = tuple[str, Message]


class AgentCore:
    """One craft's agent.

    Parameters
    ----------
    scenario : Scenario
        The run; of it the agent uses what is known aboard.
    craft : str
        Which craft this is.

    Raises
    ------
    ConfigError
        If the mission or the slots cannot work, or the modem cannot do what the plan needs.
    """

    def __init__(self, scenario: Scenario, craft: str) -> None:
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._fix_timeout_ns = round(scenario.team.fix_timeout_s * NS)
        plan = plan_mission(scenario)
        profile = load_profile(scenario.link.profile)
        check_capabilities(scenario, plan, profile)
        self._plan = plan.everybody[craft]
        self._processor = ManoeuvreProcessor(self._plan)
        self._guidance = TrackKeeping(scenario.guidance)
        self._place_keeping = PlaceKeeping(scenario.guidance, scenario.team.speed_max_mps)
        form = state_form(scenario, profile)
        self._coordination = team = coordinate(scenario, craft, plan, profile, form)
        self._controller = team.controller
        self._estimator: Any = team.estimator
        self._members = plan.craft
        self._prepare = getattr(self._estimator, "prepare", None)
        self._guard = load_guard(scenario, craft, plan)
        self._speed_min_mps, self._speed_max_mps = scenario.team.speed_min_mps, scenario.team.speed_max_mps
        self._navigation = OwnNavigation(scenario, craft)
        self._messenger = Messenger(scenario, craft, plan, profile, team.talk, team.policy, team.message_bytes)
        self._tasks = TaskOffice(
            scenario, craft, plan, self._processor, self._messenger.mail, self._messenger.answer_ns
        )
        self._cable = CableGuard(scenario, craft, plan)
        self._state_tells_task = form == "full"
        self._time_ns: int | None = None
        self._fix: Fix | None = None
        self._fix_usable = False
        self._own: Own | None = None
        self._beliefs: list[MateBelief] = []
        self._places: list[PlaceBelief] = []
        self._modem_events = 0

    @property
    def bad_frames(self) -> int:
        """Datagrams so far that were no word of a mate."""
        return self._coordination.talk.bad_frames + self._tasks.bad

    @property
    def takes_orders(self) -> bool:
        """Whether the craft may leave the formation for a task: with the shared reference everybody is waited for."""
        return not isinstance(self._estimator, SharedReference)

    def on_order(self, order: TaskOrder) -> None:
        """Take an order of the operator; it counts at the next step."""
        self._tasks.on_order(order)

    def on_fix(self, fix: Fix) -> None:
        """Take a fix of the own navigation; one that is no number is no better than an invalid one."""
        self._fix = fix
        numbers = fix.north_m + fix.east_m + fix.down_m + fix.heading_rad + fix.speed_mps + fix.sigma_m
        self._fix_usable = fix.valid and math.isfinite(numbers)

    def on_modem(self, event: ModemEvent) -> None:
        """Take a modem event; it counts at the next step."""
        self._modem_events += 1
        self._messenger.on_event(event)

    def on_truth(self, truth: Truth) -> None:
        """Take the true poses: for the bench-only ideal estimator."""
        if hasattr(self._estimator, "see"):
            self._estimator.see(truth)

    def step(self, tick: int, now_ns: int) -> Iterator[Output]:
        """Do one step; what is not urgent is done after the setpoint has been taken.

        Parameters
        ----------
        tick : int
            Number of the step, as the fix says.
        now_ns : int
            Mission time by the craft's own clock, which may drift and be set.

        Yields
        ------
        (topic, message)
            Transmissions, then the setpoint, which says how many transmissions there have been, then the state, news of
            tasks, and now and then the ledger of the modem port.
        """
        # For an estimator time never runs back, though GPS may set the clock back: it stands until it is passed again.
        self._time_ns = time_ns = now_ns if self._time_ns is None else max(self._time_ns, now_ns)
        health = self._navigation_health(now_ns)
        lost = bool(health)
        self._fix = fix = self._navigation.filtered(time_ns / NS, self._fix, lost=lost)
        self._places = [] if lost else self._navigation.place(fix)
        if fix is not None and not lost:
            if not self._tasks.busy:
                self._processor.follow(fix.north_m, fix.east_m)
            self._own = Own(fix.north_m, fix.east_m, self._processor.progress)
        sent, heard = self._messenger.take(now_ns)
        health += self._navigation.hear_ranges(self._messenger.take_ranges())
        if self._own is not None:
            of_members = [report for report in heard if report.craft in self._members]
            self._beliefs = self._estimator.step(time_ns / NS, self._own, sent, of_members)
        mates = [belief.progress for belief in self._beliefs if belief.craft not in self._tasks.on_task]
        ordered = self._order_speed(mates, health)
        states = [report for report in heard if isinstance(report, Report)]
        task = self._tasks.step(now_ns, fix, states, mates, lost=lost)
        health += self._tasks.health
        ordered, task = self._keep_apart(time_ns / NS, ordered, task, states, health)
        taut = task is None and self._own is not None and self._cable.taut(self._own, self._beliefs)
        health += ["cable_taut"] if taut else []
        yield from self._speak(now_ns, health, lost=lost)
        setpoint = self._navigation.corrected(self._setpoint(tick, now_ns, ordered, task, hold=lost or taut), health)
        yield "setpoint", setpoint
        self._navigation.ordered(setpoint)
        yield "state", self._state(tick, now_ns, ordered, mates, health)
        yield from self._news()
        if self._messenger.ledger_due(now_ns):
            yield "port", self.ledger(now_ns)
        if self._prepare is not None:
            self._prepare((time_ns + self._tick_ns) / NS)

    def ledger(self, now_ns: int) -> PortLedger:
        """Count what has become of everything the modem was asked for, at a time."""
        return self._messenger.ledger(now_ns)

    # -- inside -------------------------------------------------------------------------------------------------

    def _navigation_health(self, now_ns: int) -> list[str]:
        if self._fix is None:
            return ["no_fix"]
        if not self._fix_usable:
            return ["invalid_fix"]
        return ["stale_fix"] if now_ns - self._fix.t_ns > self._fix_timeout_ns else []

    def _order_speed(self, mates: list[float], health: list[str]) -> float:
        """Ask the controller; whatever a controller or an estimator of somebody's own says, limits are kept."""
        planned = self._processor.track.speed_mps
        ordered = self._controller.speed(planned, self._processor.progress, mates)
        least, most = self._speed_min_mps, self._speed_max_mps
        if least <= ordered <= most:
            return ordered
        health.append("speed_limited")
        return min(max(ordered, least), most) if math.isfinite(ordered) else planned

    def _keep_apart(
        self, now_s: float, ordered_mps: float, task: Steering | None, heard: Iterable[Report], health: list[str]
    ) -> tuple[float, Steering | None]:
        """Yield to a mate that would be too near: what is ordered by the law, and by a task."""
        if self._guard is None or self._fix is None or self._own is None:
            return ordered_mps, task
        for report in heard:
            self._guard.hear(report.craft, report.state)
        place, on_task = (self._own.north_m, self._own.east_m, self._fix.down_m), self._tasks.on_task
        if task is None:
            speed_mps = self._navigation.speed_over_ground(self._fix)
            ordered_mps, yields = self._guard.limit(
                now_s, ordered_mps, speed_mps, place, self._own.progress, self._beliefs, on_task
            )
        else:
            limited_mps, yields = self._guard.limit_on_task(
                now_s, task.speed_mps, task.course_rad, place, self._beliefs, on_task
            )
            task = task._replace(speed_mps=limited_mps)
        if yields:
            health.append("separation")
        return ordered_mps, task

    def _speak(self, now_ns: int, health: list[str], *, lost: bool) -> list[Output]:
        """Ask the modem for everything that is to be said before the next step."""

        def word() -> Any:
            if self._fix is None or lost:
                return None
            told = self._coordination.word(self._fix, self._processor, self._navigation.speed_over_ground(self._fix))
            if not self._tasks.busy or not isinstance(told, wire.TeamState):
                return told
            # A shorter form cannot say so; of a silent craft the mates believe that it follows its plan.
            on_task = msgspec.structs.replace(told, flags=told.flags | wire.ON_TASK)
            return on_task if self._state_tells_task else None

        requests = self._messenger.speak(now_ns, now_ns + self._tick_ns, word, must=self._tasks.busy)
        if self._messenger.untold:
            health.append("outside_frame")
        return [("modem_tx", request) for request in requests]

    def _state(self, tick: int, now_ns: int, ordered_mps: float, mates: list[float], health: list[str]) -> AgentState:
        processor = self._processor
        return AgentState(
            tick,
            now_ns,
            processor.number,
            processor.place.theta,
            processor.place.xte_m,
            processor.track.speed_mps,
            ordered_mps,
            quality(processor.progress, mates),
            self._beliefs,
            health,
            self.bad_frames,
            self._places,
            self._modem_events,
        )

    def _news(self) -> Iterator[Output]:
        news, self._tasks.news = self._tasks.news, []
        for item in news:
            yield "task_news", item

    def _setpoint(self, tick: int, now_ns: int, speed_mps: float, task: Steering | None, *, hold: bool) -> Setpoint:
        if task is not None:
            mode: Literal["hold", "steer"] = "hold" if hold or not task.speed_mps else "steer"
            speed_mps = 0.0 if mode == "hold" else task.speed_mps
            return Setpoint(tick, now_ns, mode, task.course_rad, speed_mps, task.depth_m, self._messenger.transmissions)
        processor = self._processor
        track = processor.track
        course = self._guidance.course(track, processor.place)
        if self._plan.hold_at_end and processor.place.theta >= 1.0 and self._fix is not None:
            towards = self._place_keeping.steer(self._fix.north_m, self._fix.east_m, track.point(1.0))
            hold = hold or towards is None
            course, speed_mps = towards or (course, 0.0)
        if hold:
            return Setpoint(tick, now_ns, "hold", course, 0.0, track.depth_m, self._messenger.transmissions)
        return Setpoint(tick, now_ns, "steer", course, speed_mps, track.depth_m, self._messenger.transmissions)
