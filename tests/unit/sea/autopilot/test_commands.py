"""Behaviour 12: whom commands reach, and what ACKs say."""

import math

import pytest
from autopilots import ARM, SET_MODE, START, Bench


def test_an_ack_carries_the_askers_ids():
    """The ACK is addressed to who asked, and comes after 15 to 28 ms on a Rover."""
    bench = Bench().run(3.0)
    delays = []
    for n in range(20):
        at_s = bench.now
        bench.send(
            "COMMAND_LONG", system=40 + n, component=7, command=SET_MODE, target_system=1, param1=1.0, param2=4.0
        )
        ack = bench.run(at_s + 0.06, 0.005).last("COMMAND_ACK")
        assert (ack["target_system"], ack["target_component"]) == (40 + n, 7)
        delays.append(next(t for t, _, m in bench.heard if m is ack) - at_s)
    assert min(delays) >= 0.015
    assert max(delays) <= 0.045, "28 ms, and a tick"


def test_duplicates_give_two_acks():
    """The same command twice gives two ACKs."""
    bench = Bench().run(3.0)
    for _ in range(2):
        bench.send("COMMAND_LONG", command=SET_MODE, target_system=1, param1=1.0, param2=4.0)
    assert len(bench.run(3.2).said("COMMAND_ACK")) == 2


def test_an_absent_system_does_not_answer():
    """A command to another system id is met with silence."""
    bench = Bench().run(3.0)
    assert bench.command(ARM, 1, target_system=9) is None
    assert not bench.pilot.brain.modes.armed


def test_a_foreign_component_is_obeyed():
    """ARM sent to component 77, which there is not, arms."""
    bench = Bench("sub").run(3.0)
    assert bench.command(ARM, 1, target_component=77) == 0
    assert bench.pilot.brain.modes.armed


@pytest.mark.parametrize("number", [213, 31000])
def test_unsupported(number):
    """NAV_SET_YAW_SPEED, and whatever nobody knows, is UNSUPPORTED."""
    assert Bench().run(3.0).command(number, 1) == 3


def test_reposition_as_long_is_unsupported():
    """DO_REPOSITION is UNSUPPORTED as COMMAND_LONG; as COMMAND_INT the craft goes there and stays."""
    bench = Bench(wind_ned_mps=(0.0, 0.0)).guided()
    bench.mode("LOITER")
    assert bench.command(192, 0, 0, 0, 0, 54.3701, 10.16) == 3
    there = {"x": 543_702_000, "y": 101_600_000, "z": 0.0}
    assert bench.command(192, name="COMMAND_INT", **there) == 0
    bench.run(bench.now + 40.0)
    north, east = START.local(54.3702, 10.16)
    assert math.dist((bench.truth.north_m, bench.truth.east_m), (north, east)) < 3.0
    assert bench.shown == 15


def test_px4_repositions_while_it_loiters():
    """A PX4 takes DO_REPOSITION in either form, and goes there in its loiter mode without a stream."""
    bench = Bench("px4", wind_ned_mps=(0.0, 0.0)).guided()
    assert bench.command(192, 0, 0, 0, 0, 54.3702, 10.16) == 0
    bench.run(bench.now + 40.0)
    north, east = START.local(54.3702, 10.16)
    assert math.dist((bench.truth.north_m, bench.truth.east_m), (north, east)) < 3.0
    assert bench.shown == 0x03040000


def test_change_speed_needs_a_position_target():
    """On a Rover DO_CHANGE_SPEED is FAILED while velocities are sent, and ACCEPTED after a position; then it counts."""
    bench = Bench().guided().drive(2.0, 1.0, 0.0)
    assert bench.command(178, 1, 1.5) == 4
    bench.velocity(0.0, 0.0, mask=0x0DF8, x=100.0)
    assert bench.command(178, 1, 1.5) == 0
    assert bench.run(bench.now + 10.0).speed == pytest.approx(1.5, abs=0.05)


def test_calibration_answers_once_and_late():
    """A gyro calibration gives one ACK after 5.1 s, without IN_PROGRESS."""
    bench = Bench().run(3.0)
    assert bench.command(241, 1, wait=5.0) is None
    bench.run(bench.now + 0.3)
    assert [m["result"] for m in bench.said("COMMAND_ACK")] == [0]


@pytest.mark.parametrize(("number", "mode"), [(17, 5), (20, 11)])
def test_commands_that_are_modes(number, mode):
    """LOITER_UNLIM and RETURN_TO_LAUNCH change the mode."""
    bench = Bench().guided()
    assert bench.command(number) == 0
    assert bench.run(bench.now + 1.1).shown == mode


