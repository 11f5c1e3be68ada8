"""The link's process: ``python -m grex_link SCENARIO``, the same as ``grex link``."""

import tyro

from grex_link.console import Overrides, ScenarioFile
from grex_link.process import run_process


def link(scenario: ScenarioFile, overrides: Overrides = ()) -> None:
    """Run the link emulator: the water between the craft. It waits for the simulator and ends with it.

    Parameters
    ----------
    scenario
        The scenario file, the same for everybody.
    overrides
        The same for everybody, too.
    """
    from grex_link.bus import ZenohBus, serve
    from grex_link.emulator import Emulator
    from grex_link.log import speak_as
    from grex_link.scenario import load

    config = load(scenario, overrides)
    speak_as("link")
    with ZenohBus(config, "link", "link") as bus:
        serve(bus, Emulator(config, bus), config.clock)


if __name__ == "__main__":
    run_process(lambda: tyro.cli(link, prog="python -m grex_link"))
