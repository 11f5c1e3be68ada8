"""The simulated craft: lags, limits, disturbance, depth and current."""

import math

import msgspec
import numpy as np
import pytest

from grex_link.config import CraftConfig, Loop, SeaConfig, SpeedLimit, SpeedWander, VehicleConfig
from grex_link.messages import Setpoint
from grex_sim.vehicle import LagLoop, SurgeActuator, Vehicle

STILL = SeaConfig()
EASY = VehicleConfig(
    heading=Loop(lag_s=2.0, min=-9.0, max=9.0, rate_max=9.0),
    surge=Loop(lag_s=2.0, min=0.3, max=3.0, rate_max=9.0),
    pitch=Loop(lag_s=1.5, min=-0.5, max=0.5, rate_max=9.0),
)


def vehicle(config=EASY, sea=STILL, start=(0.0, 0.0, 0.0, 0.0), speed_mps=1.0, dt=1.0):
    """A craft at the origin, on course north."""
    return Vehicle("auv1", CraftConfig(vehicle=config), sea, start, speed_mps, dt)


def steer(course_rad=0.0, speed_mps=1.0, depth_m=0.0):
    """A setpoint to steer by."""
    return Setpoint(0, 0, "steer", course_rad, speed_mps, depth_m)


HOLD = Setpoint(0, 0, "hold", 1.0, 2.0, 0.0)


@pytest.mark.parametrize("dt", [1.0, 0.1])
def test_surge_step_response(dt):
    """Surge answers a step as a first-order lag does: 1 - exp(-t/T), exactly, whatever the step."""
    craft = vehicle(speed_mps=1.0, dt=dt)
    for step in range(1, 30):
        craft.step(steer(speed_mps=2.0))
        assert craft.surge_mps == pytest.approx(2.0 - math.exp(-step * dt / 2.0), abs=1e-12)


def test_heading_step_response():
    """Heading answers likewise."""
    craft = vehicle()
    for step in range(1, 30):
        craft.step(steer(course_rad=0.5))
        assert craft.heading_rad == pytest.approx(0.5 * (1.0 - math.exp(-step / 2.0)), abs=1e-12)


def test_roll_rights_itself():
    """A rolled craft comes upright as a first-order lag does."""
    craft = vehicle()
    craft.roll_rad = 0.2
    craft.step(steer())
    assert craft.pose.roll_rad == pytest.approx(0.2 * math.exp(-1.0))


def test_no_lag_is_at_once():
    """A loop without a lag reaches its value in one step."""
    assert LagLoop(Loop(lag_s=0.0, min=-9.0, max=9.0, rate_max=9.0), 1.0).change(0.7) == 0.7


@pytest.mark.parametrize(("error", "change"), [(8.0, 0.1), (-8.0, -0.1), (0.05, 0.05 * (1.0 - math.exp(-0.25)))])
def test_rate_limit(error, change):
    """A state changes by no more than its rate times the step, either way."""
    loop = LagLoop(Loop(lag_s=2.0, min=-9.0, max=9.0, rate_max=0.2), 0.5)
    assert loop.change(error) == pytest.approx(change)


def test_rate_limits_of_a_craft():
    """Surge ramps at 0.2 m/s² and heading turns at 0.35 rad/s while far from their values."""
    craft = vehicle(VehicleConfig())
    for step in range(1, 4):
        craft.step(steer(course_rad=3.0, speed_mps=3.0))
        assert craft.surge_mps == pytest.approx(1.0 + 0.2 * step)
        assert craft.heading_rad == pytest.approx(0.35 * step)


@pytest.mark.parametrize(("ordered", "reached"), [(9.0, 3.0), (0.1, 0.3), (0.0, 0.3)])
def test_surge_limits(ordered, reached):
    """Surge stays within the craft's limits, whatever is ordered."""
    craft = vehicle()
    for _ in range(60):
        craft.step(steer(speed_mps=ordered))
    assert craft.surge_mps == pytest.approx(reached)


