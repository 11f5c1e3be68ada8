"""The agent's core: what it makes of fixes and modem events, step by step."""

import math
from typing import ClassVar

import pytest
from core_steps import NS, TEAM, fix, outputs, scenario, step

from grex_agent.core import AgentCore
from grex_link import wire
from grex_link.messages import Fix, ModemEvent, Pose, Received, Transmit, Truth, TxEvent


def datagram(place=1, t_s=10.0, north_m=9.0, track=0, theta=0.03):
    """A team state as it is on the air."""
    return wire.pack(wire.TeamState(place, t_s, north_m, -25.0, 0.0, 1.0, 0.0, track, theta, 0.1))


def received(source, payload, seq=0):
    """A datagram from a mate."""
    return ModemEvent(seq, 20 * NS, Received(source, payload))


# -- every step ---------------------------------------------------------------------------------------------------


def test_follows_the_plan():
    """A step of a craft on its plan says: steer along the track, at the planned speed, at the planned depth."""
    core = AgentCore(scenario(mission={"start_ned_m": [0.0, 0.0, 8.0]}), "auv1")
    _, state, setpoint = step(core, 12)
    assert (setpoint.tick, setpoint.t_ns, setpoint.mode) == (12, 12 * NS, "steer")
    assert (setpoint.course_rad, setpoint.speed_mps, setpoint.depth_m) == (0.0, 1.0, 8.0)
    assert (state.tick, state.t_ns, state.track) == (12, 12 * NS, 0)
    assert (state.theta, state.xte_m) == pytest.approx((0.03, 0.0))
    assert (state.planned_mps, state.ordered_mps, state.quality) == (1.0, 1.0, 0.0)
    assert (state.mates, state.health, state.bad_frames) == ([], [], 0)


def test_corrects_its_course():
    """A craft 4 m to starboard of its track steers 0.2 rad to port."""
    _, state, setpoint = step(AgentCore(scenario(), "auv1"), 12, fix(12, east_m=4.0))
    assert setpoint.course_rad == pytest.approx(-0.2)
    assert state.xte_m == pytest.approx(4.0)


def test_changes_tracks():
    """Behind a leg the craft takes up the arc, with its course, lead and speed."""
    core = AgentCore(scenario(), "auv2")
    step(core, 1, fix(1, north_m=393.0, east_m=-25.0))
    _, state, setpoint = step(core, 2, fix(2, north_m=394.1, east_m=-25.0))
    radius = math.hypot(6.0, 90.0)
    assert state.track == 1
    assert state.theta == pytest.approx(0.0, abs=0.001)
    assert setpoint.speed_mps == pytest.approx(radius / 65.0)
    assert setpoint.course_rad == pytest.approx(math.atan2(-6.0, 90.0) + 2.0 / 65.0, abs=0.01)


def test_one_setpoint_a_step():
    """Every step ends with exactly one state and one setpoint, with and without a new fix."""
    core = AgentCore(scenario("second_level"), "auv3")
    for tick in range(40):
        if tick % 3:
            core.on_fix(fix(tick, east_m=25.0))
        _, state, setpoint = outputs(core, tick)
        assert (state.tick, setpoint.tick) == (tick, tick)


# -- navigation that fails ----------------------------------------------------------------------------------------


def test_without_a_fix_it_holds():
    """Before its first fix a craft holds and says ``no_fix``; its slot passes unused."""
    transmissions, state, setpoint = outputs(AgentCore(scenario("second_level"), "auv1"), 0)
    assert state.health == ["no_fix"]
    assert (setpoint.mode, setpoint.speed_mps) == ("hold", 0.0)
    assert transmissions == []


@pytest.mark.parametrize(
    "fields",
    [
        {"north_m": 9999.0, "valid": False},
        {"north_m": math.nan},
        {"east_m": math.inf},
        {"down_m": -math.inf},
        {"heading_rad": math.nan},
        {"sigma_m": math.nan},
    ],
)
def test_an_invalid_fix_moves_nothing(fields):
    """On a fix that is invalid or no number a craft holds, says ``invalid_fix`` and stays where it was in its plan."""
    core = AgentCore(scenario("second_level"), "auv1")
    step(core, 29)
    transmissions, state, setpoint = step(core, 30, fix(30, **fields))
    assert state.health == ["invalid_fix"]
    assert setpoint.mode == "hold"
    assert state.theta == pytest.approx(29.0 / 400.0)
    assert transmissions == []


def test_a_stale_fix():
    """A fix 5 s old is still good, an older one is stale: the craft holds until there is a new one."""
    core = AgentCore(scenario("second_level"), "auv1")
    step(core, 24)
    assert outputs(core, 25, 29.0)[1:][1].mode == "steer"
    transmissions, state, setpoint = outputs(core, 26, 30.0)
    assert state.health == ["stale_fix"]
    assert (setpoint.mode, setpoint.speed_mps, transmissions) == ("hold", 0.0, [])
    _, state, setpoint = step(core, 31)
    assert (state.health, setpoint.mode) == ([], "steer")


