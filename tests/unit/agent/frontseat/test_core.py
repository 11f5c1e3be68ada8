"""The adapter's core, given literal messages at literal times: whom it speaks to, who has the craft, what it sends."""

import math

import pytest
from mavlink_bench import (
    ARM,
    DENIED,
    FAILED,
    GOOD_FLAGS,
    IN_PROGRESS,
    REQUEST,
    SET_INTERVAL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    MavlinkBench,
    setpoint,
)

from grex_agent.frontseat.dialect import mavlink

FAMILIES = ["rover", "sub", "px4"]


# -- whom it speaks to ------------------------------------------------------------------------------------------------


def test_it_says_whom_it_found():
    """The first line names the family, what the autopilot calls itself, and its system id."""
    bench = MavlinkBench().run(0.1)
    assert bench.words[0] == "found ArduPilot Rover (ardupilotmega, surface boat), system 1"


@pytest.mark.parametrize(("autopilot", "kind"), [(8, 6), (8, 26), (8, 18), (3, 6), (8, 11)])
def test_a_ground_station_is_no_autopilot(autopilot: int, kind: int):
    """It never takes the heartbeat of a ground station, a gimbal or another onboard computer for its autopilot."""
    bench = MavlinkBench()
    bench.says.clear()
    bench.run(0.5)
    bench.heartbeat(system=9, kind=(autopilot, kind))
    assert bench.core.peer is None
    bench.heartbeat(system=2, kind=(3, 11))
    assert bench.core.target_system == 2


def test_it_waits_for_the_system_it_was_told():
    """With a system id in the scenario it waits for that one, and says once whom it hears instead."""
    bench = MavlinkBench(system=7).run(5.0)
    assert bench.core.peer is None
    assert bench.words == ["heard system id 1; waiting for 7"]
    wanted = "no heartbeat of an autopilot with system id 7 on udpin:127.0.0.1:1 (heard system id"
    what_to_do = ": set frontseat.system, or the autopilot's SYSID_THISMAV)"
    assert bench.core.waits_for(bench.now_ns) == f"{wanted} 1{what_to_do}"
    bench.heartbeat(system=12)
    assert bench.core.waits_for(bench.now_ns) == f"{wanted}s 1, 12{what_to_do}"
    bench.heartbeat(system=7)
    assert bench.core.target_system == 7


def test_other_systems_are_not_listened_to():
    """What another vehicle on the same link says does not count."""
    bench = MavlinkBench(arm=True).steering()
    bench.hear(mavlink.MAVLink_heartbeat_message(11, 3, 1, 4, 4, 3), system=2)
    bench.hear(mavlink.MAVLink_global_position_int_message(1, 10, 10, 0, 0, 0, 0, 0, 0), system=2)
    bench.run(0.1)
    assert bench.phase == "steering"
    assert bench.estimate.valid


def test_an_unknown_vehicle_is_refused_in_words():
    """A copter is of no known family, and the line says what could be done."""
    bench = MavlinkBench()
    bench.kind = 3, 2
    bench.run(3.0)
    assert bench.core.peer is None
    assert len(bench.words) == 1
    assert "no known family" in bench.words[0]
    assert bench.words[0] in bench.core.waits_for(bench.now_ns)


def test_a_family_can_be_named():
    """A vehicle that is none of those known is spoken to as the family that the scenario names."""
    bench = MavlinkBench(family="sub")
    bench.kind = 0, 0
    bench.run(0.5)
    assert bench.core.peer is None
    bench = MavlinkBench(family="rover")
    bench.core._config = type(bench.config)(url="udpin:127.0.0.1:1", family="rover")
    bench.kind = 0, 0
    bench.run(0.5)
    assert bench.core.peer.family.name == "rover"


def test_somebody_else_with_our_ids():
    """Another heartbeat with our own ids is a fault that says which; nothing but heartbeats is sent from then on."""
    bench = MavlinkBench(arm=True).steering()
    bench.hear(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), system=255, component=191)
    assert "system 255, component 191" in bench.core.fault
    assert bench.warnings[-1] == bench.core.fault
    assert not bench.setpoints(2.0)
    assert not bench.estimate.valid


