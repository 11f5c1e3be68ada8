"""The agent as a pure core: fixes and modem events go in, a setpoint, a state and transmissions come out.

At every step the manoeuvre processor finds where the craft stands, the estimator says where the mates stand, the
controller (eq. 2) orders the speed and the guidance the course. In the own slots a team state is transmitted.
"""

import math
import sys
from collections.abc import Iterator
from typing import Any

from grex_agent.coordination import load_controller, quality
from grex_agent.guidance import PlaceKeeping, TrackKeeping
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link import wire
from grex_link.config import Scenario
from grex_link.errors import WireError
from grex_link.messages import (
    AgentState,
    Fix,
    MateBelief,
    Message,
    ModemEvent,
    Received,
    Setpoint,
    Transmit,
    Truth,
    TxEvent,
)
from grex_link.profile import load_profile
from grex_link.tdma import plan_schedule
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

    Attributes
    ----------
    bad_frames : int
        Datagrams that were no team state of a mate.
    """

    def __init__(self, scenario: Scenario, craft: str) -> None:
        self._craft = craft
        self._team = list(scenario.craft)
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self._fix_timeout_ns = round(scenario.team.fix_timeout_s * NS)
        plan = plan_mission(scenario)
        self._plan = plan.craft[craft]
        self._processor = ManoeuvreProcessor(self._plan)
        self._guidance = TrackKeeping(scenario.guidance)
        self._place_keeping = PlaceKeeping(scenario.guidance, scenario.team.speed_max_mps)
        self._controller = load_controller(scenario.team)
        self._estimator: Any = load_estimator(TeamContext(craft, plan, scenario, self._controller))
        self._prepare = getattr(self._estimator, "prepare", None)
        self._speed_min_mps, self._speed_max_mps = scenario.team.speed_min_mps, scenario.team.speed_max_mps
        self._schedule = plan_schedule(scenario.link.mac, self._team, load_profile(scenario.link.profile))
        self._next_slot_ns = 0
        self._fix: Fix | None = None
        self._fix_usable = False
        self._own: Own | None = None
        self._events: list[ModemEvent] = []
        self._on_air: dict[int, wire.TeamState] = {}
        self._transmissions = 0
        self._beliefs: list[MateBelief] = []
        self.bad_frames = 0

    def on_fix(self, fix: Fix) -> None:
        """Take a fix of the own navigation; one that is no number is no better than an invalid one."""
        self._fix = fix
        numbers = fix.north_m + fix.east_m + fix.down_m + fix.heading_rad + fix.speed_mps + fix.sigma_m
        self._fix_usable = fix.valid and math.isfinite(numbers)

    def on_modem(self, event: ModemEvent) -> None:
        """Take a modem event; it counts at the next step."""
        self._events.append(event)

    def on_truth(self, truth: Truth) -> None:
        """Take the true poses: for the bench-only ideal estimator."""
        self._estimator.see(truth)

    def step(self, tick: int, now_ns: int) -> Iterator[Output]:
        """Do one step; what is not urgent is done after the setpoint has been taken.

        Parameters
        ----------
        tick : int
            Number of the step, as the fix says.
        now_ns : int
            Mission time.

        Yields
        ------
        (topic, message)
            Transmissions, then the setpoint, which says how many transmissions there have been, then the state.
        """
        fix, health = self._fix, self._navigation_health(now_ns)
        lost = bool(health)
        if fix is not None and not lost:
            self._processor.follow(fix.north_m, fix.east_m)
            self._own = Own(fix.north_m, fix.east_m, self._processor.progress)
        sent, heard = self._take_events(now_ns)
        if self._own is not None:
            self._beliefs = self._estimator.step(now_ns / NS, self._own, sent, heard)
        mates = [belief.progress for belief in self._beliefs]
        ordered = self._order_speed(mates, health)
        if fix is not None and not lost:
            yield from self._transmit(fix, now_ns, ordered, health)
        yield "setpoint", self._setpoint(tick, now_ns, ordered, hold=lost)
        yield "state", self._state(tick, now_ns, ordered, mates, health)
        if self._prepare is not None:
            self._prepare((now_ns + self._tick_ns) / NS)

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

    def _take_events(self, now_ns: int) -> tuple[list[wire.TeamState], list[Report]]:
        sent: list[wire.TeamState] = []
        heard: list[Report] = []
        for arrived in self._events:
            event = arrived.event
            if isinstance(event, Received):
                if report := self._unpack(event, now_ns):
                    heard.append(report)
            elif isinstance(event, TxEvent) and (state := self._on_air.pop(event.ticket, None)) and event.status == "SENT":
                sent.append(state)
        self._events.clear()
        return sent, heard

    def _unpack(self, event: Received, now_ns: int) -> Report | None:
        try:
            state = wire.unpack(event.payload, now_ns / NS)
            place = self._team.index(event.source)
        except (WireError, ValueError):
            self.bad_frames += 1
            return None
        if event.source == self._craft or place % 16 != state.source or state.track >= len(self._plan.tracks):
            self.bad_frames += 1
            return None
        return Report(event.source, state)

    def _transmit(self, fix: Fix, now_ns: int, speed_mps: float, health: list[str]) -> list[Output]:
        """Request a transmission for every own slot that opens before the next step."""
        before_ns = now_ns + self._tick_ns
        if before_ns <= self._next_slot_ns:
            return []
        openings = self._schedule.openings(self._craft, now_ns, before_ns)
        following = self._schedule.openings(self._craft, before_ns, before_ns + self._schedule.cycle_ns)
        self._next_slot_ns = following[0] if following else sys.maxsize
        outputs: list[Output] = []
        for t_ns in openings:
            state = wire.TeamState(
                source=self._team.index(self._craft),
                t_s=fix.t_ns / NS,
                north_m=fix.north_m,
                east_m=fix.east_m,
                depth_m=fix.down_m,
                speed_mps=speed_mps,
                heading_rad=fix.heading_rad,
                track=self._processor.number,
                theta=self._processor.place.theta,
                sigma_m=fix.sigma_m,
            )
            try:
                payload = wire.pack(state)
            except WireError:
                health.append("outside_frame")
                break
            # What the mates will read, not what was packed.
            self._on_air[self._transmissions] = wire.unpack(payload, state.t_s)
            outputs.append(("modem_tx", Transmit(self._transmissions, t_ns, payload)))
            self._transmissions += 1
        return outputs

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
        )

    def _setpoint(self, tick: int, now_ns: int, speed_mps: float, *, hold: bool) -> Setpoint:
        processor = self._processor
        track = processor.track
        course = self._guidance.course(track, processor.place)
        if self._plan.hold_at_end and processor.place.theta >= 1.0 and self._fix is not None:
            towards = self._place_keeping.steer(self._fix.north_m, self._fix.east_m, track.point(1.0))
            hold = hold or towards is None
            course, speed_mps = towards or (course, 0.0)
        if hold:
            return Setpoint(tick, now_ns, "hold", course, 0.0, track.depth_m, self._transmissions)
        return Setpoint(tick, now_ns, "steer", course, speed_mps, track.depth_m, self._transmissions)
