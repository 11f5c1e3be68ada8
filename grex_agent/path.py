"""Tracks: straight lines and arcs, and where a position stands on them (paper, section II.A, Fig. 2).

All angles are radians clockwise from north, positions metres in NED. Cross-track errors are positive to starboard of
the track. Scalars, not arrays: these functions run for every craft and every mate at every step.
"""

import math
from typing import Protocol

import msgspec

TWO_PI = 2.0 * math.pi


class Place(msgspec.Struct, frozen=True, gc=False):
    """Where a position stands on a track.

    Attributes
    ----------
    theta : float
        Degree of execution Θ (eq. 1): 0 at the start, 1 at the end, beyond both outside.
    xte_m : float
        Cross-track error, positive to starboard of the track.
    course_rad : float
        Course of the track at the foot point.
    """

    theta: float
    xte_m: float
    course_rad: float


class Track(Protocol):
    """One track of a craft's path.

    Attributes
    ----------
    length_m : float
        Length along the track.
    curvature : float
        1/radius, positive to starboard, 0 on a line; 1/m.
    speed_mps : float
        Planned speed over ground v' (eq. 2).
    depth_m : float
        Planned depth at its end.
    """

    length_m: float
    curvature: float
    speed_mps: float
    depth_m: float

    def locate(self, north_m: float, east_m: float) -> Place:
        """Find where a position stands on the track."""

    def point(self, theta: float) -> tuple[float, float]:
        """Find the point (north, east) at a degree of execution."""

    @property
    def shape(self) -> tuple[float, float, float, float, float, float, float]:
        """(a, b, c, d, R, φ₀, φ₁) of north = a + bΘ + R cos(φ₀ + φ₁Θ), east = c + dΘ + R sin(φ₀ + φ₁Θ): for arrays."""


def wrap(angle_rad: float) -> float:
    """Bring an angle into [-π, π)."""
    return (angle_rad + math.pi) % TWO_PI - math.pi


class Line:
    """A straight track; see `Track`.

    Parameters
    ----------
    start, end : tuple of float
        North and east, metres.
    speed_mps : float
        Planned speed over ground.
    depth_m : float
        Planned depth.
    """

    __slots__ = ("_course", "_east", "_north", "_tangent_east", "_tangent_north", "curvature", "depth_m", "length_m",
                 "speed_mps")  # fmt: skip

    def __init__(self, start: tuple[float, float], end: tuple[float, float], speed_mps: float, depth_m: float) -> None:
        along_north, along_east = end[0] - start[0], end[1] - start[1]
        self.length_m = math.hypot(along_north, along_east)
        self.curvature = 0.0
        self.speed_mps = speed_mps
        self.depth_m = depth_m
        self._north, self._east = start
        self._tangent_north, self._tangent_east = along_north / self.length_m, along_east / self.length_m
        self._course = math.atan2(along_east, along_north)

    def locate(self, north_m: float, east_m: float) -> Place:
        """Find where a position stands on the line: by the foot of the perpendicular."""
        north, east = north_m - self._north, east_m - self._east
        along = north * self._tangent_north + east * self._tangent_east
        return Place(along / self.length_m, east * self._tangent_north - north * self._tangent_east, self._course)

    def point(self, theta: float) -> tuple[float, float]:
        """Find the point (north, east) at a degree of execution."""
        along = theta * self.length_m
        return self._north + along * self._tangent_north, self._east + along * self._tangent_east

    @property
    def shape(self) -> tuple[float, float, float, float, float, float, float]:
        """The line as numbers; see `Track`."""
        north, east = self.length_m * self._tangent_north, self.length_m * self._tangent_east
        return self._north, north, self._east, east, 0.0, 0.0, 0.0


class Arc:
    """A track on a circle; see `Track`.

    Θ is measured from the middle of the arc, so that the cut of the arc tangent lies opposite to the track and Θ is
    continuous well beyond both ends.

    Parameters
    ----------
    start, centre : tuple of float
        North and east, metres.
    turn_rad : float
        Angle of the arc, positive to starboard.
    speed_mps : float
        Planned speed over ground.
    depth_m : float
        Planned depth.
    """

    __slots__ = ("_centre_east", "_centre_north", "_half", "_middle", "_radius", "_side", "curvature", "depth_m",
                 "length_m", "speed_mps")  # fmt: skip

    def __init__(
        self,
        start: tuple[float, float],
        centre: tuple[float, float],
        turn_rad: float,
        speed_mps: float,
        depth_m: float,
    ) -> None:
        north, east = start[0] - centre[0], start[1] - centre[1]
        self._centre_north, self._centre_east = centre
        self._radius = math.hypot(north, east)
        self._side = math.copysign(1.0, turn_rad)
        self._half = abs(turn_rad) / 2.0
        self._middle = math.atan2(east, north) + turn_rad / 2.0
        self.length_m = self._radius * abs(turn_rad)
        self.curvature = self._side / self._radius
        self.speed_mps = speed_mps
        self.depth_m = depth_m

    def locate(self, north_m: float, east_m: float) -> Place:
        """Find where a position stands on the arc: by its angle about the centre."""
        north, east = north_m - self._centre_north, east_m - self._centre_east
        angle = math.atan2(east, north)
        side = self._side
        beyond_middle = (angle - self._middle + math.pi) % TWO_PI - math.pi
        return Place(
            (beyond_middle * side / self._half + 1.0) / 2.0,
            side * (self._radius - math.sqrt(north * north + east * east)),
            angle + side * (math.pi / 2.0),
        )

    def point(self, theta: float) -> tuple[float, float]:
        """Find the point (north, east) at a degree of execution."""
        angle = self._middle + self._side * self._half * (2.0 * theta - 1.0)
        return self._centre_north + self._radius * math.cos(angle), self._centre_east + self._radius * math.sin(angle)

    @property
    def shape(self) -> tuple[float, float, float, float, float, float, float]:
        """The arc as numbers; see `Track`."""
        turn = 2.0 * self._side * self._half
        return self._centre_north, 0.0, self._centre_east, 0.0, self._radius, self._middle - turn / 2.0, turn
