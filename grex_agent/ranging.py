"""Ranges to those who know where they are: whom to ask, and what a range and a message make together.

Only craft with an absolute navigation are ranged to. A craft whose own position comes from ranges hands on the errors
of others: two such craft that corrected each other would take the same news for new again and again, and claim to be
far better than they are. Positions that come from outside have errors of their own, and so may be used freely.

A one-way range belongs to the moment the message left, a two-way range to the middle between ping and answer. The other
end's position then is that of its newest message, carried along its plan at the speed it told.
"""

import math

from grex_agent.mission import TeamPlan
from grex_agent.range_update import Range
from grex_agent.team.path_length import PathLength
from grex_link.config import Scenario
from grex_link.messages import RangeResult, Received
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import NAVIGATION_VALID, ON_TASK, TeamState

#: What is not known of a speed told, as a share of it: it is that of a moment, and turns and waves change it.
_CARRYING_ERROR = 0.1
#: A message older than this says nothing of where its sender is: it may have left its plan since, unheard.
_OLD_S = 300.0


class Ranging:
    """Makes ranges of what the modem says.

    Parameters
    ----------
    scenario : Scenario
        Who is ranged to, and how.
    craft : str
        On which craft this is.
    plan : TeamPlan
        The plans of those ranged to.
    profile : ModemProfile
        The modem: its times and its ambiguity.
    """

    def __init__(self, scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile) -> None:
        self._config = scenario.team.ranging
        self._profile = profile
        self._sound_mps = scenario.link.water.nominal_sound_speed_mps
        self._paths = {mate: PathLength(plan.craft[mate]) for mate in ranged_to(scenario, craft)}
        base = scenario.craft[craft].base
        self._place = None if base is None else base.place_ned_m
        self._plan = None if base is not None else plan.everybody[craft]
        self._told: dict[str, TeamState] = {}
        self._ranges: list[Range] = []
        self._turn = self._messages = 0

    def on_message(self, event: Received, t_ns: int, state: TeamState) -> None:
        """Take a team state that has arrived at a time by the own clock, and the travel time if it was measured."""
        mate = event.source
        if mate not in self._paths:
            return
        astray = state.flags & ON_TASK and self._place is None  # a base asks how far it is, wherever that may be
        if not state.flags & NAVIGATION_VALID or astray:
            self._told.pop(mate, None)  # where it was before says no more where it is
            return
        if mate not in self._told or state.t_s >= self._told[mate].t_s:
            self._told[mate] = state
        if self._config.mode != "one_way" or event.one_way_s is None:
            return
        profile = self._profile
        heard_s = t_ns / NS - profile.decode_latency_s - profile.airtime_ns(len(event.payload)) / NS
        travel_s = self._whole_travel_s(event.one_way_s, state)
        self._note(mate, heard_s, heard_s - travel_s, travel_s * self._sound_mps)

    def on_range(self, event: RangeResult, t_ns: int) -> None:
        """Take a two-way range that has been measured, or not, at a time by the own clock."""
        if event.range_m is None or event.destination not in self._told:
            return
        profile = self._profile
        one_way_s = profile.ping_airtime_ns / NS + profile.decode_latency_s + event.range_m / self._sound_mps
        middle_s = t_ns / NS - one_way_s - profile.ranging.reply_s / 2.0
        self._note(event.destination, middle_s, middle_s, event.range_m)

    def on_own_messages(self, messages: int) -> None:
        """Count own messages that have left."""
        self._messages += messages

    def next_to_ask(self) -> str | None:
        """Say whom to ask for an answer now that so many messages have left: all in turn; None for nobody."""
        if self._config.mode != "two_way" or not self._paths:
            return None
        if self._place is None and self._messages < self._config.every:  # a base says nothing: it asks in every slot
            return None
        self._messages = 0
        mates = list(self._paths)
        self._turn += 1
        return mates[(self._turn - 1) % len(mates)]

    def take(self) -> list[Range]:
        """Take the ranges since the last time."""
        ranges, self._ranges = self._ranges, []
        return ranges

    # -- inside -------------------------------------------------------------------------------------------------

    def _whole_travel_s(self, measured_s: float, state: TeamState) -> float:
        """Travel time without the modem's ambiguity: the one nearest to what the plan has between the two."""
        ambiguity_s = self._profile.ranging.ambiguity_s
        if not ambiguity_s:
            return measured_s
        if self._plan is not None:
            track = min(state.track, len(self._plan.tracks) - 1)
            here = (*self._plan.point(track + state.theta), self._plan.tracks[track].depth_m)
        else:
            here = self._place or (0.0, 0.0, 0.0)
        planned_s = math.dist(here, (state.north_m, state.east_m, state.depth_m)) / self._sound_mps
        return measured_s + ambiguity_s * round((planned_s - measured_s) / ambiguity_s)

    def _note(self, mate: str, own_s: float, mate_s: float, range_m: float) -> None:
        state, path = self._told[mate], self._paths[mate]
        if not math.isfinite(state.sigma_m + state.speed_mps):
            return
        if mate_s - state.t_s > _OLD_S:
            return
        way_m = state.speed_mps * (mate_s - state.t_s)
        distance_m, _ = path.told(state)
        (north0, east0), (north1, east1) = path.point(distance_m), path.point(distance_m + way_m)
        north, east = state.north_m + north1 - north0, state.east_m + east1 - east0
        sigma_m = math.hypot(state.sigma_m, _CARRYING_ERROR * way_m)
        self._ranges.append(Range(own_s, mate_s, mate, range_m, north, east, state.depth_m, sigma_m))


def ranged_to(scenario: Scenario, craft: str) -> list[str]:
    """Whom a craft ranges to: craft with absolute navigation if its own is not; a base, the craft it watches."""
    config = scenario.craft[craft]
    if config.base is not None:
        return [config.base.watch]
    if config.inertial is None:
        return []
    return [mate for mate in scenario.formation if mate != craft and scenario.craft[mate].inertial is None]
