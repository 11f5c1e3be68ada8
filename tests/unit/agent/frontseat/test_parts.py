"""The parts of the adapter: clock, boot watch, codec, feeding."""

import math

import pytest
from mavlink_bench import DATUM, MavlinkBench, of

from grex_agent.frontseat.bootwatch import BootWatch
from grex_agent.frontseat.dialect import Codec, mavlink
from grex_agent.frontseat.echoes import Echoes
from grex_agent.frontseat.feeding import Feeder
from grex_agent.frontseat.timekeeping import Timekeeper
from grex_agent.frontseat.timesync import BootClock, older
from grex_agent.frontseat.trim import SpeedTrim
from grex_link.messages import Fix
from grex_link.units import NS


def test_the_shortest_round_trip_counts():
    """Among answers that were delayed by up to 200 ms the quickest tells the offset, to half of its own 22 ms."""
    clock = BootClock()
    for k, delay in enumerate([0.2, 0.1, 0.022, 0.15, 0.18]):
        sent = 10.0 + k
        # All of the delay is on the way there: the worst case.
        clock.on_exchange(sent, sent + delay, sent + delay - 4.0)
    assert clock.round_trip_s == pytest.approx(0.022)
    assert clock.ours_s(20.0) == pytest.approx(24.0, abs=0.0111)


@pytest.mark.parametrize("rate", [0.99, 1.0, 4.8, 16.2])
def test_the_rate_is_measured(rate: float):
    """However fast the autopilot's clock runs, its rate is known to half a per cent after twenty seconds."""
    clock = BootClock(1.0)
    for k in range(400):
        late = 0.03 * (k % 7) / 7
        clock.on_boot_time(100.0 + 0.05 * k + late, rate * 0.05 * k)
    assert clock.rate == pytest.approx(rate, rel=0.005)
    assert clock.theirs_s(120.0) == pytest.approx(rate * 20.0, abs=0.1 * rate)


def test_busy_is_not_old():
    """At twenty times real time a delay of 0.2 s is that of the machine; at real time the limit is the limit."""
    assert not older(0.2, 20.0, 1.5)
    assert older(0.4, 20.0, 1.5)
    assert older(1.6, 1.0, 1.5)
    assert not older(1.4, 1.0, 1.5)


def test_a_late_datagram_is_no_reboot():
    """One message that was overtaken by others changes nothing."""
    watch = BootWatch()
    assert [watch.see("A", t, 10.0 + t, 1.0) for t in (1.0, 1.2, 1.1, 1.3, 1.4)] == [None] * 5
    assert not watch.doubtful


def test_a_stall_is_no_reboot():
    """Messages that have waited while we were busy come all at once, and are no jump or reboot."""
    watch = BootWatch()
    watch.see("A", 1.0, 11.0, 1.0)
    assert [watch.see("A", 1.0 + 0.2 * k, 16.0 + 0.001 * k, 1.0) for k in range(25)] == [None] * 25


def test_a_reboot_is_found_once():
    """A clock that begins anew is found within a second, and once."""
    watch = BootWatch()
    found = [watch.see("A", 100.0 + 0.2 * k, 0.2 * k, 1.0) for k in range(20)]
    found += [watch.see("A", 0.2 * k, 10.0 + 0.2 * k, 1.0) for k in range(20)]
    assert [finding for finding in found if finding] == ["reboot"]
    assert found.index("reboot") <= 26


@pytest.mark.parametrize("apart", [0.1, 30.0, -0.1])
def test_two_clocks_are_found(apart: float):
    """Two autopilots that speak in turn are found, even if they were started together."""
    watch = BootWatch()
    found = []
    for k in range(20):
        found.append(watch.see("A", 50.0 + 0.2 * k, 0.2 * k, 1.0))
        found.append(watch.see("A", 50.0 + 0.2 * k - apart - (0.2 if apart < 0 else 0.0), 0.2 * k + 0.05, 1.0))
    assert "duplicate" in found
    assert found.index("duplicate") < 15


