"""The plan: a lawnmower that turns as a rigid body, explicit tracks, and what cannot be planned."""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest

from grex_agent.mission import plan_mission, range_max_m, range_min_m
from grex_agent.path import Arc, Line
from grex_link.errors import ConfigError
from grex_link.scenario import decode

TRIANGLE = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -25.0, 0.0], "auv3": [-6.0, 25.0, 2.0]}
FORMATIONS = {
    1: {"auv1": [3.0, 7.0, 1.0]},
    2: {"auv1": [0.0, -20.0, 0.0], "auv2": [4.0, 20.0, 0.0]},
    3: TRIANGLE,
    7: {
        f"auv{place}": [18.0 * math.sin(0.9 * place), 18.0 * math.cos(0.9 * place), float(place)] for place in range(7)
    },
}


def plan(formation=TRIANGLE, team=None, craft=None, **mission):
    """Plan a lawnmower of a formation."""
    craft = {name: {} for name in formation} | (craft or {})
    mission = {"type": "lawnmower", "formation_m": formation, "legs": 4} | mission
    return plan_mission(decode({"mission": mission, "craft": craft, "team": team or {}}))


def plan_tracks(tracks, craft=None, **mission):
    """Plan explicit tracks."""
    mission = {"type": "tracks", "craft": tracks} | mission
    return plan_mission(decode({"mission": mission, "craft": {name: {} for name in tracks} | (craft or {})}))


def line(north, east, speed=1.0, depth=0.0):
    """A straight track to a point."""
    return {"type": "line", "to_ned_m": [north, east, depth], "speed_mps": speed}


def listed(*tracks, start=(0.0, 0.0, 0.0)):
    """One craft's list of tracks."""
    return {"start_ned_m": list(start), "tracks": list(tracks)}


def points(team, progress):
    """Planned positions of all craft, shape (craft, 2)."""
    return np.array([craft.point(progress) for craft in team.craft.values()])


def polygon_angles(corners):
    """Signed angle at each corner between the vectors to its neighbours."""
    before, after = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.arctan2(cross, (before * after).sum(axis=1))


# -- the lawnmower ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", FORMATIONS)
def test_rigid_body(size):
    """At equal progress all distances and all angles are those of the formation, on lines, on arcs and beyond."""
    team = plan(FORMATIONS[size])
    wanted = np.array(list(FORMATIONS[size].values()))[:, :2]
    for progress in np.linspace(-0.3, 7.4, 155):
        corners = points(team, progress)
        for i, j in combinations(range(size), 2):
            assert math.dist(corners[i], corners[j]) == pytest.approx(math.dist(wanted[i], wanted[j]), abs=1e-9)
        if size > 2:
            assert polygon_angles(corners) == pytest.approx(polygon_angles(wanted), abs=1e-9)


@pytest.mark.parametrize("size", FORMATIONS)
def test_joints_and_durations(size):
    """Every track begins where the one before ends, and takes all craft equally long."""
    team = plan(FORMATIONS[size])
    for craft in team.craft.values():
        assert [type(track) for track in craft.tracks] == [Line, Arc] * 3 + [Line]
        for track, following in pairwise(craft.tracks):
            assert track.point(1.0) == pytest.approx(following.point(0.0), abs=1e-9)
        durations = [track.length_m / track.speed_mps for track in craft.tracks]
        assert durations == pytest.approx([400.0, math.pi * 65.0] * 3 + [400.0])
    assert team.duration_s == pytest.approx(4 * 400.0 + 3 * math.pi * 65.0)


def test_speeds_by_hand():
    """On an arc a craft goes V·r/R with its own radius r about the common centre: inside slower, outside faster."""
    speeds = [[track.speed_mps for track in craft.tracks] for craft in plan(speed_mps=1.2).craft.values()]
    inner, outer = 1.2 * math.hypot(6.0, 40.0) / 65.0, 1.2 * math.hypot(6.0, 90.0) / 65.0
    assert speeds[0] == pytest.approx([1.2] * 7)
    assert speeds[1] == pytest.approx([1.2, outer, 1.2, inner, 1.2, outer, 1.2])
    assert speeds[2] == pytest.approx([1.2, inner, 1.2, outer, 1.2, inner, 1.2])


def test_first_turn_to_port_mirrors():
    """Turning to port first is the mirror image of turning to starboard first, formation and all."""
    mirrored = {name: [ahead, -starboard, below] for name, (ahead, starboard, below) in TRIANGLE.items()}
    starboard, port = plan(), plan(mirrored, first_turn="port")
    for progress in np.linspace(0.0, 7.0, 71):
        assert points(port, progress) == pytest.approx(points(starboard, progress) * [1.0, -1.0], abs=1e-9)


