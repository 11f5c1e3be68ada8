"""Minimum separation: of two craft that would come too near, the one behind slows down.

Everybody is taken to go on straight for a while: oneself as one was last ordered, a mate along its plan at planned
speed from where it is believed to be. If the closest approach within the horizon is below the minimum and the standard
deviation of the mate's place, the craft that has the other one ahead slows to the least speed. If each has the other
ahead, as where courses cross, it is the one that has come less far in the plan, and of two equal ones the later in the
team. It is a guard on the speed alone: courses stay as they are, and as it slows craft but never stops them, a team
cannot stand still for it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from grex_agent.mission import TeamPlan
from grex_link.config import TeamConfig
from grex_link.messages import Fix, MateBelief

_AHEAD = 1e-3


class SeparationGuard:
    """Keeps a craft clear of those ahead of it.

    Parameters
    ----------
    config : TeamConfig
        Least separation, least speed, horizon.
    craft : str
        Whose guard it is.
    plan : TeamPlan
        Of everybody, in the order of the team.
    """

    def __init__(self, config: TeamConfig, craft: str, plan: TeamPlan) -> None:
        self._least_m = config.separation_min_m
        self._horizon_s = config.separation_horizon_s
        self._speed_min_mps = config.speed_min_mps
        self._craft = craft
        self._plan = plan.craft
        self._places = {name: place for place, name in enumerate(plan.craft)}
        self._velocity = 0.0, 0.0

    def ordered(self, speed_mps: float, course_rad: float) -> None:
        """Note what the craft has been ordered to do."""
        self._velocity = speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)

    def speed(self, ordered_mps: float, own: Fix, progress: float, beliefs: Sequence[MateBelief]) -> float:
        """Limit the ordered speed; it is never raised.

        Parameters
        ----------
        ordered_mps : float
            What the law orders, m/s.
        own : Fix
            Where the craft is.
        progress : float
            Own track number plus Θ.
        beliefs : sequence of MateBelief
            Where the mates are.
        """
        if self._least_m is None or ordered_mps <= self._speed_min_mps:
            return ordered_mps
        for mate in beliefs:
            near = self._encounter(own, mate)
            if near.distance_m < self._least_m + mate.sigma_m and self._yields(near, mate, progress):
                return self._speed_min_mps
        return ordered_mps

    # -- inside -------------------------------------------------------------------------------------------------

    def _yields(self, near: "Encounter", mate: MateBelief, progress: float) -> bool:
        if not (near.mate_ahead and near.own_ahead):
            return near.mate_ahead
        if mate.progress != progress:
            return mate.progress > progress
        return self._places[mate.craft] < self._places[self._craft]

    def _encounter(self, own: Fix, mate: MateBelief) -> "Encounter":
        """Look ahead as far as the horizon; in depth the mate is where its plan says."""
        plan = self._plan[mate.craft]
        track = plan.tracks[min(max(int(mate.progress), 0), len(plan.tracks) - 1)]
        here, further = plan.point(mate.progress), plan.point(mate.progress + _AHEAD)
        share = track.speed_mps / max(math.dist(here, further), 1e-9)
        mate_velocity = (further[0] - here[0]) * share, (further[1] - here[1]) * share
        apart = mate.north_m - own.north_m, mate.east_m - own.east_m
        closing = mate_velocity[0] - self._velocity[0], mate_velocity[1] - self._velocity[1]
        squared = _dot(closing, closing)
        when_s = min(max(-_dot(apart, closing) / squared, 0.0), self._horizon_s) if squared > 0.0 else 0.0
        return Encounter(
            math.hypot(apart[0] + when_s * closing[0], apart[1] + when_s * closing[1], track.depth_m - own.down_m),
            _dot(apart, self._velocity) > 0.0,
            _dot(apart, mate_velocity) < 0.0,
        )


class Encounter(NamedTuple):
    """How two craft come near each other."""

    distance_m: float
    """Least distance within the horizon."""
    mate_ahead: bool
    """Whether the mate is ahead of oneself."""
    own_ahead: bool
    """Whether oneself is ahead of the mate."""


def _dot(a: tuple[float, float], b: tuple[float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1]
