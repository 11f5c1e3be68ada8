"""Missions of scenarios in deploy/ with craft on MAVLink: their simulated autopilots, and what came of it."""

import json
import math
from contextlib import ExitStack
from pathlib import Path

import msgspec
from frontseat_runs import autopilot, fixes, free_port
from launching import running

from grex_agent.mission import TeamPlan, plan_mission
from grex_link.messages import Fix
from grex_link.scenario import load

#: A simulated craft that turns and speeds up as the boat does, orders half a second on their way included.
BOAT = (
    "vehicle.heading={lag_s=1.4, min=-1e9, max=1e9, rate_max=0.75}",
    "vehicle.surge={lag_s=1.5, min=0.0, max=5.0, rate_max=0.9}",
)
SCENARIOS = Path(__file__).parents[2] / "deploy" / "scenarios"


class Flown(msgspec.Struct):
    """A mission that was flown.

    Attributes
    ----------
    summary : dict
        What ``grex run --json`` has printed.
    plan : TeamPlan
        What was planned.
    fixes : dict
        Recorded fixes of every craft.
    words : dict
        What the frontseats have said.
    """

    summary: dict
    plan: TeamPlan
    fixes: dict[str, list[Fix]]
    words: dict[str, str]


def fly_team(
    name: str, folder: Path, *overrides: str, pace: float, plain: bool = False, speed_error: float = 0.0
) -> Flown:
    """Fly a scenario of deploy/ as processes at a pace.

    Parameters
    ----------
    name : str
        Its file, without ``.toml``.
    folder : Path
        For what comes of it.
    *overrides : str
        As after ``--set``.
    pace : float
        Mission seconds a wall second; the autopilots are as much quicker.
    plain : bool
        Whether the simulator moves the craft that have an autopilot otherwise.
    speed_error : float
        Relative speed error of auv1, whoever moves it.
    """
    sets = [*overrides, f"clock.pace={pace:g}", f"craft.auv1.vehicle.speed_error_relative={speed_error:g}"]
    scenario = load(SCENARIOS / f"{name}.toml", sets)
    with ExitStack() as stack:
        for craft, config in scenario.mavlink_craft.items():
            if plain:
                sets += [f'craft.{craft}.frontseat={{type="sim"}}', *(f"craft.{craft}.{loop}" for loop in BOAT)]
                continue
            port = free_port()
            sets.append(f'craft.{craft}.frontseat.url="udpin:127.0.0.1:{port}"')
            north, east, course = plan_mission(scenario).craft[craft].start
            options = ["--speedup", f"{pace:g}", "--ready", f"{3.0 * pace:g}", "--sysid", str(config.system)]
            # At the quay they lie still, as simulated craft do before the first tick.
            options += ["--wind", "0,0"]
            options += ["--speed-error", f"{speed_error:g}"] if craft == "auv1" else []
            heading = math.degrees(course)
            url, log = f"udpout:127.0.0.1:{port}", folder / f"{craft}.log"
            stack.enter_context(autopilot(url, log, *options, start=(north, east), heading_deg=heading))
        arguments = [word for text in sets for word in ("--set", text)]
        out = folder / "run"
        launcher = stack.enter_context(
            running("run", str(SCENARIOS / f"{name}.toml"), *arguments, "--json", "--out", str(out))
        )
        printed, err = launcher.communicate(timeout=120.0 + plan_mission(scenario).duration_s / pace)
    assert (launcher.returncode, err) == (0, ""), (printed, err)
    words = {} if plain else {c: (out / f"frontseat-{c}.log").read_text() for c in scenario.mavlink_craft}
    found = {craft: fixes(out, craft) for craft in scenario.craft}
    return Flown(json.loads(printed), plan_mission(scenario), found, words)
