"""Plans as one line each: distance along them, and progress (track number plus Θ)."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from grex_agent.mission import CraftPlan
from grex_link.wire import TeamState

#: Variance of a Θ told in steps of 1/4095.
_THETA_VARIANCE = (1.0 / 4095.0) ** 2 / 12.0

Array = npt.NDArray[np.float64]


class PathLength:
    """The plan of one craft as one line.

    Parameters
    ----------
    plan : CraftPlan
        The tracks.
    """

    def __init__(self, plan: CraftPlan) -> None:
        self.tracks = plan.tracks
        self._point = plan.point
        self.starts = [0.0, *accumulate(track.length_m for track in plan.tracks)][:-1]

    def number(self, distance_m: float) -> int:
        """Find the number of the track at a distance; the first and the last one go on beyond their ends."""
        return max(bisect_right(self.starts, distance_m) - 1, 0)

    def progress(self, distance_m: float) -> float:
        """Track number plus Θ at a distance."""
        number = self.number(distance_m)
        return number + (distance_m - self.starts[number]) / self.tracks[number].length_m

    def point(self, distance_m: float) -> tuple[float, float]:
        """North and east of the plan at a distance, metres."""
        return self._point(self.progress(distance_m))

    def told(self, message: TeamState) -> tuple[float, float]:
        """Distance that a message tells, and its variance: Θ's, where it is not cut off at 0 or 1."""
        number = min(message.track, len(self.tracks) - 1)
        track, theta = self.tracks[number], message.theta
        if not 0.0 < theta < 1.0:
            theta = track.locate(message.north_m, message.east_m).theta
        variance = message.sigma_m**2 + _THETA_VARIANCE * track.length_m**2
        return self.starts[number] + theta * track.length_m, variance


class Located(NamedTuple):
    """Where craft stand on their plans; shape (n,) each."""

    progress: Array
    """Track number plus Θ."""
    length_m: Array
    """Of the present track."""
    planned_mps: Array
    """Planned speed of the present track."""
    theta: Array
    """Of the present track."""
    shape: Array
    """Of the present track, (7, n); see `grex_agent.path.Track`."""

    def points(self) -> tuple[Array, Array]:
        """North and east of the plans there, metres."""
        a, b, c, d, radius, start, turn = self.shape
        angle = start + turn * self.theta
        return a + b * self.theta + radius * np.cos(angle), c + d * self.theta + radius * np.sin(angle)


class PathLengths:
    """The plans of many craft, a row each, as arrays.

    Parameters
    ----------
    plans : sequence of CraftPlan
        One a row; they need not have the same number of tracks.
    """

    def __init__(self, plans: Sequence[CraftPlan]) -> None:
        most = max(len(plan.tracks) for plan in plans)
        self._paths = [PathLength(plan) for plan in plans]
        self._rows = np.arange(len(plans))
        # The first track goes on before its start, and beyond the last one there is none.
        self._from = np.full((len(plans), most + 1), np.inf)
        self._table = np.zeros((len(plans), most, 10))
        for row, path in enumerate(self._paths):
            self._from[row, : len(path.starts)] = [-np.inf, *path.starts[1:]]
            for number, (start, track) in enumerate(zip(path.starts, path.tracks, strict=True)):
                self._table[row, number] = start, track.length_m, track.speed_mps, *track.shape
        self._take_tracks(np.zeros(len(plans), dtype=np.intp))

    def locate(self, distances_m: Array) -> Located:
        """Find where distances along the plans are, one for each row."""
        on_track = (self._least <= distances_m) & (distances_m < self._beyond)
        if np.count_nonzero(on_track) < len(on_track):  # half the time of all()
            self._take_tracks((self._from <= distances_m[:, None]).sum(axis=1) - 1)
        theta = (distances_m - self._start) / self._length
        return Located(self._numbers + theta, self._length, self._planned, theta, self._shape)

    def locate_row(self, row: int, distance_m: float) -> Located:
        """Find where a distance along the plan of one row is; arrays of one."""
        number = self._paths[row].number(distance_m)
        found = self._table[row, number][:, None]
        theta = (distance_m - found[0]) / found[1]
        return Located(number + theta, found[1], found[2], theta, found[3:])

    def _take_tracks(self, numbers: npt.NDArray[np.intp]) -> None:
        """Note the track of every row: it seldom changes."""
        self._numbers = numbers.astype(float)
        self._least, self._beyond = self._from[self._rows, numbers], self._from[self._rows, numbers + 1]
        tracks = np.ascontiguousarray(self._table[self._rows, numbers].T)
        self._start, self._length, self._planned, self._shape = *tracks[:3], tracks[3:]
