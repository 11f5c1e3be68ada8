"""What a step of the along-track estimator costs, counted in calls: the same on every machine."""

import sys
from collections.abc import Callable

import pytest

from grex_agent.coordination import load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link.scenario import decode
from grex_link.wire import TeamState


def steps(estimator: str, mates: int) -> Callable[[int], object]:
    """Steps of a second of an estimator aboard the first of a line, with so many messages."""
    formation = {f"auv{n}": [-2.0 * n, 0.5 * n, 0.0] for n in range(mates + 1)}
    scenario = decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation, "leg_length_m": 4000.0},
            "craft": {craft: {} for craft in formation},
            "team": {"estimator": estimator},
        }
    )
    team = load_estimator(TeamContext("auv0", plan_mission(scenario), scenario, load_controller(scenario.team)))
    now = 0.0

    def step(messages: int) -> object:
        nonlocal now
        now += 1.0
        state = TeamState(1, now - 10.0, now - 12.0, 0.5, 0.0, 1.0, 0.0, 0, (now - 10.0) / 4000.0, 0.1)
        return team.step(now, Own(now, 0.0, now / 4000.0), [], [Report("auv1", state)] * messages)

    return step


def calls(work: Callable[[], object]) -> int:
    """Count the calls of functions, of Python and of C, that some work makes."""
    count = 0

    def on_event(frame: object, event: str, argument: object) -> None:
        nonlocal count
        del frame, argument
        count += event in {"call", "c_call"}

    before = sys.getprofile()
    sys.setprofile(on_event)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def cost(estimator: str, mates: int, messages: int) -> int:
    """Calls of the 31st step; the 30th is like it, so that the memory is as full as it will be."""
    step = steps(estimator, mates)
    for _ in range(29):
        step(0)
    step(messages)
    return calls(lambda: step(messages))


@pytest.mark.parametrize("messages", [0, 1])
@pytest.mark.parametrize("estimator", ["along_track", "along_track_first"])
def test_a_step_costs_the_same_for_any_number_of_mates(estimator, messages):
    """Between 3 and 50 mates a step grows by less than 2 % for each mate, with a message 10 s late or without."""
    few, some, many = (cost(estimator, mates, messages) for mates in (3, 10, 50))
    assert few > 10
    assert some - few <= 7 * 0.02 * few
    assert many - some <= 40 * 0.02 * few
