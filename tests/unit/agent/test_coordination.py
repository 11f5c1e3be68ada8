"""Coordination: eqs. (2) and (3), and controllers by name."""

import pytest

from grex_agent.coordination import ThetaP, load_controller, quality
from grex_link.config import TeamConfig
from grex_link.errors import ConfigError


@pytest.mark.parametrize(
    ("own", "mates", "speed"),
    [
        (2.5, [2.6, 2.45], 1.0 + 0.8 * 0.05),
        (2.5, [2.4, 2.45], 1.0 - 0.8 * 0.15),
        (2.5, [], 1.0),
        (2.5, [2.5], 1.0),
        (0.95, [1.05], 1.08),
        (0.0, [9.0], 3.0),
        (9.0, [0.0, 0.0], 0.3),
    ],
)
def test_eq_2_by_hand(own, mates, speed):
    """Eq. (2): v = v' + K Σ (Θ_i − Θ_m) with K = 0.8 m/s, 0.3 … 3 m/s; no jump where one changes track."""
    assert ThetaP(TeamConfig()).speed(1.0, own, mates) == pytest.approx(speed, abs=1e-12)


def test_gain_and_limits_are_the_scenarios():
    """K, v_min and v_max come from the scenario."""
    controller = ThetaP(TeamConfig(gain_mps=2.0, speed_min_mps=0.5, speed_max_mps=1.5))
    assert controller.speed(1.0, 0.0, [0.1]) == pytest.approx(1.2)
    assert controller.speed(1.0, 0.0, [1.0]) == 1.5
    assert controller.speed(1.0, 1.0, [0.0]) == 0.5


def test_eq_3_by_hand():
    """Q = Σ (Θ_i − Θ_m): positive for a craft that is behind, zero for one that is alone."""
    assert quality(2.5, [2.6, 2.45]) == pytest.approx(0.05)
    assert quality(1.0, [0.9, 0.9]) == pytest.approx(-0.2)
    assert quality(1.0, []) == 0.0


class Crawl:
    """A user's controller: half the planned speed, whatever the others do."""

    def __init__(self, config):
        self.config = config

    def speed(self, planned_mps, own, mates):
        return planned_mps / 2.0


def test_controller_by_name():
    """``theta_p`` is the paper's law; an import path brings the user's own, built with the team's table."""
    assert isinstance(load_controller(TeamConfig()), ThetaP)
    config = TeamConfig(controller=f"{__name__}:Crawl")
    controller = load_controller(config)
    assert controller.speed(1.0, 0.0, []) == 0.5
    assert controller.config is config


def test_unknown_controller():
    """A controller that is not known is refused with the path of the fault and the names there are."""
    words = r"^\$\.team\.controller: 'fuzzy' is not one of theta_p, .*shared_reference, nor"
    with pytest.raises(ConfigError, match=words):
        load_controller(TeamConfig(controller="fuzzy"))