# -- streams ----------------------------------------------------------------------------------------------------------


def test_it_asks_for_its_messages():
    """Each message it needs is asked for by its interval, one command after another."""
    bench = MavlinkBench().run(2.0)
    asked = {round(command.param1): command.param2 for command in bench.commands(SET_INTERVAL)}
    assert asked == {33: 200_000, 32: 200_000, 30: 200_000, 193: 500_000, 24: 500_000}


def test_what_comes_too_rarely_is_asked_for_again():
    """A message whose measured rate is off is asked for again, the others are not."""
    bench = MavlinkBench().run(8.0)
    bench.says.discard("local")
    since = bench.now
    bench.run(11.0)
    asked = {round(command.param1) for command in bench.commands(SET_INTERVAL, since)}
    assert asked == {32}


def test_what_is_refused_is_left_alone():
    """A message the autopilot does not have is not asked for again and again."""
    bench = MavlinkBench()
    bench.answers[SET_INTERVAL] = DENIED
    bench.says.discard("local")
    bench.run(20.0)
    assert len([c for c in bench.commands(SET_INTERVAL) if round(c.param1) == 32]) == 1


def test_a_reboot_is_noticed():
    """A clock that begins anew is a reboot: it is said, and every message is asked for again."""
    bench = MavlinkBench().run(8.0)
    since = bench.now
    bench.boot = bench.now
    bench.run(3.0)
    assert bench.warnings[0] == "the autopilot has booted: its message rates are asked for again"
    assert len(bench.commands(SET_INTERVAL, since)) == 5


def test_two_autopilots_with_one_id():
    """Two clocks behind one system id are two vehicles: it is said, and neither gets anything."""
    bench = MavlinkBench(arm=True).steering()
    for _ in range(20):
        bench.run(0.1)
        bench.hear(mavlink.MAVLink_attitude_message(bench.boot_ms - 20_000, 0, 0, 0, 0, 0, 0))
    assert any("two autopilots have system id 1" in words for words in bench.warnings)
    assert not bench.setpoints(2.0)
    assert "two autopilots" in bench.estimate.reason


def test_a_clock_that_jumps():
    """A clock that jumps ahead is measured anew, and positions go on being valid."""
    bench = MavlinkBench().run(5.0)
    bench.boot -= 1000.0
    bench.run(3.0)
    assert bench.warnings == ["the autopilot's clock has jumped: its time is measured anew"]
    assert bench.estimate.valid


# -- arming -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES)
def test_it_takes_the_craft_when_it_may(family: str):
    """With arm = true it sets the mode, then arms, and steers once the heartbeat says so."""
    bench = MavlinkBench(family, arm=True).run(4.0)
    assert bench.phase == "steering"
    assert (bench.mode, bench.armed) == (bench.family.guided, True)
    modes = bench.commands(SET_MODE)
    assert [(c.param1, c.param2, c.param3) for c in modes] == [bench.family.mode_parameters(bench.family.guided)]
    assert bench.core.waits_for(bench.now_ns) == ""


def test_without_leave_it_touches_nothing():
    """With arm = false it never asks for a mode or to arm; it says once that it waits for a person, who then may."""
    bench = MavlinkBench().run(30.0)
    assert not bench.commands(SET_MODE)
    assert not bench.commands(ARM)
    assert bench.words.count("ready: waiting for a person to set GUIDED and to arm") == 1
    assert bench.core.waits_for(bench.now_ns) == ""
    bench.mode, bench.armed = 15, True
    bench.start(setpoint()).run(2.0)
    assert bench.phase == "steering"


def test_it_does_not_arm_without_a_position():
    """Nothing is asked for as long as the position is not valid, and what is missing is said with its reason."""
    bench = MavlinkBench(arm=True)
    bench.flags = 0xA7
    bench.run(10.0)
    assert not bench.commands(SET_MODE)
    assert bench.core.waits_for(bench.now_ns) == "no valid position: its estimator has no position (flags 0x0a7)"


