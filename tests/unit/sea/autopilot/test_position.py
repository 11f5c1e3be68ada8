"""Behaviours 7 and 9: positions that lie, and an origin of its own."""

import math

import pytest
from autopilots import START, Bench


def place(message) -> tuple[float, float]:
    return START.local(message["lat"] * 1e-7, message["lon"] * 1e-7)


def test_a_rovers_position_runs_on_when_satellites_are_lost():
    """Fix type falls at 2 s, flags and local position only at 7.5 s; the global one runs on at 2 m/s while it holds."""
    bench = Bench().guided()
    assert bench.command(511, 32, 100_000.0) == 0
    assert bench.command(511, 33, 100_000.0) == 0
    bench.drive(8.0, 2.0, 0.0)
    bench.set_parameter("SIM_GPS_DISABLE", 1)
    lost = bench.now
    bench.drive(5.0, 2.0, 0.0)
    assert bench.last("GPS_RAW_INT")["fix_type"] == 1
    assert bench.last("EKF_STATUS_REPORT")["flags"] == 0x33F
    bench.drive(4.5, 2.0, 0.0)
    assert bench.last("EKF_STATUS_REPORT")["flags"] == 0xA7
    assert (bench.shown, bench.last("HEARTBEAT")["system_status"]) == (4, 5)
    assert "EKF failsafe" in bench.texts(lost)
    silent_since = bench.now
    stood = bench.run(bench.now + 8.0).truth.north_m
    phantom = [place(m)[0] for m in bench.said("GLOBAL_POSITION_INT", bench.now - 5.0)]
    bench.run(bench.now + 10.0)
    assert bench.said("LOCAL_POSITION_NED", silent_since) == []
    assert len(bench.said("GLOBAL_POSITION_INT", silent_since)) > 150
    assert (phantom[-1] - phantom[0]) / (0.1 * (len(phantom) - 1)) == pytest.approx(2.0, abs=0.1)
    assert bench.truth.north_m == pytest.approx(stood, abs=1.0)
    assert bench.last("GLOBAL_POSITION_INT")["vx"] == 0


def test_a_subs_position_freezes():
    """A Sub that loses its fixes says so at 14 s; its global position stands still, it stays in GUIDED, armed."""
    bench = Bench("sub").guided().drive(5.0, 0.5, 0.0)
    bench.set_parameter("SIM_GPS_DISABLE", 1)
    lost = bench.now
    bench.drive(13.0, 0.5, 0.0)
    assert bench.last("EKF_STATUS_REPORT")["flags"] == 0x33F
    bench.drive(3.0, 0.5, 0.0)
    assert bench.last("EKF_STATUS_REPORT")["flags"] == 0xA7
    assert "EKF3 IMU0 stopped aiding" in bench.texts(lost)
    since, north = bench.now, bench.truth.north_m
    bench.drive(20.0, 0.5, 0.0)
    frozen = {place(m) for m in bench.said("GLOBAL_POSITION_INT", since)}
    assert len(frozen) == 1
    assert bench.truth.north_m - north > 5.0
    assert (bench.shown, bench.armed) == (4, True)


def test_satellites_that_come_back_do_not_bring_the_mode_back():
    """With satellites again the position is true again, and the mode is still HOLD."""
    bench = Bench().guided().drive(8.0, 2.0, 0.0)
    bench.set_parameter("SIM_GPS_DISABLE", 1)
    bench.run(bench.now + 20.0)
    bench.set_parameter("SIM_GPS_DISABLE", 0)
    bench.run(bench.now + 12.0)
    assert bench.last("EKF_STATUS_REPORT")["flags"] == 0x33F
    north, east = place(bench.last("GLOBAL_POSITION_INT"))
    assert math.dist((north, east), (bench.truth.north_m, bench.truth.east_m)) < 0.2
    assert bench.shown == 4
    assert bench.last("HEARTBEAT")["system_status"] == 4


def test_a_short_loss_is_hardly_seen():
    """Five seconds without satellites change the fix type, and neither flags nor mode."""
    bench = Bench().guided().drive(8.0, 2.0, 0.0)
    since = bench.now
    bench.set_parameter("SIM_GPS_DISABLE", 1)
    bench.drive(5.0, 2.0, 0.0)
    bench.set_parameter("SIM_GPS_DISABLE", 0)
    bench.drive(10.0, 2.0, 0.0)
    assert 1 in {m["fix_type"] for m in bench.said("GPS_RAW_INT", since)}
    assert {m["flags"] for m in bench.said("EKF_STATUS_REPORT", since)} == {0x33F}
    assert bench.shown == 15


def test_the_origin_is_its_own():
    """Two craft at one place have origins apart, none at the start; each local frame counts from its own."""
    origins = []
    for system in (1, 2):
        bench = Bench(system=system, wind_ned_mps=(0.0, 0.0)).run(3.0)
        origins.append(bench.pilot.brain.estimator.origin)
        bench.send("COMMAND_LONG", target_system=system, command=512, param1=32.0)
        local = bench.run(bench.now + 0.1).last("LOCAL_POSITION_NED")
        assert local["x"] == pytest.approx(-origins[-1][0], abs=1e-6)
    assert math.dist(origins[0], origins[1]) > 0.5
    assert min(math.hypot(*origin) for origin in origins) > 0.1


