"""Can the tasks, the events and the cables of a scenario work? What cannot is refused before anything starts."""

from collections.abc import Iterator

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan, pair_range_max_m
from grex_agent.modem.abilities import Abilities
from grex_agent.tasks.runner import TaskRunner
from grex_link.config import Scenario
from grex_link.errors import ConfigError, WireError
from grex_link.profile import ModemProfile
from grex_link.task_wire import ORDER_BYTES, Order, pack_order

#: What a refusal means, for a person.
WHY = {
    "speed": "the speed is outside the craft's limits",
    "radius": "the circle is too narrow for the craft at this speed",
    "depth": "the craft cannot go to this depth",
    "tracks": "the craft's plan has no such track",
    "cable": "the craft is tied to another one by cable",
    "no_fix": "the craft does not know where it is",
}


def check_task_plan(scenario: Scenario, plan: TeamPlan, profile: ModemProfile) -> None:
    """Refuse tasks and events that no craft could do, orders that the modem cannot carry, and cables too short.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    _check_cables(scenario, plan)
    runners = {
        craft: TaskRunner(scenario, craft, plan, ManoeuvreProcessor(each)) for craft, each in plan.everybody.items()
    }
    for craft, config in scenario.craft.items():
        for number, task in enumerate(config.tasks):
            if refusal := runners[craft].refusal(task, lost=False):
                raise ConfigError(f"$.craft.{craft}.tasks[{number}]", WHY[refusal])
    on_call = [runners[craft] for craft in plan.standby if scenario.standby[craft].on_call]
    for number, event in enumerate(scenario.events):
        try:
            pack_order(Order(0, 0, event.task))
        except WireError as error:
            raise ConfigError(f"$.events[{number}]", str(error)) from None
        refusals = [runner.refusal(event.task, lost=False) for runner in on_call]
        if all(refusals):
            raise ConfigError(f"$.events[{number}]", f"no craft on call can do it: {WHY[refusals[0]]}")
    if scenario.events:
        _check_modem(scenario, profile)


def _check_modem(scenario: Scenario, profile: ModemProfile) -> None:
    most = Abilities(profile, list(scenario.craft), 0).capabilities().message_max_bytes
    if most < ORDER_BYTES:
        raise ConfigError(
            "$.link.profile",
            f"{scenario.link.profile} carries {most} bytes at most, and an order to inspect an event has {ORDER_BYTES}",
        )


def _check_cables(scenario: Scenario, plan: TeamPlan) -> None:
    for number, first, second, length_m in cables(scenario):
        planned_m = pair_range_max_m(plan, first, second)
        if planned_m > length_m:
            raise ConfigError(
                f"$.link.land[{number}].length_m",
                f"{length_m:g} m is too short: {first} and {second} are planned to be {planned_m:.1f} m apart",
            )


def cables(scenario: Scenario) -> Iterator[tuple[int, str, str, float]]:
    """Yield number among the land links, both craft and length of the cables that have one."""
    for number, land in enumerate(scenario.link.land):
        if land.length_m is not None:
            yield number, *land.between, land.length_m
