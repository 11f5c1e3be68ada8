"""The agent's core with a clock that is wrong, drifts, and is set by GPS."""

import math

import pytest
from core_steps import NS, outputs, scenario
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.core import AgentCore
from grex_agent.modem.openings import LATE_NS
from grex_link import wire
from grex_link.mac import plan_mac
from grex_link.messages import Fix


def asked_at(core, clock, ticks):
    """Step a core whose clock reads `clock(true time)` through ticks of a second; (true time, slot) of each request."""
    asked = []
    for tick in range(ticks):
        t_ns = round(clock(tick) * NS)
        core.on_fix(Fix(tick, t_ns, float(tick), 0.0, 0.0, 0.0, 1.0, 0.1))
        asked += [(tick, request.t_ns / NS) for request in outputs(core, tick, t_ns / NS)[0]]
    return asked


def test_slots_are_by_the_own_clock():
    """A craft whose clock is 7.5 s ahead speaks 7.5 s early, and says the time its clock says."""
    assert asked_at(AgentCore(scenario(), "auv1"), lambda true_s: true_s + 7.5, 60) == [(22, 30.0), (52, 60.0)]
    core = AgentCore(scenario(), "auv1")
    core.on_fix(Fix(23, 30 * NS, 23.0, 0.0, 0.0, 0.0, 1.0, 0.1))
    ((request,), _, setpoint) = outputs(core, 23, 30.0)
    assert wire.unpack(request.payload, 30.0).t_s == pytest.approx(30.0)
    assert setpoint.t_ns == 30 * NS


def test_a_drifting_clock_uses_every_slot_once():
    """A clock that gains or loses a thousandth skips no slot and uses none twice."""
    for drift in (-1e-3, 1e-3):
        core = AgentCore(scenario(), "auv1")
        slots = [slot for _, slot in asked_at(core, lambda true_s, drift=drift: true_s * (1.0 + drift), 3000)]
        assert slots == [30.0 * number for number in range(100 if drift < 0 else 101)]


def test_a_slot_between_two_windows_of_a_fast_clock():
    """A clock that gains leaves gaps between one step's window and the next: a slot that opens in one is used."""
    slots = [{"craft": "auv1", "start_s": 4.0035, "length_s": 10.0}]
    core = AgentCore(scenario(link={"mac": {"type": "tdma", "slots": slots, "cycle_s": 100.0}}), "auv1")
    assert asked_at(core, lambda true_s: true_s * 1.001, 20) == [(4, 4.0035)]


@pytest.mark.parametrize(("set_at", "back_s"), [(31, 4.0), (45, 20.0), (65, 40.0), (61, 0.4)])
def test_a_clock_set_back(set_at, back_s):
    """Set back, a craft repeats no slot, and is silent for no longer than it was set back."""
    core = AgentCore(scenario(), "auv1")
    asked = asked_at(core, lambda true_s: true_s if true_s < set_at else true_s - back_s, 200)
    slots = [slot for _, slot in asked]
    assert slots == sorted(set(slots))
    assert slots == [30.0 * number for number in range(len(slots))]
    for tick, slot in asked:
        assert tick == math.floor(slot + (back_s if tick >= set_at else 0.0)) or tick == set_at
    assert asked[-1][0] > 200 - 30 - 1


@pytest.mark.parametrize(("set_at", "forward_s"), [(15, 10.0), (20, 100.0), (29, 1.5)])
def test_a_clock_set_forward(set_at, forward_s):
    """Set forward, only the slots that have passed are lost; none is used late."""
    core = AgentCore(scenario(), "auv1")
    asked = asked_at(core, lambda true_s: true_s if true_s < set_at else true_s + forward_s, 120)
    slots = [slot for _, slot in asked]
    passed = [slot for slot in range(0, 120 + round(forward_s), 30) if set_at <= slot < set_at + forward_s]
    assert slots == [float(slot) for slot in range(0, 120 + math.floor(forward_s), 30) if slot not in passed]


clocks = st.lists(st.tuples(st.integers(1, 60), st.floats(-70.0, 70.0), st.floats(-1e-3, 1e-3)), max_size=4)


@settings(max_examples=60, deadline=None)
@given(clocks, st.sampled_from(["tdma", "slotted_aloha", "aloha"]))
def test_every_opening_is_asked_for_once(jumps, kind):
    """Whatever a clock does, no opening is asked for twice, none is asked for late, and steady time misses none."""
    macs = {
        "tdma": {"cycle_s": 45.0},
        "slotted_aloha": {"probability": 0.4, "slot_s": 10.0},
        "aloha": {"rate_per_s": 0.2},
    }
    document = scenario(link={"mac": {"type": kind} | macs[kind]})
    core = AgentCore(document, "auv1")
    mac = plan_mac(document, 0.0, wire.TEAM_STATE_BYTES)
    steps = [
        (seconds, jump if first == 0 else 0.0, drift) for seconds, jump, drift in jumps for first in range(seconds)
    ]
    local_ns, reached_ns, expected, asked = 0, 0, [], []
    for tick, (_, jump_s, drift) in enumerate([*steps, *[(0, 0.0, 0.0)] * 30]):
        local_ns += round((1.0 + jump_s + drift) * NS) if tick else 0
        core.on_fix(Fix(tick, local_ns, float(tick), 0.0, 0.0, 0.0, 1.0, 0.1))
        asked += [request.t_ns for request in outputs(core, tick, local_ns / NS)[0]]
        expected += mac.openings("auv1", max(reached_ns, local_ns - LATE_NS), local_ns + NS)
        reached_ns = max(reached_ns, local_ns + NS)
    assert asked == expected
    assert len(set(asked)) == len(asked)


class Watch:
    """A user's estimator that writes down the time it is told."""

    def __init__(self, context):
        self.times = []

    def step(self, now_s, own, sent, heard):
        self.times.append(now_s)
        return []


def test_time_stands_for_an_estimator_until_a_clock_set_back_has_passed_it_again():
    """An estimator is promised that time never decreases; the fix is as good as ever all the same."""
    core = AgentCore(scenario(f"{__name__}:Watch"), "auv1")
    for tick, t_s in enumerate((100.0, 101.0, 81.0, 82.0, 102.5)):
        core.on_fix(Fix(tick, round(t_s * NS), 0.0, 0.0, 0.0, 0.0, 1.0, 0.1))
        _, state, setpoint = outputs(core, tick, t_s)
        assert (state.health, setpoint.mode, state.t_ns) == ([], "steer", round(t_s * NS))
    assert core._estimator.times == [100.0, 101.0, 101.0, 101.0, 102.5]
