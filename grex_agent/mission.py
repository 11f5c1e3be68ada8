"""The plan of the team: every craft's tracks, made offline and known to all (paper, sections II.A and V).

A lawnmower turns the formation as a rigid body: on an arc all craft rotate by the same angle about one common centre,
so that equal Θ gives exactly the desired formation on lines and arcs. Planned speeds differ so that a track takes all
craft equally long.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from grex_agent.closest import Places, closest_approach, greatest_distance_m
from grex_agent.path import Arc, Line, Track
from grex_link.config import Lawnmower, LineConfig, Scenario, TrackList, Tracks
from grex_link.errors import ConfigError

NorthEast = tuple[float, float]
#: A team state numbers its track in 8 bits.
TRACKS_MAX = 255
#: On arcs positions are compared at every so many radians: the greatest distance is missed by 0.1 % of their diameter.
_ARC_STEP_RAD = math.radians(5.0)
_LINE_STEPS = 32


@dataclass(frozen=True, slots=True)
class CraftPlan:
    """One craft's part of the plan.

    Attributes
    ----------
    tracks : tuple of Track
        In the order in which they are followed.
    start_depth_m : float
        Depth at the beginning.
    hold_at_end : bool
        Stay at the end of the last track, instead of going straight on.
    """

    tracks: tuple[Track, ...]
    start_depth_m: float
    hold_at_end: bool

    @property
    def start(self) -> tuple[float, float, float]:
        """North, east and course at the beginning, metres and radians."""
        north, east = self.tracks[0].point(0.0)
        return north, east, self.tracks[0].locate(north, east).course_rad

    def track(self, progress: float) -> Track:
        """Find the track at a progress (track number plus Θ)."""
        return self.tracks[min(max(int(progress), 0), len(self.tracks) - 1)]

    def course_rad(self, progress: float) -> float:
        """Find the course of the plan at a progress."""
        return self.track(progress).locate(*self.point(progress)).course_rad

    def point(self, progress: float) -> NorthEast:
        """Find the planned point at a progress (track number plus Θ); beyond the last track it goes on."""
        track = min(max(int(progress), 0), len(self.tracks) - 1)
        return self.tracks[track].point(progress - track)

    def depth(self, progress: float) -> float:
        """Planned depth at a progress, metres."""
        return self.tracks[min(max(int(progress), 0), len(self.tracks) - 1)].depth_m


@dataclass(frozen=True, slots=True)
class TeamPlan:
    """The plan of the team.

    Attributes
    ----------
    craft : dict of str to CraftPlan
        The *members* of the formation, in the order of the team: who waits for whom, and who is scored.
    duration_s : float
        How long their mission takes.
    standby : dict of str to CraftPlan
        Those who stand by: a metre of track at their place, which they do not follow.
    places : tuple of (float, float, float)
        Where events call somebody to, NED, metres.
    order : tuple of str
        Everybody, in the order of the team; empty for that of `craft`.
    """

    craft: dict[str, CraftPlan]
    duration_s: float
    bases: tuple[tuple[float, float, float], ...] = ()
    """Where modems stand that have no part in the mission, NED, metres."""
    standby: dict[str, CraftPlan] = field(default_factory=dict)
    places: tuple[tuple[float, float, float], ...] = ()
    order: tuple[str, ...] = ()

    @property
    def everybody(self) -> dict[str, CraftPlan]:
        """Plans of members and of those who stand by, in the order of the team."""
        plans = self.craft | self.standby
        return {craft: plans[craft] for craft in self.order or plans}


def plan_mission(scenario: Scenario) -> TeamPlan:
    """Plan a scenario's mission.

    Raises
    ------
    ConfigError
        If a craft would have to leave its speed limits, or tracks do not take all craft equally long.
    """
    mission = scenario.mission
    if isinstance(mission, Lawnmower):
        plans = {craft: _lawnmower(mission, mission.formation_m[craft]) for craft in scenario.formation}
        table = "formation_m"
    else:
        plans = {craft: _track_list(mission, craft, mission.craft[craft]) for craft in scenario.formation}
        table = "craft"
    if any(len(plan.tracks) > TRACKS_MAX for plan in plans.values()):
        raise ConfigError("$.mission.legs", f"more than {TRACKS_MAX} tracks, which is all a message can number")
    _check_durations(plans)
    for craft, plan in plans.items():
        _check_speeds(scenario, craft, plan, f"$.mission.{table}.{craft}")
    first = next(iter(plans.values()))
    duration_s = sum(track.length_m / track.speed_mps for track in first.tracks)
    standby = {
        craft: _standby(scenario.standby[craft].at_ned_m, scenario.team.speed_min_mps)
        for craft in scenario.craft
        if craft in scenario.standby
    }
    _check_places(plans | standby)
    return TeamPlan(
        plans,
        duration_s,
        tuple(base.place_ned_m for base in scenario.bases.values()),
        standby,
        tuple(event.at_ned_m for event in scenario.events),
        tuple(craft for craft in scenario.craft if craft not in scenario.bases),
    )


def _check_places(plans: dict[str, CraftPlan]) -> None:
    """Refuse two craft at one place, which no coordination can keep apart."""
    taken: dict[tuple[float, float, float], str] = {}
    for craft, plan in plans.items():
        north, east, _ = plan.start
        place = round(north, 3), round(east, 3), round(plan.start_depth_m, 3)
        other = taken.setdefault(place, craft)
        if other != craft:
            raise ConfigError("$", f"{other} and {craft} would start at the same place; move one of them")


def _standby(at_ned_m: tuple[float, float, float], speed_mps: float) -> CraftPlan:
    north, east, depth = at_ned_m
    return CraftPlan((Line((north, east), (north + 1.0, east), speed_mps or 1.0, depth),), depth, hold_at_end=True)


def range_max_m(plan: TeamPlan) -> float:
    """Greatest distance between any two craft at equal times of the planned mission, metres, in three dimensions.

    All craft run their tracks in step. Between lines the distance is greatest at an end of both; on arcs it is looked
    up every few degrees. At the beginning of a track a craft may still be at the depth of the one before. Places of
    events count as if somebody were there.
    """
    return greatest_distance_m(np.array([[*team, *plan.places] for team in _moments(plan)]))


def range_min_m(plan: TeamPlan) -> float:
    """Least distance between any two craft at equal times of the planned mission, metres."""
    approach = closest_approach(planned_places(plan))
    return 0.0 if approach is None else approach.distance_m


def planned_places(plan: TeamPlan) -> Places:
    """Where everybody is at equal times of the planned mission, close enough to go straight between: metres NED.

    Returns
    -------
    ndarray, shape (moments, members + standing by + bases, 3)
    """
    return np.array(list(_moments(plan, least=_LINE_STEPS)))


def pair_range_max_m(plan: TeamPlan, first: str, second: str) -> float:
    """Greatest distance between two craft at equal times of the planned mission, metres, in three dimensions."""
    places = {craft: place for place, craft in enumerate((*plan.craft, *plan.standby))}
    moments = _moments(plan, least=_LINE_STEPS)
    return max(math.dist(team[places[first]], team[places[second]]) for team in moments)


def _standing(plan: TeamPlan) -> list[tuple[float, float, float]]:
    return [(*craft.start[:2], craft.start_depth_m) for craft in plan.standby.values()]


def _moments(plan: TeamPlan, least: int = 1) -> Iterator[list[tuple[float, float, float]]]:
    """Yield positions of all craft at equal times: at ends of tracks, every few degrees of arcs, and often enough."""
    craft, still = list(plan.craft.values()), [*_standing(plan), *plan.bases]
    before = [each.start_depth_m for each in craft]
    for tracks in zip(*(each.tracks for each in craft), strict=True):
        depths = [track.depth_m for track in tracks]
        turn_rad = max(abs(track.curvature) * track.length_m for track in tracks)
        steps = max(least, math.ceil(turn_rad / _ARC_STEP_RAD))
        for step in range(steps + 1):
            places = [track.point(step / steps) for track in tracks]
            for now in (depths, before) if step == 0 else (depths,):
                yield [*((*place, depth) for place, depth in zip(places, now, strict=True)), *still]
        before = depths


def _lawnmower(mission: Lawnmower, place: tuple[float, float, float]) -> CraftPlan:
    north, east, down = mission.start_ned_m
    ahead, starboard, below = place
    tracks: list[Track] = []
    turn_length_m = math.pi * mission.turn_radius_m
    for reference, heading, turn in _legs(mission, (north, east)):
        end = _moved(reference, heading, mission.leg_length_m, 0.0)
        own_start = _moved(reference, heading, ahead, starboard)
        own_end = _moved(end, heading, ahead, starboard)
        tracks.append(Line(own_start, own_end, mission.speed_mps, down + below))
        if turn:
            centre = _moved(end, heading, 0.0, math.copysign(mission.turn_radius_m, turn))
            _check_turn(mission, starboard, turn)
            radius = math.dist(centre, own_end)
            speed = mission.speed_mps * math.pi * radius / turn_length_m
            tracks.append(Arc(own_end, centre, turn, speed, down + below))
    return CraftPlan(tuple(tracks), down + below, mission.at_end == "hold")


def _check_turn(mission: Lawnmower, starboard: float, turn: float) -> None:
    """Check that a craft stays on the outer side of the turning centre: beyond it, it would have to go backwards."""
    inside = math.copysign(starboard, starboard * turn)
    if inside >= mission.turn_radius_m:
        raise ConfigError(
            "$.mission.turn_radius_m",
            f"{mission.turn_radius_m:g} m is too narrow: a craft {inside:g} m inside would pass the turning centre",
        )


def _legs(mission: Lawnmower, start: NorthEast) -> Iterator[tuple[NorthEast, float, float]]:
    """Yield start of the reference point, heading, and the turn at the end (0 after the last) of every leg."""
    heading = math.radians(mission.heading_deg)
    turn = math.pi if mission.first_turn == "starboard" else -math.pi
    reference = start
    for leg in range(mission.legs):
        yield reference, heading, turn if leg < mission.legs - 1 else 0.0
        across = math.copysign(2.0 * mission.turn_radius_m, turn)
        reference = _moved(reference, heading, mission.leg_length_m, across)
        heading += math.pi
        turn = -turn


def _moved(point: NorthEast, heading: float, ahead: float, starboard: float) -> NorthEast:
    cos, sin = math.cos(heading), math.sin(heading)
    return point[0] + ahead * cos - starboard * sin, point[1] + ahead * sin + starboard * cos


def _track_list(mission: Tracks, craft: str, listed: TrackList) -> CraftPlan:
    north, east, depth = listed.start_ned_m
    at, start_depth = (north, east), depth
    tracks: list[Track] = []
    for number, config in enumerate(listed.tracks):
        path = f"$.mission.craft.{craft}.tracks[{number}]"
        if isinstance(config, LineConfig):
            end, depth = config.to_ned_m[:2], config.to_ned_m[2]
            if math.dist(at, end) < 1e-3:
                raise ConfigError(f"{path}.to_ned_m", "the track has no length: it ends where it starts")
            tracks.append(Line(at, end, config.speed_mps, depth))
        else:
            if math.dist(at, config.centre_ne_m) < 1e-3 or abs(config.turn_deg) < 1e-3:
                raise ConfigError(path, "the arc has no length: give it a radius and an angle")
            tracks.append(Arc(at, config.centre_ne_m, math.radians(config.turn_deg), config.speed_mps, depth))
        at = tracks[-1].point(1.0)
    return CraftPlan(tuple(tracks), start_depth, mission.at_end == "hold")


def _check_durations(plans: dict[str, CraftPlan]) -> None:
    """Check that every track takes all craft equally long, so that the team can keep one Θ."""
    (leader, first), *others = plans.items()
    for craft, plan in others:
        if len(plan.tracks) != len(first.tracks):
            raise ConfigError(
                f"$.mission.craft.{craft}.tracks",
                f"{len(plan.tracks)} tracks, but {leader} has {len(first.tracks)}",
            )
        for number, (track, reference) in enumerate(zip(plan.tracks, first.tracks, strict=True)):
            wanted_s = reference.length_m / reference.speed_mps
            if abs(track.length_m / track.speed_mps - wanted_s) > 0.01 * wanted_s:
                raise ConfigError(
                    f"$.mission.craft.{craft}.tracks[{number}].speed_mps",
                    f"the track takes {track.length_m / track.speed_mps:.1f} s but {wanted_s:.1f} s for {leader}; "
                    f"{track.length_m / wanted_s:.4g} m/s would do",
                )


def _check_speeds(scenario: Scenario, craft: str, plan: CraftPlan, path: str) -> None:
    team, surge = scenario.team, scenario.craft[craft].vehicle.surge
    least, most = max(team.speed_min_mps, surge.min), min(team.speed_max_mps, surge.max)
    for number, track in enumerate(plan.tracks):
        if not least <= track.speed_mps <= most:
            raise ConfigError(
                path,
                f"track {number} needs {track.speed_mps:.2f} m/s, outside the craft's {least:g} … {most:g} m/s; "
                "change the formation, the turn radius or the speed",
            )
