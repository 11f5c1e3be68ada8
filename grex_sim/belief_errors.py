"""How far beliefs about mates are from the truth, and whether their own sigma says so (NEES).

The normalised estimation error squared of a belief is (Δnorth² + Δeast²) / σ², σ being that of each horizontal axis.
For a consistent estimator it is χ²-distributed with 2 degrees of freedom: 2 on average, and 95 % of all lie in `BAND`.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from grex_link.messages import AgentState, Truth
from grex_sim.intervals import Estimate, mean_of_series
from grex_sim.score import Series

#: 2.5 % and 97.5 % of χ² with 2 degrees of freedom, −2·ln(1 − p).
BAND = (-2.0 * math.log(0.975), -2.0 * math.log(0.025))


@dataclass(frozen=True, slots=True)
class BeliefErrors:
    """One craft's beliefs about one mate, step by step; shape (n,) each.

    Attributes
    ----------
    t_s : ndarray
        Mission time of the tick, seconds.
    north_m, east_m : ndarray
        Believed minus true position.
    sigma_m : ndarray
        Claimed standard deviation of each axis; NaN where none is claimed.
    age_s : ndarray
        Age of the newest information; NaN before there is any.
    """

    t_s: Series
    north_m: Series
    east_m: Series
    sigma_m: Series
    age_s: Series

    @property
    def distance_m(self) -> Series:
        """Horizontal error."""
        return np.hypot(self.north_m, self.east_m)

    @property
    def nees(self) -> Series:
        """Normalised error squared; NaN where no sigma is claimed."""
        return (self.north_m**2 + self.east_m**2) / self.sigma_m**2

    @property
    def rms_m(self) -> float:
        """Root mean square of the horizontal error; NaN if there is no number."""
        finite = self.distance_m[np.isfinite(self.distance_m)]
        return math.sqrt(float((finite**2).mean())) if len(finite) else math.nan

    @property
    def mean_nees(self) -> Estimate:
        """Mean NEES, 2 if consistent."""
        return mean_of_series(self.nees)

    @property
    def inside(self) -> float:
        """Share of the time in which the NEES lies in `BAND`, 0.95 if consistent; NaN if none is claimed."""
        nees = self.nees[np.isfinite(self.nees)]
        return float(((nees >= BAND[0]) & (nees <= BAND[1])).mean()) if len(nees) else math.nan


def belief_errors(states: Iterable[AgentState], truths: Mapping[int, Truth]) -> dict[str, BeliefErrors]:
    """Compare what one craft believed with the truth of the same tick.

    Parameters
    ----------
    states : iterable of AgentState
        Of one craft.
    truths : dict of int to Truth
        By tick.

    Returns
    -------
    dict of str to BeliefErrors
        By mate.
    """
    rows: dict[str, list[tuple[float, ...]]] = {}
    poses = {tick: {pose.craft: pose for pose in truth.poses} for tick, truth in truths.items()}
    for state in states:
        for belief in state.mates:
            pose = poses.get(state.tick, {}).get(belief.craft)
            if pose is None:
                continue
            sigma_m = belief.sigma_m if belief.sigma_m > 0.0 else math.nan
            age_s = belief.age_s if belief.age_s >= 0.0 else math.nan
            errors = belief.north_m - pose.north_m, belief.east_m - pose.east_m
            rows.setdefault(belief.craft, []).append((truths[state.tick].t_ns / 1e9, *errors, sigma_m, age_s))
    return {mate: BeliefErrors(*np.array(found, dtype=float).T) for mate, found in rows.items()}


def band_of_mean(count: int) -> tuple[float, float]:
    """Find the 95 % band of the mean NEES of so many beliefs at one time, taken as independent."""
    from scipy.special import chdtri

    return tuple(float(chdtri(2 * count, tail)) / count for tail in (0.975, 0.025))  # type: ignore[return-value]