@pytest.mark.parametrize(("start", "ordered", "sense"), [(3.0, -3.0, 1.0), (-3.0, 3.0, -1.0)])
def test_heading_takes_the_short_way(start, ordered, sense):
    """From 3 rad to -3 rad a craft turns through south, not through north, and its heading stays in [-π, π)."""
    craft = vehicle(start=(0.0, 0.0, 0.0, start))
    turned = 0.0
    for _ in range(30):
        before = craft.heading_rad
        craft.step(steer(course_rad=ordered))
        turn = (craft.heading_rad - before + math.pi) % (2.0 * math.pi) - math.pi
        assert turn * sense >= 0.0
        assert -math.pi <= craft.heading_rad < math.pi
        turned += turn
    assert turned == pytest.approx(sense * (2.0 * math.pi - 6.0), abs=1e-5)
    assert craft.heading_rad == pytest.approx(ordered, abs=1e-5)


@pytest.mark.parametrize(
    ("errors", "reached"),
    [
        ({"speed_error_relative": 0.0125}, 1.2 * 1.0125),
        ({"speed_error_mps": -0.1}, 1.1),
        ({"speed_error_relative": 0.5, "speed_error_mps": 0.05}, 1.85),
    ],
)
def test_disturbed_actuator(errors, reached):
    """A disturbed actuator gives (1 + relative) times the order and the offset more."""
    craft = vehicle(VehicleConfig(**errors))
    for _ in range(60):
        craft.step(steer(speed_mps=1.2))
    assert craft.surge_mps == pytest.approx(reached)


def test_disturbance_comes_after_the_limit():
    """A craft at its limit is still disturbed."""
    craft = vehicle(VehicleConfig(speed_error_relative=0.1))
    for _ in range(80):
        craft.step(steer(speed_mps=9.0))
    assert craft.surge_mps == pytest.approx(3.3)


def test_straight_run():
    """On course and at speed a craft moves by speed times step."""
    craft = vehicle(start=(5.0, 6.0, 0.0, math.pi / 6.0), speed_mps=2.0, dt=0.5)
    for _ in range(10):
        craft.step(steer(course_rad=math.pi / 6.0, speed_mps=2.0))
    assert (craft.north_m, craft.east_m) == pytest.approx((5.0 + 10.0 * math.cos(math.pi / 6.0), 11.0))


def test_moves_with_the_mean_of_old_and_new():
    """A step is made with the mean heading and the mean surge of its beginning and end."""
    craft = vehicle()
    craft.step(steer(course_rad=0.5, speed_mps=2.0))
    heading, surge = craft.heading_rad / 2.0, (1.0 + craft.surge_mps) / 2.0
    assert (craft.north_m, craft.east_m) == pytest.approx((surge * math.cos(heading), surge * math.sin(heading)))


@pytest.mark.parametrize(("start_m", "ordered_m"), [(0.0, 12.0), (15.0, 3.0)])
def test_depth_converges(start_m, ordered_m):
    """The depth controller brings a craft to its depth, deeper or shallower, with pitch within its limits."""
    craft = vehicle(VehicleConfig(), start=(0.0, 0.0, start_m, 0.0))
    first = None
    for _ in range(240):
        craft.step(steer(depth_m=ordered_m))
        first = craft.pitch_rad if first is None else first
        assert abs(craft.pitch_rad) <= 0.5
    assert first * (ordered_m - start_m) < 0.0
    assert craft.down_m == pytest.approx(ordered_m, abs=0.01)


def test_dive():
    """A pitched craft goes down by surge times the sine of its pitch, and that much slower ahead."""
    config = VehicleConfig(pitch=Loop(lag_s=0.0, min=-0.5, max=0.5, rate_max=9.0))
    craft = vehicle(config)
    craft.pitch_rad = -0.5
    craft.step(steer(depth_m=100.0))
    assert (craft.north_m, craft.down_m) == pytest.approx((math.cos(0.5), math.sin(0.5)))


@pytest.mark.parametrize("setpoint", [HOLD, None])
def test_hold_stops(setpoint):
    """On hold, or without a setpoint, the thrusters stop and the heading is kept; the disturbance stops, too."""
    craft = vehicle(VehicleConfig(speed_error_mps=0.4), start=(0.0, 0.0, 4.0, 0.7))
    for _ in range(60):
        craft.step(setpoint)
    assert craft.surge_mps == pytest.approx(0.0, abs=1e-9)
    assert craft.heading_rad == pytest.approx(0.7)
    assert craft.down_m == pytest.approx(4.0)


def test_hold_drifts():
    """A craft on hold goes where the current takes it."""
    craft = vehicle(sea=SeaConfig(current_ned_mps=(0.1, -0.2, 0.0)), speed_mps=0.0)
    for _ in range(10):
        craft.step(HOLD)
    assert (craft.north_m, craft.east_m) == pytest.approx((1.0, -2.0))


