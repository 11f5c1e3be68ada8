"""Craft that the sea does not move: their fixes are where they are."""

import pytest

from grex_agent.mission import plan_mission
from grex_link.messages import Fix, Setpoint
from grex_link.scenario import loads
from grex_sim.external import External
from grex_sim.sea import Sea

TEXT = """
datum = { latitude_deg = 54.37, longitude_deg = 10.16 }
clock.pace = "live"
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 20, 0]
auv3 = [0, 40, 0]
[craft.auv1]
[craft.auv2.frontseat]
type = "mavlink"
url = "udpin:127.0.0.1:14550"
[craft.auv3]
"""
SECOND = 1_000_000_000


def fix(tick: int, north_m: float, east_m: float = 0.0, **changes) -> Fix:
    values = {"down_m": 1.0, "heading_rad": 0.5, "speed_mps": 2.0, "sigma_m": 0.3}
    return Fix(tick, tick * SECOND, north_m, east_m, **(values | changes))


@pytest.fixture
def craft() -> External:
    return External("auv2", (5.0, 6.0, 7.0, 0.1))


def test_until_it_says_where_it_is(craft):
    """Before its first fix a craft is where it was planned to be."""
    pose = craft.pose(3 * SECOND)
    assert (pose.north_m, pose.east_m, pose.down_m, pose.heading_rad) == (5.0, 6.0, 7.0, 0.1)


def test_the_first_fix_is_where_it_is(craft):
    """Far from its planned place it is where its first fix says, and does not rush there."""
    craft.on_fix(fix(0, 100.0), 0)
    assert craft.pose(SECOND).north_m == 100.0


def test_it_is_carried_on_to_the_tick(craft):
    """With the fix of the tick before it is carried on by its velocity; with that of the tick itself it is there."""
    craft.on_fix(fix(1, 10.0, 4.0), SECOND)
    craft.on_fix(fix(2, 12.0, 3.0), 2 * SECOND)
    assert (craft.pose(3 * SECOND).north_m, craft.pose(3 * SECOND).east_m) == (14.0, 2.0)
    craft.on_fix(fix(3, 13.5, 2.5), 3 * SECOND)
    assert (craft.pose(3 * SECOND).north_m, craft.pose(3 * SECOND).east_m) == (13.5, 2.5)


def test_a_craft_that_is_silent_stops(craft):
    """It is carried on for two seconds at most: nobody knows where it goes."""
    craft.on_fix(fix(1, 10.0), SECOND)
    craft.on_fix(fix(2, 11.0), 2 * SECOND)
    assert craft.pose(60 * SECOND).north_m == 13.0
    craft.on_fix(fix(60, 50.0), 60 * SECOND)
    assert craft.pose(61 * SECOND).north_m == 50.0


def test_a_fix_that_is_not_valid(craft):
    """What is not valid, or old, does not move it."""
    craft.on_fix(fix(5, 10.0), 5 * SECOND)
    craft.on_fix(fix(6, 99.0, valid=False), 6 * SECOND)
    craft.on_fix(fix(4, 77.0), 4 * SECOND)
    assert craft.pose(6 * SECOND).north_m == 10.0


def test_the_sea_moves_the_others_only():
    """The sea moves and fixes the simulated craft; the truth holds all, in the order of the team."""
    scenario = loads(TEXT)
    sea = Sea(scenario, plan_mission(scenario))
    assert sea.simulated == ["auv1", "auv3"]
    sea.external["auv2"].on_fix(fix(0, -3.0, 18.0), 0)
    ahead = Setpoint(0, 0, "steer", 0.0, 1.0, 0.0)
    sea.advance(dict.fromkeys(scenario.craft, ahead))
    assert [pose.craft for pose in sea.truth.poses] == ["auv1", "auv2", "auv3"]
    assert sea.truth.poses[0].north_m > 0.5
    assert (sea.truth.poses[1].north_m, sea.truth.poses[1].east_m) == (-3.0, 18.0)
    assert len(sea.fixes([0, 0, 0])) == 2