def test_the_drift_before_the_origin_counts():
    """A craft that drifted 4.2 m before its estimator was ready has its origin there, not at its start."""
    bench = Bench(ready_s=None, wind_ned_mps=(0.1, 0.0), system=3).run(43.0)
    still = Bench(wind_ned_mps=(0.0, 0.0), system=3).run(3.0)
    north = bench.pilot.brain.estimator.origin[0] - still.pilot.brain.estimator.origin[0]
    assert north == pytest.approx(4.2, abs=0.05)


def test_home_moves_the_relative_altitude_only():
    """DO_SET_HOME 5 m higher changes relative_alt by 5 m and leaves the local position alone."""
    bench = Bench(wind_ned_mps=(0.0, 0.0)).run(3.0)
    bench.command(511, 32, 100_000.0)
    bench.run(5.0)
    before, local = bench.last("GLOBAL_POSITION_INT")["relative_alt"], bench.last("LOCAL_POSITION_NED")
    assert bench.command(179, 0.0, 0.0, 0.0, 0.0, 54.3705, 10.16, 5.0) == 0
    bench.run(8.0)
    assert bench.last("GLOBAL_POSITION_INT")["relative_alt"] - before == -5000
    assert bench.last("LOCAL_POSITION_NED")["x"] == pytest.approx(local["x"], abs=1e-6)
    assert bench.last("HOME_POSITION")["latitude"] == 543_705_000


@pytest.mark.parametrize(("family", "moved"), [("rover", False), ("sub", False), ("px4", True)])
def test_a_second_origin(family, moved):
    """SET_GPS_GLOBAL_ORIGIN after the fact is silently ignored by ArduPilot; a PX4's local position jumps."""
    bench = Bench(family, wind_ned_mps=(0.0, 0.0)).run(3.0)
    bench.command(511, 32, 100_000.0)
    bench.run(4.0)
    since, before = bench.now, bench.last("LOCAL_POSITION_NED")["x"]
    bench.send("SET_GPS_GLOBAL_ORIGIN", target_system=1, latitude=543_710_000, longitude=101_600_000, altitude=0)
    bench.run(6.0)
    jump = bench.last("LOCAL_POSITION_NED")["x"] - before
    assert jump == pytest.approx(-111.3, abs=3.0) if moved else abs(jump) < 0.01
    assert len(bench.said("GPS_GLOBAL_ORIGIN", since)) == int(moved)


def test_an_origin_before_there_is_one_is_taken():
    """A Sub without a position takes an origin, answers twice, and measures from there."""
    bench = Bench("sub").run(1.0)
    bench.send("SET_GPS_GLOBAL_ORIGIN", target_system=1, latitude=543_701_000, longitude=101_600_000, altitude=0)
    bench.run(1.2)
    assert len(bench.said("GPS_GLOBAL_ORIGIN")) == 2
    bench.run(3.0)
    bench.command(512, 32)
    assert bench.last("LOCAL_POSITION_NED")["x"] == pytest.approx(-11.1, abs=0.5)


def fixes(bench, offset_m=0.0):
    latitude, longitude = START.globe(bench.truth.north_m + offset_m, bench.truth.east_m)
    bench.send("GPS_INPUT", fix_type=3, lat=round(latitude * 1e7), lon=round(longitude * 1e7))


def test_fixes_fed_in_give_a_position():
    """A Sub told to take GPS_INPUT has no position without it, and one 21.9 s of boot time after fixes have begun."""
    bench = Bench("sub", ready_s=4.0, parameters={"GPS1_TYPE": 14}).run(10.0)
    assert bench.mode("GUIDED") == 4
    bench.run(12.0, 0.2, lambda: fixes(bench))
    assert not bench.pilot.brain.estimator.aiding
    bench.run(13.0, 0.2, lambda: fixes(bench))
    assert bench.pilot.brain.estimator.aiding
    assert bench.mode("GUIDED") == 0


def test_a_jump_in_fed_fixes_is_smoothed_and_their_end_is_a_loss():
    """A single fix 3.3 m off moves the position half a metre; 14 s after the last fix aiding stops."""
    bench = Bench("sub", ready_s=4.0, parameters={"GPS1_TYPE": 14}).run(1.0)
    bench.run(8.0, 0.2, lambda: fixes(bench))
    fixes(bench, 3.3)
    bench.run(8.1)
    moved = bench.pilot.brain.estimator.belief.north_m - bench.truth.north_m
    assert moved == pytest.approx(0.5, abs=0.1)
    bench.run(21.0)
    assert bench.pilot.brain.estimator.aiding
    bench.run(23.0)
    assert not bench.pilot.brain.estimator.aiding


def test_fixes_are_ignored_by_default():
    """Without GPS1_TYPE = 14 a GPS_INPUT changes nothing."""
    bench = Bench("sub").run(3.0)
    fixes(bench, 50.0)
    bench.run(4.0)
    assert bench.pilot.brain.estimator.belief.north_m == pytest.approx(bench.truth.north_m, abs=0.01)