def test_two_clocks_that_agree_are_found():
    """Two autopilots that were started in the same moment are found, and are not seen in values that have names."""
    watch = BootWatch()
    named = [watch.see("NAMED_VALUE_FLOAT", 50.0 + 0.2 * (k // 4), 0.2 * (k // 4), 1.0) for k in range(80)]
    assert not any(named)
    found = [watch.see("ATTITUDE", 54.0 + 0.2 * (k // 2), 4.0 + 0.2 * (k // 2), 1.0) for k in range(20)]
    assert "duplicate" in found


def test_bytes_there_and_back():
    """A message survives the wire between garbage, in pieces, and of two peers at once."""
    ours, theirs = Codec(255, 191), Codec(1, 1)
    heartbeat = theirs.encode(mavlink.MAVLink_heartbeat_message(11, 3, 0, 15, 4, 3))
    text = theirs.encode(mavlink.MAVLink_statustext_message(6, b"hello"))
    assert [message.get_type() for message in ours.decode(b"boot: ok\r\n" + heartbeat, "a")] == ["HEARTBEAT"]
    assert ours.garbage > 0
    assert ours.decode(text[:9], "a") == []
    assert [message.get_type() for message in ours.decode(heartbeat, "b")] == ["HEARTBEAT"]
    assert [message.text for message in ours.decode(text[9:], "a")] == ["hello"]


def test_garbage_costs_no_message():
    """Bytes that look like the beginning of a long message cost none of those that come after them."""
    ours, theirs = Codec(255, 191), Codec(1, 1)
    sent = [theirs.encode(mavlink.MAVLink_timesync_message(0, k)) for k in range(40)]
    heard = []
    for number, data in enumerate(sent):
        heard += ours.decode(bytes([0xFD, 200, 0, 0, 7, 7]) if number % 4 == 0 else b"")
        heard += ours.decode(data)
    heard += ours.decode(b"\0" * 300)
    assert [message.ts1 for message in heard] == list(range(40))


def test_messages_are_numbered():
    """Every message has the next number, and the ids of its sender."""
    codec, reader = Codec(200, 7), Codec(1, 1)
    heard = [reader.decode(codec.encode(mavlink.MAVLink_timesync_message(0, k)))[0] for k in range(3)]
    assert [message.get_seq() for message in heard] == [0, 1, 2]
    assert {(message.get_srcSystem(), message.get_srcComponent()) for message in heard} == {(200, 7)}


@pytest.mark.parametrize(("key", "heard"), [(b"k" * 32, True), (b"x" * 32, False), (None, False)])
def test_signing(key, heard):
    """With a key only what is signed with it is heard; the rest is garbage."""
    ours = Codec(255, 191, b"k" * 32, 1_800_000_000 * NS)
    theirs = Codec(1, 1, key, 1_800_000_000 * NS)
    data = theirs.encode(mavlink.MAVLink_heartbeat_message(11, 3, 0, 15, 4, 3))
    assert bool(ours.decode(data)) == heard
    assert bool(ours.garbage) != heard
    signed = 0x01
    assert ours.encode(mavlink.MAVLink_timesync_message(1, 1))[2] & signed


def fix(**changes) -> Fix:
    values = {"north_m": 30.0, "east_m": -40.0, "down_m": 5.0, "heading_rad": 0.0, "speed_mps": 1.0, "sigma_m": 0.5}
    return Fix(0, 0, **(values | changes))


def test_gps_input():
    """A fed fix is a GPS_INPUT: place in degrees, velocity, accuracy, and the GPS week of the wall clock."""
    feeder = Feeder("gps_input", DATUM, 1_800_000_000 * NS)
    for at_s in (6.0, 8.0, 10.0):
        feeder.on_fix(fix(north_m=20.0 + at_s), at_s, 1.0)
    message = feeder.due(11.0, 1.0)
    assert message.lat / 1e7 == pytest.approx(54.37 + 31.0 / 111_330.0, abs=1e-6)
    assert message.horiz_accuracy == pytest.approx(0.5)
    assert message.fix_type == 3
    assert (message.vn, message.ve) == pytest.approx((1.0, 0.0))
    assert not message.ignore_flags & mavlink.GPS_INPUT_IGNORE_FLAG_VEL_HORIZ
    seconds = message.time_week * 604_800 + message.time_week_ms / 1000
    assert seconds == pytest.approx(1_800_000_011 - 315_964_800 + 18)
    assert feeder.due(15.0, 1.0) is None


def test_what_is_not_valid_is_not_fed():
    """A position that is not valid, or no number, ends the feeding: the autopilot must know that there is none."""
    feeder = Feeder("gps_input", DATUM, 0)
    for bad in (fix(valid=False), fix(north_m=math.nan)):
        for at_s in (1.0, 3.0):
            feeder.on_fix(fix(), at_s, 1.0)
        assert feeder.due(3.1, 1.0) is not None
        feeder.on_fix(bad, 3.1, 1.0)
        assert feeder.due(3.2, 1.0) is None


def carried(seconds: float, rate: float = 1.0, heading=lambda _: 0.0, current=(0.0, 0.5)):
    """A feeder that has been told, twice a second, of a craft that makes 1 m/s through water that moves."""
    feeder, north, east = Feeder("gps_input", DATUM, 0), 0.0, 0.0
    for k in range(round(2.0 * seconds) + 1):
        heading_rad = heading(k / 2.0)
        feeder.on_fix(fix(north_m=north, east_m=east, heading_rad=heading_rad), 5.0 + k / 2.0 / rate, rate)
        north += 0.5 * (math.cos(heading_rad) + current[0])
        east += 0.5 * (math.sin(heading_rad) + current[1])
    return feeder


@pytest.mark.parametrize("rate", [1.0, 5.0])
def test_a_fed_velocity_is_that_over_ground(rate):
    """What carries a craft sideways is in GPS_INPUT: an autopilot believes its GPS's velocity."""
    feeder = carried(10.0, rate)
    message = feeder.due(5.0 + 10.0 / rate, rate)
    assert (message.vn, message.ve) == pytest.approx((1.0, 0.5), abs=1e-6)
    later = feeder.due(5.0 + 12.0 / rate, rate)
    assert (later.lon - message.lon) / 1e7 * 111_330.0 * math.cos(math.radians(54.37)) == pytest.approx(1.0, abs=0.05)


def test_a_fed_velocity_turns_with_the_craft():
    """In a turn of 9 degrees a second the velocity fed is that of the moment, not the mean of the last ten seconds."""
    message = carried(20.0, heading=lambda at_s: math.pi / 20.0 * at_s).due(25.0, 1.0)
    assert (message.vn, message.ve) == pytest.approx((-1.0, 0.5), abs=0.15)


def test_a_fed_velocity_is_as_good_as_the_positions():
    """The accuracy claimed of the velocity is that of the two positions over their time; a GPS without it is none."""
    assert carried(1.5).due(6.5, 1.0) is None
    assert carried(2.0).due(7.0, 1.0).speed_accuracy == pytest.approx(math.hypot(0.5 / 2, 0.5 / 2, 0.1), abs=1e-6)
    assert carried(60.0).due(65.0, 1.0).speed_accuracy == pytest.approx(math.hypot(0.05, 0.05, 0.1), abs=0.002)


def test_a_gap_in_the_positions_is_no_velocity():
    """After more than four seconds without positions the velocity is learned anew."""
    feeder = carried(10.0)
    feeder.on_fix(fix(), 20.0, 1.0)
    assert feeder.due(20.1, 1.0) is None


def test_vision_is_told_in_the_autopilots_own_frame():
    """Vision is about the autopilot's origin: it is asked for, given if there is none, and taken into account."""
    bench = MavlinkBench("sub", feed="vision").run(3.0)
    bench.answers[512] = 4
    bench.run(2.0)
    given = bench.said("SET_GPS_GLOBAL_ORIGIN")[0]
    assert (given.latitude, given.longitude) == (543_700_000, 101_600_000)
    bench.take(bench.core.on_navigation(fix(), bench.now_ns))
    bench.run(1.0)
    assert not bench.said("VISION_POSITION_ESTIMATE")
    bench.hear(mavlink.MAVLink_gps_global_origin_message(543_700_000 + 1000, 101_600_000, 0))
    bench.take(bench.core.on_navigation(fix(speed_mps=0.0), bench.now_ns))
    bench.run(1.0)
    told = bench.said("VISION_POSITION_ESTIMATE")
    assert 4 <= len(told) <= 6
    assert (told[-1].x, told[-1].y, told[-1].z) == pytest.approx((30.0 - 11.13, -40.0, 5.0), abs=0.05)


def seen(now_s: float, **changes):
    """What vision is told at a time."""
    feeder = Feeder("vision", DATUM, 1_800_000_000 * NS)
    feeder.on_origin(mavlink.MAVLink_gps_global_origin_message(543_700_000, 101_600_000, 0))
    feeder.on_fix(fix(**changes), now_s, 1.0)
    return feeder.due(now_s, 1.0)


def test_vision_is_stamped_with_the_clock_that_answers_timesync():
    """A PX4 that has learned our clock from TIMESYNC can place a position: it is not stamped with the date."""
    assert seen(11.0).usec == 11_000_000
    answer = Timekeeper(1.0).on_timesync(mavlink.MAVLink_timesync_message(0, 1), 11.0)[0]
    assert seen(11.0).usec == answer.tc1 // 1000


def test_vision_tells_every_variance():
    """Each of the six variances is a number: an ArduPilot adds them up, and NaN is an internal error there."""
    covariance = seen(11.0, sigma_m=0.5).covariance
    assert [covariance[k] for k in (0, 6, 11)] == [0.25] * 3
    assert [covariance[k] for k in (15, 18, 20)] == pytest.approx([0.04] * 3)


def test_of_gives_a_sender():
    """The bench's own messages have the ids they are given."""
    assert of(mavlink.MAVLink_timesync_message(0, 1), 9, 8).get_srcSystem() == 9


def test_a_message_that_comes_twice():
    """A link that brings every message twice, the second time late, is one autopilot and nothing else."""
    bench = MavlinkBench(arm=True).steering()
    kept = []
    for number in range(40):
        bench.run(0.1)
        kept.append(of(mavlink.MAVLink_attitude_message(bench.boot_ms, 0, 0, 0, 0, 0, 0), number=200 + number))
        for message in (kept[-1], kept[max(0, len(kept) - 4)]):
            bench.take(bench.core.on_message(message, bench.now_ns))
    assert not bench.core.peer.muted
    assert bench.phase == "steering"


def trimmed(made: float, wanted: float = 1.0, seconds: float = 120.0, course_rad: float = 0.0) -> tuple[float, float]:
    """Run a trim on a craft that makes good a share of what it is asked for; return what is asked for and made."""
    trim, asked, speed = SpeedTrim(), wanted, 0.0
    for k in range(round(seconds * 5)):
        speed += 0.2 / 3.0 * (made * asked - speed)
        asked = trim.asked_mps(wanted, course_rad, (speed, 0.0), 0.2 * k)
    return asked, speed


@pytest.mark.parametrize("made", [0.8, 1.0, 1.25])
def test_trim(made: float):
    """A craft that makes 80 % or 125 % of what it is asked for makes what the agent wants after two minutes."""
    assert trimmed(made)[1] == pytest.approx(1.0, abs=0.02)


def test_trim_has_limits():
    """A craft that cannot go faster is not asked for more and more, and a wrong course teaches nothing."""
    assert trimmed(0.1)[0] == pytest.approx(1.4)
    assert trimmed(0.8, course_rad=1.0)[0] == 1.0
    assert SpeedTrim().asked_mps(0.0, 0.0, (1.0, 0.0), 100.0) == 0.0


def test_trim_does_not_learn_from_speeding_up():
    """The seconds in which a craft speeds up do not count."""
    assert trimmed(1.0, seconds=5.0)[0] == 1.0


@pytest.mark.parametrize("numbers", [1, 256])
def test_the_same_again_is_no_echo(numbers: int):
    """A message without a time whose content never changes counts each time, even if messages are badly numbered."""
    bench = MavlinkBench().run(2.0)
    bench.says.discard("estimator")
    for k in range(20):
        bench.run(0.2)
        message = of(mavlink.MAVLink_ekf_status_report_message(0x33F, 0, 0, 0, 0, 0), number=k % numbers)
        bench.take(bench.core.on_message(message, bench.now_ns))
    assert bench.estimate.valid


def test_echoes():
    """A message is an echo when it has been heard among the last hundred; after 256 its number is another one's."""
    echoes = Echoes()
    for number in range(1000):
        message = of(mavlink.MAVLink_attitude_message(5, 0, 0, 0, 0, 0, 0), number=number)
        assert not echoes.is_one(message)
        assert echoes.is_one(message)
