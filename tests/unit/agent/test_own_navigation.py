"""What a craft removes of its own order: the current nobody knows, and its own speed error."""

import math

import msgspec
import pytest
from core_steps import scenario

from grex_agent.coordination import check_unbiased, load_controller
from grex_agent.core import AgentCore
from grex_agent.own_navigation import OwnNavigation
from grex_link.errors import ConfigError
from grex_link.messages import Fix, Setpoint

NS = 1_000_000_000


def sailed(controller="theta_p_unbiased", seconds=600, error=0.0, current=(0.0, 0.0), known=(0.0, 0.0), **team):
    """Let an own filter see a craft that makes (1 + error) of the speed through the water, on turning courses."""
    sea = {"current_ned_mps": [*current, 0.0], "known_current_ned_mps": [*known, 0.0]}
    given = {"controller": controller, "own_filter": {}} | team
    navigation = OwnNavigation(scenario(team=given, sea=sea), "auv1")
    north = east = 0.0
    for second in range(seconds):
        course = 0.0 if second % 200 < 100 else 1.5
        fix = Fix(second, second * NS, north, east, 0.0, course, 1.0 + error, 0.1)
        navigation.filtered(float(second), fix, lost=False)
        order = Setpoint(second, second * NS, "steer", course, 1.0, 0.0)
        # The craft is ordered 1 m/s through the water: the order over ground has the known current in it.
        over_ground = math.cos(course) + known[0], math.sin(course) + known[1]
        navigation.ordered(msgspec.structs.replace(order, course_rad=math.atan2(over_ground[1], over_ground[0]),
                                                   speed_mps=math.hypot(*over_ground)))  # fmt: skip
        north += (1.0 + error) * math.cos(course) + current[0]
        east += (1.0 + error) * math.sin(course) + current[1]
    return navigation


def corrected(navigation, course=0.0, speed=1.0, mode="steer", health=None):
    """Return what becomes of an order: course and speed over ground."""
    setpoint = navigation.corrected(Setpoint(0, 0, mode, course, speed, 0.0), [] if health is None else health)
    return setpoint.course_rad, setpoint.speed_mps


def test_the_own_speed_error_is_removed():
    """A craft that makes 5 % more is ordered 5 % less, and by a law that removes nothing just what the law says."""
    assert corrected(sailed(error=0.05))[1] == pytest.approx(1.0 / 1.05, abs=0.01)
    assert corrected(sailed("theta_p", error=0.05)) == pytest.approx((0.0, 1.0), abs=0.01)


def test_an_unknown_current_is_removed_whatever_the_law():
    """In an unknown current the order is that through the water which makes the wanted course and speed over ground."""
    for controller in ("theta_p", "theta_p_unbiased"):
        course, speed = corrected(sailed(controller, current=(0.15, 0.1)))
        assert (speed * math.cos(course), speed * math.sin(course)) == pytest.approx((0.85, -0.1), abs=0.01)


def test_a_known_current_is_left_to_the_frontseat():
    """What the frontseat compensates is not compensated twice."""
    assert corrected(sailed(current=(0.15, 0.1), known=(0.15, 0.1)), 0.7) == pytest.approx((0.7, 1.0), abs=0.01)


def test_only_so_much_is_removed():
    """An error of 30 % is removed up to bias_max_relative; the law's feedback does the rest."""
    navigation = sailed(error=-0.3, bias_max_relative=0.1)
    assert navigation.speed_error == pytest.approx(-0.1)
    assert corrected(navigation)[1] == pytest.approx(1.0 / 0.9, abs=0.01)


def test_what_comes_out_keeps_the_limits():
    """The order that goes out is within the speeds a controller may order, whatever is estimated."""
    navigation = sailed(error=-0.1, speed_max_mps=1.0, speed_min_mps=0.5)
    assert corrected(navigation)[1] == 1.0
    assert corrected(navigation, speed=0.1)[1] == 0.5


@pytest.mark.parametrize(("ahead", "words"), [(-0.4, ["speed_limited"]), (0.0, []), (0.7, ["speed_limited"])])
def test_limits_that_are_met_are_told(ahead, words):
    """A current that would take more speed than a craft may be ordered, or less, is a word of health, and said once."""
    navigation, health = sailed(current=(ahead, 0.0), speed_max_mps=1.2, speed_min_mps=0.5), []
    limited = corrected(navigation, health=health)[1]
    assert health == words
    assert limited == pytest.approx({-0.4: 1.2, 0.0: 1.0, 0.7: 0.5}[ahead], abs=0.01)
    corrected(navigation, health=health)
    assert health == words


def test_the_state_tells_that_the_limits_are_met():
    """In an unknown current of 0.8 m/s against it an agent that may be ordered 1.5 m/s says ``speed_limited``."""
    assert steered(against_mps=0.8).health == ["speed_limited"]
    assert steered(against_mps=0.0).health == []


def steered(against_mps):
    """Last state of an agent that goes where it is ordered, with a current to the south that nobody knows."""
    team = {"own_filter": {"speed_sigma_mps": 0.05}, "speed_max_mps": 1.5}
    core, north, order = AgentCore(scenario("none", team=team), "auv1"), 0.0, 0.0
    for now in range(60):
        core.on_fix(Fix(now, now * NS, north, 0.0, 0.0, 0.0, order, 0.1))
        out = dict(core.step(now, now * NS))
        order = out["setpoint"].speed_mps
        north += order - against_mps
    return out["state"]


def test_holding_is_left_alone():
    """A craft that holds, or stands at its place, is not set in motion by a correction."""
    navigation = sailed(error=0.05, current=(0.1, 0.1))
    assert corrected(navigation, speed=0.0, mode="hold") == (0.0, 0.0)
    assert corrected(navigation, 1.0, 0.0) == (1.0, 0.0)


def test_without_a_filter_nothing_is_corrected():
    """Fixes as they are, orders as they are."""
    navigation = OwnNavigation(scenario(), "auv1")
    assert corrected(navigation, 1.2, 0.9) == (1.2, 0.9)


@pytest.mark.parametrize("controller", ["theta_p_unbiased", "shared_reference"])
def test_a_law_that_removes_needs_an_estimate(controller):
    """Without the own filter such a law is refused, in one line that says what to add."""
    with pytest.raises(ConfigError, match=r"\$\.team\.own_filter: is missing: .* add \[team\.own_filter\]"):
        AgentCore(scenario("none", team={"controller": controller}), "auv1")


def test_the_unbiased_law_is_the_same_law():
    """What it orders is what eq. (2) orders: the mates' models of it hold."""
    config = scenario(team={"controller": "theta_p_unbiased", "own_filter": {}}).team
    check_unbiased(config)
    plain = scenario().team
    assert load_controller(config).speed(1.0, 0.5, [0.6]) == load_controller(plain).speed(1.0, 0.5, [0.6])


def test_the_shared_reference_needs_no_estimator():
    """An estimator beside the shared reference is refused: it would be of no effect."""
    with pytest.raises(ConfigError, match=r"\$\.team\.estimator: .*'none'"):
        AgentCore(scenario("along_track", team={"controller": "shared_reference", "own_filter": {}}), "auv1")


def test_a_word_too_long_for_the_modem():
    """A modem that cannot carry the word of so large a team is refused, with what would do."""
    with pytest.raises(ConfigError, match=r"\$\.team\.controller: .* tells 9 bytes .*theta_p"):
        AgentCore(scenario("none", team={"controller": "shared_reference", "own_filter": {}},
                           link={"profile": "janus"}), "auv1")  # fmt: skip
