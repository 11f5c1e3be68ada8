"""Behaviour 2: an ACK is no fact."""

import pytest
from autopilots import ARM, MODES, SET_MODE, Bench


def test_a_mode_accepted_too_early_is_taken_back():
    """GUIDED 0.2 s after power-on: ACCEPTED, shown, and 1.2 s later it is MANUAL again, with a text."""
    bench = Bench(ready_s=None).run(0.2)
    assert bench.mode("GUIDED") == 0
    assert bench.run(1.1).shown == 15
    assert bench.run(2.2).shown == 0
    assert "Flight mode change failed" in bench.texts()


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
def test_an_unknown_mode_fails(family):
    """A mode nobody knows is FAILED with a text, and the old one stays."""
    bench = Bench(family).run(3.0)
    shown = bench.shown
    assert bench.command(SET_MODE, 1, 99) == 4
    assert any("No such mode" in text for text in bench.texts())
    assert bench.run(5.0).shown == shown


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
def test_a_mode_without_the_custom_flag_is_denied(family):
    """DO_SET_MODE with base mode 0 is DENIED."""
    assert Bench(family).run(3.0).command(SET_MODE, 0, 15) == 2


@pytest.mark.parametrize("mode", ["GUIDED", "POSHOLD", "SURFACE"])
def test_a_sub_refuses_modes_that_need_a_position(mode):
    """Without a position a Sub's GUIDED, POSHOLD and SURFACE are FAILED with a text; ALT_HOLD arms at once."""
    bench = Bench("sub", ready_s=None).run(5.0)
    assert bench.mode(mode) == 4
    assert any("requires position" in text for text in bench.texts())
    assert bench.mode("ALT_HOLD") == 0
    assert bench.command(ARM, 1) == 0


def test_a_rover_takes_any_mode_while_disarmed():
    """Without a position a disarmed Rover shows GUIDED; armed in MANUAL it refuses it."""
    bench = Bench(ready_s=None).run(5.0)
    assert bench.mode("GUIDED") == 0
    assert bench.run(7.0).shown == 15
    assert bench.mode("MANUAL") == 0
    assert bench.run(24.0).command(ARM, 1) == 0
    assert bench.mode("GUIDED") == 4


def test_the_old_mode_message_has_no_ack():
    """SET_MODE works and is not acknowledged."""
    bench = Bench().run(3.0)
    bench.send("SET_MODE", target_system=1, base_mode=1, custom_mode=MODES["rover"]["HOLD"])
    assert bench.run(5.0).shown == 4
    assert not bench.said("COMMAND_ACK")


def test_px4_refuses_to_arm_by_event():
    """A PX4 without a position is TEMPORARILY_REJECTED, with an EVENT and no text at all."""
    bench = Bench("px4", ready_s=None).run(2.0)
    assert bench.command(ARM, 1) == 1
    assert bench.said("EVENT")
    assert bench.texts() == []


def test_px4_takes_offboard_without_a_stream_while_disarmed():
    """OFFBOARD without set-points is accepted while disarmed; arming in it is not."""
    bench = Bench("px4").run(3.0)
    assert bench.mode("GUIDED") == 0
    assert bench.run(5.0).shown == 0x060000
    assert bench.command(ARM, 1) == 1


def test_disarming_always_works():
    """DISARM is accepted, shown, and the craft stops."""
    bench = Bench(wind_ned_mps=(0.0, 0.0)).guided().drive(5.0, 2.0, 0.0)
    assert bench.command(ARM, 0) == 0
    bench.run(bench.now + 6.0)
    assert not bench.armed
    assert bench.speed < 0.1
