"""The modem driver's process: ``python -m grex_agent.modem SCENARIO --craft NAME``, the same as ``grex modem``."""

import tyro

from grex_link.console import Overrides, ScenarioFile
from grex_link.process import run_process


def modem(scenario: ScenarioFile, craft: str, overrides: Overrides = ()) -> None:
    """Run the driver of one craft's modem on a serial port, in place of the emulator. It ends with the simulator.

    Parameters
    ----------
    scenario
        The scenario file, the same for everybody.
    craft
        Whose modem it is; the scenario says on which port.
    overrides
        The same for everybody, too.
    """
    from contextlib import closing

    from grex_agent.modem.micromodem_rates import check_serial_modems
    from grex_agent.modem.serial import ModemDriver, open_port
    from grex_link.bus import ZenohBus, serve
    from grex_link.clock import WallClock, unix_ns
    from grex_link.errors import ConfigError
    from grex_link.log import speak_as
    from grex_link.scenario import load
    from grex_link.topics import modem_place

    config = load(scenario, overrides)
    if craft not in config.craft:
        raise ConfigError("--craft", f"unknown craft {craft!r}; there are {', '.join(config.craft)}")
    check_serial_modems(config)
    speak_as(f"modem {craft}")
    time = WallClock(config.clock.factor, unix_ns())
    with closing(open_port(config, craft)) as port, ZenohBus(config, "modem", modem_place(craft)) as bus:
        serve(bus, ModemDriver(config, craft, bus, port, time), config.clock)


if __name__ == "__main__":
    run_process(lambda: tyro.cli(modem, prog="python -m grex_agent.modem"))
