"""fd(k) of one moment after another, as it is seen from outside while a run goes on."""

import math
from collections.abc import Sequence

import numpy as np

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan
from grex_link.config import ScoreConfig
from grex_sim.score import judge


class Formation:
    """How far a team is from its formation; see `grex_sim.score`.

    Who looks at every tick from the start gets the very fd(k) of the score; who comes later must say on which tracks
    the craft are.

    Parameters
    ----------
    plan : TeamPlan
        What was planned.
    weights : ScoreConfig
        ξ1, ξ2, ξ3.
    """

    def __init__(self, plan: TeamPlan, weights: ScoreConfig) -> None:
        self._plans = list(plan.craft.values())
        self._weights = weights
        self._followers = [ManoeuvreProcessor(craft) for craft in self._plans]

    def take_up(self, tracks: Sequence[int]) -> None:
        """Go forward to the tracks that the craft are on."""
        for follower, number in zip(self._followers, tracks, strict=True):
            if number > follower.number:
                follower.go_to(number)

    def deviation(self, places: Sequence[tuple[float, float]]) -> tuple[float, float, float, float]:
        """Judge one moment.

        Parameters
        ----------
        places : sequence of tuple of float
            True north and east of every craft, metres, in the order of the team.

        Returns
        -------
        tuple of float
            fd(k), and its distance, angle and cross-track parts; NaN if a place is none.
        """
        if not all(math.isfinite(value) for place in places for value in place):
            return (math.nan,) * 4
        pairs = zip(self._followers, places, strict=True)
        xte = np.array([[follower.follow(*place).xte_m for follower, place in pairs]])
        progress = sum(follower.progress for follower in self._followers) / len(self._followers)
        planned = np.array([[craft.point(progress) for craft in self._plans]])
        score = judge(np.array([places]), planned, xte, self._weights)
        return (score.fd, *score.parts)
