"""How near any two of several craft come to each other, when they go straight between given moments."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Places = npt.NDArray[np.float64]


class Approach(NamedTuple):
    """The closest approach of any two craft.

    Attributes
    ----------
    distance_m : float
        Between them then.
    first, second : int
        Which two, in the order of the team.
    moment : float
        When: the number of a moment, and the share of the way to the next one.
    """

    distance_m: float
    first: int
    second: int
    moment: float


def closest_approach(places: Places) -> Approach | None:
    """Find the closest approach of any two craft.

    Parameters
    ----------
    places : ndarray, shape (moments, craft, 2 or 3)
        Where each craft is at each moment, metres.

    Returns
    -------
    Approach or None
        The first of equally close ones; None where there are no two craft, or no moment.
    """
    moments, craft = places.shape[:2]
    if not moments or craft < 2:
        return None
    found = (_nearest_to(places, first) for first in range(craft - 1))
    return min(found, key=lambda approach: approach.distance_m)


def _nearest_to(places: Places, first: int) -> Approach:
    """Find the closest approach of a craft and those after it."""
    away = places[:, first + 1 :] - places[:, first, None]
    moves = np.diff(away, axis=0, append=away[-1:])
    length2 = (moves**2).sum(axis=2)
    towards = -(away * moves).sum(axis=2)
    shares = np.clip(np.divide(towards, length2, out=np.zeros_like(towards), where=length2 > 0.0), 0.0, 1.0)
    distances = np.linalg.norm(away + shares[..., None] * moves, axis=2)
    moment, mate = divmod(int(distances.argmin()), distances.shape[1])
    return Approach(float(distances[moment, mate]), first, first + 1 + mate, moment + float(shares[moment, mate]))


def greatest_distance_m(places: Places) -> float:
    """Find the greatest distance of any two craft at any moment, metres; shape as in `closest_approach`."""
    craft = places.shape[1]
    away = (np.linalg.norm(places[:, first + 1 :] - places[:, first, None], axis=2) for first in range(craft - 1))
    return max((float(distances.max()) for distances in away if distances.size), default=0.0)
