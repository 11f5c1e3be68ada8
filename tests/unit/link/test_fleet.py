"""Fleets and formations are spelled out into a table and a place for each craft."""

import math

import numpy as np
import pytest

from grex_agent.mission import plan_mission, planned_places
from grex_link.config import ScoreConfig
from grex_link.errors import ConfigError
from grex_link.fleet import FormationConfig, places
from grex_link.scenario import decode, fingerprint, loads
from grex_sim.score import score

FLEET = """
[fleet]
count = 4
[fleet.craft.vehicle]
speed_error_relative = 0.01
depth_gain_rad_per_m = 0.1
[mission]
type = "lawnmower"
turn_radius_m = 100.0
[mission.formation]
type = "abreast"
spacing_m = 20.0
"""
TYPES = ["abreast", "astern", "v", "polygon"]


def formation(kind, count, **more):
    """North and east of the craft of a formation with 20 m between neighbours."""
    return np.array(places(FormationConfig(type=kind, spacing_m=20.0, **more), count))


def crossed(points):
    """Whether any two sides of a polygon cross."""

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    sides = list(zip(points, [*points[1:], points[0]], strict=True))
    return any(
        side(a, b, c) * side(a, b, d) < -1e-6 and side(c, d, a) * side(c, d, b) < -1e-6
        for place, (a, b) in enumerate(sides)
        for c, d in sides[:place]
    )


def test_a_fleet_is_spelled_out():
    """What a fleet comes to is the same scenario, with the same fingerprint, as one with a table for each craft."""
    spelled = {
        "craft": {
            f"auv{n}": {"vehicle": {"speed_error_relative": 0.01, "depth_gain_rad_per_m": 0.1}} for n in range(1, 5)
        },
        "mission": {
            "type": "lawnmower",
            "turn_radius_m": 100.0,
            "formation_m": {f"auv{n}": [0.0, 20.0 * (n - 2.5), 0.0] for n in range(1, 5)},
        },
    }
    short = loads(FLEET)
    assert list(short.craft) == ["auv1", "auv2", "auv3", "auv4"]
    assert fingerprint(short) == fingerprint(decode(spelled))


def test_one_of_a_fleet_is_special():
    """A table of one craft changes what it says, and leaves the rest and the order; others come after the fleet."""
    made = loads(FLEET + "[craft.boat]\n[craft.auv3.vehicle]\nspeed_error_relative = -0.02\n")
    assert list(made.craft) == ["auv1", "auv2", "auv3", "auv4", "boat"]
    errors = [craft.vehicle.speed_error_relative for craft in made.craft.values()]
    assert errors == [0.01, 0.01, -0.02, 0.01, 0.0]
    assert made.craft["auv3"].vehicle.depth_gain_rad_per_m == 0.1


def test_a_special_type_takes_nothing_of_another():
    """A craft of a fleet with another frontseat has nothing left of the fleet's."""
    fleet = FLEET + '[fleet.craft.frontseat]\ntype = "mavlink"\nurl = "udpin:127.0.0.1:14550"\n'
    made = loads(
        fleet + '[craft.auv1.frontseat]\ntype = "sim"\n', ["clock.pace=live", "datum={latitude_deg=1,longitude_deg=1}"]
    )
    assert list(made.mavlink_craft) == ["auv2", "auv3", "auv4"]


def test_a_fleet_of_another_size_is_one_override():
    """The number of craft is one value."""
    assert len(loads(FLEET, ["fleet.count=7", "mission.formation.type=polygon"]).mission.formation_m) == 7


@pytest.mark.parametrize(
    ("override", "path"),
    [
        ("fleet.count=0", "$.fleet.count"),
        ("fleet.count=201", "$.fleet.count"),
        ("craft.auv5={}", "$.craft.auv5"),
        ("fleet.nonsense=1", "$.fleet"),
        ("fleet.name=auv", "$.fleet.name"),
        ("fleet=3", "$.fleet"),
        ("craft=3", "$.craft"),
        ("fleet.craft.nonsense=1", "$.craft.auv1.nonsense"),
        ("mission.formation.type=ring", "$.mission.formation.type"),
        ("mission.formation.spacing_m=-1", "$.mission.formation.spacing_m"),
        ("mission.formation.spacing_m=nan", "$.mission.formation.spacing_m"),
        ("mission.formation=3", "$.mission.formation"),
        ("mission.type=tracks", "$.mission.formation"),
        ("mission.formation_m.auv1=[0.0, 0.0, 0.0]", "$.mission.formation_m"),
    ],
)
def test_faults_are_one_line_with_a_path(override, path):
    """Whatever is wrong with the shorthand is said in one line that begins with its path."""
    with pytest.raises(ConfigError) as refused:
        loads(FLEET, [override])
    line = str(refused.value)
    assert line.startswith((path + ":", path + " ")), line
    assert "\n" not in line


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 50])
@pytest.mark.parametrize("kind", TYPES)
def test_neighbours_are_as_far_apart_as_said(kind, count):
    """Neighbours are the spacing apart, nobody is nearer than that to anybody, and sides do not cross (Fig. 3)."""
    points = formation(kind, count)[:, :2]
    assert points.shape == (count, 2)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(steps, 20.0)
    away = np.linalg.norm(points[:, None] - points[None], axis=2) + 1e9 * np.eye(count)
    assert count == 1 or away.min() > 19.999
    assert not crossed(points.tolist())


def test_where_formations_stand():
    """Abreast from port to starboard about the reference, astern behind it, a V with its tip and a polygon ahead."""
    np.testing.assert_allclose(formation("abreast", 3), [[0, -20, 0], [0, 0, 0], [0, 20, 0]], atol=1e-9)
    np.testing.assert_allclose(formation("astern", 3, below_m=5.0), [[0, 0, 5], [-20, 0, 5], [-40, 0, 5]], atol=1e-9)
    side = 20.0 * math.sqrt(0.5)
    np.testing.assert_allclose(formation("v", 3), [[-side, -side, 0], [0, 0, 0], [-side, side, 0]], atol=1e-9)
    np.testing.assert_allclose(formation("v", 3, angle_deg=60.0)[2], [-20 * math.cos(math.pi / 6), 10, 0], atol=1e-9)
    half = 20.0 * math.sqrt(0.5)
    np.testing.assert_allclose(formation("polygon", 4), [[half, 0, 0], [0, half, 0], [-half, 0, 0], [0, -half, 0]],
                               atol=1e-9)  # fmt: skip


@pytest.mark.parametrize("count", [1, 2, 3, 50])
@pytest.mark.parametrize("kind", TYPES)
def test_score_of_any_team(kind, count):
    """FD is 0 when a team of any size is where it should be, finite when one is not, and greater than 0 then."""
    made = loads(FLEET, [f"fleet.count={count}", f"mission.formation.type={kind}", "mission.turn_radius_m=1500",
                         "mission.legs=1", "mission.formation.spacing_m=20"])  # fmt: skip
    plan = plan_mission(made)
    right = planned_places(plan)[:, :, :2]
    assert score(right, plan, ScoreConfig()).fd == pytest.approx(0.0, abs=1e-5)
    wrong = right.copy()
    wrong[:, -1, 1] += 3.0
    judged = score(wrong, plan, ScoreConfig())
    assert math.isfinite(judged.fd)
    assert judged.fd > 3.0 / count - 1e-6
