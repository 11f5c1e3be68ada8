"""Tasks, events and cables of a scenario as a text for a person: a part of what ``grex check`` prints."""

import math
from collections.abc import Iterator

from grex_agent.mission import TeamPlan, pair_range_max_m
from grex_agent.tasks.check import cables
from grex_link.config import Scenario
from grex_link.task_wire import ECHO_BYTES, ORDER_BYTES
from grex_link.tasks import Task, type_of
from grex_sim.layout import entry


def tasking(scenario: Scenario, plan: TeamPlan) -> Iterator[str]:
    """Say who is in the formation, who stands by, what there is to do, and how far cables reach.

    Nothing for a scenario in which all are in the formation and nobody has a task.
    """
    if plan.standby:
        yield from entry("Formation", f"{', '.join(plan.craft)}: they wait for each other, and are scored")
    for craft in plan.standby:
        config = scenario.standby[craft]
        call = "on call" if config.on_call else "not on call"
        yield from entry("Stands by", f"{craft} at {_place(config.at_ned_m)}, {call}")
    for craft, each in scenario.craft.items():
        if each.tasks:
            yield from entry("Tasks", f"{craft}: {'; '.join(map(_words, each.tasks))}")
    for number, event in enumerate(scenario.events):
        nearest = _nearest(scenario, plan, event.at_ned_m)
        who = f"nearest on call, if all are at their places: {nearest}"
        yield from entry(
            "Event", f"event{number} at {event.at_s:g} s, seen by {event.seen_by}: {_words(event.task)}; {who}"
        )
    if scenario.events or plan.standby:
        yield from entry(
            "Orders",
            f"{ORDER_BYTES} bytes, echoed in {ECHO_BYTES}; sent up to {scenario.tasking.tries} times; "
            f"`grex task` is typed on {scenario.operators_craft}",
        )
    for _, first, second, length_m in cables(scenario):
        planned_m = pair_range_max_m(plan, first, second)
        yield from entry("Cable", f"{first} and {second}: {length_m:g} m, at most {planned_m:.1f} m apart by the plan")


def _nearest(scenario: Scenario, plan: TeamPlan, at_ned_m: tuple[float, float, float]) -> str:
    on_call = [craft for craft in plan.standby if scenario.standby[craft].on_call]
    return min(on_call, key=lambda craft: (math.dist(scenario.standby[craft].at_ned_m[:2], at_ned_m[:2]), craft))


def _words(task: Task) -> str:
    """Say a task in a few words."""
    fields = {name: getattr(task, name) for name in task.__struct_fields__}
    words = [type_of(task)]
    if "at_ned_m" in fields:
        words.append(_place(fields["at_ned_m"]))
    if "track" in fields:
        words.append(f"track {fields['track']}")
    if "for_s" in fields:
        words.append(f"for {fields['for_s']:g} s" if fields["for_s"] else "until told otherwise")
    if "shape" in fields:
        words.append(f"{fields['shape']} of {fields['radius_m']:g} m, then {fields['then']}")
    return ", ".join(words)


def _place(at_ned_m: tuple[float, float, float]) -> str:
    north, east, depth = at_ned_m
    return f"north {north:g} m, east {east:g} m, depth {depth:g} m"