@pytest.mark.parametrize("current", [(0.0, 0.0, 0.0), (0.0, 0.0, -0.8)])
def test_no_craft_flies(current):
    """However it is ordered and lifted, a craft never comes above the surface."""
    craft = vehicle(VehicleConfig(), SeaConfig(current_ned_mps=current), start=(0.0, 0.0, 1.5, 0.0))
    for _ in range(60):
        craft.step(steer(depth_m=-20.0))
        assert craft.down_m >= 0.0
    assert craft.down_m == 0.0


def test_known_current_is_compensated():
    """In a current that it knows a craft makes good the course and speed ordered."""
    craft = vehicle(sea=SeaConfig(current_ned_mps=(0.2, 0.3, 0.0)))
    for _ in range(60):
        craft.step(steer())
    north, east = craft.north_m, craft.east_m
    craft.step(steer())
    assert (craft.north_m - north, craft.east_m - east) == pytest.approx((1.0, 0.0), abs=1e-6)
    assert craft.holdable


def test_unknown_current_sets_the_craft_off():
    """What it does not know of the current moves the craft besides."""
    craft = vehicle(sea=SeaConfig(current_ned_mps=(0.2, 0.3, 0.0), known_current_ned_mps=(0.2, 0.0, 0.0)))
    for _ in range(60):
        craft.step(steer())
    north, east = craft.north_m, craft.east_m
    craft.step(steer())
    assert (craft.north_m - north, craft.east_m - east) == pytest.approx((1.0, 0.3), abs=1e-6)


def test_holdable():
    """A craft says when its ordered course cannot be made good, and when it can again."""
    craft = vehicle(sea=SeaConfig(current_ned_mps=(0.0, 3.5, 0.0)))
    craft.step(steer())
    assert not craft.holdable
    craft.step(steer(course_rad=math.pi / 2.0))
    assert craft.holdable


def test_pose():
    """A pose is the whole true state."""
    craft = vehicle(start=(1.0, 2.0, 3.0, 0.4), speed_mps=1.5)
    pose = craft.pose
    assert (pose.craft, pose.north_m, pose.east_m, pose.down_m) == ("auv1", 1.0, 2.0, 3.0)
    assert (pose.roll_rad, pose.pitch_rad, pose.heading_rad, pose.surge_mps) == (0.0, 0.0, 0.4, 1.5)


def test_a_speed_limit_holds_for_its_time():
    """In the times given the surge is no more than the limit; before and after it is what is ordered."""
    limits = (SpeedLimit(start_s=50.0, end_s=100.0, max_mps=0.8),)
    craft = vehicle(msgspec.structs.replace(EASY, speed_limits=limits))
    surges = []
    for _ in range(160):
        craft.step(steer(speed_mps=1.2))
        surges.append(craft.surge_mps)
    assert surges[49] == pytest.approx(1.2, abs=1e-6)
    assert surges[99] == pytest.approx(0.8, abs=1e-6)
    assert surges[51] > 0.8
    assert surges[159] == pytest.approx(1.2, abs=1e-6)


def test_a_wandering_speed_error():
    """The speed error has the deviation and the time constant given, whatever the craft, and no draw is shared."""
    wander = SpeedWander(sigma_relative=0.03, time_s=60.0)
    actuator = SurgeActuator("auv1", VehicleConfig(speed_wander=wander), 1, 1.0)
    errors = np.array([actuator.drive(2.0) / 2.0 - 1.0 for _ in range(40_000)])
    assert errors.std() == pytest.approx(0.03, rel=0.1)
    assert abs(errors.mean()) < 0.004
    assert np.corrcoef(errors[:-60], errors[60:])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.12)


def test_wandering_is_a_matter_of_seed_and_craft():
    """The same seed and craft wander alike; another seed or another craft do not; at rest nothing wanders."""
    config = VehicleConfig(speed_wander=SpeedWander(sigma_relative=0.03))

    def wandering(craft, seed):
        actuator = SurgeActuator(craft, config, seed, 1.0)
        return [actuator.drive(1.0) for _ in range(5)]

    assert wandering("auv1", 1) == wandering("auv1", 1)
    assert wandering("auv1", 1) != wandering("auv1", 2)
    assert wandering("auv1", 1) != wandering("auv2", 1)
    assert SurgeActuator("auv1", config, 1, 1.0).drive(0.0) == 0.0
