"""The agent's process: ``python -m grex_agent SCENARIO --craft NAME``, the same as ``grex agent``."""

import tyro

from grex_link.console import Overrides, ScenarioFile
from grex_link.process import run_process


def agent(scenario: ScenarioFile, craft: str, overrides: Overrides = ()) -> None:
    """Run one craft's agent. It waits for the simulator, in whatever order they are started, and ends with it.

    Parameters
    ----------
    scenario
        The scenario file, the same for everybody.
    craft
        Which craft of the scenario this is.
    overrides
        The same for everybody, too.
    """
    from grex_agent.shell import Agent
    from grex_link.bus import ZenohBus, serve
    from grex_link.errors import ConfigError
    from grex_link.log import speak_as
    from grex_link.scenario import load

    config = load(scenario, overrides)
    if craft not in config.craft:
        raise ConfigError("--craft", f"unknown craft {craft!r}; there are {', '.join(config.craft)}")
    speak_as(f"agent {craft}")
    with ZenohBus(config, "agent", craft) as bus:
        serve(bus, Agent(config, craft, bus), config.clock)


if __name__ == "__main__":
    run_process(lambda: tyro.cli(agent, prog="python -m grex_agent"))
