"""Behaviour 8: nothing is streamed that was not asked for, asking has limits, and a reboot forgets it."""

import pytest
from autopilots import ARM, REBOOT, REQUEST, SET_INTERVAL, Bench

from grex_sim.autopilot.streams import Streams

LOCAL, ATTITUDE, GLOBAL = 32, 30, 33


def rate(bench, name: str, seconds: float = 4.0) -> float:
    since = bench.now
    bench.run(since + seconds, 0.02)
    return len(bench.said(name, since)) / seconds


@pytest.mark.parametrize(
    ("family", "name", "hz"),
    [
        ("rover", "GLOBAL_POSITION_INT", 1.0),
        ("rover", "LOCAL_POSITION_NED", 0.0),
        ("sub", "ATTITUDE", 10.0),
        ("sub", "GLOBAL_POSITION_INT", 3.0),
        ("sub", "NAMED_VALUE_FLOAT", 17.0),
        ("sub", "LOCAL_POSITION_NED", 0.0),
        ("px4", "LOCAL_POSITION_NED", 30.0),
        ("px4", "TIMESYNC", 10.0),
    ],
)
def test_default_rates(family, name, hz):
    """Each family's default rates are those of a real one."""
    assert rate(Bench(family).run(3.0), name) == pytest.approx(hz, rel=0.1, abs=0.01)


def test_an_interval_is_kept():
    """LOCAL_POSITION_NED asked for at 10 Hz comes at 10 Hz, and -1 stops it."""
    bench = Bench().run(3.0)
    assert bench.command(SET_INTERVAL, LOCAL, 100_000.0) == 0
    assert rate(bench, "LOCAL_POSITION_NED") == pytest.approx(10.0, abs=0.3)
    assert bench.command(SET_INTERVAL, LOCAL, -1.0) == 0
    assert rate(bench, "LOCAL_POSITION_NED") == 0.0


@pytest.mark.parametrize(("family", "hz", "result"), [("rover", 40, 0), ("rover", 50, 2), ("sub", 50, 0)])
def test_rates_have_a_limit(family, hz, result):
    """A Rover gives 40 Hz and denies 50; a Sub gives 50."""
    assert Bench(family).run(3.0).command(SET_INTERVAL, ATTITUDE, 1e6 / hz) == result


@pytest.mark.parametrize(("family", "interval", "once"), [("rover", 2, 4), ("sub", 2, 4), ("px4", 4, 4)])
def test_unknown_messages(family, interval, once):
    """The interval of a message nobody knows is DENIED (PX4: FAILED); asking for it once is FAILED."""
    bench = Bench(family).run(3.0)
    assert bench.command(SET_INTERVAL, 11999, 1e5) == interval
    assert bench.command(REQUEST, 11999) == once


def test_the_local_position_is_silent_without_an_origin():
    """Asked for before there is an origin it does not come; it starts with it."""
    bench = Bench(ready_s=None).run(5.0)
    assert bench.command(SET_INTERVAL, LOCAL, 100_000.0) == 0
    assert not bench.run(41.9).said("LOCAL_POSITION_NED")
    assert bench.run(42.5).said("LOCAL_POSITION_NED")


def test_a_reboot_forgets_intervals():
    """After a reboot the time since boot begins anew, intervals are the default ones, the mode MANUAL, disarmed."""
    bench = Bench().run(3.0)
    bench.command(SET_INTERVAL, LOCAL, 100_000.0)
    bench.mode("GUIDED")
    bench.run(5.0)
    assert bench.command(REBOOT, 1) == 0
    since = bench.now
    bench.run(10.0)
    assert bench.said("LOCAL_POSITION_NED", since + 0.3) == []
    assert bench.last("GLOBAL_POSITION_INT")["time_boot_ms"] < 5000
    assert (bench.shown, bench.armed) == (0, False)


def test_an_armed_craft_does_not_reboot():
    """A reboot is FAILED while armed."""
    bench = Bench().guided()
    assert bench.command(REBOOT, 1) == 4
    boot_ms = bench.last("SYSTEM_TIME")["time_boot_ms"]
    assert bench.run(bench.now + 3.0).last("SYSTEM_TIME")["time_boot_ms"] > boot_ms


