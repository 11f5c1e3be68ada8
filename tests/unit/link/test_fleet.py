"""Many craft in a few lines."""

import math
from itertools import pairwise

import pytest

from grex_link.errors import ConfigError
from grex_link.fleet import LineFormation, PolygonFormation, VFormation
from grex_link.scenario import fingerprint, loads

FLEET = """
[mission]
type = "lawnmower"
formation = { type = "v", spacing_m = 12.0 }
[fleet]
count = 5
craft.vehicle.speed_error_relative = 0.01
"""


@pytest.mark.parametrize("count", [2, 3, 8, 50])
@pytest.mark.parametrize(
    "formation",
    [
        LineFormation(12.0),
        LineFormation(12.0, "astern"),
        VFormation(12.0),
        VFormation(12.0, opening_deg=150.0),
        PolygonFormation(12.0),
    ],
)
def test_neighbours_are_spaced(formation, count):
    """In every formation of 2 to 50 craft neighbours are as far apart as asked for, and nobody is nearer."""
    places = formation.places(count)
    assert len(places) == count
    assert [math.dist(a, b) for a, b in pairwise(places)] == pytest.approx([12.0] * (count - 1))
    nearest = min(math.dist(a, b) for n, a in enumerate(places) for b in places[:n])
    assert nearest == pytest.approx(12.0)


def test_a_fleet_is_written_out():
    """A fleet is what one would have written by hand: same craft, same places, same fingerprint."""
    short = loads(FLEET)
    assert list(short.craft) == ["auv1", "auv2", "auv3", "auv4", "auv5"]
    places = "\n".join(f"{craft} = {list(place)}" for craft, place in short.mission.formation_m.items())
    tables = "\n".join(f"[craft.{craft}.vehicle]\nspeed_error_relative = 0.01" for craft in short.craft)
    long = loads(f'[mission]\ntype = "lawnmower"\n[mission.formation_m]\n{places}\n{tables}')
    assert fingerprint(short) == fingerprint(long)
    ahead, starboard, _ = short.mission.formation_m["auv1"]
    assert (ahead, starboard) == pytest.approx((-24.0 * math.sqrt(0.5), -24.0 * math.sqrt(0.5)), abs=1e-6)
    assert short.mission.formation_m["auv3"] == (0.0, 0.0, 0.0)


def test_one_of_a_fleet_may_differ():
    """A table of a craft changes that one only; a name of its own adds one."""
    scenario = loads(FLEET, ["craft.auv2.vehicle.speed_error_mps=0.1", "craft.ship.vehicle.speed_error_mps=0.2"])
    errors = [(each.vehicle.speed_error_relative, each.vehicle.speed_error_mps) for each in scenario.craft.values()]
    assert errors == [(0.01, 0.0), (0.01, 0.1), (0.01, 0.0), (0.01, 0.0), (0.01, 0.0), (0.0, 0.2)]


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("fleet.count=0", r"\$\.fleet\.count: expected `int` >= 1"),
        ("fleet.name=auv", r"\$\.fleet\.name: expected `str` matching"),
        ("fleet.many=3", r"\$\.fleet: object contains unknown field `many`"),
        ("fleet.craft.vehicle.speed=1", r"\$\.craft\.auv1\.vehicle\.speed: unknown key"),
        ("mission.formation.type=star", r"\$\.mission\.formation\.type: invalid value 'star'"),
        ("mission.formation.spacing_m=-1.0", r"\$\.mission\.formation\.spacing_m: expected `float` > 0\.0"),
        ("mission.formation_m.auv1=[0.0, 0.0, 0.0]", r"\$\.mission\.formation: there is formation_m too"),
    ],
)
def test_what_cannot_be_is_one_line(override, line):
    """A fault of a fleet or a formation is one line that names its path."""
    with pytest.raises(ConfigError, match=line) as fault:
        loads(FLEET, [override])
    assert "\n" not in str(fault.value)
