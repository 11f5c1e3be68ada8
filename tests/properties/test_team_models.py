"""Every model of a mate: messages may come when they like, and silence makes unsure."""

import math
from functools import cache

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


LEG_M, LAST_S, BACK_S = 5000.0, 100, 3700
#: The law these know brings a mate back, so that their sigma has a bound; that of all others has none.
BOUNDED = {"along_track", "along_track_first"}


@cache
def silent_for_an_hour(estimator, back_m=None):
    """Beliefs of auv2, by second: it says where it is at 100 s and, if at all, `back_m` ahead of its plan at 3700 s."""
    team, beliefs = aboard(estimator, "auv1", TEAM, leg_length_m=LEG_M, legs=1), {}

    def heard_of(craft, now, more_m=0.0):
        ahead, starboard, _ = TEAM[craft]
        far, number = now + more_m, list(TEAM).index(craft)
        return Report(craft, TeamState(number, now, far + ahead, starboard, 0.0, 1.0, 0.0, 0, far / LEG_M, 0.1))

    for now in range(1, BACK_S + 31):
        heard = [heard_of("auv3", float(now))] if now % 30 == 0 else []
        heard += [heard_of("auv2", float(now))] if now == LAST_S else []
        heard += [heard_of("auv2", float(now), back_m)] if now == BACK_S and back_m is not None else []
        beliefs[now], _ = team.step(float(now), Own(now, 0.0, now / LEG_M), [], heard)
    return beliefs


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_in_an_hour_of_silence_sigma_grows(estimator):
    """From minute to minute of silence sigma grows, to many times what it was; ever slower where it has a bound."""
    beliefs = silent_for_an_hour(estimator)
    sigmas = [beliefs[now].sigma_m for now in range(LAST_S, BACK_S + 1, 60)]
    growth = np.diff(sigmas)
    assert (growth > 1e-3).all()
    assert sigmas[-1] > 10.0 * sigmas[0]
    if estimator in BOUNDED:
        assert growth[-1] < 0.7 * growth.max()
    assert beliefs[BACK_S].age_s == BACK_S - LAST_S
    # Whoever does not stand still goes on with the plan meanwhile, and nothing makes it jump.
    steps = np.diff([belief.north_m for now, belief in beliefs.items() if now > LAST_S])
    assert np.abs(steps - (0.0 if estimator == "hold_last" else 1.0)).max() < 0.05


@pytest.mark.parametrize("sigmas", [0.0, -2.0])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_on_return_it_moves_by_what_it_learns(estimator, sigmas):
    """A mate comes back as far off as was claimed: belief moves by gain times innovation, at once to the place told."""
    before = silent_for_an_hour(estimator)[BACK_S]
    # What stands still is off by the way made meanwhile; all others by so many sigmas.
    standing_m = BACK_S - LAST_S if estimator == "hold_last" else 0.0
    back_m = (0.0 if standing_m else sigmas) * before.sigma_m
    beliefs = silent_for_an_hour(estimator, back_m)
    after, told_m = beliefs[BACK_S], BACK_S + TEAM["auv2"][0] + back_m
    innovation_m = told_m - before.north_m
    assert innovation_m == pytest.approx(back_m + standing_m, abs=1e-6 * LEG_M)
    # Variance after an update: P·R / (P + R); so the gain P / (P + R) is 1 - after / before.
    gain = 1.0 - (after.sigma_m / before.sigma_m) ** 2
    assert 0.98 < gain < 1.0
    assert after.north_m - before.north_m == pytest.approx(gain * innovation_m, abs=0.05)
    assert abs(after.north_m - told_m) < after.sigma_m
    assert after.sigma_m < 0.4
    assert after.age_s == 0.0
    # From there it glides on, with a speed that the hour's error has changed a little.
    steps = np.diff([beliefs[now].north_m for now in range(BACK_S, BACK_S + 31)])
    assert np.abs(steps - (0.0 if standing_m else 1.0)).max() < 0.1


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
