"""Where craft are going to be within the time looked ahead, and how near that brings them: many at once."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from grex_agent.mission import TeamPlan
from grex_agent.plan_time import PlanTime

Array = npt.NDArray[np.float64]
#: North, east and depth, metres.
Point = tuple[float, float, float]

#: How far is looked ahead, seconds, and in steps of how many.
HORIZON_S = 30.0
STEP_S = 5.0
_AFTER_S = np.arange(0.0, HORIZON_S + STEP_S, STEP_S)
#: So many speeds are tried at once.
_SPEEDS = 17
#: A distance is kept if it is short by no more, metres.
_KEPT_M = 1e-6


class PlannedWays:
    """Planned places of many craft at many times, as arrays.

    Parameters
    ----------
    plan : TeamPlan
        Tracks of everybody; who holds at their end goes no further.
    time : PlanTime
        Their times.
    """

    def __init__(self, plan: TeamPlan, time: PlanTime) -> None:
        craft = list(plan.craft.values())
        numbers = range(len(craft[0].tracks))
        self._shapes = np.array([[(*track.shape, track.depth_m) for track in each.tracks] for each in craft])
        self._starts = [time.at(float(number)) for number in numbers]
        self._durations = np.array([time.at(number + 1.0) for number in numbers]) - self._starts
        end_s = time.at(float(len(numbers)))
        self._ends = np.array([end_s if each.hold_at_end else math.inf for each in craft])

    def points(self, rows: npt.NDArray[np.intp], plan_s: Array) -> Array:
        """Find planned places.

        Parameters
        ----------
        rows : ndarray of int, shape (n,)
            Which craft, by its place in the team.
        plan_s : ndarray, shape (n, times)
            Plan times, seconds.

        Returns
        -------
        ndarray, shape (n, times, 3)
            North, east and depth, metres.
        """
        number = np.maximum(np.searchsorted(self._starts, plan_s, side="right") - 1, 0)
        theta = (plan_s - np.take(self._starts, number)) / self._durations[number]
        a, b, c, d, radius, start, turn, depth = np.moveaxis(self._shapes[rows[:, None], number], -1, 0)
        angle = start + turn * theta
        return np.stack(
            [a + b * theta + radius * np.cos(angle), c + d * theta + radius * np.sin(angle), depth], axis=-1
        )

    def ways(self, rows: npt.NDArray[np.intp], places: Array, plan_s: Array, rates: Array) -> Array:
        """Say where craft are going to be that follow their plans, as far beside them as they are.

        Parameters
        ----------
        rows : ndarray of int, shape (n,)
            Which craft.
        places : ndarray, shape (n, 3)
            Where they are.
        plan_s, rates : ndarray, shape (n,)
            Where they stand, as plan time, and how fast they go, as a share of the planned speed.

        Returns
        -------
        ndarray, shape (n, times, 3)
            Places now and at the end of every step; the depth is that of now.
        """
        ends_s = np.maximum(self._ends[rows], plan_s)
        times_s = np.minimum(plan_s[:, None] + rates[:, None] * _AFTER_S, ends_s[:, None])
        planned = self.points(rows, times_s)
        return places[:, None] + (planned - planned[:, :1]) * (1.0, 1.0, 0.0)


def ways_straight(place: Point, course_rad: float, speeds_mps: Array) -> Array:
    """Say where a craft is going to be that goes straight on, at each of some speeds; shape (n,) to (n, times, 3)."""
    direction = np.array([math.cos(course_rad), math.sin(course_rad), 0.0])
    ways: Array = np.array(place) + speeds_mps[:, None, None] * _AFTER_S[:, None] * direction
    return ways


def nearest_m(one: Array, other: Array) -> Array:
    """Least distance of craft that go straight from place to place, in step; shape (..., times, 3) to (...)."""
    away = other - one
    start, move = away[..., :-1, :], np.diff(away, axis=-2)
    length2, towards = (move * move).sum(axis=-1), -(start * move).sum(axis=-1)
    share = np.clip(np.divide(towards, length2, out=np.zeros_like(towards), where=length2 > 0.0), 0.0, 1.0)
    distances: Array = np.linalg.norm(start + share[..., None] * move, axis=-1).min(axis=-1)
    return distances


def keep(ways: Array, others: Array, least_m: Array) -> npt.NDArray[np.bool_]:
    """Whether a craft keeps its distances; of one that it is nearer to now, whether it comes no nearer and has it last.

    Parameters
    ----------
    ways : ndarray, shape (m, times, 3)
        Ways it may go.
    others : ndarray, shape (n, times, 3)
        Those of others.
    least_m : ndarray, shape (n,)
        The distances.

    Returns
    -------
    ndarray of bool, shape (m,)
        Of each way.
    """
    own = ways[:, None]
    ends = np.linalg.norm(others[:, [0, -1]] - own[:, :, [0, -1]], axis=-1)
    comes_m = np.minimum(ends[..., 0], least_m) - _KEPT_M
    keeps = (ends[..., 1] >= least_m - _KEPT_M) & (nearest_m(own, others) >= comes_m)
    kept: npt.NDArray[np.bool_] = keeps.all(axis=-1)
    return kept


def fastest(are_kept: Callable[[Array], npt.NDArray[np.bool_]], least: float, most: float) -> float:
    """Find the greatest speed between two with which a distance is kept, to a 250th: if it is with none, the least.

    Whoever yields goes behind: of speeds that keep the distance, only those count that are less than all that do not.
    """
    if most <= least:
        return most
    for _ in range(2):
        speeds = np.linspace(least, most, _SPEEDS)
        kept = are_kept(speeds)
        if kept[-1]:
            return most
        if not kept[0]:
            return least
        broken = int(np.argmin(kept))
        least, most = float(speeds[broken - 1]), float(speeds[broken])
    return least
