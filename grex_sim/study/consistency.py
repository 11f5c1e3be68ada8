"""Are errors as great as an estimator claims? Normalised estimation error squared (NEES), one sample a run.

Two craft abeam run a line. Each has the estimator aboard and orders its speed by it, as agents do; messages leave every
30 s, take 10 s, are packed as on the air and lost at random, at the receiver only. Each craft moves as the estimator's
model says, with errors drawn from the deviations the estimator is told: see `grex_sim.study.plants`. At the end of a
run, at some moment of the cycle, the squared error of the mate's place along its path is divided by the variance
claimed. Samples of different runs are independent, so that n times their mean is χ² of n degrees of freedom.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from grex_agent.coordination import load_controller
from grex_agent.mission import plan_mission
from grex_agent.own_filter import OwnFilter
from grex_agent.team.acknowledgement import Acknowledgements
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link import draws, wire
from grex_link.config import OwnFilterConfig, Scenario, SpeedModelConfig
from grex_link.messages import Fix
from grex_link.scenario import decode
from grex_sim.study.plants import Plant, Told, build_plant

#: Runs for each seed of a study.
RUNS = 5
_LENGTH_M = 400.0
_CYCLE_S, _AIRTIME_S = 30, 10
_SETTLED_S = 240
_OWN = "own_filter"


class Consistency(NamedTuple):
    """NEES of an estimator, mean over some runs.

    Attributes
    ----------
    estimator : str
        As in ``team.estimator``, or ``own_filter``.
    loss : float
        Share of messages lost, or of fixes.
    gain_mps : float
        K of eq. (2), m/s.
    """

    estimator: str
    loss: float
    gain_mps: float = 0.8

    def check(self) -> None:
        """Find a fault before anything runs."""
        if self.estimator != _OWN:
            _scenario(self)

    def run(self, seed: int) -> float:
        """Mean over the runs of a seed; each has draws of its own."""
        sample = _own_sample if self.estimator == _OWN else _sample
        return math.fsum(sample(self, seed * 100 + run) for run in range(RUNS)) / RUNS


class Aboard:
    """One craft of the two: how it moves, what it believes, and what it has said.

    Parameters
    ----------
    context : TeamContext
        What its estimator is built from.
    plant : Plant
        How it moves.
    acknowledgements : Acknowledgements
        What it has heard.
    """

    def __init__(self, context: TeamContext, plant: Plant, acknowledgements: Acknowledgements) -> None:
        self.craft = context.craft
        self.plant = plant
        self.estimator = load_estimator(context)
        self.mates: list[Any] = []
        self._acknowledgements = acknowledgements
        self._place = list(context.plan.craft).index(self.craft)
        self._track = context.plan.craft[self.craft].tracks[0]

    @property
    def progress(self) -> float:
        """True progress along the one track."""
        return self.plant.distance_m / _LENGTH_M

    def step(self, now: int, sent: list[wire.TeamState], heard: list[Report]) -> None:
        """Move for a second under what was believed, then believe anew."""
        self.plant.step(self.progress, [mate.progress for mate in self.mates])
        for report in heard:
            self._acknowledgements.hear(report.craft, report.state.t_s)
        place = self.plant.place()
        self.mates = self.estimator.step(float(now), Own(*place, self.progress), sent, heard)

    def say(self, now: int, told: Told) -> wire.TeamState:
        """Tell the own state as others read it."""
        theta = self._track.locate(told.north_m, told.east_m).theta
        flags = wire.NAVIGATION_VALID | self._acknowledgements.flags(now)
        state = wire.TeamState(
            self._place, float(now), told.north_m, told.east_m, 0.0, told.speed_mps, 0.0, 0, theta, told.sigma_m, flags
        )
        return wire.unpack(wire.pack(state, "full"), float(now))


def _scenario(job: Consistency) -> Scenario:
    formation = {"auv1": [0.0, 0.0, 0.0], "auv2": [0.0, 20.0, 0.0]}
    mission = {"type": "lawnmower", "formation_m": formation, "legs": 1, "leg_length_m": _LENGTH_M}
    team = {"estimator": job.estimator, "gain_mps": job.gain_mps}
    return decode({"mission": mission, "craft": {craft: {} for craft in formation}, "team": team})


def team_of_two(job: Consistency, seed: int) -> list[Aboard]:
    """Put the estimator aboard two craft that move as it thinks."""
    scenario = _scenario(job)
    plan, law = plan_mission(scenario), load_controller(scenario.team)

    def aboard(craft: str) -> Aboard:
        acknowledgements = Acknowledgements(craft, list(plan.craft), _CYCLE_S)
        context = TeamContext(craft, plan, scenario, law, acknowledgements)
        return Aboard(context, build_plant(scenario, plan.craft[craft], law, (seed, craft)), acknowledgements)

    return [aboard(craft) for craft in scenario.craft]


def sail(team: list[Aboard], loss: float, seed: int, seconds: int) -> Iterator[int]:
    """Step both through a mission; yields the time after each step."""
    on_air: dict[int, tuple[Aboard, wire.TeamState]] = {}
    for now in range(1, seconds + 1):
        speaker, said = on_air.pop(now, (None, None))
        lost = draws.uniform(seed, "study loss", now) < loss
        for craft in team:
            sent = [said] if said is not None and craft is speaker else []
            heard = [Report(speaker.craft, said)] if speaker and said and craft is not speaker and not lost else []
            craft.step(now, sent, heard)
        for place, craft in enumerate(team):
            if now % _CYCLE_S == place * _AIRTIME_S:
                on_air[now + _AIRTIME_S] = craft, craft.say(now, craft.plant.tell(now))
        yield now


def _sample(job: Consistency, run: int) -> float:
    """Squared error over variance claimed, of what craft 1 believes of craft 2."""
    seconds = _SETTLED_S + int(_CYCLE_S * draws.uniform(run, "study end"))
    team = team_of_two(job, run)
    for _ in sail(team, job.loss, run, seconds):
        pass
    observer, mate = team
    (belief,) = observer.mates
    return float((belief.progress * _LENGTH_M - mate.plant.distance_m) / belief.sigma_m) ** 2


def _own_sample(job: Consistency, run: int) -> float:
    """Squared error of the position over its covariance, per degree of freedom, with turns and lost fixes."""
    config, model, sigma = OwnFilterConfig(), SpeedModelConfig(), 1.0

    def normal(*what: object) -> np.ndarray[Any, Any]:
        return np.array(draws.normal(run, "study own", *what))

    own = OwnFilter(config, model, (0.0, 0.0))
    gain, keep = 1.0 - math.exp(-1.0 / model.lag_s), math.exp(-1.0 / model.error_time_s)
    place, current = np.zeros(2), config.current_sigma_mps * normal("current")
    error, error_in_speed = model.error_relative * normal("errors")
    speed = 1.0 + error_in_speed
    heading = 0.0
    for now in range(_SETTLED_S + int(_CYCLE_S * draws.uniform(run, "study end")) + 1):
        turned = math.pi / 2.0 * (now // 100 % 4)
        if now:
            steps, in_speed = normal("place", now), normal("speed", now)
            faster = speed + gain * ((1.0 + error) - speed) + model.noise_mps * in_speed[0]
            middle = heading + math.remainder(turned - heading, 2.0 * math.pi) / 2.0
            along = (speed + faster) / 2.0 * np.array([math.cos(middle), math.sin(middle)])
            place = place + along + current + config.place_noise_m * steps
            speed = faster
            error = keep * error + model.error_relative * math.sqrt(1.0 - keep * keep) * in_speed[1]
            current = current + config.current_noise_mps * normal("drift", now)
        heading = turned
        north, east = place + sigma * normal("fix", now)
        fix = Fix(now, now * 10**9, north, east, 0.0, heading, 1.0, sigma)
        # A turn that nobody sees would be another error than noise: the fix of that moment is never lost.
        lost = now % 100 and draws.uniform(run, "study fix", now) < job.loss
        own.step(float(now), None if lost else fix, 1.0)
    assert own.state is not None  # noqa: S101 - the first fix is never lost
    assert own.covariance is not None  # noqa: S101
    wrong = np.array(own.state[:2]) - place
    return float(wrong @ np.linalg.solve(own.covariance[:2, :2], wrong)) / 2.0