def test_a_reboot_keeps_parameters():
    """A parameter that was set is still set after a reboot."""
    bench = Bench().run(3.0)
    bench.set_parameter("WP_SPEED", 1.5)
    bench.command(REBOOT, 1)
    bench.run(8.0)
    bench.send("PARAM_REQUEST_READ", target_system=1, param_id="WP_SPEED", param_index=-1)
    assert bench.run(8.2).last("PARAM_VALUE")["param_value"] == 1.5


def test_each_ground_station_has_its_own_intervals():
    """What one link asks for does not come on the other; a mode change is seen on both."""
    bench = Bench(links=2).run(3.0)
    bench.command(SET_INTERVAL, LOCAL, 100_000.0, link=1)
    bench.mode("HOLD")
    bench.run(6.0)
    links = {link for _, link, m in bench.heard if getattr(m, "name", "") == "LOCAL_POSITION_NED"}
    assert links == {1}
    shown = {link: m["custom_mode"] for _, link, m in bench.heard if getattr(m, "name", "") == "HEARTBEAT"}
    assert shown == {0: 4, 1: 4}
    acks = [link for _, link, m in bench.heard if getattr(m, "name", "") == "COMMAND_ACK"]
    assert acks == [1, 0]


def test_old_style_streams():
    """REQUEST_DATA_STREAM of position at 4 Hz brings both positions at 4 Hz, and stops them again."""
    bench = Bench().run(3.0)
    ask = {"target_system": 1, "target_component": 1, "req_stream_id": 6, "req_message_rate": 4}
    bench.send("REQUEST_DATA_STREAM", start_stop=1, **ask)
    assert rate(bench, "LOCAL_POSITION_NED") == pytest.approx(4.0, abs=0.3)
    bench.send("REQUEST_DATA_STREAM", start_stop=0, **ask)
    assert rate(bench, "GLOBAL_POSITION_INT") == 0.0


def test_intervals_can_be_read():
    """GET_MESSAGE_INTERVAL answers with the interval, -1 for what is not sent, 0 for what nobody knows."""
    bench = Bench().run(3.0)
    for number, interval in ((GLOBAL, 1_000_000), (LOCAL, -1), (11999, 0)):
        assert bench.command(510, number) == 0
        assert bench.last("MESSAGE_INTERVAL")["interval_us"] == interval


def test_who_was_away_gets_no_flood():
    """After ten seconds in which nothing was taken one message is due, not a hundred."""
    streams = Streams({"ATTITUDE": 10.0}, None, 0.0)
    assert streams.due(0.0) == ["ATTITUDE"]
    assert streams.due(10.0) == ["ATTITUDE"]
    assert streams.due(10.01) == []
    assert streams.due(10.1) == ["ATTITUDE"]


def test_arming_is_on_the_bench_too():
    """A stream goes on at its rate while the craft is armed."""
    bench = Bench().run(3.0)
    bench.command(SET_INTERVAL, ATTITUDE, 50_000.0)
    assert bench.command(ARM, 1) == 0
    assert rate(bench, "ATTITUDE") == pytest.approx(20.0, abs=0.5)


def test_odd_intervals():
    """0 brings the default back, or ends what has none; no number is DENIED."""
    bench = Bench().run(3.0)
    bench.command(SET_INTERVAL, GLOBAL, 100_000.0)
    assert bench.command(SET_INTERVAL, GLOBAL, 0.0) == 0
    assert rate(bench, "GLOBAL_POSITION_INT") == pytest.approx(1.0, abs=0.3)
    bench.command(SET_INTERVAL, LOCAL, 100_000.0)
    assert bench.command(SET_INTERVAL, LOCAL, 0.0) == 0
    assert rate(bench, "LOCAL_POSITION_NED") == 0.0
    assert bench.command(SET_INTERVAL, LOCAL, float("nan")) == 2
