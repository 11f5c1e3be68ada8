"""From a task to tracks: pure geometry."""

import math
from typing import NamedTuple

from grex_agent.path import Arc, Line, Track
from grex_link.tasks import Inspect

NorthEast = tuple[float, float]

#: Nearer than this is there.
_NOTHING_M = 0.01
#: Radius of the circle in which a craft changes its depth without going anywhere.
CIRCLE_M = 10.0


class Route(NamedTuple):
    """Tracks of a task: the way there, then a lap that is repeated."""

    way: tuple[Track, ...]
    lap: tuple[Track, ...] = ()

    @property
    def tracks(self) -> tuple[Track, ...]:
        """All of them, in order."""
        return self.way + self.lap


def straight(at: NorthEast, to_ned_m: tuple[float, float, float], speed_mps: float) -> tuple[Track, ...]:
    """Plan the straight way to a place; none if the craft is there."""
    north, east, depth = to_ned_m
    if math.dist(at, (north, east)) < _NOTHING_M:
        return ()
    return (Line(at, (north, east), speed_mps, depth),)


def survey(task: Inspect, at: NorthEast) -> Route:
    """Plan an inspection: straight to the nearest point of the circle or corner of the box, then round to starboard."""
    north, east, depth = task.at_ned_m
    corners = _circle(task, at) if task.shape == "circle" else _box(task, at)
    way = straight(at, (*corners[0], depth), task.speed_mps)
    if task.shape == "circle":
        half = (Arc(start, (north, east), math.pi, task.speed_mps, depth) for start in corners)
        return Route(way, tuple(half))
    ends = [*corners[1:], corners[0]]
    return Route(way, tuple(Line(*side, task.speed_mps, depth) for side in zip(corners, ends, strict=True)))


def circle(at: NorthEast, heading_rad: float, depth_m: float, speed_mps: float) -> Route:
    """Plan a circle to starboard of where a craft is and heads, to change its depth in."""
    centre = at[0] - CIRCLE_M * math.sin(heading_rad), at[1] + CIRCLE_M * math.cos(heading_rad)
    opposite = 2.0 * centre[0] - at[0], 2.0 * centre[1] - at[1]
    return Route((), tuple(Arc(start, centre, math.pi, speed_mps, depth_m) for start in (at, opposite)))


def _circle(task: Inspect, at: NorthEast) -> list[NorthEast]:
    """Return the two points at which the half circles begin."""
    north, east = task.at_ned_m[:2]
    bearing = math.atan2(at[1] - east, at[0] - north)
    return [
        (north + task.radius_m * math.cos(angle), east + task.radius_m * math.sin(angle))
        for angle in (bearing, bearing + math.pi)
    ]


def _box(task: Inspect, at: NorthEast) -> list[NorthEast]:
    """Return the corners, clockwise from the nearest one."""
    north, east, half = *task.at_ned_m[:2], task.radius_m
    corners = [(north + a * half, east + b * half) for a, b in ((1, -1), (1, 1), (-1, 1), (-1, -1))]
    first = min(range(4), key=lambda number: math.dist(corners[number], at))
    return corners[first:] + corners[:first]
