"""Every model of a mate: messages may come when they like, and silence makes unsure."""

import math

import numpy as np
import pytest
from along_track_one import OneByOneFirst
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.coordination import ThetaP, load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link.scenario import decode
from grex_link.wire import TeamState

MODELS = ["hold_last", "dead_reckoning", "first_level", "biased_planar_first", "along_track_first"]
ESTIMATORS = [*MODELS, "second_level", "biased_planar", "along_track"]
TEAM = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -8.0, 0.0], "auv3": [-3.0, 5.0, 0.0]}
END = 90


def context(estimator, craft, formation, **mission):
    """What an estimator aboard a craft is built from: legs of 30 m and half circles of 31 m."""
    mission = {"legs": 3, "leg_length_m": 30.0, "turn_radius_m": 10.0} | mission
    scenario = decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation, **mission},
            "craft": {name: {} for name in formation},
            "team": {"estimator": estimator},
        }
    )
    return TeamContext(craft, plan_mission(scenario), scenario, load_controller(scenario.team))


def aboard(estimator, craft="auv1", formation=TEAM, **mission):
    """Build an estimator aboard a craft."""
    return load_estimator(context(estimator, craft, formation, **mission))


PLANS = context("none", "auv1", TEAM).plan.craft


def said(craft, t_s, progress, speed_mps=1.0):
    """What a craft on its plan says."""
    number = min(int(progress), 4)
    north, east = PLANS[craft].point(progress)
    theta = progress - number
    return TeamState(list(TEAM).index(craft), t_s, north, east, 0.0, speed_mps, 0.0, number, theta, 0.1)


@st.composite
def reports(draw):
    """(report, delay): near the plan, at whole seconds, up to 28 s late."""
    moments = draw(st.lists(st.tuples(st.integers(1, 60), st.sampled_from(["auv2", "auv3"])), unique=True, max_size=6))
    made = []
    for t_s, craft in moments:
        progress = t_s / 30.5 * draw(st.floats(0.8, 1.2))
        state = said(craft, float(t_s), progress, draw(st.floats(0.5, 1.5)))
        made.append((Report(craft, state), draw(st.integers(0, 28))))
    return made


def run(estimator, arrivals, until_s=END):
    """Step aboard auv1 every second, with what arrives at that second; return the last beliefs."""
    team = aboard(estimator)
    for now in range(1, until_s + 1):
        heard = [report for report, at in arrivals if at == now]
        beliefs = team.step(float(now), Own(now, 0.0, now / 30.5 + 0.05 * math.sin(now)), [], heard)
    return beliefs


