"""From the words of ``grex task`` to a task."""

import math
from typing import Any

import msgspec

from grex_agent.mission import plan_mission
from grex_link import task_wire
from grex_link.config import Scenario
from grex_link.errors import ConfigError, WireError
from grex_link.tasks import Task


def build_task(scenario: Scenario, craft: str, what: str, options: dict[str, Any]) -> Task:
    """Build a task of the options given.

    Raises
    ------
    ConfigError
        Names the option that is wrong, missing, or not one of this kind of task.
    """
    kind = next(each for each in task_wire.KINDS if each.__struct_config__.tag == what)
    fields = {"at": "at_ned_m", "for": "for_s", "radius": "radius_m", "speed": "speed_mps"}
    table: dict[str, Any] = {"type": what}
    for option, value in options.items():
        field = fields.get(option, option)
        if field not in kind.__struct_fields__:
            raise ConfigError(f"--{option}", f"{what} has no such thing")
        table[field] = _place(scenario, craft, value) if option == "at" else value
    if "at_ned_m" in kind.__struct_fields__ and "at" not in options:
        raise ConfigError("--at", f"is missing: {what} needs a place, north,east or north,east,depth")
    try:
        made: Task = msgspec.convert(table, Task)
        task_wire.pack_order(task_wire.Order(0, 0, made))
    except (msgspec.ValidationError, WireError) as error:
        raise ConfigError(what, str(error)) from None
    return made


def _place(scenario: Scenario, craft: str, text: str) -> tuple[float, float, float]:
    try:
        north, east, *depth = map(float, text.split(","))
    except ValueError:
        raise ConfigError("--at", f"{text!r} is not north,east or north,east,depth in metres") from None
    if len(depth) > 1 or not all(map(math.isfinite, (north, east, *depth))):
        raise ConfigError("--at", f"{text!r} is not north,east or north,east,depth in metres")
    return north, east, depth[0] if depth else plan_mission(scenario).everybody[craft].start_depth_m
