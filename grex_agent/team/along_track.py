"""A mate on its own path: how far it has come, how fast it is, and its speed error.

A craft that keeps its track moves in one dimension. State x = [s, v, β]: distance along the plan (m), speed (m/s), and
speed error as a share of the speed ordered. With u the mate's own order (eq. 2) at its progress, and its surge loop,

    v ← v + clip((1 - exp(-dt/T))·((1 + β)·u - v), ± a_max·dt),   s ← s + dt·(v_old + v_new)/2,   β ← exp(-dt/τ)·β

The Jacobian contains ∂u/∂s: the mate corrects itself by its true progress, and so an error of s dies out as its own
coordination does. β is a Gauss–Markov process of given deviation and time constant, which makes its process noise;
v has a small one for what is unknown of u. A message measures s and v.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from grex_agent.coordination import SpeedController
from grex_agent.gaussian import Gaussian, propagate, update
from grex_agent.mission import CraftPlan
from grex_agent.team.interface import TeamContext
from grex_agent.team.levels import FirstLevelOf, SecondLevelOf
from grex_agent.team.mate import MateModel
from grex_link.config import SpeedModelConfig
from grex_link.wire import TeamState

_NUDGE = 1e-3
#: Variance of a Θ told in steps of 1/4095.
_THETA_VARIANCE = (1.0 / 4095.0) ** 2 / 12.0


class PathLength:
    """A plan as one line: distance along it, and progress (track number plus Θ).

    Parameters
    ----------
    plan : CraftPlan
        The tracks.
    """

    def __init__(self, plan: CraftPlan) -> None:
        self.tracks = plan.tracks
        self._point = plan.point
        self._starts = [0.0, *accumulate(track.length_m for track in plan.tracks)][:-1]

    def number(self, distance_m: float) -> int:
        """Find the number of the track at a distance; the first and the last one go on beyond their ends."""
        return max(bisect_right(self._starts, distance_m) - 1, 0)

    def start(self, number: int) -> float:
        """Distance at which a track begins, metres."""
        return self._starts[number]

    def progress(self, distance_m: float) -> float:
        """Track number plus Θ at a distance."""
        number = self.number(distance_m)
        return number + (distance_m - self._starts[number]) / self.tracks[number].length_m

    def point(self, distance_m: float) -> tuple[float, float]:
        """North and east of the plan at a distance, metres."""
        return self._point(self.progress(distance_m))

    def told(self, message: TeamState) -> tuple[float, float]:
        """Distance that a message tells, and its variance: Θ's, where it is not cut off at 0 or 1."""
        number = min(message.track, len(self.tracks) - 1)
        track, theta = self.tracks[number], message.theta
        if not 0.0 < theta < 1.0:
            theta = track.locate(message.north_m, message.east_m).theta
        variance = message.sigma_m**2 + _THETA_VARIANCE * track.length_m**2
        return self._starts[number] + theta * track.length_m, variance


class SpeedModel:
    """How a mate's speed follows what it orders, with an error that wanders.

    Parameters
    ----------
    config : SpeedModelConfig
        Lag, limits and noises.
    """

    def __init__(self, config: SpeedModelConfig) -> None:
        self.config = config

    def step(self, speed: float, ordered: float, error: float, dt: float) -> tuple[float, tuple[float, float, float]]:
        """Speed after `dt`, and its derivatives by speed, ordered speed and error."""
        config = self.config
        gain = 1.0 - math.exp(-dt / config.lag_s) if config.lag_s > 0.0 else 1.0
        change, most = gain * ((1.0 + error) * ordered - speed), config.acceleration_max_mps2 * dt
        if abs(change) > most:
            return speed + math.copysign(most, change), (1.0, 0.0, 0.0)
        return speed + change, (1.0 - gain, gain * (1.0 + error), gain * ordered)

    def fading(self, dt: float) -> tuple[float, float]:
        """Share of the error that is left after `dt`, and the variance that comes in."""
        keep = math.exp(-dt / self.config.error_time_s)
        return keep, self.config.error_relative**2 * (1.0 - keep * keep)

    def hear_speed(self, x: Gaussian, told: float, expected: float, ordered: float, speed: int, error: int) -> Gaussian:
        """Work in a told speed; one that is far off means that the error has changed at once, and frees it."""
        variance = self.config.told_sigma_mps**2
        surprise = told - expected
        if surprise**2 > self.config.surprise**2 * (float(x.covariance[speed, speed]) + variance):
            freed = x.covariance.copy()
            freed[speed, speed] += surprise**2
            freed[error, error] += (surprise / ordered) ** 2
            freed[speed, error] += surprise**2 / ordered
            freed[error, speed] = freed[speed, error]
            x = Gaussian(x.mean, freed)
        return update(x, speed, surprise, variance)


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

    def update(self, state: Gaussian, message: TeamState) -> Gaussian:
        """Work in the distance told, and the speed if the message has one."""
        if message.form == "full":
            planned = self._path.tracks[self._path.number(state.mean[0])].speed_mps
            state = self._speed.hear_speed(state, message.speed_mps, state.mean[1], planned, 1, 2)
        distance, variance = self._path.told(message)
        return update(state, 0, distance - state.mean[0], variance)

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


class AlongTrackFirst(FirstLevelOf):
    """Along-track filters of the mates."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[Gaussian]:
        """Build the along-track filter of a mate."""
        team = context.scenario.team
        return AlongTrackMate(plan, context.controller, team.speed_model, team.kalman.fix_sigma_m**2)


class AlongTrack(SecondLevelOf):
    """Along-track filters of the mates, and of oneself as they see it."""

    model = AlongTrackFirst.model
