"""The adapter's process: ``python -m grex_agent.frontseat SCENARIO --craft NAME``, the same as ``grex frontseat``."""

from pathlib import Path
from typing import Annotated

import tyro

from grex_link.console import Overrides
from grex_link.process import run_process


def frontseat(
    scenario: Annotated[
        Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[SCENARIO]", help="The scenario file (TOML).")
    ] = None,
    craft: Annotated[str | None, tyro.conf.arg(metavar="NAME")] = None,
    overrides: Overrides = (),
    arm: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False,  # noqa: FBT002 - a flag
    probe: Annotated[str | None, tyro.conf.arg(metavar="URL")] = None,
) -> None:
    """Run the adapter between one craft's agent and its autopilot, over MAVLink. It ends with the simulator.

    Before anything else, `grex frontseat --probe URL` says who answers there and what is missing; with a scenario, how
    far the craft is from its datum, too.

    Parameters
    ----------
    scenario
        The scenario file, the same for everybody.
    craft
        Whose autopilot it is; the scenario says where.
    overrides
        The same for everybody, too.
    arm
        The adapter may set the mode and arm, as arm = true in the scenario says; without either a person does.
    probe
        Only look: who answers at udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD.
    """
    from grex_link.errors import ConfigError

    if probe is not None:
        from grex_agent.frontseat.probe import look
        from grex_link.scenario import load

        look(probe, None if scenario is None else load(scenario, overrides).datum)
    elif scenario is None or craft is None:
        raise ConfigError("grex frontseat", "needs a scenario and --craft NAME, or --probe URL")
    else:
        _adapt(scenario, craft, overrides, may_arm=arm)


def _adapt(scenario: Path, craft: str, overrides: Overrides, *, may_arm: bool) -> None:
    from contextlib import closing

    import msgspec

    from grex_agent.frontseat.address import check_frontseats, parse_url, read_key
    from grex_agent.frontseat.connection import Connection
    from grex_agent.frontseat.core import FrontseatCore
    from grex_agent.frontseat.dialect import Codec
    from grex_agent.frontseat.node import Frontseat, prepare
    from grex_link import clock, log
    from grex_link.bus import ZenohBus, serve
    from grex_link.errors import ConfigError
    from grex_link.log import speak_as
    from grex_link.scenario import load
    from grex_link.topics import frontseat_place
    from grex_link.units import NS

    config = load(scenario, overrides)
    if craft not in config.craft:
        raise ConfigError("--craft", f"unknown craft {craft!r}; there are {', '.join(config.craft)}")
    path = f"$.craft.{craft}.frontseat"
    check_frontseats(config)
    if craft not in config.mavlink_craft or config.datum is None:
        raise ConfigError(f"{path}.type", "is not mavlink; the simulator moves this craft")
    speak_as(f"frontseat {craft}")
    ours = config.mavlink_craft[craft]
    ours = msgspec.structs.replace(ours, arm=ours.arm or may_arm)
    unix_ns = clock.unix_ns()
    codec = Codec(ours.own_system, ours.own_component, read_key(ours, path), unix_ns)
    core = FrontseatCore(ours, config.datum, config.clock.factor, unix_ns - round(clock.monotonic_s() * NS))
    with closing(Connection(parse_url(ours.url, f"{path}.url"), codec)) as connection:
        connection.open(f"{path}.url")
        log.info(f"joining the run, for {config.clock.start_timeout_s:g} s at most; the autopilot is on {ours.url}")
        with ZenohBus(config, "frontseat", frontseat_place(craft), present=False) as bus:
            node = Frontseat(config, craft, bus, connection, core)
            try:
                prepare(bus, node, config.clock.start_timeout_s)
                bus.announce()
                serve(bus, node, config.clock)
            finally:
                node.hand_back()


if __name__ == "__main__":
    run_process(lambda: tyro.cli(frontseat, prog="python -m grex_agent.frontseat"))
