"""Behaviours 4 and 5: set-points that stop, and those that are met with silence."""

import math

import pytest
from autopilots import Bench

ALL_BUT_VXY = 0x0DC7 | 0x20
"""Velocity with VZ ignored too: the habit of two dimensions."""


def test_a_rover_stops_with_a_text_and_stays_guided():
    """3.0 s after the last set-point a Rover says so once, coasts to rest, keeps its place, armed and in GUIDED."""
    bench = Bench().guided().drive(6.0, 2.0, 0.0)
    last = bench.now
    bench.run(last + 2.9)
    assert not any("stopping" in text for text in bench.texts())
    assert bench.speed > 1.9
    bench.run(last + 3.3)
    assert "target not received last 3secs, stopping" in bench.texts(last)
    bench.run(last + 7.5)
    assert bench.speed < 0.1
    place = bench.truth
    bench.run(last + 60.0)
    assert math.dist((place.north_m, place.east_m), (bench.truth.north_m, bench.truth.east_m)) < 2.5
    assert (bench.shown, bench.armed) == (15, True)
    assert sum("stopping" in text for text in bench.texts()) == 1


def test_a_rover_keeps_its_place_against_a_current():
    """Having stopped, a Rover in a current of 0.3 m/s is within 3 m of its place a minute later."""
    bench = Bench(current_ned_mps=(0.0, 0.3, 0.0)).guided().drive(4.0, 1.0, 0.0)
    place = bench.run(bench.now + 10.0).truth
    bench.run(bench.now + 60.0)
    assert math.dist((place.north_m, place.east_m), (bench.truth.north_m, bench.truth.east_m)) < 3.0


def test_a_sub_stops_without_a_word():
    """A Sub zeroes its velocity after 3 s, stays in GUIDED, armed, and says nothing."""
    bench = Bench("sub").guided().drive(6.0, 0.5, 0.0)
    last = bench.now
    bench.run(last + 2.9)
    assert bench.speed > 0.35
    bench.run(last + 8.0)
    assert bench.speed < 0.05
    assert bench.texts(last) == []
    assert (bench.shown, bench.armed) == (4, True)


def test_px4_leaves_offboard_and_comes_back_by_itself():
    """1 s without set-points and a PX4 is in POSCTL, armed; when they come again it is in OFFBOARD by itself."""
    bench = Bench("px4").guided().drive(5.0, 2.0, 0.0)
    last = bench.now
    bench.run(last + 0.9)
    assert bench.pilot.brain.modes.mode.name == "OFFBOARD"
    bench.run(last + 2.1)
    assert (bench.shown, bench.armed) == (0x030000, True)
    bench.drive(2.0, 2.0, 0.0)
    assert bench.shown == 0x060000


def test_px4_does_not_come_back_from_a_mode_somebody_asked_for():
    """A PX4 that was put into LOITER stays there, whatever set-points come."""
    bench = Bench("px4").guided().drive(3.0, 2.0, 0.0)
    assert bench.mode("LOITER") == 0
    bench.drive(4.0, 2.0, 0.0)
    assert bench.shown == 0x03040000
    assert bench.speed < 0.5


@pytest.mark.parametrize(("gap_s", "warnings"), [(2.0, 0), (4.0, 5)])
def test_the_slowest_rate_that_keeps_it_going(gap_s, warnings):
    """At 0.5 Hz a Rover drives on; at 0.25 Hz it stops and goes, with five warnings in 20 s."""
    bench = Bench().guided()
    since = bench.now
    bench.run(since + 20.0, gap_s, lambda: bench.velocity(2.0, 0.0))
    bench.run(since + 20.0 + gap_s * 0.9)
    assert sum("stopping" in text for text in bench.texts(since)) == warnings


def test_a_depth_sent_once_is_not_reached():
    """In ALT_HOLD a depth streamed is reached in some seconds; sent once, it is held where the craft was after 5 s."""
    bench = Bench("sub").run(3.0)
    assert bench.mode("ALT_HOLD") == 0
    assert bench.command(400, 1) == 0

    def depth(metres):
        fields = {"coordinate_frame": 6, "target_system": 1, "type_mask": 0x0FFB, "lat_int": 0, "lon_int": 0}
        velocity = {"vx": 0.0, "vy": 0.0, "vz": 0.0, "yaw": 0.0, "yaw_rate": 0.0}
        bench.send("SET_POSITION_TARGET_GLOBAL_INT", alt=-metres, **fields, **velocity)

    bench.run(bench.now + 8.0, 0.5, lambda: depth(5.0))
    assert bench.truth.down_m == pytest.approx(5.0, abs=0.2)
    depth(20.0)
    bench.run(bench.now + 20.0)
    assert 6.0 < bench.truth.down_m < 15.0


