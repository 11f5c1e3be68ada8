"""When an autopilot's position may be believed: the ways in which real ones have lied."""

import math

import pytest
from mavlink_bench import ARM, DATUM, SET_MODE, MavlinkBench, setpoint

from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.geodesy import distance_m, say_distance, to_degrees, to_mission


@pytest.fixture
def bench() -> MavlinkBench:
    bench = MavlinkBench().run(3.0)
    assert bench.estimate.valid
    return bench


def test_the_mission_frame():
    """Metres north and east of the datum, whatever the autopilot's own origin is; there and back is exact."""
    assert to_mission(DATUM, DATUM.latitude_deg, DATUM.longitude_deg) == pytest.approx((0.0, 0.0), abs=1e-6)
    north, east = to_mission(DATUM, DATUM.latitude_deg + 0.01, DATUM.longitude_deg)
    assert (north, east) == pytest.approx((1113.3, 0.0), abs=0.5)
    assert to_mission(DATUM, *to_degrees(DATUM, 321.0, -654.0)) == pytest.approx((321.0, -654.0), abs=0.01)


def test_the_own_origin_does_not_matter(bench):
    """LOCAL_POSITION_NED says 500, 500 here: the position is that of latitude and longitude all the same."""
    bench.lat, bench.lon = to_degrees(DATUM, 30.0, -40.0)
    bench.heading = 0.7
    bench.run(0.5)
    found = bench.estimate
    assert (found.north_m, found.east_m) == pytest.approx((30.0, -40.0), abs=0.05)
    assert found.heading_rad == pytest.approx(0.7)


def test_it_is_carried_to_the_time_asked_for(bench):
    """A position that was measured a moment ago is carried on by its velocity."""
    bench.velocity = 2.0, -1.0
    bench.run(0.4)
    later = bench.core.estimate(bench.now_ns + 200_000_000, bench.now_ns)
    now = bench.estimate
    assert later.north_m - now.north_m == pytest.approx(0.4, abs=1e-3)
    assert later.east_m - now.east_m == pytest.approx(-0.2, abs=1e-3)
    assert now.speed_mps == pytest.approx(math.hypot(2.0, 1.0), abs=0.01)


def test_frozen_or_phantom_motion(bench):
    """Dead reckoning that runs on without LOCAL_POSITION_NED, at full rate and with good flags, is not believed."""
    bench.says.discard("local")
    bench.run(1.0)
    assert bench.estimate.valid
    bench.run(1.0)
    assert not bench.estimate.valid
    assert "LOCAL_POSITION_NED has been silent" in bench.estimate.reason
    assert [words for words in bench.warnings if words.startswith("no valid position")]


@pytest.mark.parametrize(
    ("flags", "reason"),
    [(0x0A7, "no position (flags 0x0a7)"), (0x0AF, "no position"), (0x3BF, "only holds its position (flags 0x3bf)")],
)
def test_flags(bench, flags: int, reason: str):
    """Without an absolute position, or in constant-position mode, the estimator's flags win over everything else."""
    bench.flags = flags
    bench.run(0.6)
    assert not bench.estimate.valid
    assert reason in bench.estimate.reason


def test_gps_is_faster_than_flags(bench):
    """A lost GPS fix counts while the flags are still good."""
    bench.fix_type = 1
    bench.run(0.6)
    assert bench.estimate.reason == "its GPS has no fix (type 1)"


def test_nowhere(bench):
    """Latitude 0, longitude 0 is no place."""
    bench.lat = bench.lon = 0.0
    bench.run(0.5)
    assert not bench.estimate.valid
    assert "latitude 0, longitude 0" in bench.estimate.reason


@pytest.mark.parametrize(
    ("missing", "reason"), [("estimator", "estimator says nothing"), ("gps", "GPS says nothing"), ("global", "s old")]
)
def test_what_does_not_come(bench, missing: str, reason: str):
    """What has to come and does not makes the position invalid, and the reason says what it is."""
    bench.says.discard(missing)
    bench.run(6.0)
    assert not bench.estimate.valid
    assert reason in bench.estimate.reason


def test_sigma(bench):
    """The accuracy that the GPS claims, 0.5 m over both axes, is the sigma of each."""
    assert bench.estimate.sigma_m == pytest.approx(0.5 / math.sqrt(2.0))
    px4 = MavlinkBench("px4").run(3.0)
    assert px4.estimate.sigma_m == pytest.approx(0.7 / math.sqrt(2.0), rel=1e-5)


def test_vision_needs_no_gps():
    """A craft that is told its position needs no GPS of its own."""
    for feed, valid in (("vision", True), ("none", False)):
        bench = MavlinkBench("sub", feed=feed)
        bench.fix_type = 0
        assert bench.run(3.0).estimate.valid == valid


HOME_OF_SITL = -35.363261, 149.165230
WRONG_DATUM = "the autopilot is 16200 km from the datum; set [datum] to where the mission is"


def test_a_wrong_datum():
    """Far from the datum nothing is valid: no mode, no arming, no steering by a person's leave; what to do is said."""
    for arm in (True, False):
        bench = MavlinkBench(arm=arm)
        bench.lat, bench.lon = HOME_OF_SITL
        good, bench.flags = bench.flags, 0xA7
        bench.run(2.0)
        bench.flags = good
        bench.run(5.0)
        bench.text("EKF3 IMU0 is using GPS")
        assert (bench.estimate.valid, bench.estimate.reason) == (False, WRONG_DATUM)
        assert bench.core.waits_for(bench.now_ns) == f"no valid position: {WRONG_DATUM}"
        assert not [c for c in bench.said("COMMAND_LONG") if c.command in {ARM, SET_MODE}]
        assert bench.warnings.count(f"no valid position: {WRONG_DATUM}") == 1
        bench.mode, bench.armed = 15, True
        bench.start(setpoint())
        assert not bench.setpoints(5.0)


def test_how_far_from_the_datum():
    """Up to 20 km from the datum a position counts; without a datum it counts anywhere on earth."""
    for north_m, valid in ((19_900.0, True), (20_200.0, False)):
        bench = MavlinkBench()
        bench.lat, bench.lon = to_degrees(DATUM, north_m, 0.0)
        assert bench.run(3.0).estimate.valid == valid
    bench = MavlinkBench()
    bench.core = FrontseatCore(bench.config, None)
    bench.lat, bench.lon = HOME_OF_SITL
    assert bench.run(3.0).estimate.valid
    assert bench.core.peer.navigation.place == pytest.approx(HOME_OF_SITL)


def test_the_other_side_of_the_earth():
    """The distance to the datum is that along the earth, also where the plane of the mission frame says little."""
    antipode = -DATUM.latitude_deg, DATUM.longitude_deg - 180.0
    assert math.hypot(*to_mission(DATUM, *antipode)) < 50_000.0
    assert say_distance(distance_m(DATUM, *antipode)) == "20000 km"
    assert say_distance(distance_m(DATUM, *to_degrees(DATUM, 30.0, -40.0))) == "50 m"


def test_before_anything_is_heard():
    """Before an autopilot is heard there is a position of which nothing is true, and a reason."""
    bench = MavlinkBench()
    assert bench.estimate.reason == "no autopilot has been heard"
    missing = "no heartbeat of an autopilot on udpin:127.0.0.1:1; look whether it is on and sends to this address"
    assert bench.core.waits_for(bench.now_ns) == missing