def test_arming_denied():
    """Refused arming is asked for again every second, and each new reason is said once."""
    bench = MavlinkBench(arm=True)
    bench.answers[ARM] = FAILED
    bench.run(1.0)
    for _ in range(4):
        bench.text("Arm: GPS 1: Bad fix", severity=2)
        bench.run(1.0)
    assert 3 <= len(bench.commands(ARM)) <= 6
    refused = [words for words in bench.warnings if "refuses" in words and "Bad fix" in words]
    assert refused == ["the autopilot refuses: arm FAILED (Arm: GPS 1: Bad fix); it is asked again"]
    assert "Bad fix" in bench.core.waits_for(bench.now_ns)
    bench.answers[ARM] = 0
    bench.run(2.5)
    assert bench.phase == "steering"


def test_rejected_without_a_word():
    """PX4 gives no reason for a rejection, and the log says that it does not."""
    bench = MavlinkBench("px4", arm=True)
    bench.answers[ARM] = TEMPORARILY_REJECTED
    bench.run(3.0)
    assert any("arm TEMPORARILY_REJECTED (it does not say why)" in words for words in bench.warnings)


def test_accepted_is_not_done():
    """An acknowledged mode that the autopilot leaves again right away is asked for again."""
    bench = MavlinkBench(arm=True)
    bench.answers[ARM] = FAILED
    bench.run(2.0)
    assert bench.mode == 15
    bench.mode = 0
    bench.run(1.2)
    assert any("went back to MANUAL" in words for words in bench.warnings)
    bench.run(2.0)
    assert bench.mode == 15


def test_a_command_without_an_answer_is_sent_four_times():
    """A command nobody answers is sent four times, half a second apart, with a counter; then it is said."""
    bench = MavlinkBench(arm=True)
    bench.answers.pop(SET_MODE)
    bench.run(4.0)
    modes = bench.commands(SET_MODE)[:4]
    assert [command.confirmation for command in modes] == [0, 1, 2, 3]
    assert any("mode unanswered (no answer)" in words for words in bench.warnings)


def test_in_progress_is_waited_for():
    """A command in progress is not sent again after half a second: that would begin it anew."""
    bench = MavlinkBench(arm=True)
    bench.answers[SET_MODE] = IN_PROGRESS
    bench.run(2.5)
    assert len(bench.commands(SET_MODE)) == 1


# -- steering ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES)
def test_the_set_point(family: str):
    """A set-point is a velocity along the course, vz included, to this autopilot; a sub is to look there, too."""
    bench = MavlinkBench(family, arm=True).steering(setpoint(1.5, math.radians(90.0)))
    message = bench.setpoints(1.0)[-1]
    assert (message.type_mask, message.coordinate_frame) == (0x09C7 if family == "sub" else 0x0DC7, 1)
    assert message.yaw == pytest.approx(math.pi / 2 if family == "sub" else 0.0)
    assert (message.target_system, message.target_component) == (1, 1)
    assert (message.vx, message.vy, message.vz) == pytest.approx((0.0, 1.5, 0.0), abs=1e-6)


def test_depth_is_steered_by_its_error():
    """A sub that is too shallow is sent down, and never faster than a limit."""
    bench = MavlinkBench("sub", arm=True)
    bench.depth = 4.5
    bench.steering(setpoint(1.0, depth_m=5.0))
    assert bench.setpoints(1.0)[-1].vz == pytest.approx(0.15, abs=1e-6)
    bench.depth = 20.0
    assert bench.setpoints(1.0)[-1].vz == pytest.approx(-0.3, abs=1e-6)
    assert bench.estimate.down_m == 20.0


