"""Two baselines that know nothing of a mate's control law: its last position, and that moved on at planned speed.

An estimator that does not beat them is not worth its cost.
"""

import math
from collections.abc import Sequence

import msgspec

from grex_agent.mission import CraftPlan
from grex_agent.team.interface import TeamContext
from grex_agent.team.levels import FirstLevelOf
from grex_agent.team.mate import MateModel
from grex_agent.team.path_length import PathLength
from grex_link.wire import TeamState


class Told(msgspec.Struct, frozen=True, gc=False):
    """How far a mate is thought to be."""

    distance_m: float
    """Along its plan."""
    sigma_told_m: float
    """Deviation of what it told last."""
    drift_m: float
    """Deviation that has come with the time since: a speed that is off by the same amount all the time."""


class ReckonedMate:
    """A mate that goes on at a share of its planned speed; see `MateModel`.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    share : float
        Of the planned speed: 1 for dead reckoning, 0 for the last position.
    error_relative : float
        By how much of the planned speed its speed may be off.
    start_sigma_m : float
        Deviation of its place at the beginning.
    """

    def __init__(self, plan: CraftPlan, share: float, error_relative: float, start_sigma_m: float) -> None:
        self._path = PathLength(plan)
        self._share = share
        self._error = error_relative
        self._start = Told(0.0, start_sigma_m, 0.0)

    def start(self) -> Told:
        """At the start of the plan."""
        return self._start

    def predict(self, state: Told, others: Sequence[float], dt: float) -> Told:
        """Go on; what the others do changes nothing."""
        del others
        planned = dt * self._path.tracks[self._path.number(state.distance_m)].speed_mps
        drift = state.drift_m + self._error * planned
        return Told(state.distance_m + self._share * planned, state.sigma_told_m, drift)

    def update(self, state: Told, message: TeamState) -> Told:
        """Start anew from what is told."""
        del state
        distance, variance = self._path.told(message)
        return Told(distance, math.sqrt(variance), 0.0)

    def progress(self, state: Told) -> float:
        """Track number plus Θ."""
        return self._path.progress(state.distance_m)

    def position(self, state: Told) -> tuple[float, float, float]:
        """On the plan at that distance, and the deviation along it."""
        return (*self._path.point(state.distance_m), math.hypot(state.sigma_told_m, state.drift_m))


class HoldLast(FirstLevelOf):
    """Every mate is where it said that it was."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[Told]:
        """Build the model of a mate."""
        return ReckonedMate(plan, 0.0, 1.0, context.scenario.team.kalman.fix_sigma_m)


class DeadReckoning(FirstLevelOf):
    """Every mate goes on at planned speed from where it said that it was."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[Told]:
        """Build the model of a mate."""
        team = context.scenario.team
        return ReckonedMate(plan, 1.0, team.speed_model.error_relative, team.kalman.fix_sigma_m)
