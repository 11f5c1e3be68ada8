"""One task under way: by its tracks to where it is to be done, then what is to be done there, until it is done."""

import math
from typing import NamedTuple, Protocol

from grex_agent.guidance import PlaceKeeping, TrackKeeping
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import CraftPlan
from grex_agent.tasks.planner import Route
from grex_link.config import GuidanceConfig
from grex_link.messages import Fix

#: So far off the wanted depth is deep enough.
DEPTH_M = 1.0
#: So near to a place in the moving formation a craft has rejoined it.
JOIN_M = 5.0


class Steering(NamedTuple):
    """What a craft should do: course over ground (radians), speed (m/s; 0: hold), depth (m)."""

    course_rad: float
    speed_mps: float
    depth_m: float


class Pilot(NamedTuple):
    """Guidance of the craft."""

    tracks: TrackKeeping
    places: PlaceKeeping
    speed_max_mps: float
    gain_per_s: float

    @classmethod
    def of(cls, config: GuidanceConfig, speed_max_mps: float) -> "Pilot":
        """Build it as the scenario says."""
        places = PlaceKeeping(config, speed_max_mps)
        return cls(TrackKeeping(config), places, speed_max_mps, config.distance_gain_per_s)


class Activity(Protocol):
    """A task, or a part of one, that is being done. `done` is final."""

    done: bool

    def steer(self, fix: Fix, dt_s: float) -> Steering:
        """Say what to do now; `dt_s` seconds with a valid fix have passed since the last time."""


class Running:
    """Runs along a route, its lap again and again: for a time on the lap, or until a depth has been reached.

    Parameters
    ----------
    pilot : Pilot
        Guidance.
    route : Route
        The tracks.
    lasting_s : float
        Time on the lap.
    depth_m : float or None
        Instead: done at this depth.
    """

    def __init__(self, pilot: Pilot, route: Route, lasting_s: float = 0.0, depth_m: float | None = None) -> None:
        self.done = not route.tracks
        self._pilot = pilot
        self._route = route
        self._left_s = lasting_s
        self._depth_m = depth_m
        if not self.done:
            self._processor = ManoeuvreProcessor(CraftPlan(route.tracks, 0.0, hold_at_end=False))

    def steer(self, fix: Fix, dt_s: float) -> Steering:
        """Follow the tracks."""
        processor, last = self._processor, len(self._route.tracks) - 1
        on_lap = processor.number >= len(self._route.way)
        place = processor.follow(fix.north_m, fix.east_m)
        if on_lap and self._depth_m is None:
            self._left_s -= dt_s
        if processor.number == last and place.theta >= 1.0 and self._route.lap:
            processor.go_to(len(self._route.way))
            place = processor.follow(fix.north_m, fix.east_m)
        if self._depth_m is not None:
            self.done = abs(fix.down_m - self._depth_m) <= DEPTH_M
        elif self._route.lap:
            self.done = on_lap and self._left_s <= 0.0
        else:
            self.done = processor.number == last and place.theta >= 1.0
        track = processor.track
        return Steering(self._pilot.tracks.course(track, place), track.speed_mps, track.depth_m)


class Staying:
    """Keeps a place and a depth, for a time or for ever (0)."""

    def __init__(self, pilot: Pilot, at_ned_m: tuple[float, float, float], lasting_s: float) -> None:
        self.done = False
        self._pilot = pilot
        self._at = at_ned_m
        self._left_s = lasting_s or math.inf

    def steer(self, fix: Fix, dt_s: float) -> Steering:
        """Go back when off the place, else stop."""
        self._left_s -= dt_s
        self.done = self._left_s <= 0.0
        course, speed = self._pilot.places.steer(fix.north_m, fix.east_m, self._at[:2]) or (fix.heading_rad, 0.0)
        return Steering(course, speed, self._at[2])


class Joining:
    """Goes after a place that moves: that of the craft in its formation."""

    def __init__(self, pilot: Pilot) -> None:
        self.done = False
        self._pilot = pilot
        self.target: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
        """North, east, depth (m) and planned speed (m/s) there; to be set before every step."""

    def steer(self, fix: Fix, dt_s: float) -> Steering:
        """Go straight for it, faster the farther it is."""
        del dt_s
        north, east, depth, speed = self.target
        ahead, across = north - fix.north_m, east - fix.east_m
        distance = math.hypot(ahead, across)
        self.done = distance <= JOIN_M
        speed = min(speed + self._pilot.gain_per_s * distance, self._pilot.speed_max_mps)
        return Steering(math.atan2(across, ahead), speed, depth)
