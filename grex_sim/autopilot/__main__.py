"""The autopilot's process: ``python -m grex_sim.autopilot``, the same as ``grex autopilot``."""

from pathlib import Path
from typing import Annotated, Literal

import tyro

from grex_link.process import run_process

_Text = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def autopilot(
    url: Annotated[_Text, tyro.conf.arg(metavar="URL")] = (),
    family: Literal["rover", "sub", "px4"] = "rover",
    sysid: Annotated[int, tyro.conf.arg(metavar="N")] = 1,
    start: Annotated[str, tyro.conf.arg(metavar="LAT,LON[,HEADING]")] = "54.3700,10.1600",
    speedup: Annotated[float, tyro.conf.arg(metavar="K")] = 1.0,
    ready: Annotated[float | None, tyro.conf.arg(metavar="S")] = None,
    fault: Annotated[_Text, tyro.conf.arg(metavar="KIND@AT[:LASTS][=VALUE]")] = (),
    param: Annotated[_Text, tyro.conf.arg(metavar="NAME=VALUE")] = (),
    current: Annotated[str, tyro.conf.arg(metavar="NORTH,EAST")] = "0,0",
    wind: Annotated[str, tyro.conf.arg(metavar="NORTH,EAST")] = "0.1,0.05",
    noise: Annotated[float, tyro.conf.arg(metavar="M")] = 0.03,
    seed: Annotated[int, tyro.conf.arg(metavar="INT")] = 1,
    firmware: Literal["4.6", "4.7"] = "4.6",
    signing_key_file: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None,
) -> None:
    """Run a simulated craft whose autopilot speaks MAVLink as real ones do; Ctrl-C ends it.

    Parameters
    ----------
    url
        udpout:HOST:PORT, udpin:HOST:PORT, tcpin:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD or pty:[NAME]; again and
        again for several ground stations. Default udpout:127.0.0.1:14550.
    family
        ArduPilot Rover on a boat, ArduPilot Sub, or PX4 on a rover.
    sysid
        System id.
    start
        Where it starts, degrees.
    speedup
        So many times as fast as the wall clock; all its timeouts are in its own time.
    ready
        Seconds until its estimator is ready, all other times of the boot in proportion; default as real ones (40 s).
    fault
        What goes wrong, and when, in its own seconds: silence, deaf, gps, loss, duplicate, garbage, late, refuse, jump,
        reboot, disarm, pilot. For instance silence@20:10, loss@0:60=0.3, pilot@30=HOLD. While it runs, PARAM_SET of
        GREX_SILENCE, GREX_LOSS and so on does the same.
    param
        A parameter's value at the start.
    current
        Of the water, m/s; it holds its course against it.
    wind
        Drift while disarmed, m/s.
    noise
        Position error, metres (one sigma).
    seed
        Of its draws.
    firmware
        ArduPilot's names of parameters.
    signing_key_file
        File with the 32 bytes, in hexadecimal, of a MAVLink 2 signing key: nothing else is heard.
    """
    from grex_link import clock
    from grex_link.log import speak_as
    from grex_sim.autopilot.brain import Settings
    from grex_sim.autopilot.codec import Codec
    from grex_sim.autopilot.core import Autopilot
    from grex_sim.autopilot.family import load_family
    from grex_sim.autopilot.faults import parse
    from grex_sim.autopilot.links import open_link
    from grex_sim.autopilot.options import Checked, read_key, read_parameters, read_start, read_vector
    from grex_sim.autopilot.shell import Pace, Shell

    table = load_family(family)
    place, heading_rad = read_start(start)
    urls = url or ("udpout:127.0.0.1:14550",)
    checked = Checked(sysid=sysid, speedup=speedup, ready_s=ready, noise_m=noise)
    unix_s = clock.unix_ns() / 1e9
    settings = Settings(
        family=table,
        system=checked.sysid,
        place=place,
        heading_rad=heading_rad,
        ready_s=checked.ready_s,
        links=len(urls),
        faults=tuple(parse(text) for text in fault),
        seed=seed,
        noise_m=checked.noise_m,
        current_ned_mps=(*read_vector("--current", current), 0.0),
        wind_ned_mps=read_vector("--wind", wind),
        epoch_unix_s=unix_s,
        firmware="4.7" if firmware == "4.7" and table.autopilot == 3 else "",
        speedup=checked.speedup,
        parameters=read_parameters(param),
    )
    speak_as(f"autopilot {sysid}")
    pilot = Autopilot(settings)
    links = [open_link(text) for text in urls]
    key = read_key(signing_key_file)
    codecs = [Codec(sysid, key, unix_s) for _ in links]
    for link in links:
        _tell(f"{family} with system id {sysid} at {link.where}")
    Shell(pilot, links, codecs, Pace(speedup, table.clock_ppm, clock.monotonic_s()), _tell).run()


def _tell(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - this is the console


if __name__ == "__main__":
    run_process(lambda: tyro.cli(autopilot, prog="python -m grex_sim.autopilot"))
