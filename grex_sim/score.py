"""The figure of merit: formation deviation FD and its three parts (GREX 2008, eqs. 4 and 5).

    fd(k) = ξ1/p·[|d_1p - d_1p(k)| + Σ|d_i,i+1 - d_i,i+1(k)|] + ξ2/(p-1)·Σ|α_i - α_i(k)| + ξ3/p·Σ|XTE_i(k)|

FD is the mean of fd(k) over the run (T = 1 in eq. 4). d and α are those of the plan where all craft have the team's
mean progress; for a formation that turns as a rigid body they are constant. Angles are radians; d is metres.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan
from grex_link.config import ScoreConfig

Series = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Score:
    """How well the formation was kept.

    Attributes
    ----------
    distance, angle, xte : ndarray, shape (l,)
        The weighted parts of fd(k) for k = 1 … l; metres, radians, metres.
    """

    distance: Series
    angle: Series
    xte: Series

    @property
    def fd_series(self) -> Series:
        """fd(k), shape (l,)."""
        return self.distance + self.angle + self.xte

    @property
    def fd(self) -> float:
        """Formation deviation FD."""
        return _mean(self.fd_series)

    @property
    def parts(self) -> tuple[float, float, float]:
        """Means of the distance, angle and cross-track parts."""
        return _mean(self.distance), _mean(self.angle), _mean(self.xte)


def score(positions: Series, plan: TeamPlan, weights: ScoreConfig) -> Score:
    """Judge a true trajectory.

    Parameters
    ----------
    positions : ndarray, shape (ticks, craft, 2)
        True north and east, metres; the first tick is the start and is not judged.
    plan : TeamPlan
        What was planned, in the same order of craft.
    weights : ScoreConfig
        ξ1, ξ2, ξ3.
    """
    real = positions[1:]
    return judge(real, *_plan_along(real, plan), weights)


def judge(real: Series, planned: Series, xte: Series, weights: ScoreConfig) -> Score:
    """Compare true with planned positions, both of shape (l, craft, 2), and weigh; `xte` has shape (l, craft)."""
    craft = real.shape[1]
    distance = np.abs(_distances(planned) - _distances(real)).sum(axis=1) / max(craft, 1)
    angle = np.abs(_angles(planned) - _angles(real)).sum(axis=1) / max(craft - 1, 1)
    return Score(weights.distance * distance, weights.angle * angle, weights.xte * np.abs(xte).mean(axis=1))


def _plan_along(real: Series, plan: TeamPlan) -> tuple[Series, Series]:
    """Planned positions at the team's mean progress, shape of `real`, and cross-track errors, shape (l, craft)."""
    followers = [ManoeuvreProcessor(craft_plan) for craft_plan in plan.craft.values()]
    plans = list(plan.craft.values())
    planned = np.empty_like(real)
    xte = np.empty(real.shape[:2])
    for step, places in enumerate(real.tolist()):
        for place, (follower, (north, east)) in enumerate(zip(followers, places, strict=True)):
            xte[step, place] = follower.follow(north, east).xte_m
        progress = sum(follower.progress for follower in followers) / len(followers)
        planned[step] = [craft_plan.point(progress) for craft_plan in plans]
    return planned, xte


def _distances(points: Series) -> Series:
    """Lengths of the polygon's sides d_12 … d_(p-1)p and d_1p, shape (l, p)."""
    sides = points - np.roll(points, -1, axis=1)
    lengths: Series = np.hypot(sides[..., 0], sides[..., 1])
    return lengths


def _angles(points: Series) -> Series:
    """Angles α_1 … α_(p-1) at the vertices between the vectors to both neighbours, radians, shape (l, p-1)."""
    before, after = np.roll(points, 1, axis=1) - points, np.roll(points, -1, axis=1) - points
    lengths = np.hypot(before[..., 0], before[..., 1]) * np.hypot(after[..., 0], after[..., 1])
    dots = (before * after).sum(axis=2)
    cosines = np.divide(dots, lengths, out=np.ones_like(dots), where=lengths > 0.0)
    angles: Series = np.arccos(np.clip(cosines, -1.0, 1.0))
    return angles[:, :-1]


def _mean(series: Series) -> float:
    return float(series.mean()) if series.size else math.nan
