"""The agent of a base: what goes in and comes out, at literal times."""

import pytest
from missions import SCENARIOS

from grex_agent.base import BaseCore
from grex_agent.mission import plan_mission
from grex_agent.shell import Agent
from grex_link import wire
from grex_link.errors import ConfigError
from grex_link.mac import plan_mac
from grex_link.messages import AgentState, ModemEvent, RangeRequest, RangeResult, Received, Setpoint, Transmit
from grex_link.scenario import load
from grex_link.units import NS
from grex_sim.sea import Sea


def scenario(*overrides):
    """The scenario of a base that watches auv2, the second of three; its slot opens at 4.551 s of 6.068 s."""
    return load(SCENARIOS / "base.toml", overrides)


def told(t_s, source=1):
    """What a craft says, on its first track at 1 m/s to the north."""
    state = wire.TeamState(source, t_s, -20.0 + t_s, -30.0, 10.0, 1.0, 0.0, 0, t_s / 300.0, 0.2)
    return Received(f"auv{source + 1}", wire.pack(state))


def run(core, until, events=()):
    """Let a base step once a second; events are (second, happening). Returns what came out, with its second."""
    out, waiting = [], list(events)
    for now in range(until):
        while waiting and waiting[0][0] <= now:
            at, happening = waiting.pop(0)
            core.on_modem(ModemEvent(0, round(at * NS), happening))
        out += [(now, message) for _, message in core.step(now, now * NS)]
    return out


def kind(out, wanted):
    """Those messages of one kind, with their second."""
    return [(now, message) for now, message in out if isinstance(message, wanted)]


def test_it_asks_in_its_slot_and_tells_nothing():
    """In every slot of its own, and at no other time, it asks the craft it watches for an answer; it sends nothing."""
    out = run(BaseCore(scenario(), "base"), 8)
    ((now, request),) = kind(out, RangeRequest)
    assert (now, request.t_ns, request.destination) == (4, round(4.551 * NS), "auv2")
    assert kind(out, Transmit) == []
    setpoints = kind(out, Setpoint)
    assert [setpoint.mode for _, setpoint in setpoints] == ["hold"] * 8
    assert [setpoint.transmissions for _, setpoint in setpoints] == [0] * 4 + [1] * 4


def test_messages_and_ranges_make_a_belief():
    """It believes nothing at first; then what the craft it watches says, and no other; and a range sharpens that."""
    core = BaseCore(scenario(), "base")
    events = [(2.0, told(1.5, source=0)), (3.0, told(2.5)), (5.6, RangeResult(0, "auv2", 167.9))]
    states = [state for _, state in kind(run(core, 8, events), AgentState)]
    assert [len(state.places) for state in states] == [0, 0, 0, 1, 1, 1, 1, 1]
    assert [mate.craft for mate in states[3].mates] == ["auv2"]
    assert states[3].places[0].north_m == pytest.approx(-17.0, abs=0.2)
    deaf = [state for _, state in kind(run(BaseCore(scenario(), "base"), 8, events[:2]), AgentState)]
    with_range, without = (sum(each[6].places[0].covariance_m2[:2]) for each in (states, deaf))
    assert with_range < without
    assert all(state.health == [] for state in states)


def test_an_outlier_is_reported():
    """A range 50 m off is not used, and is a word of health in that step."""
    events = [(3.0, told(2.5)), (5.6, RangeResult(0, "auv2", 216.0))]
    states = [state for _, state in kind(run(BaseCore(scenario(), "base"), 8, events), AgentState)]
    assert [state.health for state in states] == [[]] * 6 + [["range_rejected"], []]


def test_who_only_listens_needs_no_slot():
    """Without two-way ranging the base has no slot, and the craft share the cycle."""
    config = scenario("team.ranging.mode=off", "link.mac.guard_s=0.6")
    assert {slot.craft for slot in plan_mac(config, 426.0, 15).slots} == {"auv1", "auv2", "auv3"}
    out = run(BaseCore(config, "base"), 8)
    assert kind(out, RangeRequest) == []


def test_the_sea_keeps_it_in_its_place():
    """Whatever it is told, the base stays, and it has a place in the truth and fixes as every craft."""
    config = scenario()
    sea = Sea(config, plan_mission(config))
    for _ in range(3):
        sea.advance({})
    pose = sea.truth.poses[3]
    assert (pose.craft, pose.north_m, pose.east_m, pose.down_m) == ("base", 150.0, -60.0, 20.0)
    assert len(sea.fixes([0] * 4)) == 4


def test_only_a_base():
    """A craft that moves has no such agent, and a base no other."""
    with pytest.raises(ConfigError, match="no base"):
        BaseCore(scenario(), "auv1")
    assert isinstance(Agent(scenario(), "base", None)._core, BaseCore)
