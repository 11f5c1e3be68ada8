"""The guard of a cable: who waits, and when."""

import pytest
from task_bench import habitat

from grex_agent.cable import SHARE, CableGuard
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own
from grex_link.messages import MateBelief

#: top at the surface, low 10 m below, 15 m of cable.
SCENARIO = habitat()
PLAN = plan_mission(SCENARIO)


def taut(craft: str, ahead_m: float, progress: float, mates: float) -> bool:
    mate = "low" if craft == "top" else "top"
    belief = MateBelief(mate, 100.0, 0.0, mates, 0.0, 0.0)
    return CableGuard(SCENARIO, craft, PLAN).taut(Own(100.0 + ahead_m, 0.0, progress), [belief])


@pytest.mark.parametrize("craft", ["top", "low"])
def test_the_one_that_is_ahead_waits(craft):
    """Beyond nine tenths of the cable in three dimensions the one with more progress holds, the other goes on."""
    limit_m = ((SHARE * 15.0) ** 2 - 10.0**2) ** 0.5
    assert taut(craft, limit_m + 0.1, 0.6, 0.5)
    assert not taut(craft, limit_m - 0.1, 0.6, 0.5)
    assert not taut(craft, -limit_m - 0.1, 0.5, 0.6)


def test_one_of_two_always_goes_on():
    """At equal progress the first of the team waits, and only that one."""
    assert taut("top", 12.0, 0.5, 0.5)
    assert not taut("low", 12.0, 0.5, 0.5)


def test_others_are_not_tied():
    """A craft without a cable never waits for one, and nobody waits for a craft it is not tied to."""
    belief = MateBelief("aid", 900.0, 0.0, 0.0, 0.0, 0.0)
    assert not CableGuard(SCENARIO, "top", PLAN).taut(Own(0.0, 0.0, 1.0), [belief])
    assert not CableGuard(SCENARIO, "aid", PLAN).taut(Own(0.0, 0.0, 1.0), [belief])
