"""The paper's planar Kalman filters KF 1 and KF 2 (GREX 2008, eqs. 6–11), on filterpy.

State x = [north, east, v_north, v_east]ᵀ, measurement y = [north, east]ᵀ, input u = wanted velocity.

    Φ = [1 0 dt 0; 0 1 0 dt; 0 0 1-a 0; 0 0 0 1-a],  B = [0 0; 0 0; a 0; 0 a],  C = [1 0 0 0; 0 1 0 0]

with a = K_v dt, limited to 1 so that a late step cannot make the model unstable. Both axes have the same model and the
same noise, so the covariance of both is one 2×2 matrix: three numbers.

KF 1 runs at every step and only predicts (eq. 10); KF 2 runs when a message arrives (eq. 11). The prediction of both
is written out, because it runs for every mate at every step; the update is filterpy's, and the tests hold the whole
against filterpy's filter.
"""

import importlib.util
import sys
from types import ModuleType
from typing import Any

import msgspec
import numpy as np

from grex_link.config import KalmanConfig


class PlanarState(msgspec.Struct, frozen=True, gc=False):
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
        v_north, v_east, pv, vv = x.v_north, x.v_east, x.pv, x.vv
        return PlanarState(
            x.north + dt * v_north,
            x.east + dt * v_east,
            keep * v_north + gain * u_north,
            keep * v_east + gain * u_east,
            x.pp + dt * (2.0 * pv + dt * vv) + self.position_noise * dt,
            keep * (pv + dt * vv),
            keep * keep * vv + self.velocity_noise * dt,
        )


class Recalculation:
    """KF 2: the update at the time of a message, and the recalculation from there up to now (eq. 11).

    The update is filterpy's; the prediction is that of KF 1, which has the same structure. One object serves all
    mates of a craft, one after the other.

    Parameters
    ----------
    model : PlanarModel
        The same model as KF 1.

    Attributes
    ----------
    state : PlanarState
        Mean and covariance now.
    """

    def __init__(self, model: PlanarModel) -> None:
        self._predict = model.predict
        self._filter: Any = _kalman_filter_class()(dim_x=4, dim_z=2, dim_u=2)
        self._filter.H = np.eye(2, 4)
        self._filter.R = np.eye(2) * model.fix_noise
        self.state = PlanarState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def start(self, x: PlanarState) -> None:
        """Go back to a stored state."""
        self.state = x

    def predict(self, u_north: float, u_east: float, dt: float) -> None:
        """Predict over `dt` seconds with a wanted velocity."""
        self.state = self._predict(self.state, u_north, u_east, dt)

    def update(self, north_m: float, east_m: float) -> None:
        """Work in a position."""
        kalman, x = self._filter, self.state
        kalman.x = np.array([x.north, x.east, x.v_north, x.v_east])
        kalman.P = np.array(
            [[x.pp, 0.0, x.pv, 0.0], [0.0, x.pp, 0.0, x.pv], [x.pv, 0.0, x.vv, 0.0], [0.0, x.pv, 0.0, x.vv]]
        )
        kalman.update(np.array([north_m, east_m]))
        north, east, v_north, v_east = kalman.x.tolist()
        pp, pv, vv = float(kalman.P[0, 0]), float(kalman.P[0, 2]), float(kalman.P[2, 2])
        self.state = PlanarState(north, east, v_north, v_east, pp, pv, vv)


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