def test_heading_and_start_move_the_whole_plan():
    """Another heading turns the plan about the start, another start shifts it; nothing else changes."""
    heading = math.radians(-130.0)
    turn = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
    there = plan(heading_deg=-130.0, start_ned_m=[300.0, -70.0, 12.0])
    for progress in np.linspace(0.0, 7.0, 71):
        assert points(there, progress) == pytest.approx(points(plan(), progress) @ turn.T + [300.0, -70.0], abs=1e-9)
    assert there.craft["auv3"].start == pytest.approx((*points(there, 0.0)[2], heading), abs=1e-9)


def test_depths():
    """A craft keeps the depth of the start plus its own place below it."""
    craft = plan(start_ned_m=[0.0, 0.0, 10.0]).craft["auv3"]
    assert craft.start_depth_m == 12.0
    assert {track.depth_m for track in craft.tracks} == {12.0}


@pytest.mark.parametrize(("at_end", "hold"), [("continue", False), ("hold", True)])
def test_at_end(at_end, hold):
    """What happens at the end is part of every craft's plan."""
    assert all(craft.hold_at_end is hold for craft in plan(at_end=at_end).craft.values())
    assert plan_tracks({"auv1": listed(line(9.0, 0.0))}, at_end=at_end).craft["auv1"].hold_at_end is hold


def test_point_beyond_the_plan():
    """Before the first and after the last track the plan goes straight on."""
    craft = plan(legs=1).craft["auv1"]
    assert craft.point(-0.25) == pytest.approx((-100.0, 0.0))
    assert craft.point(2.5) == pytest.approx((1000.0, 0.0))


# -- explicit tracks ----------------------------------------------------------------------------------------------


def test_track_list():
    """Listed tracks are followed from the start on, each from where the last one ended, with its own depth."""
    arc = {"type": "arc", "centre_ne_m": [30.0, 20.0], "turn_deg": 90.0, "speed_mps": 0.8}
    team = plan_tracks({"auv1": listed(line(30.0, 10.0, 1.5, 4.0), arc, line(0.0, 0.0, 1.0), start=(0.0, 10.0, 2.0))})
    craft = team.craft["auv1"]
    assert craft.start == pytest.approx((0.0, 10.0, 0.0))
    assert craft.start_depth_m == 2.0
    assert [track.depth_m for track in craft.tracks] == [4.0, 4.0, 0.0]
    assert [track.speed_mps for track in craft.tracks] == [1.5, 0.8, 1.0]
    assert craft.point(1.0) == pytest.approx((30.0, 10.0))
    assert craft.point(2.0) == pytest.approx((40.0, 20.0))
    assert craft.point(3.0) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert team.duration_s == pytest.approx(30.0 / 1.5 + 5.0 * math.pi / 0.8 + math.hypot(40.0, 20.0))


def test_durations_may_differ_by_a_hundredth():
    """Rounded speeds pass: a track may take one craft up to 1 % longer than another."""
    plan_tracks({"auv1": listed(line(100.0, 0.0)), "auv2": listed(line(100.0, 9.0, 1.009), start=(0.0, 9.0, 0.0))})


# -- distances and places -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", FORMATIONS)
def test_a_rigid_formation_keeps_its_greatest_distance(size):
    """The greatest distance of a lawnmower is the longest line through its formation, depth included."""
    places = FORMATIONS[size].values()
    wanted = max((math.dist(a, b) for a, b in combinations(places, 2)), default=0.0)
    assert range_max_m(plan(FORMATIONS[size])) == pytest.approx(wanted, abs=1e-9)


def test_greatest_distance_of_lines_is_at_an_end():
    """Craft that run apart are farthest apart where they end; craft that meet, where they start."""
    apart = {"auv1": listed(line(100.0, 0.0)), "auv2": listed(line(100.0, 76.0, 1.25), start=(0.0, 1.0, 0.0))}
    assert range_max_m(plan_tracks(apart)) == pytest.approx(76.0)
    meeting = {"auv1": listed(line(0.0, 50.0)), "auv2": listed(line(0.0, 50.0, 1.0), start=(0.0, 100.0, 0.0))}
    assert range_max_m(plan_tracks(meeting)) == pytest.approx(100.0)


def test_greatest_distance_on_arcs_is_found_between_their_ends():
    """Two craft that turn round, away from each other, are farthest apart on their way."""

    def half_circle(east, turn_deg):
        turn = {"type": "arc", "centre_ne_m": [0.0, east], "turn_deg": turn_deg, "speed_mps": 1.0}
        return listed(turn, start=(-40.0, east, 0.0))

    team = plan_tracks({"auv1": half_circle(0.0, 180.0), "auv2": half_circle(10.0, -180.0)})
    assert range_max_m(team) == pytest.approx(10.0 + 2 * 40.0, rel=1e-3)


