"""``grex task``: an operator's order from the command line; what is heavy is imported when it is given."""

from typing import Annotated, Literal

import tyro

from grex_link.console import Overrides, ScenarioFile

Kind = Literal["goto", "follow", "hold", "inspect", "surface", "return"]
At = Annotated[str | None, tyro.conf.arg(metavar="N,E[,D]")]
Seconds = Annotated[float | None, tyro.conf.arg(name="for", metavar="S")]
Metres = Annotated[float | None, tyro.conf.arg(metavar="M")]
Speed = Annotated[float | None, tyro.conf.arg(metavar="M/S")]
Number = Annotated[int | None, tyro.conf.arg(metavar="NUMBER")]


def task(
    scenario: ScenarioFile,
    what: Annotated[Kind, tyro.conf.Positional],
    craft: Annotated[str, tyro.conf.arg(metavar="NAME")],
    at: At = None,
    lasting: Seconds = None,
    radius: Metres = None,
    shape: Literal["circle", "box"] | None = None,
    speed: Speed = None,
    then: Literal["return", "surface", "hold"] | None = None,
    track: Number = None,
    wait: Annotated[float, tyro.conf.arg(metavar="S")] = 3600.0,
    overrides: Overrides = (),
) -> None:
    """Order a craft of a run on the bus to do a task, and say what becomes of it, until it is done.

    The order goes to the craft the operator is on (tasking.operator), which sends it on by sound, or by cable or radio.

    Parameters
    ----------
    scenario
        The scenario file of the run.
    what
        Go to a place; follow the plan from a track; hold; inspect a place; surface; return to the formation or place.
    craft
        Who shall do it.
    at
        goto, inspect: north, east and depth, metres; without a depth it is that at which the craft began.
    lasting
        hold, inspect, surface: how long; 0 for ever (not inspect).
    radius
        inspect: of the circle, or half the side of the box.
    shape
        inspect: which.
    speed
        On the way and in the survey.
    then
        inspect: what follows.
    track
        follow: from which on.
    wait
        Wall seconds to wait for its end.
    overrides
        The same as those of the run, where they matter: bus.endpoints, team.name.
    """
    from grex_link.errors import ConfigError
    from grex_link.scenario import load
    from grex_sim.operator import give_order
    from grex_sim.task_words import build_task

    config = load(scenario, overrides)
    if craft not in config.craft:
        raise ConfigError("--craft", f"unknown craft {craft!r}; there are {', '.join(config.craft)}")
    given = {"at": at, "for": lasting, "radius": radius, "shape": shape, "speed": speed, "then": then, "track": track}
    order = build_task(config, craft, what, {option: value for option, value in given.items() if value is not None})
    give_order(config, craft, order, wait, lambda line: print(line, flush=True))  # noqa: T201