@pytest.mark.parametrize("family", ["rover", "sub"])
def test_hold_stands_still(family: str):
    """On hold ArduPilot is asked for no speed at all, which alone stops its throttle, and for the old heading."""
    bench = MavlinkBench(family, arm=True).steering(setpoint(0.0, math.pi / 2, "hold"))
    message = bench.setpoints(1.0)[-1]
    assert (message.type_mask, message.vx, message.vy) == (0x09C7, 0.0, 0.0)
    assert message.yaw == pytest.approx(math.pi / 2)


def test_hold_of_px4_keeps_the_bow():
    """PX4 knows no yaw beside a velocity: its speed is next to nothing, in the old direction."""
    bench = MavlinkBench("px4", arm=True).steering(setpoint(0.0, math.pi / 2, "hold"))
    message = bench.setpoints(1.0)[-1]
    assert message.type_mask == 0x0DC7
    assert 0.0 < math.hypot(message.vx, message.vy) <= 0.01
    assert math.atan2(message.vy, message.vx) == pytest.approx(math.pi / 2, abs=1e-3)


@pytest.mark.parametrize("pace", [1.0, 5.0])
def test_rates_are_in_the_autopilots_time(pace: float):
    """Set-points come at their rate and heartbeats once a second of the autopilot's clock, however fast it runs."""
    bench = MavlinkBench(arm=True, pace=pace, setpoint_rate_hz=4.0).run(4.0)
    since = bench.now
    bench.run(10.0, every=0.01)
    assert len(bench.said("SET_POSITION_TARGET_LOCAL_NED", since)) == pytest.approx(40 * pace, rel=0.1)
    assert len(bench.said("HEARTBEAT", since)) == pytest.approx(10 * pace, rel=0.1)


def test_a_clock_that_runs_faster_than_expected():
    """The rate of the autopilot's clock is measured: heartbeats and set-points keep up with it."""
    bench = MavlinkBench(arm=True)
    bench.speedup = 8.0
    bench.run(10.0, every=0.02)
    assert bench.core.peer.rate == pytest.approx(8.0, rel=0.03)
    since = bench.now
    bench.run(5.0, every=0.01)
    assert len(bench.said("HEARTBEAT", since)) == pytest.approx(40, rel=0.1)


def test_a_silent_agent():
    """When the agent is silent for too long the craft goes to a mode that holds; its set-points are not repeated."""
    bench = MavlinkBench(arm=True).steering()
    bench.run(3.0)
    bench.agent = None
    bench.run(2.7)
    assert bench.mode == 4
    assert bench.phase == "holding"
    assert not bench.setpoints(5.0)
    assert [words for words in bench.warnings if "silent" in words] == [
        "the agent is silent: the craft is handed back to its autopilot, to hold"
    ]


def test_the_agent_speaks_again():
    """When a silent agent speaks again, the mode is taken back if arm = true, and is a person's to give if not."""
    for arm, phase in ((True, "steering"), (False, "person")):
        bench = MavlinkBench(arm=arm)
        if not arm:
            bench.mode, bench.armed = 15, True
        bench.steering()
        bench.run(2.0)
        bench.agent = None
        bench.run(4.0)
        assert bench.mode == 4
        bench.agent = setpoint()
        bench.run(3.0)
        assert bench.phase == phase


def test_a_mission_that_has_not_started():
    """Before the mission starts a silent agent is not stale: the craft stands still, armed, and is told so."""
    bench = MavlinkBench(arm=True).run(20.0)
    assert bench.phase == "steering"
    message = bench.setpoints(1.0)[-1]
    assert math.hypot(message.vx, message.vy) <= 0.01


@pytest.mark.parametrize("mode", [0, 4, 11])
def test_a_pilot_takes_over(mode: int):
    """A mode that was not asked for is not fought: no set-point, no command, one line; a person gives it back."""
    bench = MavlinkBench(arm=True).steering()
    bench.run(2.0)
    bench.mode = mode
    bench.run(1.2)
    since = bench.now
    assert not bench.setpoints(20.0)
    assert not bench.commands(SET_MODE, since)
    assert not bench.commands(ARM, since)
    assert len([words for words in bench.warnings if "no set-points are sent" in words]) == 1
    bench.mode = 15
    bench.run(1.5)
    assert bench.phase == "steering"
    assert bench.setpoints(1.0)


