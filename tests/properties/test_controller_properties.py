"""Controller, estimators and agents, whatever happens to them: limits, no NaN, and no craft is special."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.coordination import ThetaP, load_controller, quality
from grex_agent.core import AgentCore
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link import wire
from grex_link.config import TeamConfig
from grex_link.messages import Fix, ModemEvent, Received, TxEvent
from grex_link.scenario import decode
from grex_sim.sea import Sea

NS = 1_000_000_000
FORMATION = {"a": (0.0, 0.0, 0.0), "b": (-6.0, -25.0, 0.0), "c": (-6.0, 25.0, 0.0), "d": (9.0, 8.0, 0.0)}
progress = st.floats(-1e6, 1e6)


def scenario(estimator, order="abcd", craft=None):
    """A team of four on a short lawnmower, in an order."""
    formation = {name: FORMATION[name] for name in order}
    return decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation, "legs": 3, "leg_length_m": 40.0},
            "craft": {name: (craft or {}).get(name, {}) for name in order},
            "team": {"estimator": estimator},
        }
    )


# -- the controller -----------------------------------------------------------------------------------------------


@given(
    st.floats(0.0, 10.0),
    progress,
    st.lists(progress, max_size=8),
    st.tuples(st.floats(0.0, 2.0), st.floats(2.0, 5.0)),
    st.floats(0.0, 100.0),
)
def test_speed_is_within_limits(planned, own, mates, limits, gain):
    """Whatever the others do, the speed ordered is a number between v_min and v_max."""
    config = TeamConfig(speed_min_mps=limits[0], speed_max_mps=limits[1], gain_mps=gain)
    assert limits[0] <= ThetaP(config).speed(planned, own, mates) <= limits[1]


@given(st.floats(0.5, 2.0), st.floats(0.0, 9.0), st.lists(st.floats(0.0, 9.0), max_size=8), st.randoms())
def test_no_mate_is_special(planned, own, mates, random):
    """The order of the mates does not matter to speed and quality."""
    shuffled = random.sample(mates, len(mates))
    controller = ThetaP(TeamConfig())
    assert controller.speed(planned, own, shuffled) == pytest.approx(controller.speed(planned, own, mates), abs=1e-9)
    assert quality(own, shuffled) == pytest.approx(quality(own, mates), abs=1e-9)


@given(st.floats(0.5, 2.0), st.floats(0.0, 9.0), st.lists(st.floats(0.0, 9.0), min_size=1), st.floats(0.0, 9.0))
def test_nobody_slows_down_for_a_mate_ahead(planned, own, mates, more):
    """If a mate is further on, the craft is not slower."""
    controller = ThetaP(TeamConfig())
    ahead = [mates[0] + more, *mates[1:]]
    assert controller.speed(planned, own, ahead) >= controller.speed(planned, own, mates) - 1e-9


@given(st.floats(0.5, 2.0), st.floats(0.0, 9.0), st.integers(0, 8))
def test_equal_progress_is_the_plan(planned, own, size):
    """In a team at one progress everybody goes at the planned speed."""
    assert ThetaP(TeamConfig()).speed(planned, own, [own] * size) == pytest.approx(planned, abs=1e-9)


# -- the whole agent ----------------------------------------------------------------------------------------------

fixes = st.builds(
    lambda north, east, heading, valid: (north, east, heading, valid),
    st.floats(-9000.0, 9000.0) | st.just(math.nan),
    st.floats(-9000.0, 9000.0) | st.just(-math.inf),
    st.floats(-math.pi, math.pi),
    st.booleans(),
)
states = st.builds(
    wire.TeamState,
    source=st.integers(0, 3),
    t_s=st.floats(0.0, 60.0),
    north_m=st.floats(-8000.0, 8000.0),
    east_m=st.floats(-8000.0, 8000.0),
    depth_m=st.just(0.0),
    speed_mps=st.floats(0.0, 5.0),
    heading_rad=st.floats(-math.pi, math.pi),
    track=st.integers(0, 255),
    theta=st.floats(0.0, 1.0),
    sigma_m=st.floats(0.0, 100.0),
)
payloads = st.one_of(st.binary(max_size=20), st.builds(wire.pack, states))
events = st.one_of(
    st.builds(Received, st.sampled_from([*FORMATION, "stranger"]), payloads),
    st.builds(TxEvent, st.integers(0, 3), st.sampled_from(["SENT", "FAILED"])),
)


@given(
    st.sampled_from(["first_level", "second_level"]),
    st.lists(st.tuples(st.none() | fixes, st.lists(events, max_size=3)), min_size=1, max_size=35),
)
def test_agent_survives_everything(estimator, steps):
    """Whatever fixes and datagrams come, every step orders a course and a speed within limits, and nothing is NaN."""
    core = AgentCore(scenario(estimator), "a")
    seq = 0
    for tick, (place, heard) in enumerate(steps):
        if place is not None:
            north, east, heading, valid = place
            core.on_fix(Fix(tick, tick * NS, north, east, 0.0, heading, 1.0, 0.1, valid))
        for event in heard:
            core.on_modem(ModemEvent(seq, tick * NS, event))
            seq += 1
        put = list(core.step(tick, tick * NS))
        state, setpoint = dict(put)["state"], dict(put)["setpoint"]
        assert -math.pi <= setpoint.course_rad <= math.pi
        assert 0.3 <= state.ordered_mps <= 3.0
        assert setpoint.speed_mps == (state.ordered_mps if setpoint.mode == "steer" else 0.0)
        assert (setpoint.mode == "hold") is bool({"no_fix", "invalid_fix", "stale_fix"} & set(state.health))
        numbers = [state.theta, state.xte_m, state.quality]
        for mate in state.mates:
            numbers += [mate.north_m, mate.east_m, mate.progress, mate.sigma_m, mate.age_s]
        assert all(map(math.isfinite, numbers))
        requests = [message for topic, message in put if topic == "modem_tx"]
        assert all(wire.unpack(request.payload, tick).source == 0 for request in requests)


# -- no craft is special ------------------------------------------------------------------------------------------


@given(
    st.sampled_from(["first_level", "second_level"]),
    st.permutations("abcd"),
    st.lists(st.tuples(st.integers(1, 60), st.sampled_from("bcd"), st.floats(0.5, 1.5)), max_size=5),
)
def test_beliefs_do_not_depend_on_the_order_of_the_team(estimator, order, said):
    """Naming the craft in another order gives the same beliefs about each of them."""
    believed = []
    for team in ("abcd", "".join(order)):
        config = scenario(estimator, team)
        context = TeamContext("a", plan_mission(config), config, load_controller(config.team))
        estimating = load_estimator(context)
        for now in range(1, 61):
            heard = []
            for t_s, craft, rate in said:
                if now == min(t_s + 10, 60):
                    north, east = context.plan.craft[craft].point(rate * t_s / 40.0)
                    track = int(rate * t_s / 40.0)
                    state = wire.TeamState(0, float(t_s), north, east, 0.0, 1.0, 0.0, track, 0.0, 0.1)
                    heard.append(Report(craft, state))
            beliefs = estimating.step(float(now), Own(0.0, 0.0, now / 41.0), [], heard)
        assert [belief.craft for belief in beliefs] == [craft for craft in team if craft != "a"]
        believed.append({belief.craft: belief for belief in beliefs})
    for craft, belief in believed[0].items():
        other = believed[1][craft]
        assert (other.north_m, other.east_m, other.progress, other.sigma_m, other.age_s) == pytest.approx(
            (belief.north_m, belief.east_m, belief.progress, belief.sigma_m, belief.age_s), abs=1e-9
        )


def sail(order, errors):
    """Let a team with disturbed actuators and ideal knowledge go round a turn; returns where everybody is."""
    craft = {name: {"vehicle": {"speed_error_relative": errors[name]}} for name in order}
    config = scenario("ideal", order, craft)
    water = Sea(config, plan_mission(config))
    agents = {name: AgentCore(config, name) for name in order}
    for tick in range(70):
        setpoints = {}
        for (name, core), fix in zip(agents.items(), water.fixes([0] * len(order)), strict=True):
            core.on_truth(water.truth)
            core.on_fix(fix)
            setpoints[name] = dict(core.step(tick, tick * NS))["setpoint"]
        water.advance(setpoints)
    return {pose.craft: (pose.north_m, pose.east_m, pose.surge_mps) for pose in water.truth.poses}


@given(st.permutations("abcd"), st.lists(st.floats(-0.3, 0.3), min_size=4, max_size=4))
def test_a_run_does_not_depend_on_the_order_of_the_team(order, errors):
    """Naming the craft in another order moves each of them in the same way."""
    named = dict(zip("abcd", errors, strict=True))
    one, other = sail("abcd", named), sail("".join(order), named)
    for name, state in one.items():
        assert other[name] == pytest.approx(state, abs=1e-9)
