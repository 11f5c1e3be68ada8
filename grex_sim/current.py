"""Sea-current compensation in three dimensions (paper, section III, Fig. 6).

The ground velocity is the water velocity plus the current. A craft that wants to go along the unit vector v0 can
reach those points of the line {s·v0} that lie on the sphere of radius |u| about the current, u being its speed
through the water.
"""

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
_STILL = 1e-12
_NO_CURRENT = (0.0, 0.0, 0.0)


class Steering(NamedTuple):
    """What to steer to make good a course.

    Attributes
    ----------
    heading_rad, pitch_rad : float
        Direction to point in; pitch positive upwards.
    surge_mps : float
        Speed through the water.
    ground_mps : float
        Speed over ground along the wanted direction that comes of it; negative when the craft is set back.
    holdable : bool
        False if the course cannot be made good: across it the current is stronger than the craft, or along it.
    """

    heading_rad: float
    pitch_rad: float
    surge_mps: float
    ground_mps: float
    holdable: bool


def compensate(
    course_rad: float,
    pitch_rad: float,
    speed_mps: float,
    current: Vector,
    surge_min_mps: float,
    surge_max_mps: float,
) -> Steering:
    """Find heading, pitch and surge for a wanted velocity over ground.

    If the wanted speed needs more surge than there is, or less than the least, the surge is set to the limit. Of the
    two speeds over ground at which the line then meets the sphere the one nearer to the wanted is taken: a craft told
    to wait in a following current points against it. If the line misses the sphere – the current across the course is
    stronger than the craft – the craft points straight against the current across, which keeps it as near to its track
    as can be (`holdable` is False). If the line meets the sphere only behind the craft, it keeps the course and is set
    back along it as slowly as can be (`holdable` is False too).

    Parameters
    ----------
    course_rad, pitch_rad : float
        Wanted direction over ground; pitch positive upwards.
    speed_mps : float
        Wanted speed over ground.
    current : tuple of float
        Known current, NED, m/s.
    surge_min_mps, surge_max_mps : float
        Limits of the speed through the water.
    """
    if current == _NO_CURRENT:
        surge = min(max(speed_mps, surge_min_mps), surge_max_mps)
        return Steering(course_rad, pitch_rad, surge, surge, holdable=True)
    level = math.cos(pitch_rad)
    v0 = (level * math.cos(course_rad), level * math.sin(course_rad), -math.sin(pitch_rad))
    water = _minus(v0, speed_mps, current)
    surge = math.sqrt(_dot(water, water))
    if surge_min_mps - 1e-9 <= surge <= surge_max_mps + 1e-9:
        return _steering(water, surge, speed_mps, (course_rad, pitch_rad), holdable=True)
    surge = surge_max_mps if surge > surge_max_mps else surge_min_mps
    along = _dot(v0, current)
    reserve = along * along - _dot(current, current) + surge * surge
    if reserve < 0.0:
        across = _minus(v0, along, current)
        return _steering(across, surge, along, (course_rad, pitch_rad), holdable=False)
    root = math.sqrt(reserve)
    ahead = [ground for ground in (along - root, along + root) if ground > 0.0]
    ground = min(ahead, key=lambda reached: abs(reached - speed_mps)) if ahead else along + root
    return _steering(_minus(v0, ground, current), surge, ground, (course_rad, pitch_rad), holdable=ground > 0.0)


def _minus(direction: Vector, length: float, current: Vector) -> Vector:
    return (
        length * direction[0] - current[0],
        length * direction[1] - current[1],
        length * direction[2] - current[2],
    )


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _steering(water: Vector, surge: float, ground: float, fallback: tuple[float, float], *, holdable: bool) -> Steering:
    norm = math.sqrt(_dot(water, water))
    if norm < _STILL:
        return Steering(fallback[0], fallback[1], surge, ground, holdable)
    level = math.hypot(water[0], water[1])
    heading = math.atan2(water[1], water[0]) if level > _STILL else fallback[0]
    return Steering(heading, -math.atan2(water[2], level), surge, ground, holdable)