def test_an_external_estimate_needs_no_altitude():
    """EXTERNAL_POSITION_ESTIMATE with an altitude is DENIED, with NaN taken while aiding, as a COMMAND_INT only."""
    bench = Bench("sub").run(3.0)
    there = {"x": 543_700_000, "y": 101_600_000}
    assert bench.command(43003, name="COMMAND_INT", **there, z=0.0) == 2
    assert bench.command(43003, name="COMMAND_INT", **there, z=math.nan) == 0
    assert bench.command(43003) == 3
    blind = Bench("sub", ready_s=None).run(3.0)
    assert blind.command(43003, name="COMMAND_INT", **there, z=math.nan) == 4


def sees(**parameters):
    """A Sub that is told its place by vision: before it has an origin, and after."""
    bench = Bench("sub", ready_s=4.0, wind_ned_mps=(0.0, 0.0), parameters=parameters).run(1.0)

    def go_on(until, **changes):
        there = {"usec": 0, "x": 3.0, "y": -2.0, "z": 0.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0} | changes
        bench.run(until, 0.2, lambda: bench.send("VISION_POSITION_ESTIMATE", **there))
        return bench

    return go_on


def set_origin(bench):
    bench.send("SET_GPS_GLOBAL_ORIGIN", target_system=1, latitude=543_700_000, longitude=101_600_000, altitude=0)


def test_vision_gives_a_position():
    """With VISO_TYPE, EK3_SRC1_POSXY = 6 and an origin that somebody set, VISION_POSITION_ESTIMATE makes a position."""
    go_on = sees(EK3_SRC1_POSXY=6, VISO_TYPE=1)
    bench = go_on(5.0)
    assert not bench.pilot.brain.estimator.aiding, "no origin yet"
    set_origin(bench)
    go_on(9.0)
    assert bench.pilot.brain.estimator.aiding
    assert bench.pilot.brain.estimator.belief.north_m == pytest.approx(3.0, abs=0.01)
    assert bench.pilot.brain.estimator.belief.east_m == pytest.approx(-2.0, abs=0.01)


def test_vision_needs_its_driver():
    """With VISO_TYPE = 0 nobody in an ArduPilot listens to vision, whatever its estimator is told to use."""
    go_on = sees(EK3_SRC1_POSXY=6)
    set_origin(go_on(1.2))
    assert not go_on(9.0).pilot.brain.estimator.aiding


@pytest.mark.parametrize(
    ("first", "angle", "aiding"), [(0.2, 0.04, True), (0.2, math.nan, False), (math.nan,) * 2 + (True,)]
)
def test_an_ardupilot_adds_up_the_variances(first, angle, aiding):
    """A NaN among the variances spoils the estimate, unless the first one says that none is known."""
    go_on = sees(EK3_SRC1_POSXY=6, VISO_TYPE=1)
    set_origin(go_on(1.2))
    covariance = [math.nan] * 21
    for k in (0, 6, 11):
        covariance[k] = first
    for k in (15, 18, 20):
        covariance[k] = angle
    assert go_on(9.0, covariance=covariance).pilot.brain.estimator.aiding is aiding


@pytest.mark.parametrize(("ahead_s", "aiding"), [(0.0, True), (1_800_000_000.0, False)])
def test_a_px4_that_has_learned_our_clock_takes_no_other(ahead_s, aiding):
    """After 50 s of TIMESYNC a PX4 places vision by its stamp: one of another clock is not taken any more."""
    bench = Bench("px4", wind_ned_mps=(0.0, 0.0), parameters={"EKF2_EV_CTRL": 1}).run(3.0)
    bench.send("SET_GPS_GLOBAL_ORIGIN", target_system=1, latitude=543_700_000, longitude=101_600_000, altitude=0)

    def ours_s():
        return 7000.0 + bench.now

    def see():
        bench.send("TIMESYNC", tc1=round(ours_s() * 1e9), ts1=round((bench.now - 0.0004) * 1e9))
        bench.send("VISION_POSITION_ESTIMATE", usec=round((ours_s() + ahead_s) * 1e6), x=3.0, y=-2.0)

    bench.run(40.0, 0.1, see)
    assert bench.pilot.brain.estimator.aiding, "before that it goes by the arrival"
    bench.run(75.0, 0.1, see)
    assert bench.pilot.brain.estimator.aiding is aiding


@pytest.mark.parametrize(("action", "mode", "says"), [(0, 15, False), (2, 15, True)])
def test_the_position_failsafe_can_be_turned_off(action, mode, says):
    """FS_EKF_ACTION 0 does nothing, 2 only says so."""
    bench = Bench(parameters={"FS_EKF_ACTION": action}).guided().drive(5.0, 1.0, 0.0)
    bench.set_parameter("SIM_GPS_DISABLE", 1)
    bench.drive(12.0, 1.0, 0.0)
    assert bench.shown == mode
    assert ("EKF failsafe" in bench.texts()) is says
