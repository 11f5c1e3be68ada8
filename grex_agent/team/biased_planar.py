"""The paper's planar filter with one more state: the speed error of the mate along its course.

State x = [north, east, v_north, v_east, β]. The paper's model (GREX 2008, eqs. 6–9) is driven by the speed and course
that the mate orders, and so its velocity forgets within 1/K_v whatever a message has taught it. Here the input is
(1 + β)·u along the course, and β, a Gauss–Markov process, keeps it.
"""

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from grex_agent.gaussian import Gaussian, propagate, update
from grex_agent.mission import CraftPlan
from grex_agent.team.interface import TeamContext
from grex_agent.team.levels import FirstLevelOf, SecondLevelOf
from grex_agent.team.mate import MateModel
from grex_agent.team.planar import Follower, Stand, follower_of
from grex_agent.team.speed_model import SpeedModel
from grex_link.config import TeamConfig
from grex_link.wire import TeamState


class BiasedState(msgspec.Struct, frozen=True, gc=False):
    """State of the filter, and where it stands on the plan."""

    x: Gaussian
    stand: Stand


class BiasedPlanarMate:
    """The filter of one mate; see `MateModel`.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    follower : Follower
        What it would order.
    config : TeamConfig
        The planar model, and how a mate's speed error changes.
    """

    def __init__(self, plan: CraftPlan, follower: Follower, config: TeamConfig) -> None:
        self._plan = plan
        self._follower = follower
        self._kalman = config.kalman
        self._speed = SpeedModel(config.speed_model)

    def start(self) -> BiasedState:
        """At the start of the plan, at planned speed."""
        north, east, course = self._plan.start
        speed = self._plan.tracks[0].speed_mps
        place, velocity = self._kalman.fix_sigma_m**2, self._kalman.velocity_process_sigma_mps**2
        covariance = np.diag((place, place, velocity, velocity, self._speed.config.error_relative**2))
        x = Gaussian((north, east, speed * math.cos(course), speed * math.sin(course), 0.0), covariance)
        return BiasedState(x, self._follower.stand(north, east, 0))

    def predict(self, state: BiasedState, others: Sequence[float], dt: float) -> BiasedState:
        """Predict over `dt` seconds; the input is the velocity that the mate would order, with its error."""
        speed, course = self._follower.order(state.stand, others)
        north, east, v_north, v_east, error = state.x.mean
        gain = min(self._kalman.velocity_transfer_per_s * dt, 1.0)
        stay = 1.0 - gain
        u_north, u_east = gain * speed * math.cos(course), gain * speed * math.sin(course)
        keep, error_noise = self._speed.fading(dt)
        mean = (
            north + dt * v_north,
            east + dt * v_east,
            stay * v_north + (1.0 + error) * u_north,
            stay * v_east + (1.0 + error) * u_east,
            keep * error,
        )
        jacobian = np.array(
            [
                [1.0, 0.0, dt, 0.0, 0.0],
                [0.0, 1.0, 0.0, dt, 0.0],
                [0.0, 0.0, stay, 0.0, u_north],
                [0.0, 0.0, 0.0, stay, u_east],
                [0.0, 0.0, 0.0, 0.0, keep],
            ]
        )
        place = self._kalman.position_process_sigma_m**2 * dt
        velocity = self._kalman.velocity_process_sigma_mps**2 * dt
        noise = np.diag((place, place, velocity, velocity, error_noise))
        x = propagate(mean, state.x.covariance, jacobian, noise)
        return BiasedState(x, self._follower.stand(mean[0], mean[1], state.stand.number))

    def update(self, state: BiasedState, message: TeamState) -> BiasedState:
        """Work in the position told; the mate knows its own track best."""
        variance = max(self._kalman.fix_sigma_m, message.sigma_m) ** 2
        x = update(state.x, 0, message.north_m - state.x.mean[0], variance)
        x = update(x, 1, message.east_m - x.mean[1], variance)
        return BiasedState(x, self._follower.stand(x.mean[0], x.mean[1], message.track))

    def progress(self, state: BiasedState) -> float:
        """Track number plus Θ."""
        return state.stand.progress

    def position(self, state: BiasedState) -> tuple[float, float, float]:
        """North, east, and the greater of their two deviations, metres."""
        variances = state.x.covariance
        return state.x.mean[0], state.x.mean[1], math.sqrt(max(variances[0, 0], variances[1, 1]))


class BiasedPlanarFirst(FirstLevelOf):
    """Planar filters with a speed error, of the mates."""

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[BiasedState]:
        """Build the filter of a mate."""
        return BiasedPlanarMate(plan, follower_of(context, plan), context.scenario.team)


class BiasedPlanar(SecondLevelOf):
    """Planar filters with a speed error, of the mates, and of oneself as they see it."""

    model = BiasedPlanarFirst.model