# -- the modem ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("craft", "first"), [("auv1", 0), ("auv2", 10), ("auv3", 20)])
def test_transmits_in_its_own_slots(craft, first):
    """A craft transmits once in each of its slots, and counts its transmissions in the setpoint."""
    core = AgentCore(scenario(), craft)
    east_m = TEAM[craft][1]
    times, counts = [], []
    for tick in range(75):
        transmissions, _, setpoint = step(core, tick, fix(tick, east_m=east_m))
        times += [(request.seq, request.t_ns) for request in transmissions]
        counts.append(setpoint.transmissions)
    slots = list(range(first, 75, 30))
    assert times == [(seq, slot * NS) for seq, slot in enumerate(slots)]
    assert counts == [sum(slot <= tick for slot in slots) for tick in range(75)]


def test_slots_between_steps():
    """A slot that opens between two steps is asked for at the first, for the time at which it opens."""
    slots = [{"craft": "auv1", "start_s": 3.4, "length_s": 10.0}]
    mac = {"type": "tdma", "slots": slots, "cycle_s": 15.0}
    core = AgentCore(scenario(link={"mac": mac}), "auv1")
    asked = [(tick, request.t_ns) for tick in range(20) for request in step(core, tick)[0]]
    assert asked == [(3, 3_400_000_000), (18, 18_400_000_000)]


def test_uneven_steps_use_every_slot_once():
    """At a live pace, with steps closer than a tick and never on time, a slot is used once, not twice."""
    core = AgentCore(scenario(), "auv1")
    asked = []
    for count in range(130):
        now_s = 0.3 + 0.7 * count
        core.on_fix(Fix(count, round(now_s * NS), now_s, 0.0, 0.0, 0.0, 1.0, 0.1))
        asked += [request.t_ns for request in outputs(core, count, now_s)[0]]
    assert asked == [30 * NS, 60 * NS, 90 * NS]


def test_a_slot_that_was_missed_stays_missed():
    """After a silence for want of a fix nothing is sent outside the own slots."""
    core = AgentCore(scenario(), "auv1")
    outputs(core, 0)
    asked = [request.t_ns for tick in range(1, 31) for request in step(core, tick)[0]]
    assert asked == [30 * NS]


def test_the_payload_is_the_own_state():
    """A transmission carries place in the team, time, position, depth, speed made good, heading, track, Θ, sigma."""
    core = AgentCore(scenario(mission={"start_ned_m": [0.0, 0.0, 8.0]}), "auv2")
    own = fix(40, 17.3, -24.2, down_m=8.04, heading_rad=0.5, speed_mps=0.9, sigma_m=0.15)
    (request,), _, _ = step(core, 40, own)
    told = wire.unpack(request.payload, 40.0)
    assert (told.source, told.track) == (1, 0)
    assert told.flags == wire.NAVIGATION_VALID | 0b111111 << wire.HEARD_SHIFT  # nothing heard of either mate yet
    assert told.t_s == pytest.approx(40.0, abs=1e-9)
    assert (told.north_m, told.east_m) == pytest.approx((17.3, -24.2), abs=0.0625)
    assert told.depth_m == pytest.approx(8.04, abs=0.05)
    assert told.speed_mps == pytest.approx(0.9, abs=0.01)
    assert told.heading_rad == pytest.approx(0.5, abs=math.pi / 512)
    assert told.theta == pytest.approx(23.3 / 400.0, abs=1e-3)
    assert 0.15 <= told.sigma_m <= 0.15 * math.sqrt(2.0)


def test_outside_the_frame():
    """A position that no message can carry is not sent, and health says so; back inside, the next slot is used."""
    core = AgentCore(scenario(), "auv1")
    transmissions, state, setpoint = step(core, 0, fix(0, north_m=8192.1))
    assert (transmissions, state.health, setpoint.transmissions) == ([], ["outside_frame"], 0)
    assert setpoint.mode == "steer"
    (request,), state, setpoint = step(core, 30, fix(30, north_m=8191.8))
    assert (request.seq, state.health, setpoint.transmissions) == (0, [], 1)