def test_a_pilot_disarms():
    """A craft that somebody disarms is not armed again."""
    bench = MavlinkBench(arm=True).steering()
    bench.armed = False
    bench.run(10.0)
    assert len(bench.commands(ARM)) == 1
    assert any("disarmed the craft" in words for words in bench.warnings)


def test_a_pilot_before_the_agent_comes_back():
    """A pilot who sets a mode while the craft holds for a silent agent keeps it when the agent speaks again."""
    bench = MavlinkBench(arm=True).steering()
    bench.agent = None
    bench.run(4.0)
    assert bench.mode == 4
    bench.mode = 0
    bench.run(1.5)
    bench.agent = setpoint()
    bench.run(5.0)
    assert bench.mode == 0
    assert bench.phase == "taken"


def test_px4_comes_back_by_itself():
    """PX4 leaves OFFBOARD when set-points fail to arrive and returns: they go on for a while, and steering goes on."""
    bench = MavlinkBench("px4", arm=True).steering()
    bench.mode = 3 << 16
    assert bench.setpoints(2.0)
    bench.mode = 6 << 16
    bench.run(1.5)
    assert bench.phase == "steering"
    bench.mode = 3 << 16
    bench.run(5.0)
    assert bench.phase == "taken"
    assert not bench.setpoints(2.0)


def test_px4_wants_set_points_first():
    """PX4 gets set-points before it is asked for OFFBOARD; the others do not."""
    for family, streams in (("px4", True), ("rover", False)):
        bench = MavlinkBench(family, arm=True)
        bench.answers[SET_MODE] = FAILED
        bench.run(3.0)
        assert bool(bench.said("SET_POSITION_TARGET_LOCAL_NED")) == streams


def test_a_reboot_at_sea():
    """After a reboot in the middle of a mission only a person arms again; positions go on as soon as they are valid."""
    bench = MavlinkBench(arm=True).steering()
    bench.run(2.0)
    bench.boot, bench.mode, bench.armed = bench.now, 0, False
    since = bench.now
    bench.run(10.0)
    assert bench.phase == "taken"
    assert not bench.commands(ARM, since)
    assert bench.estimate.valid


def test_silence():
    """A silent autopilot gets no set-points, its position is not valid, and all goes on when it is heard again."""
    bench = MavlinkBench(arm=True).steering()
    says, bench.says = bench.says, set()
    bench.run(4.0)
    assert not bench.setpoints(6.0)
    assert not bench.estimate.valid
    assert [words for words in bench.warnings if "silent for 3 s" in words]
    bench.says = says
    bench.run(2.0)
    assert bench.phase == "steering"
    assert bench.estimate.valid
    assert bench.setpoints(1.0)


# -- handing back -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES)
def test_handing_back(family: str):
    """At the end the craft is set to a mode that holds, and only its heartbeat proves it."""
    bench = MavlinkBench(family, arm=True).steering()
    bench.take(bench.core.release(bench.now_ns))
    assert not bench.core.released
    bench.run(1.1)
    assert bench.core.released
    assert bench.mode == bench.family.holds[0]
    assert not bench.setpoints(1.0)


def test_handing_back_to_another_hold():
    """A sub without a position refuses POSHOLD: it is asked for ALT_HOLD."""
    bench = MavlinkBench("sub", arm=True).steering()
    bench.answers[SET_MODE] = FAILED
    bench.take(bench.core.release(bench.now_ns))
    bench.run(0.3)
    bench.answers[SET_MODE] = 0
    bench.run(2.0)
    assert bench.core.released
    assert bench.mode in bench.family.holds
    assert [round(command.param2) for command in bench.commands(SET_MODE)][1:3] == [16, 2]


