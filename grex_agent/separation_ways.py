"""Where craft are going to be within the time looked ahead, and how near that brings two of them."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from grex_agent.mission import CraftPlan
from grex_agent.plan_time import PlanTime

#: How far is looked ahead, seconds, and in steps of how many.
HORIZON_S = 30.0
STEP_S = 5.0
_TIMES_S = tuple(STEP_S * step for step in range(round(HORIZON_S / STEP_S) + 1))
#: A distance is kept if it is short by no more, metres.
_KEPT_M = 1e-6

Point = tuple[float, float, float]
#: Places of one craft, now and at the end of every step.
Way = Sequence[Point]


def way_on_plan(plan: CraftPlan, time: PlanTime, place: Point, plan_s: float, rate: float) -> list[Point]:
    """Say where a craft is going to be that follows its plan, as far beside it as it is.

    Parameters
    ----------
    plan : CraftPlan
        Its tracks; who holds at their end goes no further.
    time : PlanTime
        Of the team.
    place : (float, float, float)
        Where it is, north, east and depth, metres.
    plan_s : float
        Where it stands, as plan time, seconds.
    rate : float
        How fast it goes, as a share of the planned speed.
    """
    last_s = time.at(float(len(plan.tracks))) if plan.hold_at_end else math.inf
    north, east = plan.point(time.progress(plan_s))
    beside = place[0] - north, place[1] - east
    ahead = (plan.point(time.progress(max(min(plan_s + rate * after_s, last_s), plan_s))) for after_s in _TIMES_S[1:])
    return [place, *((north + beside[0], east + beside[1], place[2]) for north, east in ahead)]


def way_straight(place: Point, course_rad: float, speed_mps: float) -> list[Point]:
    """Say where a craft is going to be that goes straight on; metres, radians and m/s."""
    north, east = speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)
    return [(place[0] + north * after_s, place[1] + east * after_s, place[2]) for after_s in _TIMES_S]


def nearest_m(ways: Sequence[Way]) -> list[list[float]]:
    """Least distance of any two of several craft that go straight from place to place, in step: one row a craft."""
    places = np.array(ways)
    away = places[:, None] - places[None, :]
    start, move = away[:, :, :-1], np.diff(away, axis=2)
    length2 = np.einsum("ijtk,ijtk->ijt", move, move)
    towards = -np.einsum("ijtk,ijtk->ijt", start, move)
    share = np.clip(np.divide(towards, length2, out=np.zeros_like(towards), where=length2 > 0.0), 0.0, 1.0)
    nearest = start + share[..., None] * move
    rows: list[list[float]] = np.sqrt(np.einsum("ijtk,ijtk->ijt", nearest, nearest).min(axis=2)).tolist()
    return rows


def keeps(one: Way, other: Way, least_m: float) -> bool:
    """Whether two craft keep a distance; if they are nearer now, whether they come no nearer and have it in the end."""
    now_m = math.dist(one[0], other[0])
    if math.dist(one[-1], other[-1]) < least_m - _KEPT_M:
        return False
    away = [(b[0] - a[0], b[1] - a[1], b[2] - a[2]) for a, b in zip(one, other, strict=True)]
    return min(_nearest_to_origin_m(start, end) for start, end in pairwise(away)) >= min(now_m, least_m) - _KEPT_M


def _nearest_to_origin_m(start: Point, end: Point) -> float:
    move = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length2 = move[0] ** 2 + move[1] ** 2 + move[2] ** 2
    towards = -(start[0] * move[0] + start[1] * move[1] + start[2] * move[2])
    share = min(max(towards / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return math.hypot(start[0] + share * move[0], start[1] + share * move[1], start[2] + share * move[2])