def test_hears_a_mate():
    """A team state of a mate changes the belief in it, and through eq. (2) the own speed."""
    hearing, deaf = (AgentCore(scenario("first_level"), "auv1") for _ in range(2))
    for tick in range(21):
        if tick == 20:
            hearing.on_modem(received("auv2", datagram(1, 10.0, 44.0)))
        _, heard, setpoint = step(hearing, tick)
        _, unheard, _ = step(deaf, tick)
    assert [mate.craft for mate in heard.mates] == ["auv2", "auv3"]
    assert [mate.age_s for mate in heard.mates] == [10.0, -1.0]
    assert heard.ordered_mps > unheard.ordered_mps + 0.05
    assert setpoint.speed_mps == heard.ordered_mps
    progress = 20.0 / 400.0
    assert heard.quality == pytest.approx(sum(mate.progress - progress for mate in heard.mates))
    assert heard.ordered_mps == pytest.approx(1.0 + 0.8 * heard.quality)


@pytest.mark.parametrize(
    ("source", "payload"),
    [
        ("auv2", b""),
        ("auv2", datagram()[:-1]),
        ("auv2", datagram() + b"\0"),
        ("auv2", bytes(15)),
        ("auv2", datagram(place=2)),
        ("auv2", datagram(track=15)),
        ("auv1", datagram(place=0)),
        ("stranger", datagram()),
    ],
)
def test_bad_frames(source, payload):
    """A datagram that is no team state of a mate is counted and otherwise ignored; a good one after it is heard."""
    core = AgentCore(scenario("first_level"), "auv1")
    core.on_modem(received(source, payload))
    _, state, setpoint = step(core, 12)
    assert (state.bad_frames, core.bad_frames, setpoint.mode) == (1, 1, "steer")
    assert [mate.age_s for mate in state.mates] == [-1.0, -1.0]
    core.on_modem(received("auv2", datagram(track=14)))
    _, state, _ = step(core, 13)
    assert (state.bad_frames, state.mates[0].age_s) == (1, pytest.approx(3.0))


def test_twenty_craft_share_sixteen_names():
    """On the air the place in the team is modulo 16; craft 18 is still known by its name."""
    formation = {f"c{place}": [0.0, 10.0 * place, 0.0] for place in range(20)}
    core = AgentCore(scenario("first_level", formation, mission={"turn_radius_m": 500.0}), "c0")
    core.on_modem(received("c18", datagram(18)))
    core.on_modem(received("c17", datagram(18)))
    _, state, _ = step(core, 12)
    assert [mate.craft for mate in state.mates if mate.age_s >= 0.0] == ["c18"]
    assert state.bad_frames == 1


class Listener:
    """A user's estimator that writes down what it is told and believes one thing."""

    calls: ClassVar[list] = []

    def __init__(self, context):
        self.context = context

    def step(self, now_s, own, sent, heard):
        self.calls.append((now_s, own, list(sent), list(heard)))
        return []


class Planner(Listener):
    """A user's estimator that can work in advance."""

    def prepare(self, next_s):
        self.calls.append(next_s)


class Steady:
    """A user's controller."""

    order_mps = 0.77

    def __init__(self, config):
        pass

    def speed(self, planned_mps, own, mates):
        return self.order_mps


@pytest.fixture
def listening():
    """A core of auv1 with the user's estimator and controller, and what the estimator is told."""
    Listener.calls.clear()
    plugins = {"controller": f"{__name__}:Steady"}
    return AgentCore(scenario(f"{__name__}:Listener", team=plugins), "auv1"), Listener.calls


def test_users_estimator_and_controller(listening):
    """A user's estimator is told time and own state, a user's controller orders the speed."""
    core, calls = listening
    _, state, setpoint = step(core, 12, fix(12, east_m=3.0))
    (told,) = calls
    assert told == (12.0, (12.0, 3.0, pytest.approx(0.03)), [], [])
    assert (state.ordered_mps, setpoint.speed_mps) == (0.77, 0.77)


@pytest.mark.parametrize(("order", "kept"), [(9.0, 3.0), (-1.0, 0.3), (math.nan, 1.0), (math.inf, 1.0)])
def test_users_controller_is_limited(listening, monkeypatch, order, kept):
    """Whatever a user's controller orders, the limits are kept, the plan where it is no number, and health says so."""
    monkeypatch.setattr(Steady, "order_mps", order)
    _, state, setpoint = step(listening[0], 12)
    assert (state.ordered_mps, setpoint.speed_mps, setpoint.mode) == (kept, kept, "steer")
    assert state.health == ["speed_limited"]


def test_an_estimator_is_told_the_last_good_state(listening):
    """While the navigation fails, the estimator works on with the own state last known."""
    core, calls = listening
    outputs(core, 11)
    step(core, 12)
    step(core, 13, fix(13, north_m=999.0, valid=False))
    outputs(core, 30)
    assert [(now_s, own) for now_s, own, _, _ in calls] == [
        (now_s, (12.0, 0.0, pytest.approx(0.03))) for now_s in (12.0, 13.0, 30.0)
    ]