def test_what_somebody_else_has_is_not_handed_back():
    """A craft that a pilot has is left as it is at the end."""
    bench = MavlinkBench(arm=True).steering()
    bench.mode = 0
    bench.run(2.0)
    since = bench.now
    bench.take(bench.core.release(bench.now_ns))
    assert bench.core.released
    bench.run(3.0)
    assert not bench.commands(SET_MODE, since)


# -- words ------------------------------------------------------------------------------------------------------------


def test_pieces_of_a_text():
    """What the autopilot says in pieces is one line, in the right order; a lost piece is marked."""
    bench = MavlinkBench().run(0.2)
    long = "PreArm: the first fifty characters of a long reasoning end here"
    bench.text(long[50:], 4, number=3, chunk=1)
    bench.text(long[:50], 4, number=3, chunk=0)
    assert bench.warnings == [f"autopilot: {long}"]
    bench.text("and only the end", 6, number=4, chunk=1)
    bench.run(3.0)
    assert bench.words[-1] == "autopilot: …and only the end"


def test_garbled_text():
    """Characters that are none are shown as such, and never break a line."""
    bench = MavlinkBench().run(0.2)
    bench.text("bell\x07 and\nline")
    assert bench.words[-1] == "autopilot: bell? and?line"


def test_version_is_asked_for():
    """The version is asked for, and said once."""
    bench = MavlinkBench().run(1.0)
    assert [round(command.param1) for command in bench.commands(REQUEST)] == [148]
    number, none = 4 << 24 | 6 << 16 | 3 << 8, [0] * 8
    bench.hear(mavlink.MAVLink_autopilot_version_message(0, number, 0, 0, 0, none, none, none, 0, 0, 0))
    assert bench.words[-1] == "its version is 4.6.3"


def test_timesync_is_answered():
    """A request for our time is answered with it; an answer to us measures the round trip."""
    bench = MavlinkBench().run(1.0)
    since = bench.now - 0.01
    bench.hear(mavlink.MAVLink_timesync_message(0, 777))
    answer = bench.said("TIMESYNC", since)[-1]
    assert (answer.tc1, answer.ts1) == (bench.now_ns, 777)
    bench.hear(mavlink.MAVLink_timesync_message(5_000_000_000, bench.now_ns - 22_000_000))
    assert bench.core.peer.clock.round_trip_s is None, "that was the answer to somebody else"
    asked_ns = [message.ts1 for message in bench.said("TIMESYNC") if message.tc1 == 0][-1]
    bench.now = asked_ns / 1e9 + 0.022
    bench.hear(mavlink.MAVLink_timesync_message(5_000_000_000, asked_ns))
    assert bench.core.peer.clock.round_trip_s == pytest.approx(0.022)


def test_a_date_that_jumps():
    """A date that is set while the autopilot runs is said in one line, and changes neither position nor steering."""
    bench = MavlinkBench(arm=True).steering()
    for unix_s in (0.0, 1.8e9, 1.8e9 + 1.0, 1.8e9 + 1002.0, 1.8e9 + 1003.0):
        bench.hear(mavlink.MAVLink_system_time_message(round(1e6 * unix_s), bench.boot_ms))
        bench.run(1.0)
    (line,) = [words for words in bench.warnings if "date" in words]
    assert line.startswith("the autopilot's date has jumped by +1000 s: its logs are dated wrongly, positions and")
    assert bench.estimate.valid
    assert bench.phase == "steering"


def test_an_autopilot_that_knows_no_intervals():
    """If SET_MESSAGE_INTERVAL is unsupported the groups of messages are asked for in the old way, once a boot."""
    bench = MavlinkBench()
    bench.answers[SET_INTERVAL] = UNSUPPORTED
    bench.run(12.0)
    asked = bench.said("REQUEST_DATA_STREAM")
    assert sorted(message.req_stream_id for message in asked) == [2, 6, 10, 12]
    assert {(message.target_system, message.start_stop, message.req_message_rate) for message in asked} == {(1, 1, 5)}
    bench.boot = bench.now
    bench.run(12.0)
    assert len(bench.said("REQUEST_DATA_STREAM")) == 8