def test_home_is_reached():
    """In RTL a Rover comes back to its start."""
    bench = Bench(wind_ned_mps=(0.0, 0.0)).guided().drive(10.0, 2.0, 0.0)
    bench.command(20)
    bench.run(bench.now + 60.0)
    assert math.hypot(bench.truth.north_m, bench.truth.east_m) < 3.0


def test_a_sub_surfaces():
    """In SURFACE a Sub comes up and stays there."""
    bench = Bench("sub").guided().drive(10.0, 0.0, 0.0, 0.5)
    assert bench.truth.down_m > 3.0
    assert bench.mode("SURFACE") == 0
    bench.run(bench.now + 20.0)
    assert bench.truth.down_m < 0.1


@pytest.mark.parametrize(("number", "name"), [(520, "AUTOPILOT_VERSION"), (410, "HOME_POSITION")])
def test_questions_are_answered(number, name):
    """Version and home come when asked for."""
    bench = Bench().run(3.0)
    assert bench.command(number) == 0
    assert bench.said(name)


def test_time_is_synchronised():
    """TIMESYNC comes back with our time in it and the craft's, 22 ms later; a PX4 asks for itself."""
    bench = Bench().run(3.0)
    bench.send("TIMESYNC", tc1=0, ts1=123)
    assert not bench.run(3.02, 0.02).said("TIMESYNC")
    answer = bench.run(3.04, 0.02).last("TIMESYNC")
    assert (answer["ts1"], answer["tc1"]) == (123, 3_000_000_000)
    assert {m["tc1"] for m in Bench("px4").run(3.0).said("TIMESYNC")} == {0}


def test_there_is_no_mission():
    """A ground station that asks for the mission learns that it is empty."""
    bench = Bench().run(3.0)
    bench.send("MISSION_REQUEST_LIST", target_system=1, mission_type=0)
    assert bench.run(3.1).last("MISSION_COUNT")["count"] == 0


def test_half_thrust_is_half_speed_on_a_rover():
    """SET_ATTITUDE_TARGET with thrust 0.5 and a heading east makes 2.5 m/s east."""
    bench = Bench().guided()
    q = [math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4)]
    bench.run(
        bench.now + 12.0, 0.2, lambda: bench.send("SET_ATTITUDE_TARGET", target_system=1, type_mask=7, q=q, thrust=0.5)
    )
    assert bench.pilot.brain.craft.velocity[1] == pytest.approx(2.5, abs=0.05)


def test_what_commands_refuse():
    """Nonsense is DENIED, FAILED or UNSUPPORTED, and nothing happens."""
    bench = Bench().guided()
    assert bench.command(ARM, 0.5) == 4
    assert bench.command(179, 0, 0, 0, 0, 100.0, 0.0, 0.0) == 2
    assert bench.command(192, name="COMMAND_INT", x=2_000_000_000, y=0, z=0.0) == 2
    assert bench.command(246, 9) == 3
    assert bench.command(241, 1) == 4, "calibration while armed"
    bench.velocity(0.0, 0.0, mask=0x0DF8, x=10.0)
    assert bench.command(178, 1, math.nan) == 2
    assert bench.armed or bench.pilot.brain.modes.armed
    assert Bench("sub").guided().command(20) == 3


def test_arming_by_force():
    """With the magic number arming is accepted whatever is missing."""
    bench = Bench(ready_s=None).run(5.0)
    assert bench.command(ARM, 1) == 4
    assert bench.command(ARM, 1, 21196) == 0


def test_home_here():
    """DO_SET_HOME with 1 takes the place where the craft is."""
    bench = Bench(wind_ned_mps=(0.5, 0.0)).run(13.0)
    assert bench.command(179, 1) == 0
    assert bench.last("HOME_POSITION")["latitude"] == pytest.approx(543_700_000 + 6.5 / 0.01113, abs=20)


def test_a_ping_is_answered():
    """A PING to everybody is answered to who sent it; one that is an answer is not."""
    bench = Bench().run(3.0)
    bench.send("PING", time_usec=7, seq=3, target_system=0, target_component=0)
    bench.send("PING", time_usec=7, seq=4, target_system=1, target_component=1)
    pings = bench.run(3.1).said("PING")
    assert [(m["seq"], m["target_system"]) for m in pings] == [(3, 255)]


def test_reposition_needs_a_position():
    """A Sub that may not go into GUIDED refuses DO_REPOSITION."""
    bench = Bench("sub", ready_s=None).run(3.0)
    assert bench.command(192, name="COMMAND_INT", x=543_700_000, y=101_600_000, z=0.0) == 4
