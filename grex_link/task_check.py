"""What a scenario says of who is in the formation, who stands by, and what they are to do: names and sense."""

from grex_link.config import Lawnmower, Scenario
from grex_link.errors import ConfigError
from grex_link.tasks import Hold, Surface


def check_tasks(scenario: Scenario) -> None:
    """Check what needs neither geometry nor modem.

    Raises
    ------
    ConfigError
        For a craft with two parts or none, an unknown craft, events nobody is on call for, tasks after an endless one.
    """
    _check_parts(scenario)
    for number, event in enumerate(scenario.events):
        _check_craft(scenario, event.seen_by, f"$.events[{number}].seen_by")
    if scenario.tasking.operator is not None:
        _check_craft(scenario, scenario.tasking.operator, "$.tasking.operator")
    if scenario.events and not any(standby.on_call for standby in scenario.standby.values()):
        raise ConfigError("$.events", "nobody would come: no craft in [standby] is on call")
    for craft, config in scenario.craft.items():
        for number, task in enumerate(config.tasks[:-1]):
            if isinstance(task, Hold | Surface) and not task.for_s:
                raise ConfigError(
                    f"$.craft.{craft}.tasks[{number}].for_s", "0 is for ever, but more tasks follow; give it a time"
                )
    for number, land in enumerate(scenario.link.land):
        if land.length_m is not None and land.kind != "cable":
            raise ConfigError(f"$.link.land[{number}].length_m", f"a {land.kind} has no length; say kind = 'cable'")


def _check_parts(scenario: Scenario) -> None:
    mission = scenario.mission
    table = "formation_m" if isinstance(mission, Lawnmower) else "craft"
    planned = mission.formation_m if isinstance(mission, Lawnmower) else mission.craft
    for path, names in ((f"$.mission.{table}", planned), ("$.standby", scenario.standby)):
        for craft in names:
            _check_craft(scenario, craft, f"{path}.{craft}", "")
    for craft in scenario.bases:
        for path, names in ((f"$.mission.{table}", planned), ("$.standby", scenario.standby)):
            if craft in names:
                raise ConfigError(f"{path}.{craft}", "is a base, which has no part in the mission")
    for craft in [craft for craft in scenario.craft if craft not in scenario.bases]:
        if craft in planned and craft in scenario.standby:
            raise ConfigError(f"$.standby.{craft}", f"has a part in the mission, $.mission.{table}; it cannot stand by")
        if craft not in planned and craft not in scenario.standby:
            raise ConfigError(
                f"$.mission.{table}.{craft}",
                "is missing: every craft needs its part in the mission, or its place in [standby]",
            )
    if not planned:
        raise ConfigError(f"$.mission.{table}", "is empty: at least one craft needs its part in the mission")


def _check_craft(scenario: Scenario, craft: str, path: str, name: str | None = None) -> None:
    if craft not in scenario.craft:
        called = f" {craft!r}" if name is None else name
        raise ConfigError(path, f"unknown craft{called}; there are {', '.join(scenario.craft)}")
