"""The paper's planar filter against filterpy's, and how filterpy is loaded (eqs. 6–11)."""

import subprocess
import sys
from pathlib import Path

import filterpy.kalman
import numpy as np
import pytest

from grex_agent.team.kalman import PlanarModel, PlanarState, Recalculation, _kalman_filter_class
from grex_link.config import KalmanConfig

CONFIG = KalmanConfig()
START = PlanarState(100.0, -50.0, 0.8, 0.6, 0.01, 0.002, 0.0025)


def paper_filter(config, start=START):
    """Build filterpy's filter with C, R and a start; Φ, B and Q are given at each step."""
    reference = filterpy.kalman.KalmanFilter(dim_x=4, dim_z=2, dim_u=2)
    reference.x = mean(start)
    reference.P = np.kron(np.array([[start.pp, start.pv], [start.pv, start.vv]]), np.eye(2))
    reference.H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
    reference.R = config.fix_sigma_m**2 * np.eye(2)
    return reference


def paper_predict(reference, config, u, dt, gain=None):
    """Predict by eqs. (6), (8) and (9)."""
    a = config.velocity_transfer_per_s * dt if gain is None else gain
    reference.predict(
        u=np.array(u),
        F=np.array([[1.0, 0.0, dt, 0.0], [0.0, 1.0, 0.0, dt], [0.0, 0.0, 1.0 - a, 0.0], [0.0, 0.0, 0.0, 1.0 - a]]),
        B=np.array([[0.0, 0.0], [0.0, 0.0], [a, 0.0], [0.0, a]]),
        Q=dt * np.diag(np.repeat([config.position_process_sigma_m**2, config.velocity_process_sigma_mps**2], 2)),
    )


def mean(state):
    """Mean of a state, in filterpy's order."""
    return np.array([state.north, state.east, state.v_north, state.v_east])


def assert_equal(state, reference):
    """Hold a state against filterpy's mean and covariance."""
    assert mean(state) == pytest.approx(reference.x, rel=1e-12, abs=1e-12)
    covariance = np.kron(np.array([[state.pp, state.pv], [state.pv, state.vv]]), np.eye(2))
    assert covariance == pytest.approx(reference.P, rel=1e-12, abs=1e-12)


def wanted_velocities(count):
    """Random wanted velocities, the same ones every time."""
    return np.random.default_rng(2008).uniform(-3.0, 3.0, (count, 2)).tolist()


@pytest.mark.parametrize(
    ("config", "dt"),
    [
        (CONFIG, 1.0),
        (CONFIG, 0.1),
        (CONFIG, 0.37),
        (KalmanConfig(velocity_transfer_per_s=0.4, position_process_sigma_m=0.3, fix_sigma_m=2.0), 1.0),
        (KalmanConfig(velocity_transfer_per_s=0.4, velocity_process_sigma_mps=0.0), 2.5),
    ],
)
def test_kf1_is_filterpys(config, dt):
    """KF 1 in closed form predicts the mean and covariance that filterpy does with the paper's matrices."""
    model, reference, state = PlanarModel(config), paper_filter(config), START
    for u in wanted_velocities(200):
        state = model.predict(state, *u, dt)
        paper_predict(reference, config, u, dt)
        assert_equal(state, reference)


def test_kf1_with_steps_of_any_length():
    """KF 1 equals filterpy when every step has another length, as at live paces."""
    model, reference, state = PlanarModel(CONFIG), paper_filter(CONFIG), START
    for u, dt in zip(wanted_velocities(200), np.random.default_rng(1).uniform(0.01, 1.0, 200).tolist(), strict=True):
        state = model.predict(state, *u, dt)
        paper_predict(reference, CONFIG, u, dt)
        assert_equal(state, reference)


def test_kf2_is_filterpys():
    """KF 2, predicting and updating in turn, equals filterpy with the paper's matrices."""
    kf2, reference = Recalculation(PlanarModel(CONFIG)), paper_filter(CONFIG)
    kf2.start(START)
    for step, (u, fix) in enumerate(zip(wanted_velocities(200), wanted_velocities(400)[200:], strict=True)):
        dt = 1.0 + 0.01 * (step % 80)  # more lengths than it keeps matrices for
        kf2.predict(*u, dt)
        paper_predict(reference, CONFIG, u, dt, gain=1.0)
        if step % 7 == 3:
            kf2.update(*fix)
            reference.update(np.array(fix))
        assert_equal(kf2.state, reference)


