"""The closest approach of any two craft in a run."""

import msgspec
import numpy as np
from numpy.typing import NDArray


class Approach(msgspec.Struct, frozen=True):
    """Where two craft came nearest to each other."""

    distance_m: float
    """Horizontally, metres."""
    craft: tuple[str, str]
    t_s: float
    """Mission time."""


def closest_approach(positions: NDArray[np.float64], craft: list[str], tick_s: float) -> Approach | None:
    """Find the closest approach; None for one craft, or no run.

    Parameters
    ----------
    positions : ndarray, shape (ticks, craft, 2)
        True north and east, metres, from mission time zero on.
    craft : list of str
        Names.
    tick_s : float
        Length of a tick, seconds.
    """
    best: Approach | None = None
    for place, name in enumerate(craft[:-1]):
        apart = positions[:, place + 1 :] - positions[:, place : place + 1]
        squared = (apart * apart).sum(axis=2)
        if not squared.size:
            continue
        tick, other = np.unravel_index(int(squared.argmin()), squared.shape)
        distance = float(np.sqrt(squared[tick, other]))
        if best is None or distance < best.distance_m:
            best = Approach(distance, (name, craft[place + 1 + int(other)]), float(tick) * tick_s)
    return best