def test_a_feed_that_it_does_not_take():
    """PX4 has no use for GPS_INPUT: said at once, with what it takes, and the mission does not start."""
    bench = MavlinkBench("px4", feed="gps_input", arm=True).run(3.0)
    assert bench.core.waits_for(bench.now_ns) == 'PX4 has no use for feed = "gps_input"; it takes "vision"'
    assert not bench.said("COMMAND_LONG")


def test_a_craft_that_waits_for_its_position_is_handed_back():
    """In its mode again while its position is lost, it is not steered; at the end it is set to hold all the same."""
    bench = MavlinkBench(arm=True).steering()
    bench.mode = 0
    bench.run(2.0)
    bench.flags, bench.mode = 0xA7, 15
    bench.run(3.0)
    assert bench.phase == "taken"
    bench.take(bench.core.release(bench.now_ns))
    bench.run(2.0)
    assert bench.core.released
    assert bench.mode == 4


# -- a position that is lost ------------------------------------------------------------------------------------------

LOST = "no valid position for 15 s: the craft is handed back to its autopilot, to hold; "


@pytest.mark.parametrize("pace", [1.0, 5.0])
def test_a_position_that_is_lost_for_long(pace: float):
    """A sub that stays in GUIDED without a position is set to hold after 15 s of its time; said once, for a person."""
    bench = MavlinkBench("sub", arm=True, pace=pace).steering()
    # Without a position it refuses POSHOLD, so it is asked for ALT_HOLD.
    bench.refused_modes = {16}
    bench.flags = 0xA7
    bench.run(14.0 / pace)
    assert bench.phase == "steering"
    bench.run(4.0 / pace)
    assert (bench.phase, bench.mode) == ("taken", 2)
    assert not bench.setpoints(5.0)
    assert [words for words in bench.warnings if words.startswith(LOST)] == [
        f"{LOST}set GUIDED to let the agent steer again"
    ]


def test_a_position_that_is_back_after_long():
    """When the position is back only a person lets the agent steer again; who sets GUIDED before that waits for it."""
    bench = MavlinkBench("sub", arm=True).steering()
    bench.flags = 0xA7
    bench.run(18.0)
    since = bench.now
    bench.mode = 4
    assert not bench.setpoints(5.0)
    bench.mode = 2
    bench.run(2.0)
    bench.flags = GOOD_FLAGS
    assert not bench.setpoints(10.0)
    assert not bench.commands(SET_MODE, since)
    bench.mode = 4
    bench.run(2.0)
    assert bench.phase == "steering"
    assert bench.setpoints(1.0)


def test_a_position_that_is_lost_for_a_while():
    """A position that is back within 15 s, and one that was not heard as the autopilot was silent, change nothing."""
    bench = MavlinkBench("sub", arm=True).steering()
    bench.flags = 0xA7
    bench.run(13.0)
    bench.flags = GOOD_FLAGS
    bench.run(2.0)
    says, bench.says = bench.says, set()
    bench.run(30.0)
    bench.says = {"heartbeat"}
    bench.run(2.0)
    bench.says = says
    bench.run(5.0)
    assert bench.phase == "steering"
    assert not [words for words in bench.warnings if words.startswith(LOST)]


def test_an_autopilot_that_refuses_to_hold():
    """One that refuses every mode that holds is asked for all of them every second, and is not steered meanwhile."""
    bench = MavlinkBench("sub", arm=True).steering()
    bench.refused_modes = {16, 2}
    bench.flags = 0xA7
    bench.run(17.0)
    assert bench.phase == "lost"
    since = bench.now
    assert not bench.setpoints(10.0)
    asked = [round(command.param2) for command in bench.commands(SET_MODE, since)]
    assert 16 <= len(asked) <= 22
    assert set(asked) == {16, 2}
    bench.flags = GOOD_FLAGS
    assert not bench.setpoints(3.0)
    bench.take(bench.core.release(bench.now_ns))
    assert not bench.core.released
    bench.refused_modes = set()
    bench.run(3.0)
    assert bench.core.released
