"""The figure of merit, by hand and on perfect runs (eqs. 4 and 5)."""

import math

import numpy as np
import pytest

from grex_agent.mission import plan_mission
from grex_link.config import ScoreConfig
from grex_link.scenario import decode
from grex_sim.score import score

ALL = ScoreConfig()
# A right triangle: d12 = 3, d23 = 5, d13 = 4; α1 = 90°, tan α2 = 4/3.
TRIANGLE = {"c1": [0.0, 0.0, 0.0], "c2": [0.0, 3.0, 0.0], "c3": [4.0, 0.0, 0.0]}
FIFTH = math.tau / 5.0
PENTAGON = {f"c{k}": [9.0 * math.cos(k * FIFTH), 9.0 * math.sin(k * FIFTH), 0.0] for k in range(5)}
FORMATIONS = {
    1: {"c1": [3.0, 2.0, 0.0]},
    2: {"c1": [0.0, 0.0, 0.0], "c2": [0.0, 30.0, 0.0]},
    3: TRIANGLE,
    5: PENTAGON,
}


def plan(formation, legs=1):
    """A lawnmower of legs of 100 m."""
    mission = {"type": "lawnmower", "formation_m": formation, "legs": legs, "leg_length_m": 100.0}
    return plan_mission(decode({"mission": mission, "craft": {name: {} for name in formation}}))


def planned(team, *progress):
    """Positions on the plan at progresses, one a tick, all craft alike; shape (ticks, craft, 2)."""
    return np.array([[craft.point(at) for craft in team.craft.values()] for at in progress])


def corner(points, k):
    """Angle at a corner of a polygon, by the directions of its two sides."""
    before, after = points[k - 1] - points[k], points[(k + 1) % len(points)] - points[k]
    return abs(math.remainder(math.atan2(*after) - math.atan2(*before), math.tau))


def test_one_displaced_craft_by_hand():
    """Craft 2 of a right triangle 1 m to starboard: 1.657 m of distances, 0.142 rad of angles, 1 m of XTE, by p."""
    team = plan(TRIANGLE)
    run = planned(team, 0.1, 0.2, 0.3)
    run[1:, 1, 1] += 1.0
    judged = score(run, team, ALL)
    distance = (1.0 + 0.0 + math.sqrt(32.0) - 5.0) / 3.0
    angle = abs(math.pi / 4.0 - math.atan2(4.0, 3.0)) / 2.0
    xte = 1.0 / 3.0
    assert judged.fd_series == pytest.approx([distance + angle + xte] * 2)
    assert judged.parts == pytest.approx((distance, angle, xte))
    assert judged.fd == pytest.approx(distance + angle + xte)


def test_fd_is_the_mean_over_the_run():
    """FD is the mean of fd(k) over all steps but the start, which nobody can help."""
    team = plan(TRIANGLE)
    run = planned(team, 0.1, 0.2, 0.3, 0.4)
    run[0, :, 1] += 50.0
    run[3, 0, 1] += 6.0
    judged = score(run, team, ALL)
    assert judged.fd_series.shape == judged.distance.shape == (3,)
    assert judged.fd_series[:2] == pytest.approx([0.0, 0.0], abs=1e-7)
    assert judged.fd == pytest.approx(judged.fd_series[2] / 3.0)
    assert judged.xte[2] == pytest.approx(2.0)


@pytest.mark.parametrize("weights", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.25, 0.75)])
def test_weights(weights):
    """Each part counts by its own weight ξ."""
    team = plan(TRIANGLE)
    run = planned(team, 0.1, 0.2, 0.3)
    run[1:, 1, 1] -= 0.7
    parts = score(run, team, ALL).parts
    judged = score(run, team, ScoreConfig(*weights))
    assert judged.parts == pytest.approx([weight * part for weight, part in zip(weights, parts, strict=True)])
    assert judged.fd == pytest.approx(sum(judged.parts))


@pytest.mark.parametrize("size", FORMATIONS)
def test_a_perfect_run_scores_nothing(size):
    """A team that turns as a rigid body along its plan has FD = 0, on lines and on arcs."""
    team = plan(FORMATIONS[size], legs=4)
    judged = score(planned(team, *np.linspace(0.0, 6.9, 400)), team, ALL)
    assert judged.fd_series == pytest.approx(np.zeros(399), abs=1e-6)