def test_users_estimator_may_work_in_advance():
    """An estimator that can is told, when the step's setpoint has been taken, when the next step is expected."""
    Listener.calls.clear()
    core = AgentCore(scenario(f"{__name__}:Planner", clock={"tick_s": 0.5}), "auv1")
    core.on_fix(fix(12))
    for topic, _ in core.step(12, 12 * NS):
        assert len(Listener.calls) == 1, topic
    assert Listener.calls[1:] == [12.5]


def test_what_was_sent_is_told_as_the_mates_read_it(listening):
    """When the modem has sent a message, the estimator is given it once, with its rounding."""
    core, calls = listening
    (request,), _, _ = step(core, 0, fix(0, north_m=0.3))
    core.on_modem(ModemEvent(0, 10 * NS, TxEvent(0, "SENT")))
    step(core, 10)
    core.on_modem(ModemEvent(1, 10 * NS, TxEvent(0, "SENT")))
    step(core, 11)
    assert [sent for _, _, sent, _ in calls] == [[], [wire.unpack(request.payload, 0.0)], []]
    assert calls[1][2][0].north_m == 0.25


@pytest.mark.parametrize("event", [TxEvent(0, "FAILED", "busy"), TxEvent(7, "SENT")])
def test_what_was_not_sent(listening, event):
    """A failed transmission, or one that never was, tells the estimator nothing."""
    core, calls = listening
    step(core, 0)
    core.on_modem(ModemEvent(0, 10 * NS, event))
    step(core, 10)
    core.on_modem(ModemEvent(1, 11 * NS, TxEvent(0, "SENT")))
    step(core, 11)
    assert calls[1][2] == []
    assert bool(calls[2][2]) is (event.ticket == 7)


def test_events_count_once(listening):
    """An event is used at the first step after it, and only there; reports keep their order."""
    core, calls = listening
    core.on_modem(received("auv3", datagram(2, 2.0)))
    core.on_modem(received("auv2", datagram(1, 1.0)))
    step(core, 12)
    step(core, 13)
    assert [[report.craft for report in heard] for *_, heard in calls] == [["auv3", "auv2"], []]
    assert [report.state.t_s for report in calls[0][3]] == pytest.approx([2.0, 1.0])


# -- the estimators of the scale's ends ---------------------------------------------------------------------------


def test_none_keeps_the_planned_speed():
    """Case a orders the planned speed, whatever is heard."""
    core = AgentCore(scenario("none"), "auv1")
    core.on_modem(received("auv2", datagram(1, 10.0, 300.0)))
    _, state, setpoint = step(core, 12)
    assert (setpoint.speed_mps, state.mates, state.bad_frames) == (1.0, [], 0)


def test_ideal_orders_by_the_truth():
    """Case b puts the true progress of the mates into eq. (2)."""
    core = AgentCore(scenario("ideal"), "auv1")
    positions = {"auv1": (40.0, 0.0), "auv2": (44.0, -25.0), "auv3": (14.0, 25.0)}
    poses = [Pose(craft, *place, 0.0, 0.0, 0.0, 0.0, 1.0) for craft, place in positions.items()]
    core.on_truth(Truth(12, 12 * NS, poses))
    _, state, setpoint = step(core, 12, fix(12, north_m=40.0))
    assert [mate.progress for mate in state.mates] == pytest.approx([50.0 / 400.0, 20.0 / 400.0])
    assert setpoint.speed_mps == pytest.approx(1.0 + 0.8 * (10.0 - 20.0) / 400.0)


# -- the end ------------------------------------------------------------------------------------------------------


def test_hold_at_the_end():
    """With ``at_end = "hold"`` a craft that ran past its end comes back at 0.1 m/s a metre and stops within 2 m."""
    core = AgentCore(scenario(mission={"legs": 1, "at_end": "hold"}), "auv1")
    assert step(core, 399)[2].speed_mps == 1.0
    past = step(core, 405, fix(405, north_m=405.0))[2]
    assert (past.mode, past.speed_mps, abs(past.course_rad)) == ("steer", pytest.approx(0.5), pytest.approx(math.pi))
    there = step(core, 406, fix(406, north_m=401.9))[2]
    assert (there.mode, there.speed_mps) == ("hold", 0.0)


def test_continue_at_the_end():
    """Otherwise it goes straight on."""
    core = AgentCore(scenario(mission={"legs": 1}), "auv1")
    past = step(core, 600)[2]
    assert (past.mode, past.speed_mps, past.course_rad) == ("steer", 1.0, 0.0)


def test_transmissions_are_requests():
    """What goes to the modem is a request with a ticket that counts from 0."""
    (request,), _, _ = step(AgentCore(scenario(), "auv1"), 0)
    assert isinstance(request, Transmit)
    assert (request.seq, request.t_ns, len(request.payload)) == (0, 0, wire.TEAM_STATE_BYTES)
