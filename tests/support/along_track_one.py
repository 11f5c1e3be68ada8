"""The along-track filter of one mate at a time, in scalars: what the rows of arrays are held against."""

import math
from collections.abc import Sequence

import numpy as np

from grex_agent.coordination import SpeedController
from grex_agent.gaussian import Gaussian, propagate
from grex_agent.mission import CraftPlan
from grex_agent.team.along_track import AlongTrackUpdate
from grex_agent.team.interface import TeamContext
from grex_agent.team.levels import FirstLevelOf, SecondLevelOf
from grex_agent.team.mate import MateModel
from grex_agent.team.path_length import PathLength
from grex_agent.team.speed_model import SpeedModel
from grex_link.config import SpeedModelConfig

_NUDGE = 1e-3


class AlongTrackMate:
    """The filter of one mate; see `MateModel`.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    controller : SpeedController
        Its coordination law.
    config : SpeedModelConfig
        How it keeps its speed.
    start_variance_m2 : float
        Of its place at the beginning.
    """

    def __init__(
        self, plan: CraftPlan, controller: SpeedController, config: SpeedModelConfig, start_variance_m2: float
    ) -> None:
        self._path = PathLength(plan)
        self._controller = controller
        self._speed = SpeedModel(config)
        self._start_variance = start_variance_m2
        self.update = AlongTrackUpdate(plan, self._speed)

    def start(self) -> Gaussian:
        """At the start of the plan, at planned speed."""
        config = self._speed.config
        variances = self._start_variance, config.told_sigma_mps**2, config.error_relative**2
        return Gaussian((0.0, self._path.tracks[0].speed_mps, 0.0), np.diag(variances))

    def predict(self, state: Gaussian, others: Sequence[float], dt: float) -> Gaussian:
        """Predict over `dt` seconds; the input is the speed that the mate would order."""
        distance, speed, error = state.mean
        ordered, slope = self._order(distance, others)
        after, (by_speed, by_order, by_error) = self._speed.step(speed, ordered, error, dt)
        keep, error_noise = self._speed.fading(dt)
        half, by_distance = dt / 2.0, by_order * slope
        jacobian = np.array(
            [
                [1.0 + half * by_distance, half * (1.0 + by_speed), half * by_error],
                [by_distance, by_speed, by_error],
                [0.0, 0.0, keep],
            ]
        )
        noise = np.diag((0.0, self._speed.config.noise_mps**2 * dt, error_noise))
        mean = distance + half * (speed + after), after, keep * error
        return propagate(mean, state.covariance, jacobian, noise)

    def progress(self, state: Gaussian) -> float:
        """Track number plus Θ."""
        return self._path.progress(state.mean[0])

    def position(self, state: Gaussian) -> tuple[float, float, float]:
        """On the plan at that distance, and the deviation along it."""
        return (*self._path.point(state.mean[0]), math.sqrt(state.covariance[0, 0]))

    def _order(self, distance: float, others: Sequence[float]) -> tuple[float, float]:
        """Speed that the mate orders, and how that changes with its distance."""
        track = self._path.tracks[self._path.number(distance)]
        progress = self._path.progress(distance)
        ordered = self._controller.speed(track.speed_mps, progress, others)
        nudged = self._controller.speed(track.speed_mps, progress + _NUDGE, others)
        return ordered, (nudged - ordered) / (_NUDGE * track.length_m)


class OneByOneFirst(FirstLevelOf):
    """Along-track filters of the mates."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[Gaussian]:
        """Build the along-track filter of a mate."""
        team = context.scenario.team
        return AlongTrackMate(plan, context.controller, team.speed_model, team.kalman.fix_sigma_m**2)


class OneByOne(SecondLevelOf):
    """Along-track filters of the mates, and of oneself as they see it."""

    model = OneByOneFirst.model
