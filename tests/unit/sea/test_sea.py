"""The sea: all simulated craft together."""

import math

import pytest

from grex_agent.mission import plan_mission
from grex_link.messages import Setpoint
from grex_link.scenario import decode
from grex_sim.sea import Sea

NS = 1_000_000_000
FORMATION = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -25.0, 3.0]}


def sea(tick_s=1.0, **tables):
    """Two craft that start on course east, 8 m deep."""
    mission = {"type": "lawnmower", "formation_m": FORMATION, "heading_deg": 90.0, "start_ned_m": [0.0, 0.0, 8.0]}
    craft = {"auv1": {}, "auv2": {"navigation": {"offset_ned_m": [1.0, 2.0, 0.0]}}}
    scenario = decode({"mission": mission, "craft": craft, "clock": {"tick_s": tick_s}} | tables)
    return Sea(scenario, plan_mission(scenario))


def steer(course_rad=math.pi / 2.0, speed_mps=1.0, depth_m=8.0):
    """A setpoint to steer by."""
    return Setpoint(0, 0, "steer", course_rad, speed_mps, depth_m)


def test_starts_on_the_plan():
    """Everybody starts where the plan does: in formation, on its course, at its depth and speed."""
    first, second = sea().truth.poses
    assert (first.craft, second.craft) == ("auv1", "auv2")
    assert (first.north_m, first.east_m, first.down_m) == pytest.approx((0.0, 0.0, 8.0))
    assert (second.north_m, second.east_m, second.down_m) == pytest.approx((25.0, -6.0, 11.0))
    assert (second.heading_rad, second.surge_mps) == pytest.approx((math.pi / 2.0, 1.0))


@pytest.mark.parametrize("tick_s", [1.0, 0.25])
def test_moves_everybody_tick_by_tick(tick_s):
    """A tick moves every craft under its own setpoint; one without a setpoint slows down."""
    water = sea(tick_s)
    for _ in range(4):
        water.advance({"auv1": steer()})
    first, second = water.truth.poses
    assert (water.tick, water.truth.tick, water.truth.t_ns) == (4, 4, round(4 * tick_s * NS))
    assert (first.north_m, first.east_m) == pytest.approx((0.0, 4.0 * tick_s))
    assert second.surge_mps < 1.0


def test_truth_is_kept():
    """The truth of a tick does not change when the sea moves on."""
    water = sea()
    before = water.truth
    water.advance({"auv1": steer()})
    assert before.poses[0].east_m == 0.0
    assert water.truth.poses[0].east_m == pytest.approx(1.0)


def test_fixes():
    """Each craft gets a fix by its own navigation, with its own count of modem events."""
    water = sea()
    water.advance({})
    first, second = water.fixes([3, 5])
    assert (first.tick, first.t_ns, first.modem_events, second.modem_events) == (1, NS, 3, 5)
    assert first.east_m == pytest.approx(water.truth.poses[0].east_m)
    assert second.north_m == pytest.approx(water.truth.poses[1].north_m + 1.0)
    assert second.east_m == pytest.approx(water.truth.poses[1].east_m + 2.0)


def test_adrift():
    """Craft that cannot make good their ordered course are named."""
    water = sea(sea={"current_ned_mps": [0.0, 3.5, 0.0]})
    assert water.adrift == []
    water.advance({"auv1": steer(course_rad=0.0), "auv2": steer()})
    assert water.adrift == ["auv1"]


CLOCKS = {"auv1": {"clock": {"offset_s": 2.5, "drift_ppm": 100.0}}, "auv2": {}}


def test_fixes_carry_the_time_of_the_crafts_own_clock():
    """A fix is stamped by its craft's clock, with offset and drift; tick and truth stay what they are."""
    water = sea(craft=CLOCKS)
    assert [fix.t_ns for fix in water.fixes([0, 0])] == [2_500_000_000, 0]
    for _ in range(1000):
        water.advance({})
    first, second = water.fixes([0, 0])
    assert (first.tick, second.tick, water.truth.t_ns) == (1000, 1000, 1000 * NS)
    assert (first.t_ns, second.t_ns) == (1002 * NS + 600_000_000, 1000 * NS)


def test_a_wrong_clock_does_not_move_a_fix():
    """Where a fix says the craft is does not depend on its clock, even where navigation drifts with time."""
    drifting = {"navigation": {"drift_ned_mps": [0.01, 0.02, 0.0], "white_m": 0.5}}
    right = sea(craft={"auv1": drifting, "auv2": {}})
    wrong = sea(craft={"auv1": drifting | CLOCKS["auv1"], "auv2": {}})
    for water in (right, wrong):
        for _ in range(50):
            water.advance({"auv1": steer()})
    (expected, _), (found, _) = right.fixes([0, 0]), wrong.fixes([0, 0])
    assert (found.north_m, found.east_m, found.sigma_m) == (expected.north_m, expected.east_m, expected.sigma_m)
    assert found.t_ns - expected.t_ns == 2_500_000_000 + 5_000_000


def test_gps_sets_the_clock_at_the_surface():
    """A craft at the surface with GPS stamps mission time; the one below keeps its error."""
    clock = {"offset_s": 2.5, "gps_at_surface": True}
    water = sea(
        craft={"auv1": {"clock": clock}, "auv2": {"clock": clock}},
        mission={
            "type": "lawnmower",
            "formation_m": FORMATION,
            "start_ned_m": [0.0, 0.0, 0.2],
        },
    )
    assert [fix.t_ns for fix in water.fixes([0, 0])] == [0, 2_500_000_000]
