"""What is kept of along-track filters at one time: all rows, how far everybody was, and what was said."""

from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from grex_agent.gaussian import Gaussian
from grex_link.wire import TeamState

Array = npt.NDArray[np.float64]

#: Two times that differ by less are one.
SAME_TIME_S = 1e-6


class Others(NamedTuple):
    """How far everybody was when a step was done."""

    rows: Array
    """Progress of each row, shape (n,): the mates first."""
    own: Array
    """Progress of oneself as each mate thinks, shape (m,); or (1,), if all are taken to think the same."""
    mates: int
    """How many mates there are: m."""

    def sums(self) -> Array:
        """Sum of the progress of its others, of each row; shape (n,)."""
        # A mate has oneself for others, and all mates but itself; oneself, in the rows behind, has all mates.
        instead = (self.own - self.rows.reshape(-1, len(self.own))).ravel()
        sums: Array = np.add.reduce(self.rows[: self.mates]) + instead
        return sums

    def of(self, row: int) -> list[float]:
        """Progress of the others of a row, one by one."""
        mates: list[float] = self.rows[: self.mates].tolist()
        if row >= len(mates):
            return mates
        return [float(self.own[min(row, len(self.own) - 1)]), *mates[:row], *mates[row + 1 :]]

    def put(self, mate: int, progress: float, own: float) -> "Others":
        """Say anew how far a mate is, and how far oneself is as it thinks, where each thinks for itself."""
        rows = self.rows.copy()
        rows[mate], rows[self.mates + mate] = progress, own
        return Others(rows, rows[self.mates :], self.mates)


class Said(msgspec.Struct):
    """A message at its place in the history of its row."""

    t_s: float
    message: TeamState
    prior: Gaussian
    """State before it, once it has been worked in."""


class Step(msgspec.Struct):
    """All rows at one time, after what was said of that time."""

    t_s: float
    x: Array
    """Shape (12, n): s, v, β of each row, and their covariance, line by line."""
    others: Others | None = None
    """None before anybody was driven: then each goes at planned speed."""
    said: dict[int, list[Said]] = {}
    """For a row what it said of this time and of times before the next step, in order."""

    def row(self, row: int) -> Gaussian:
        """State of a row."""
        return unpacked(self.x[:, row])

    def put(self, row: int, state: Gaussian) -> None:
        """Replace the state of a row."""
        self.x[:, row] = packed(state)

    def says(self, row: int, message: TeamState) -> bool:
        """Whether a message of a row is among those said at this step."""
        return any(said.message.t_s == message.t_s for said in self.said.get(row, ()))

    def before(self, row: int) -> Gaussian:
        """State of a row at this time, before what was said of it."""
        first = next(iter(self.said.get(row, ())), None)
        return self.row(row) if first is None or first.t_s > self.t_s + SAME_TIME_S else first.prior


def packed(state: Gaussian) -> Array:
    """State of a row as a column: s, v, β, and their covariance, line by line."""
    return np.concatenate((state.mean, state.covariance.ravel()))


def unpacked(column: Array) -> Gaussian:
    """Column of a row as its state."""
    return Gaussian(tuple(column[:3].tolist()), column[3:].reshape(3, 3).copy())