def test_a_heading_in_alt_hold_goes_back_to_the_pilots():
    """5 s after the last heading in ALT_HOLD a Sub turns back to where it looked before."""
    bench = Bench("sub").run(3.0)
    bench.mode("ALT_HOLD")
    bench.command(400, 1)
    half = math.radians(120.0) / 2.0
    q = [math.cos(half), 0.0, 0.0, math.sin(half)]
    bench.run(
        bench.now + 8.0,
        0.5,
        lambda: bench.send("SET_ATTITUDE_TARGET", target_system=1, type_mask=64 | 7, q=q, thrust=0.5),
    )
    assert bench.heading_deg == pytest.approx(120.0, abs=3.0)
    bench.run(bench.now + 4.5)
    assert bench.heading_deg == pytest.approx(120.0, abs=3.0)
    bench.run(bench.now + 6.0)
    assert bench.heading_deg == pytest.approx(0.0, abs=3.0)


@pytest.mark.parametrize(
    ("family", "more", "obeyed"),
    [
        ("rover", {}, True),
        ("rover", {"mask": ALL_BUT_VXY}, True),
        ("sub", {"mask": ALL_BUT_VXY}, False),
        ("px4", {"mask": ALL_BUT_VXY}, True),
        ("rover", {"mask": 0x0C07}, False),
        ("sub", {"mask": 0x0C07}, False),
        ("rover", {"coordinate_frame": 4}, False),
        ("rover", {"coordinate_frame": 20}, False),
        ("rover", {"coordinate_frame": 8}, True),
        ("px4", {"coordinate_frame": 8}, True),
        ("rover", {"target_system": 0}, True),
        ("rover", {"target_system": 7}, False),
        ("rover", {"system": 42}, True),
        ("rover", {"target_component": 77}, True),
    ],
)
def test_which_setpoints_are_obeyed(family, more, obeyed):
    """Mask, frame and target decide by family; what is dropped gets no ACK and no text."""
    bench = Bench(family).guided()
    since = bench.now
    bench.drive(4.0, 1.0, 0.0, **more)
    assert (bench.speed > 0.5) is obeyed
    assert bench.texts(since) == []
    assert bench.said("COMMAND_ACK", since) == []


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
def test_setpoints_in_a_wrong_mode_are_ignored(family):
    """In another mode nothing moves, and nothing is said."""
    bench = Bench(family).guided()
    bench.mode("MANUAL")
    since = bench.now
    bench.drive(4.0, 1.0, 0.0)
    assert bench.speed < 0.3
    assert bench.texts(since) == []


def test_an_offset_frame_makes_px4_leave_offboard():
    """LOCAL_OFFSET_NED is refused by a PX4, which loses OFFBOARD over it."""
    bench = Bench("px4").guided().drive(1.0, 1.0, 0.0)
    bench.velocity(1.0, 0.0, coordinate_frame=7)
    assert bench.run(bench.now + 1.1).shown == 0x030000


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_nonsense_is_dropped(value):
    """A velocity that is no number is dropped, and the craft goes on as before."""
    bench = Bench().guided().drive(4.0, 1.0, 0.0)
    bench.velocity(value, 0.0)
    bench.drive(1.0, 1.0, 0.0)
    assert bench.speed == pytest.approx(1.0, abs=0.05)


def test_a_position_is_sent_once():
    """One position target is enough: a Rover goes to x, y of its own local frame and stays, without a warning."""
    bench = Bench().guided()
    since, origin = bench.now, bench.pilot.brain.estimator.origin
    bench.velocity(0.0, 0.0, mask=0x0DF8, x=20.0, y=10.0)
    bench.run(since + 40.0)
    there = origin[0] + 20.0, origin[1] + 10.0
    assert math.dist((bench.truth.north_m, bench.truth.east_m), there) < 2.5
    assert bench.texts(since) == []