def test_kf2_starts_anew():
    """What KF 2 did for one mate leaves no trace in what it does for the next."""
    used, fresh = (Recalculation(PlanarModel(CONFIG)) for _ in range(2))
    used.start(PlanarState(1.0, 2.0, 3.0, 4.0, 5.0, 0.0, 6.0))
    used.predict(1.0, 1.0, 0.5)
    used.update(7.0, 8.0)
    for kf2 in (used, fresh):
        kf2.start(START)
        kf2.predict(1.0, 0.0, 1.0)
        kf2.update(101.0, -49.0)
    assert used.state == fresh.state


def test_a_message_draws_the_estimate_and_narrows_it():
    """An update moves the mean towards the fix, not beyond it, and makes the filter surer."""
    kf2 = Recalculation(PlanarModel(CONFIG))
    kf2.start(START)
    kf2.update(101.0, -50.0)
    assert 100.0 < kf2.state.north < 101.0
    assert kf2.state.east == pytest.approx(-50.0)
    assert kf2.state.pp < START.pp
    assert kf2.state.vv < START.vv


def test_a_late_step_is_stable():
    """A step longer than 1/K_v takes over the whole wanted velocity and no more, in KF 1 and KF 2 alike."""
    model = PlanarModel(CONFIG)
    state = model.predict(START, 2.0, -1.0, 8.0)
    assert mean(state) == pytest.approx([106.4, -45.2, 2.0, -1.0])
    kf2, reference = Recalculation(model), paper_filter(CONFIG)
    kf2.start(START)
    kf2.predict(2.0, -1.0, 8.0)
    paper_predict(reference, CONFIG, (2.0, -1.0), 8.0, gain=1.0)
    assert_equal(state, reference)
    assert_equal(kf2.state, reference)


def test_filterpy_that_is_there_is_taken():
    """In a process that has filterpy already, its own class is used."""
    assert _kalman_filter_class() is filterpy.kalman.KalmanFilter


def test_filterpy_is_loaded_without_a_trace(monkeypatch):
    """Loading the class where filterpy is not there yet leaves nothing of filterpy behind."""
    for name in [name for name in sys.modules if name.split(".")[0] == "filterpy"]:
        monkeypatch.delitem(sys.modules, name)
    found = _kalman_filter_class()
    assert not [name for name in sys.modules if name.split(".")[0] == "filterpy"]
    assert found is not filterpy.kalman.KalmanFilter
    assert found.update.__code__ == filterpy.kalman.KalmanFilter.update.__code__


def test_filterpy_is_loaded_alone():
    """The class is filterpy's own, loaded without scipy and matplotlib; the rest of filterpy can be imported after."""
    script = """
import inspect, sys
from pathlib import Path
from grex_agent.team.kalman import PlanarModel, PlanarState, Recalculation, _kalman_filter_class
from grex_link.config import KalmanConfig
found = _kalman_filter_class()
heavy = {"filterpy", "scipy", "matplotlib"}
assert not heavy & {name.split(".")[0] for name in sys.modules}, "something is left behind"
kf2 = Recalculation(PlanarModel(KalmanConfig()))
kf2.start(PlanarState(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0))
kf2.predict(1.0, 0.0, 1.0)
kf2.update(1.0, 0.0)
import filterpy.kalman
assert filterpy.kalman.KalmanFilter(dim_x=2, dim_z=1).x.shape == (2, 1)
assert filterpy.common.Q_discrete_white_noise(2).shape == (2, 2)
assert abs(filterpy.stats.logpdf(0.0, 0.0, 1.0) + 0.9189385) < 1e-6
assert inspect.getsource(found) == inspect.getsource(filterpy.kalman.KalmanFilter)
print(Path(inspect.getsourcefile(found)).relative_to(Path(filterpy.__file__).parent))
"""
    command = [sys.executable, "-W", "error", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0, check=False)
    assert done.stderr == ""
    assert Path(done.stdout.strip()) == Path("kalman/kalman_filter.py")
