"""What a measured range says of a position: the second-order Kalman update.

With d the vector from the other end, r̂ = |d| the range expected and u = d/r̂ horizontally, the expected range is
r̂ + ½·tr(H·P), its variance uᵀP u + ½·tr(H·P·H·P) + R, where P is the covariance of the horizontal position and
H = (I - u uᵀ)/r̂ the curvature of the sphere. The terms with H count when the position is uncertain across the line of
sight: without them a filter near the other end would take the curvature for news. The other end's own uncertainty is
that of its horizontal position, taken to be the same in all directions.
"""

import math
from typing import NamedTuple

import numpy as np

from grex_agent.gaussian import Gaussian, update_along

_NORTH, _EAST = 0, 1
#: Two modems are never nearer: keeps the line of sight defined.
_NEAREST_M = 0.1


class Range(NamedTuple):
    """A distance to a place that is known, more or less.

    Attributes
    ----------
    t_s, there_s : float
        Mission times of the two ends: sound that has come from there has left earlier.
    craft : str
        The other end.
    range_m : float
        Measured slant range, metres.
    north_m, east_m, down_m : float
        Where the other end was, metres NED.
    sigma_m : float
        Standard deviation of each of its horizontal coordinates, metres.
    """

    t_s: float
    there_s: float
    craft: str
    range_m: float
    north_m: float
    east_m: float
    down_m: float
    sigma_m: float


class Surprise(NamedTuple):
    """A range against what was expected.

    Attributes
    ----------
    row : ndarray, shape (n,)
        Derivatives of the range by the state.
    innovation_m, variance_m2 : float
        Measured less expected, and the variance of that.
    noise_m2 : float
        The part of the variance that is not the state's.
    """

    row: np.ndarray[tuple[int, ...], np.dtype[np.float64]]
    innovation_m: float
    variance_m2: float
    noise_m2: float

    @property
    def sigmas(self) -> float:
        """Innovation over its standard deviation: normal if all is well."""
        return self.innovation_m / math.sqrt(self.variance_m2)


def surprise(
    x: Gaussian, heard: Range, down_m: float, sigma_m: float, moved_m: tuple[float, float] = (0.0, 0.0)
) -> Surprise:
    """Compare a range with a state whose first two components are north and east.

    Parameters
    ----------
    x : Gaussian
        The state.
    heard : Range
        What was measured.
    down_m : float
        Own depth, which is known: the difference in depth is taken out.
    sigma_m : float
        Noise of the range.
    moved_m : tuple of float
        How far the craft moves, north and east, from the time of the state until that of the range.
    """
    north = x.mean[_NORTH] + moved_m[0] - heard.north_m
    east = x.mean[_EAST] + moved_m[1] - heard.east_m
    down = down_m - heard.down_m
    expected = max(math.sqrt(north * north + east * east + down * down), _NEAREST_M)
    sight = np.array([north, east]) / expected
    p = x.covariance[:2, :2]
    curvature = (np.eye(2) - np.outer(sight, sight)) / expected
    bent = curvature @ p
    noise = sigma_m**2 + float(sight @ sight) * heard.sigma_m**2 + 0.5 * float(np.trace(bent @ bent))
    row = np.zeros(len(x.mean))
    row[:2] = sight
    innovation = heard.range_m - expected - 0.5 * float(np.trace(bent))
    return Surprise(row, innovation, float(sight @ p @ sight) + noise, noise)


def work_in(x: Gaussian, seen: Surprise) -> Gaussian:
    """Correct a state by a range."""
    return update_along(x, seen.row, seen.innovation_m, seen.noise_m2)


def with_free_offset(x: Gaussian, offset: int, variance: float) -> Gaussian:
    """Let a position and the offset of what is told of it be wrong by so much more; their sum stays as it is.

    Parameters
    ----------
    x : Gaussian
        The state.
    offset : int
        Which component is the offset north; that east follows it.
    variance : float
        How much, m².
    """
    freed = x.covariance.copy()
    for axis, off in ((_NORTH, offset), (_EAST, offset + 1)):
        freed[axis, axis] += variance
        freed[off, off] += variance
        freed[axis, off] -= variance
        freed[off, axis] -= variance
    return Gaussian(x.mean, freed)