def test_depths_count_for_the_greatest_distance():
    """At the start of a track a craft is still at the depth of the one before."""
    dive = listed(line(10.0, 0.0), line(20.0, 0.0, depth=40.0), line(30.0, 0.0))
    wait = listed(line(10.0, 30.0), line(20.0, 30.0), line(30.0, 30.0), start=(0.0, 30.0, 0.0))
    assert range_max_m(plan_tracks({"auv1": dive, "auv2": wait})) == pytest.approx(50.0)
    below = listed(line(10.0, 0.0), start=(0.0, 0.0, 60.0))
    assert range_max_m(plan_tracks({"auv1": below, "auv2": listed(line(10.0, 0.0))})) == pytest.approx(60.0)


def test_least_distance():
    """The least distance is found at an end of the tracks, and where craft meet in between."""
    apart = {"auv1": listed(line(100.0, 0.0)), "auv2": listed(line(100.0, 75.0, 1.1, 40.0), start=(0.0, 30.0, 40.0))}
    assert range_min_m(plan_tracks(apart)) == pytest.approx(50.0)
    crossing = {
        "auv1": listed(line(100.0, 100.0)),
        "auv2": listed(line(0.0, 100.0, depth=8.0), start=(100.0, 0.0, 8.0)),
    }
    assert range_min_m(plan_tracks(crossing)) == pytest.approx(8.0, abs=0.1)


# -- what cannot be planned ---------------------------------------------------------------------------------------

ROUND_NOTHING = {"type": "arc", "centre_ne_m": [0.0, 0.0], "turn_deg": 90.0, "speed_mps": 1.0}
NO_ANGLE = {"type": "arc", "centre_ne_m": [0.0, 9.0], "turn_deg": 0.0, "speed_mps": 1.0}
LAME = {"auv2": {"vehicle": {"surge": {"lag_s": 2.0, "min": 0.3, "max": 0.9, "rate_max": 0.2}}}}


@pytest.mark.parametrize(
    ("make", "path", "word"),
    [
        (lambda: plan(speed_mps=2.5), "$.mission.formation_m.auv2", "track 1 needs 3.47 m/s, outside"),
        (lambda: plan(team={"speed_max_mps": 1.2}), "$.mission.formation_m.auv2", "0.3 … 1.2 m/s"),
        (lambda: plan(team={"speed_min_mps": 0.7}), "$.mission.formation_m.auv2", "0.7 … 3 m/s"),
        (lambda: plan(speed_mps=0.2), "$.mission.formation_m.auv1", "track 0 needs 0.20 m/s"),
        (lambda: plan(craft=LAME), "$.mission.formation_m.auv2", "0.3 … 0.9 m/s"),
        (lambda: plan(turn_radius_m=25.0, formation={"a": [0, 25.0, 0]}), "$.mission.turn_radius_m", "turning centre"),
        (
            lambda: plan_tracks({"auv1": listed(line(9.0, 0.0)), "auv2": listed(line(9.0, 0.0))}, LAME),
            "$.mission.craft.auv2",
            "track 0 needs 1.00 m/s",
        ),
        (
            lambda: plan_tracks({"auv1": listed(line(100.0, 0.0)), "auv2": listed(line(80.0, 0.0))}),
            "$.mission.craft.auv2.tracks[0].speed_mps",
            "takes 80.0 s but 100.0 s for auv1; 0.8 m/s would do",
        ),
        (
            lambda: plan_tracks({"auv1": listed(line(9.0, 0.0), line(9.0, 9.0)), "auv2": listed(line(9.0, 0.0))}),
            "$.mission.craft.auv2.tracks",
            "1 tracks, but auv1 has 2",
        ),
        (
            lambda: plan_tracks({"auv1": listed(line(9.0, 0.0), line(9.0, 0.0))}),
            "$.mission.craft.auv1.tracks[1].to_ned_m",
            "no length",
        ),
        (lambda: plan_tracks({"auv1": listed(ROUND_NOTHING)}), "$.mission.craft.auv1.tracks[0]", "no length"),
        (lambda: plan_tracks({"auv1": listed(NO_ANGLE)}), "$.mission.craft.auv1.tracks[0]", "no length"),
        (
            lambda: plan(formation={"a": [0, 5.0, 1.0], "b": [3.0, 0, 1.0], "c": [0, 5.0, 1.0]}),
            "$",
            "a and c would start at the same place",
        ),
    ],
)
def test_faults_are_named(make, path, word):
    """A mission that cannot be followed is refused with the path of the fault and what is wrong there."""
    with pytest.raises(ConfigError) as caught:
        make()
    assert caught.value.path == path
    assert word in caught.value.problem


def test_no_more_tracks_than_a_message_can_name():
    """A team state has 8 bits for the track, so a lawnmower of more than 255 tracks is refused beforehand."""
    assert len(plan(legs=128).craft["auv1"].tracks) == 255
    with pytest.raises(ConfigError, match=r"^\$\.mission\.legs: "):
        plan(legs=129)