def test_one_craft_is_judged_by_its_track():
    """A team of one has no distances and no angles: FD is its mean |XTE|."""
    team = plan(FORMATIONS[1])
    run = planned(team, 0.1, 0.2, 0.3)
    run[1:, 0, 1] += [-2.0, 4.0]
    assert score(run, team, ALL).parts == pytest.approx((0.0, 0.0, 3.0))


def test_a_lag_of_two():
    """Two craft 30 m abreast, one 4 m behind: the distance is hypot(30, 4), counted once for each side of eq. (5)."""
    team = plan(FORMATIONS[2])
    run = planned(team, 0.5, 0.52)
    run[1, 0, 0] -= 4.0
    distance, angle, xte = score(run, team, ALL).parts
    assert distance == pytest.approx(2.0 * (math.hypot(30.0, 4.0) - 30.0) / 2.0)
    assert (angle, xte) == pytest.approx((0.0, 0.0), abs=1e-7)


def test_a_lag_on_an_arc():
    """A craft that lags by Θ on an arc is off by the angle times its radius, and by no XTE."""
    team = plan(FORMATIONS[2], legs=2)
    one, other = team.craft.values()
    run = np.array([[one.point(1.5), other.point(at)] for at in (1.5, 1.5, 1.45)])
    judged = score(run, team, ALL)
    radii = 65.0, 35.0
    chord = math.sqrt(radii[0] ** 2 + radii[1] ** 2 - 2.0 * radii[0] * radii[1] * math.cos(0.05 * math.pi))
    assert judged.distance == pytest.approx([0.0, chord - 30.0], abs=1e-9)
    assert judged.xte == pytest.approx([0.0, 0.0], abs=1e-9)


def test_five_by_hand():
    """In a pentagon one craft off by 2 m outward changes two sides and the angles of it and its neighbours."""
    team = plan(PENTAGON)
    run = planned(team, 0.5, 0.5)
    corners = run[1].copy()
    run[1, 2] += 2.0 * (corners[2] - corners.mean(axis=0)) / 9.0
    distance, angle, xte = score(run, team, ALL).parts
    side = math.dist(corners[1], corners[2])
    assert distance == pytest.approx(2.0 * abs(math.dist(run[1, 1], run[1, 2]) - side) / 5.0)
    assert angle == pytest.approx(sum(abs(corner(run[1], k) - corner(corners, k)) for k in range(4)) / 4.0)
    assert xte == pytest.approx(2.0 * math.sin(2.0 * FIFTH) / 5.0)


def test_four_of_five_angles_count():
    """The angle at the last craft is given by the others and does not count."""
    team = plan(TRIANGLE)
    run = planned(team, 0.5, 0.5)
    run[1, 1] = run[1, 0] + [0.0, 6.0]
    angle = score(run, team, ALL).parts[1]
    assert angle == pytest.approx(abs(math.atan2(4.0, 6.0) - math.atan2(4.0, 3.0)) / 2.0)


def test_the_plan_is_taken_at_the_mean_progress():
    """A planned formation that widens is judged by the plan at the team's mean progress: a perfect run scores 0."""
    tracks = {
        "c1": {"start_ned_m": [0, 0, 0], "tracks": [{"type": "line", "to_ned_m": [100, 0, 0], "speed_mps": 1.0}]},
        "c2": {"start_ned_m": [0, 5, 0], "tracks": [{"type": "line", "to_ned_m": [100, 25, 0], "speed_mps": 1.02}]},
    }
    team = plan_mission(decode({"mission": {"type": "tracks", "craft": tracks}, "craft": {"c1": {}, "c2": {}}}))
    assert score(planned(team, *np.linspace(0.0, 1.0, 50)), team, ALL).fd == pytest.approx(0.0, abs=1e-9)
    one, other = team.craft.values()
    apart = np.array([[one.point(at), other.point(0.5)] for at in (0.5, 0.4)])
    assert score(apart, team, ALL).distance == pytest.approx(
        [math.dist(*apart[1]) - math.dist(*planned(team, 0.45)[0])]
    )


def test_two_craft_at_one_place():
    """Craft that meet have no angle between them, and no NaN comes of it."""
    team = plan(TRIANGLE)
    run = planned(team, 0.5, 0.5)
    run[1, 1] = run[1, 0]
    assert math.isfinite(score(run, team, ALL).fd)


def test_a_run_of_no_steps():
    """A run that never got beyond its start has no FD."""
    team = plan(TRIANGLE)
    assert math.isnan(score(planned(team, 0.0), team, ALL).fd)
