"""Behaviour 10: the heartbeat of the ground station, whose it must be, and what comes of its end."""

import pytest
from autopilots import Bench


def beat(bench, seconds: float, system: int = 255, **drive) -> None:
    """Heartbeats at 1 Hz, set-points at 5 Hz."""
    until = bench.now + seconds
    while bench.now < until - 1e-6:
        bench.heartbeat(system)
        bench.drive(1.0, **({"north": 1.0, "east": 0.0} | drive))


def test_a_rover_does_nothing_by_default():
    """FS_GCS_ENABLE is 0 on a Rover: without heartbeats it goes on."""
    bench = Bench().guided()
    beat(bench, 3.0)
    bench.drive(15.0, 1.0, 0.0)
    assert (bench.shown, bench.armed) == (15, True)


def test_a_rover_holds_when_told_so():
    """With FS_GCS_ENABLE = 1 it is in HOLD 6.5 s after the last heartbeat, with a text, though set-points go on."""
    bench = Bench().guided()
    bench.set_parameter("FS_GCS_ENABLE", 1)
    beat(bench, 3.0)
    last = bench.now - 1.0
    bench.drive(last + 6.4 - bench.now, 1.0, 0.0)
    assert bench.pilot.brain.modes.mode.name == "GUIDED"
    bench.drive(last + 7.8 - bench.now, 1.0, 0.0)
    assert (bench.shown, bench.armed) == (4, True)
    assert "Radio Failsafe" in bench.texts(last)


def test_heartbeats_that_come_back_do_not_bring_the_mode_back():
    """With heartbeats again it says that the failsafe is cleared, and stays in HOLD."""
    bench = Bench(parameters={"FS_GCS_ENABLE": 1}).guided()
    beat(bench, 3.0)
    bench.drive(10.0, 1.0, 0.0)
    beat(bench, 5.0)
    assert "GCS Failsafe Cleared" in bench.texts()
    assert bench.shown == 4


def test_only_the_ground_stations_own_id_counts():
    """Heartbeats of system 42 keep nothing alive; and a station never seen never fails."""
    bench = Bench(parameters={"FS_GCS_ENABLE": 1}).guided()
    beat(bench, 15.0, system=42)
    assert bench.shown == 15
    beat(bench, 2.0)
    beat(bench, 10.0, system=42)
    assert bench.shown == 4


def test_the_id_is_a_parameter():
    """With SYSID_MYGCS = 42 it is system 42's heartbeat that counts."""
    bench = Bench(parameters={"FS_GCS_ENABLE": 1, "SYSID_MYGCS": 42}).guided()
    beat(bench, 15.0, system=42)
    assert bench.shown == 15
    bench.drive(10.0, 1.0, 0.0)
    assert bench.shown == 4


def test_a_sub_disarms():
    """A Sub disarms 6 s after the last heartbeat, in mid-water and by default, and stays disarmed."""
    bench = Bench("sub").guided()
    beat(bench, 4.0, north=0.5, down=0.5)
    depth = bench.truth.down_m
    assert depth > 1.0
    last = bench.now - 1.0
    bench.drive(last + 5.9 - bench.now, 0.5, 0.0)
    assert bench.pilot.brain.modes.armed
    bench.drive(last + 6.3 - bench.now, 0.5, 0.0)
    assert not bench.pilot.brain.modes.armed
    beat(bench, 3.0)
    assert not bench.armed


@pytest.mark.parametrize(("enable", "mode"), [(3, 2), (4, 9)])
def test_a_sub_may_do_something_better(enable, mode):
    """With FS_GCS_ENABLE 3 a Sub holds its depth, with 4 it surfaces; both times it stays armed."""
    bench = Bench("sub", parameters={"FS_GCS_ENABLE": enable}).guided()
    beat(bench, 4.0, north=0.5, down=0.5)
    bench.drive(8.0, 0.5, 0.0)
    assert (bench.shown, bench.armed) == (mode, True)


@pytest.mark.parametrize(("enable", "mode"), [(0, 0x060000), (1, 0x03040000)])
def test_px4_waits_ten_seconds(enable, mode):
    """A PX4 with NAV_DLL_ACT 0 does nothing, with 1 it holds after COM_DL_LOSS_T."""
    bench = Bench("px4", parameters={"NAV_DLL_ACT": enable}).guided()
    beat(bench, 3.0)
    bench.drive(8.0, 1.0, 0.0)
    assert bench.shown == 0x060000
    bench.drive(4.0, 1.0, 0.0)
    assert bench.shown == mode


def test_an_enforced_id_is_silence_for_all_others():
    """With SYSID_ENFORCE = 1 nobody but the ground station is heard: no ACK, nothing."""
    bench = Bench(parameters={"SYSID_ENFORCE": 1}).run(3.0)
    assert bench.command(176, 1, 4, system=42) is None
    assert bench.command(176, 1, 4, system=255) == 0
