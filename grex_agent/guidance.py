"""Guidance: from where the craft is to the course and speed it should have (paper, section III). P controllers only."""

import math

from grex_agent.path import Place, Track, wrap
from grex_link.config import GuidanceConfig


class TrackKeeping:
    """Keeps a craft on its track.

    course = track's course - clip(k_x · XTE, ± limit) + feed-forward · T_ψ · v' / radius

    The last term leads the heading loop's lag on arcs.

    Parameters
    ----------
    config : GuidanceConfig
        Gains and limits.
    """

    def __init__(self, config: GuidanceConfig) -> None:
        self._gain = config.cross_track_gain_rad_per_m
        self._limit = config.correction_max_rad
        self._lead_s = config.curvature_feedforward * config.heading_lag_s

    def course(self, track: Track, place: Place) -> float:
        """Course to steer, radians in [-π, π).

        Parameters
        ----------
        track : Track
            The track being followed.
        place : Place
            Where the craft stands on it.
        """
        correction = self._gain * place.xte_m
        limit = self._limit
        correction = limit if correction > limit else -limit if correction < -limit else correction  # noqa: FURB136
        return wrap(place.course_rad - correction + self._lead_s * track.speed_mps * track.curvature)


class PlaceKeeping:
    """Keeps a craft at a place: speed in proportion to the distance, stop within the arrival radius.

    Parameters
    ----------
    config : GuidanceConfig
        Gain and arrival radius.
    speed_max_mps : float
        Highest speed it may order.
    """

    def __init__(self, config: GuidanceConfig, speed_max_mps: float) -> None:
        self._gain = config.distance_gain_per_s
        self._radius_m = config.arrival_radius_m
        self._speed_max_mps = speed_max_mps

    def steer(self, north_m: float, east_m: float, place: tuple[float, float]) -> tuple[float, float] | None:
        """Course (radians) and speed (m/s) towards a place, or None when it is reached."""
        north, east = place[0] - north_m, place[1] - east_m
        distance_m = math.hypot(north, east)
        if distance_m <= self._radius_m:
            return None
        return math.atan2(east, north), min(self._gain * distance_m, self._speed_max_mps)