def test_full_dive_is_zero():
    """MANUAL_CONTROL with z = 0 dives a Sub at full thrust; 500 is neutral; it goes on 3 s after the last message."""
    bench = Bench("sub").run(3.0)
    bench.mode("MANUAL")
    bench.command(400, 1)
    bench.send("MANUAL_CONTROL", target=1, x=0, y=0, z=500, r=0, buttons=0)
    bench.run(bench.now + 2.0)
    assert bench.truth.down_m == 0.0
    bench.send("MANUAL_CONTROL", target=1, x=500, y=0, z=0, r=0, buttons=0)
    bench.run(bench.now + 2.9)
    assert bench.truth.down_m > 1.5
    assert bench.speed > 0.3
    bench.run(bench.now + 4.0)
    assert bench.speed < 0.1


@pytest.mark.parametrize(
    ("frame", "north", "east"),
    [(7, 12.0, 5.0), (9, -5.0, 12.0)],
)
def test_positions_from_the_craft(frame, north, east):
    """An offset counts from the craft, a body offset from its bow, which looks east here."""
    bench = Bench(heading_rad=math.pi / 2.0, wind_ned_mps=(0.0, 0.0)).guided()
    bench.velocity(0.0, 0.0, mask=0x0DF8, coordinate_frame=frame, x=12.0, y=5.0)
    bench.run(bench.now + 40.0)
    assert math.dist((bench.truth.north_m, bench.truth.east_m), (north, east)) < 2.5


def global_setpoint(bench, mask: int, **more) -> None:
    fields = {"coordinate_frame": 6, "target_system": 1, "type_mask": mask, "lat_int": 0, "lon_int": 0, "alt": 0.0}
    fields |= dict.fromkeys(("vx", "vy", "vz", "yaw", "yaw_rate"), 0.0)
    bench.send("SET_POSITION_TARGET_GLOBAL_INT", **(fields | more))


def test_a_global_position_and_depth():
    """A Sub in GUIDED goes to a latitude, a longitude and a negative altitude, told once."""
    bench = Bench("sub", wind_ned_mps=(0.0, 0.0)).guided()
    global_setpoint(bench, 0x0DF8, lat_int=543_701_000, lon_int=101_600_000, alt=-4.0)
    bench.run(bench.now + 40.0)
    assert bench.truth.north_m == pytest.approx(11.1, abs=2.5)
    assert bench.truth.down_m == pytest.approx(4.0, abs=0.2)


def test_a_global_velocity():
    """The velocity of a global set-point is obeyed as that of a local one; with acceleration it is dropped."""
    bench = Bench().guided()
    bench.run(bench.now + 8.0, 0.2, lambda: global_setpoint(bench, 0x0DC7, vx=1.0))
    assert bench.speed == pytest.approx(1.0, abs=0.05)
    since = bench.now
    bench.run(since + 8.0, 0.2, lambda: global_setpoint(bench, 0x0C07, vx=1.0))
    assert bench.speed < 0.1


@pytest.mark.parametrize(("thrust", "sinks"), [(0.5, False), (0.4, True)])
def test_thrust_is_depth_on_a_sub(thrust, sinks):
    """In GUIDED half thrust keeps a Sub's depth, and less sinks."""
    bench = Bench("sub").guided().drive(6.0, 0.0, 0.0, 0.5)
    depth = bench.truth.down_m
    q = [1.0, 0.0, 0.0, 0.0]
    target = {"target_system": 1, "type_mask": 7, "q": q, "thrust": thrust}
    bench.run(bench.now + 6.0, 0.2, lambda: bench.send("SET_ATTITUDE_TARGET", **target))
    assert (bench.truth.down_m - depth > 1.0) is sinks
    assert bench.truth.down_m - depth > -0.5


def test_an_attitude_stops_px4():
    """A PX4 rover told an attitude just stops."""
    bench = Bench("px4").guided().drive(6.0, 2.0, 0.0)
    target = {"target_system": 1, "type_mask": 7, "q": [1.0, 0.0, 0.0, 0.0], "thrust": 0.5}
    bench.run(bench.now + 8.0, 0.2, lambda: bench.send("SET_ATTITUDE_TARGET", **target))
    assert bench.speed < 0.1


def test_no_attitude_is_no_order():
    """SET_ATTITUDE_TARGET whose attitude is to be ignored is dropped."""
    bench = Bench().guided()
    target = {"target_system": 1, "type_mask": 0x80, "q": [1.0, 0.0, 0.0, 0.0], "thrust": 0.5}
    bench.run(bench.now + 4.0, 0.2, lambda: bench.send("SET_ATTITUDE_TARGET", **target))
    assert bench.speed < 0.05
