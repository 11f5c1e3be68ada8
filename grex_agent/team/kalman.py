"""The paper's planar Kalman filter (GREX 2008, eqs. 6–11): KF 1 in closed form, KF 2 on filterpy.

State x = [north, east, v_north, v_east]ᵀ, measurement y = [north, east]ᵀ, input u = wanted velocity.

    Φ = [1 0 dt 0; 0 1 0 dt; 0 0 1-a 0; 0 0 0 1-a],  B = [0 0; 0 0; a 0; 0 a],  C = [1 0 0 0; 0 1 0 0]

with a = K_v dt, limited to 1 so that a late step cannot make the model unstable. Both axes have the same model and the
same noise, so the covariance of both is one 2×2 matrix: three numbers.

KF 1 runs at every step and only predicts (eq. 10); KF 2 runs when a message arrives (eq. 11). The first is written out,
because it runs for every mate at every step; the tests hold it against filterpy's.
"""

import importlib.util
import sys
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from grex_link.config import KalmanConfig


class PlanarState(NamedTuple):
    """Mean and covariance; metres, m/s and their products."""

    north: float
    east: float
    v_north: float
    v_east: float
    pp: float
    """Variance of each position."""
    pv: float
    """Covariance of position and velocity of each axis."""
    vv: float
    """Variance of each velocity."""


class PlanarModel:
    """KF 1: the prediction of one mate's state (eqs. 6–10).

    Parameters
    ----------
    config : KalmanConfig
        K_v and the noises.
    """

    def __init__(self, config: KalmanConfig) -> None:
        self.transfer_per_s = config.velocity_transfer_per_s
        self.position_noise = config.position_process_sigma_m**2
        self.velocity_noise = config.velocity_process_sigma_mps**2
        self.fix_noise = config.fix_sigma_m**2

    def predict(self, x: PlanarState, u_north: float, u_east: float, dt: float) -> PlanarState:
        """Predict over `dt` seconds with a wanted velocity, m/s north and east."""
        gain = min(self.transfer_per_s * dt, 1.0)
        keep = 1.0 - gain
        north, east, v_north, v_east, pp, pv, vv = x
        return PlanarState(
            north + dt * v_north,
            east + dt * v_east,
            keep * v_north + gain * u_north,
            keep * v_east + gain * u_east,
            pp + dt * (2.0 * pv + dt * vv) + self.position_noise * dt,
            keep * (pv + dt * vv),
            keep * keep * vv + self.velocity_noise * dt,
        )


class Recalculation:
    """KF 2: the update at the time of a message, and the recalculation up to now (eq. 11), on filterpy.

    One object serves all mates of a craft, one after the other.

    Parameters
    ----------
    model : PlanarModel
        The same model as KF 1.
    """

    def __init__(self, model: PlanarModel) -> None:
        self._model = model
        self._filter: Any = _kalman_filter_class()(dim_x=4, dim_z=2, dim_u=2)
        self._filter.H = np.eye(2, 4)
        self._filter.R = np.eye(2) * model.fix_noise
        self._matrices: dict[float, tuple[Any, Any, Any]] = {}

    @property
    def state(self) -> PlanarState:
        """Mean and covariance now."""
        north, east, v_north, v_east = self._filter.x.tolist()
        covariance = self._filter.P
        return PlanarState(
            north, east, v_north, v_east,
            float(covariance[0, 0]), float(covariance[0, 2]), float(covariance[2, 2]),
        )  # fmt: skip

    def start(self, x: PlanarState) -> None:
        """Go back to a stored state."""
        self._filter.x = np.array([x.north, x.east, x.v_north, x.v_east])
        self._filter.P = np.array(
            [[x.pp, 0.0, x.pv, 0.0], [0.0, x.pp, 0.0, x.pv], [x.pv, 0.0, x.vv, 0.0], [0.0, x.pv, 0.0, x.vv]]
        )

    def update(self, north_m: float, east_m: float) -> None:
        """Work in a position."""
        self._filter.update(np.array([north_m, east_m]))

    def predict(self, u_north: float, u_east: float, dt: float) -> None:
        """Predict over `dt` seconds with a wanted velocity."""
        transition, control, noise = self._matrices.get(dt) or self._make_matrices(dt)
        self._filter.predict(u=np.array([u_north, u_east]), B=control, F=transition, Q=noise)

    def _make_matrices(self, dt: float) -> tuple[Any, Any, Any]:
        gain = min(self._model.transfer_per_s * dt, 1.0)
        transition = np.diag([1.0, 1.0, 1.0 - gain, 1.0 - gain])
        transition[0, 2] = transition[1, 3] = dt
        control = np.zeros((4, 2))
        control[2, 0] = control[3, 1] = gain
        position, velocity = self._model.position_noise * dt, self._model.velocity_noise * dt
        noise = np.diag([position, position, velocity, velocity])
        if len(self._matrices) > 64:  # live steps are never exactly equal
            self._matrices.clear()
        self._matrices[dt] = transition, control, noise
        return self._matrices[dt]


def _kalman_filter_class() -> Any:
    """Import filterpy's `KalmanFilter` without the rest of filterpy.

    Its packages import scipy.stats and matplotlib as they load: seconds of start-up on a craft's small computer, for
    nothing that a Kalman filter uses. While its one module loads, empty packages stand in for them.
    """
    root = importlib.util.find_spec("filterpy")
    if "filterpy" in sys.modules or root is None or not root.submodule_search_locations:
        from filterpy.kalman import KalmanFilter

        return KalmanFilter
    folder = root.submodule_search_locations[0]
    stand_ins = {
        name: ModuleType(name) for name in ("filterpy", "filterpy.kalman", "filterpy.common", "filterpy.stats")
    }
    for name, module in stand_ins.items():
        module.__path__ = [folder + name.removeprefix("filterpy").replace(".", "/")]
    stand_ins["filterpy.stats"].logpdf = None  # type: ignore[attr-defined] # only its likelihood would call it
    sys.modules.update(stand_ins)
    try:
        from filterpy.common import helpers

        stand_ins["filterpy.common"].__dict__.update(pretty_str=helpers.pretty_str, reshape_z=helpers.reshape_z)
        from filterpy.kalman.kalman_filter import KalmanFilter
    finally:
        for name in [name for name in sys.modules if name.split(".")[0] == "filterpy"]:
            del sys.modules[name]
    return KalmanFilter