def assert_same(one, other):
    """Hold beliefs against each other."""
    for a, b in zip(one, other, strict=True):
        assert (a.craft, a.age_s) == (b.craft, b.age_s)
        numbers = (a.north_m, a.east_m, a.progress, a.sigma_m), (b.north_m, b.east_m, b.progress, b.sigma_m)
        assert numbers[0] == pytest.approx(numbers[1], abs=1e-9)


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=25)
@given(st.data())
def test_any_order_of_arrival(model, data):
    """Messages that arrive together give the same, in whatever order they are worked in."""
    made = [(report, 89) for report, _ in data.draw(reports())]
    shuffled = data.draw(st.permutations(made))
    assert_same(run(model, shuffled), run(model, made))


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=25)
@given(st.data())
def test_late_is_as_if_in_time(model, data):
    """For one mate alone, however late its messages come, the filter ends where one ends that had each in time."""
    made = [(report, delay) for report, delay in data.draw(reports()) if report.craft == "auv2"]

    def alone(arrivals):
        team = aboard(model, "auv1", {craft: TEAM[craft] for craft in ("auv1", "auv2")})
        for now in range(1, END + 1):
            heard = [report for report, at in arrivals if at == now]
            beliefs = team.step(float(now), Own(now, 0.0, now / 30.5 + 0.05 * math.sin(now)), [], heard)
        return beliefs

    late = alone([(report, round(report.state.t_s) + delay) for report, delay in made])
    assert_same(late, alone([(report, round(report.state.t_s)) for report, _ in made]))


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=25)
@given(st.data())
def test_without_delay_it_is_the_plain_filter(model, data):
    """Messages that come at once, none lost, give what a filter without any history gives: predict, update, predict."""
    pair = {craft: TEAM[craft] for craft in ("auv1", "auv2")}
    heard = {report.state.t_s: report.state for report, _ in data.draw(reports()) if report.craft == "auv2"}
    made = context(model, "auv1", pair)
    team = load_estimator(made)
    by_model = OneByOneFirst(made) if model == "along_track_first" else team
    plain = by_model.model(made, made.plan.craft["auv2"])
    state, driven = plain.start(), ()
    for now in range(1, END + 1):
        own = Own(now, 0.0, now / 30.5 + 0.05 * math.sin(now))
        said_now = [Report("auv2", heard[now])] if now in heard else []
        (belief,) = team.step(float(now), own, [], said_now)
        state = plain.predict(state, driven, 1.0)
        if now in heard:
            state = plain.update(state, heard[now])
        driven = (own.progress,)
    north, east, sigma = plain.position(state)
    believed = belief.north_m, belief.east_m, belief.sigma_m, belief.progress
    assert believed == pytest.approx((north, east, sigma, plain.progress(state)), abs=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_order_of_the_team_is_no_matter(estimator):
    """A team that is named in another order believes the same of each."""
    made = [Report("auv2", said("auv2", 20.0, 0.61, 0.9)), Report("auv3", said("auv3", 30.0, 1.05, 1.2))]

    def run_in(order):
        team = aboard(estimator, "auv1", {craft: TEAM[craft] for craft in order})
        for now in range(1, END + 1):
            heard = [report for report in made if report.state.t_s + 10.0 == now]
            sent = [said("auv1", 10.0, 0.4)] if now == 20 else []
            beliefs = team.step(float(now), Own(now, 0.0, now / 30.5), sent, heard)
        return sorted(beliefs, key=lambda belief: belief.craft)

    assert_same(run_in(["auv1", "auv2", "auv3"]), run_in(["auv3", "auv1", "auv2"]))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_an_hour_of_silence(estimator):
    """A mate silent for an hour is believed in with growing sigma, and hears itself where it is on return: no jump."""
    team = aboard(estimator, "auv1", TEAM, leg_length_m=5000.0, legs=1)
    planned = 5000.0
    sigmas, north_m = [], TEAM["auv2"][0]
    for now in range(1, 3802):
        heard = []
        if now in {100, 3700}:
            progress = now / planned
            ahead, starboard, _ = TEAM["auv2"]
            state = TeamState(1, float(now), now + ahead, starboard, 0.0, 1.0, 0.0, 0, progress, 0.1)
            heard = [Report("auv2", state)]
        # The third craft goes on being heard.
        if now % 30 == 0:
            ahead, starboard, _ = TEAM["auv3"]
            state = TeamState(2, float(now), now + ahead, starboard, 0.0, 1.0, 0.0, 0, now / planned, 0.1)
            heard.append(Report("auv3", state))
        mate, _ = team.step(float(now), Own(now, 0.0, now / planned), [], heard)
        if 110 <= now < 3700 and now % 300 == 0:
            sigmas.append(mate.sigma_m)
        # The last position stands still until there is another; all others glide, whatever comes and however late.
        assert estimator == "hold_last" or abs(mate.north_m - north_m) < 2.0
        north_m = mate.north_m
        assert mate.sigma_m > 0.0
    assert sigmas == sorted(sigmas)
    # The control law brings a mate back: its uncertainty may level off, and is greater than just after a message.
    assert sigmas[-1] > 1.5 * sigmas[0] or sigmas[-1] > 0.3
    assert mate.age_s == 101.0
    assert mate.north_m == pytest.approx(-6.0 + (3700.0 if estimator == "hold_last" else 3801.0), abs=3.0)


@pytest.mark.parametrize(
    "loss", [pytest.param(0.0, marks=pytest.mark.slow), 0.3, pytest.param(0.5, marks=pytest.mark.slow)]
)
def test_along_track_is_consistent(loss):
    """When a mate's speed error wanders as modelled, errors are as great as is claimed (NEES in its 95 % band)."""
    runs, draw = 100, np.random.default_rng(2008)
    errors = [_normalised_error(draw, loss) for _ in range(runs)]
    # χ² with 100 degrees of freedom: 95 % lie between 74.2 and 129.6.
    assert 74.2 < sum(errors) < 129.6


def _normalised_error(draw, loss):
    """Squared error over variance of one mate after 300 s; it speaks every 30 s, 10 s late."""
    formation = {"auv1": [0.0, 0.0, 0.0], "auv2": [0.0, 20.0, 0.0]}
    made = context("along_track_first", "auv1", formation, leg_length_m=5000.0, legs=1)
    team, law = load_estimator(made), ThetaP(made.scenario.team)
    model = made.scenario.team.speed_model
    keep = math.exp(-1.0 / model.error_time_s)
    gain = 1.0 - math.exp(-1.0 / model.lag_s)
    error = model.error_relative * draw.normal()
    distance, speed, log = 0.1 * draw.normal(), 1.0 + model.told_sigma_mps * draw.normal(), {}
    for now in range(1, 301):
        ordered = law.speed(1.0, distance / 5000.0, [(now - 1) / 5000.0])
        faster = speed + gain * ((1.0 + error) * ordered - speed) + model.noise_mps * draw.normal()
        distance, speed = distance + (speed + faster) / 2.0, faster
        error = keep * error + model.error_relative * math.sqrt(1.0 - keep * keep) * draw.normal()
        told, told_speed = distance + 0.1 * draw.normal(), speed + model.told_sigma_mps * draw.normal()
        theta = round(told / 5000.0 * 4095) / 4095
        log[now] = TeamState(1, float(now), told, 20.0, 0.0, told_speed, 0.0, 0, theta, 0.1)
        heard = [Report("auv2", log[now - 10])] if now % 30 == 20 and draw.random() >= loss else []
        (mate,) = team.step(float(now), Own(now, 0.0, now / 5000.0), [], heard)
    return ((mate.progress * 5000.0 - distance) / mate.sigma_m) ** 2
