"""Planned tracks as points to draw."""

import math
from collections.abc import Iterator

from grex_agent.mission import CraftPlan

_ARC_STEP_RAD = math.radians(4.0)


def outline(plan: CraftPlan) -> Iterator[tuple[float, float]]:
    """Yield points (north, east), metres, along the tracks: the ends of lines, and every few degrees of arcs."""
    yield plan.tracks[0].point(0.0)
    for track in plan.tracks:
        pieces = max(1, math.ceil(abs(track.curvature) * track.length_m / _ARC_STEP_RAD))
        for piece in range(1, pieces + 1):
            yield track.point(piece / pieces)
