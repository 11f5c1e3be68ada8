"""The paper's estimators: a copy of a mate's manoeuvre processor, guidance and controller about a planar filter."""

import math
from collections.abc import Sequence

import msgspec

from grex_agent.coordination import SpeedController
from grex_agent.guidance import TrackKeeping
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import CraftPlan
from grex_agent.path import Place, Track
from grex_agent.team.interface import TeamContext
from grex_agent.team.kalman import PlanarModel, PlanarState, Recalculation
from grex_agent.team.levels import FirstLevelOf, SecondLevelOf
from grex_agent.team.mate import MateModel
from grex_link.config import KalmanConfig
from grex_link.wire import TeamState


class Stand(msgspec.Struct, frozen=True, gc=False):
    """Where an estimated position stands on the plan."""

    number: int
    """Number of the track."""
    track: Track
    place: Place
    progress: float
    """Track number plus Θ."""


class Follower:
    """What a mate would order at an estimated position: its manoeuvre processor, controller and guidance.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    guidance : TrackKeeping
        Its track keeping.
    controller : SpeedController
        Its coordination law.
    """

    def __init__(self, plan: CraftPlan, guidance: TrackKeeping, controller: SpeedController) -> None:
        self._processor = ManoeuvreProcessor(plan)
        self._guidance = guidance
        self._controller = controller

    def stand(self, north_m: float, east_m: float, number: int) -> Stand:
        """Find where a position stands, from a track on."""
        processor = self._processor
        if processor.number != number:
            processor.go_to(number)
        place = processor.follow(north_m, east_m)
        return Stand(processor.number, processor.track, place, processor.progress)

    def order(self, stand: Stand, others: Sequence[float]) -> tuple[float, float]:
        """Speed (eq. 2) and course that the mate orders there, m/s and radians."""
        speed = self._controller.speed(stand.track.speed_mps, stand.progress, others)
        return speed, self._guidance.course(stand.track, stand.place)


class PlanarMateState(msgspec.Struct, frozen=True, gc=False):
    """State of the planar filter, and where it stands."""

    x: PlanarState
    stand: Stand


class PlanarMate:
    """KF 1 and KF 2 of one mate (GREX 2008, eqs. 6–11); see `MateModel`.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    follower : Follower
        What it would order.
    config : KalmanConfig
        K_v and the noises.
    """

    def __init__(self, plan: CraftPlan, follower: Follower, config: KalmanConfig) -> None:
        self._plan = plan
        self._follower = follower
        self._kf1 = PlanarModel(config)
        self._kf2 = Recalculation(self._kf1)

    def start(self) -> PlanarMateState:
        """At the start of the plan, at planned speed."""
        north, east, course = self._plan.start
        speed = self._plan.tracks[0].speed_mps
        v_north, v_east = speed * math.cos(course), speed * math.sin(course)
        x = PlanarState(north, east, v_north, v_east, self._kf1.fix_noise, 0.0, self._kf1.velocity_noise)
        return PlanarMateState(x, self._follower.stand(north, east, 0))

    def predict(self, state: PlanarMateState, others: Sequence[float], dt: float) -> PlanarMateState:
        """KF 1; the input is the velocity that the mate would order."""
        speed, course = self._follower.order(state.stand, others)
        x = self._kf1.predict(state.x, speed * math.cos(course), speed * math.sin(course), dt)
        return PlanarMateState(x, self._follower.stand(x.north, x.east, state.stand.number))

    def update(self, state: PlanarMateState, message: TeamState) -> PlanarMateState:
        """KF 2: filterpy's update with the position told.

        The mate knows its own track best; without taking it over an estimate that ran ahead could never come back.
        """
        self._kf2.start(state.x)
        self._kf2.update(message.north_m, message.east_m)
        x = self._kf2.state
        return PlanarMateState(x, self._follower.stand(x.north, x.east, message.track))

    def progress(self, state: PlanarMateState) -> float:
        """Track number plus Θ."""
        return state.stand.progress

    def position(self, state: PlanarMateState) -> tuple[float, float, float]:
        """North, east and the standard deviation of each, metres."""
        return state.x.north, state.x.east, math.sqrt(state.x.pp)


def follower_of(context: TeamContext, plan: CraftPlan) -> Follower:
    """Build what orders as a mate of a team does."""
    return Follower(plan, TrackKeeping(context.scenario.guidance), context.controller)


class FirstLevel(FirstLevelOf):
    """Planar filters of the mates (GREX 2008, case c)."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[PlanarMateState]:
        """Build the planar filter of a mate."""
        return PlanarMate(plan, follower_of(context, plan), context.scenario.team.kalman)


class SecondLevel(SecondLevelOf):
    """Planar filters of the mates, and of oneself as they see it (GREX 2008, case d)."""

    model = FirstLevel.model
