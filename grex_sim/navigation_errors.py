"""How far from the truth the positions are that agents believe in, and whether they know it."""

import math
from array import array
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from grex_link.messages import AgentState

_COLUMNS = 6


class PlaceErrors(msgspec.Struct, frozen=True):
    """Errors of a position over a run; horizontal."""

    steps: int
    rms_m: float
    """Root mean square of the distance between belief and truth, metres."""
    max_m: float
    last_m: float
    """At the end of the run."""
    sigma_m: float
    """What the agent claimed for that distance: root of the mean trace of its covariance, metres."""
    nees: float | None
    """Mean of eᵀ P⁻¹ e over the run, whose values are not independent: 2 if the covariance is right, less if it is too
    great; None if none is claimed."""


class BelievedPlaces:
    """Takes down what agents believe, to be compared with the truth when the run is over."""

    def __init__(self) -> None:
        self._rows: dict[tuple[str, str], array[float]] = {}

    def note(self, who: str, state: AgentState) -> None:
        """Take down the positions in the state of an agent."""
        for place in state.places:
            rows = self._rows.setdefault((who, place.craft), array("d"))
            rows.extend((state.tick, place.north_m, place.east_m, *place.covariance_m2))

    def errors(self, truth: NDArray[np.float64], team: Sequence[str]) -> dict[str, PlaceErrors]:
        """Compare with the truth.

        Parameters
        ----------
        truth : ndarray, shape (ticks, craft, 2)
            True north and east, metres.
        team : sequence of str
            The craft, in that order.

        Returns
        -------
        dict of str to PlaceErrors
            By craft for its own position; ``base>craft`` for what a base believes of the craft it watches.
        """
        found = {}
        for who in team:
            for craft in team:
                rows = np.array(self._rows.get((who, craft), ())).reshape(-1, _COLUMNS)
                rows = rows[rows[:, 0] < len(truth)]
                if len(rows):
                    at = truth[rows[:, 0].astype(int), team.index(craft)]
                    found[craft if who == craft else f"{who}>{craft}"] = _errors(rows[:, 1:3] - at, rows[:, 3:])
        return found


def _errors(wrong: NDArray[np.float64], covariance: NDArray[np.float64]) -> PlaceErrors:
    squared = (wrong**2).sum(axis=1)
    north, east, both = covariance.T
    determinant = north * east - both**2
    normalised = east * wrong[:, 0] ** 2 - 2.0 * both * wrong[:, 0] * wrong[:, 1] + north * wrong[:, 1] ** 2
    known = determinant > 0.0  # a navigation that claims no error has no NEES
    nees = float((normalised[known] / determinant[known]).mean()) if known.any() else None
    return PlaceErrors(
        len(wrong),
        math.sqrt(float(squared.mean())),
        math.sqrt(float(squared.max())),
        math.sqrt(float(squared[-1])),
        math.sqrt(float((north + east).mean())),
        nees,
    )
