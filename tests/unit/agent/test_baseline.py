"""The two ends of the scale, and estimators by name."""

import pytest

from grex_agent.coordination import load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.baseline import Ideal, Unaware
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator, needs_oracle
from grex_agent.team.planar import FirstLevel, SecondLevel
from grex_link.errors import ConfigError
from grex_link.messages import MateBelief, Pose, Truth
from grex_link.scenario import decode
from grex_link.wire import TeamState


def scenario(estimator):
    """Two craft abreast on a lawnmower."""
    formation = {"auv1": [0.0, 0.0, 0.0], "auv2": [0.0, 20.0, 0.0]}
    return decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation, "leg_length_m": 100.0},
            "craft": {name: {} for name in formation},
            "team": {"estimator": estimator},
        }
    )


def context(estimator, craft="auv1"):
    """What an estimator aboard a craft is built from."""
    config = scenario(estimator)
    return TeamContext(craft, plan_mission(config), config, load_controller(config.team))


def pose(craft, north_m, east_m):
    """A true pose on course north."""
    return Pose(craft, north_m, east_m, 0.0, 0.0, 0.0, 0.0, 1.0)


def test_none_believes_nothing():
    """Case a believes nothing, whatever it hears."""
    report = Report("auv2", TeamState(1, 2.0, 5.0, 20.0, 0.0, 1.0, 0.0, 0, 0.05, 0.1))
    assert load_estimator(context("none")).step(12.0, Own(0.0, 0.0, 0.0), [report.state], [report]) == []


def test_ideal_believes_the_truth():
    """Case b believes the true place and progress of every mate, without age or doubt."""
    ideal = load_estimator(context("ideal"))
    assert ideal.step(11.0, Own(0.0, 0.0, 0.0), [], []) == []
    ideal.see(Truth(12, 12_000_000_000, [pose("auv1", 12.0, 0.0), pose("auv2", 37.0, 21.0)]))
    assert ideal.step(12.0, Own(0.0, 0.0, 0.0), [], []) == [
        MateBelief("auv2", 37.0, 21.0, pytest.approx(0.37), sigma_m=0.0, age_s=0.0)
    ]


def test_ideal_follows_the_mates_tracks():
    """Case b counts the mates' tracks as they do."""
    ideal = load_estimator(context("ideal", "auv2"))
    for north_m in (50.0, 99.0, 101.0):
        ideal.see(Truth(1, 1, [pose("auv1", north_m, 0.0), pose("auv2", north_m, 20.0)]))
    (belief,) = ideal.step(12.0, Own(0.0, 0.0, 0.0), [], [])
    assert (belief.craft, int(belief.progress)) == ("auv1", 1)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("none", Unaware), ("ideal", Ideal), ("first_level", FirstLevel), ("second_level", SecondLevel)],
)
def test_known_estimators(name, kind):
    """The scenario's names stand for the paper's cases; only the ideal one is given the truth."""
    assert type(load_estimator(context(name))) is kind
    assert needs_oracle(scenario(name)) is (name == "ideal")


class Mine:
    """A user's estimator."""

    def __init__(self, built_from):
        self.built_from = built_from

    def step(self, now_s, own, sent, heard):
        return []


class NotOne:
    """A class that is no estimator."""

    def __init__(self, built_from):
        pass


def test_users_estimator():
    """An estimator of the user's own is found by its import path and built from the team's context."""
    given = context(f"{__name__}:Mine")
    estimator = load_estimator(given)
    assert isinstance(estimator, Mine)
    assert estimator.built_from is given


@pytest.mark.parametrize(
    ("name", "problem"),
    [(f"{__name__}:NotOne", "has no method 'step'"), ("psychic", "is not one of none, ideal, hold_last")],
)
def test_no_estimator(name, problem):
    """What is no estimator is refused with the path of the fault."""
    with pytest.raises(ConfigError) as caught:
        load_estimator(context(name))
    assert caught.value.path == "$.team.estimator"
    assert problem in caught.value.problem
