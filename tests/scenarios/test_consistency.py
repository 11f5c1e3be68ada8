"""Errors are as great as the estimators claim: NEES of craft that move as each estimator thinks.

::

    craft 1   ───────────►   both order their speed by what they believe of the other;
    craft 2   ───────────►   messages every 30 s, 10 s on their way, some lost

One sample a run, so that samples are independent; the sum over n runs is χ² with n degrees of freedom.
"""

import math

import msgspec
import numpy as np
import pytest

from grex_agent.team.acknowledgement import Acknowledgements
from grex_agent.team.planar import FirstLevel
from grex_sim.study.consistency import RUNS, Consistency, sail, team_of_two
from grex_sim.study.rows import ESTIMATORS
from grex_sim.study.table import chi_square_band


def nees(job, seeds):
    """Mean over some seeds, and the band in which it is to be."""
    values = [job.run(seed) for seed in range(1, seeds + 1)]
    parts = 2 if job.estimator == "own_filter" else 1
    return sum(values) / seeds, chi_square_band(parts * RUNS * seeds)


@pytest.mark.parametrize("estimator", ["dead_reckoning", "second_level", "along_track", "own_filter"])
def test_consistent_though_half_is_lost(estimator):
    """With half of the messages lost, errors are neither greater nor smaller than is claimed."""
    mean, (least, most) = nees(Consistency(estimator, 0.5), 8)
    assert least < mean < most


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_consistent(estimator, loss):
    """Every estimator is consistent when mates move as it thinks, at 0, 30 and 50 % loss."""
    mean, (least, most) = nees(Consistency(estimator, loss), 40)
    assert least < mean < most


def stiff(runs):
    """Errors in metres, and NEES, of along_track at ten times the paper's gain with half of the messages lost."""
    job, errors, normalised = Consistency("along_track", 0.5, 8.0), [], []
    for run in range(runs):
        observer, mate = team = team_of_two(job, run)
        for _ in sail(team, job.loss, run, 240 + run % 30):
            pass
        (belief,) = observer.mates
        error = belief.progress * 400.0 - mate.plant.distance_m
        errors.append(abs(error))
        normalised.append((error / belief.sigma_m) ** 2)
    return sum(errors) / runs, sum(normalised) / runs


def test_what_acknowledgements_are_worth(monkeypatch):
    """At a stiff gain, to know what the mate has heard makes errors smaller, and nearly as small as is claimed."""
    error_m, nees_of_knowing = stiff(60)
    monkeypatch.setattr(Acknowledgements, "flags", lambda *_: 0)  # everybody says that nothing is missing
    blind_m, nees_of_blind = stiff(60)
    assert error_m < 0.9 * blind_m
    assert nees_of_knowing < 0.75 * nees_of_blind


class Overconfident(FirstLevel):
    """Claims half of the deviation that it has."""

    def step(self, now_s, own, sent, heard):
        beliefs = super().step(now_s, own, sent, heard)
        return [msgspec.structs.replace(belief, sigma_m=belief.sigma_m / 2.0) for belief in beliefs]


def test_overconfidence_is_seen():
    """An estimator that claims half of its deviation falls out of the band."""
    mean, (_, most) = nees(Consistency(f"{__name__}:Overconfident", 0.3), 8)
    assert mean > 1.5 * most


@pytest.mark.parametrize(
    ("estimator", "parts"), [("along_track", 3), ("biased_planar", 5), ("second_level", 4)], ids=str
)
def test_the_whole_state_is_consistent(estimator, parts):
    """Not the place alone: the whole state of a mate that heeds no others has errors as great as is claimed."""
    assert_whole(estimator, parts, gain_mps=0.0, runs=30)


@pytest.mark.slow
def test_the_whole_state_is_consistent_though_others_are_heeded():
    """At the paper's gain, what the others make a mate do is too little to be seen in 300 runs."""
    assert_whole("along_track", 3, gain_mps=0.8, runs=300)


def assert_whole(estimator, parts, gain_mps, runs):
    """Hold the squared error of the whole state against its band."""
    mean = math.fsum(_whole(estimator, gain_mps, run) for run in range(runs)) / runs
    least, most = chi_square_band(parts * runs)
    assert least < mean / parts < most


def _whole(estimator, gain_mps, run):
    """Squared error of the whole state of craft 2 aboard craft 1, over its covariance."""
    team = team_of_two(Consistency(estimator, 0.5, gain_mps), 5000 + run)
    for _ in sail(team, 0.5, 5000 + run, 200 + run % 30):
        pass
    observer, mate = team
    plant = mate.plant
    if estimator == "along_track":
        state = observer.estimator._rows.state(0)
        believed, true, covariance = state.mean, (plant.distance_m, plant._speed, plant._error), state.covariance
    elif estimator == "biased_planar":
        state = observer.estimator._mates["auv2"].state
        believed, covariance = state.x.mean, state.x.covariance
        true = (*plant.place(), *plant._velocity, plant._error)
    else:
        x = observer.estimator._mates["auv2"].state.x
        believed, true = (x.north, x.east, x.v_north, x.v_east), (*plant.place(), *plant._velocity)
        covariance = np.kron([[x.pp, x.pv], [x.pv, x.vv]], np.eye(2))
    wrong = np.array(believed) - np.array(true)
    return float(wrong @ np.linalg.solve(covariance, wrong))
