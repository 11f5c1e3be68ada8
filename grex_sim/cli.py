"""The console ``grex``. Heavy modules are imported by the commands that need them, so that ``--help`` is quick."""

import datetime as dt
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from grex_agent.__main__ import agent
from grex_agent.frontseat.__main__ import frontseat
from grex_agent.modem.__main__ import modem
from grex_link.__main__ import link
from grex_link.console import AsJson, Overrides, ScenarioFile
from grex_link.process import run_process
from grex_sim.autopilot.__main__ import autopilot
from grex_sim.bus_options import echo, hz, topics
from grex_sim.campaign.command import campaign
from grex_sim.recorded_commands import export, replay, report
from grex_sim.task_cli import task
from grex_sim.view.command import view

Pace = Annotated[
    Literal["lockstep", "live"] | float | None,
    tyro.conf.arg(
        metavar="lockstep|live|FACTOR",
        help="As fast as possible, with the wall clock, or so many times as fast.",
    ),
]
Seed = Annotated[int | None, tyro.conf.arg(metavar="INT")]
Out = Annotated[Path | None, tyro.conf.arg(metavar="DIR", help="Folder for the run's files; default runs/NAME-TIME.")]


def run(
    scenario: ScenarioFile,
    pace: Pace = None,
    seed: Seed = None,
    overrides: Overrides = (),
    out: Out = None,
    in_process: bool = False,  # noqa: FBT001, FBT002 - a flag
    as_json: AsJson = False,  # noqa: FBT002
) -> None:
    """Run a scenario: one process a craft, one for the link, one for the simulator; then score it and draw it.

    Parameters
    ----------
    scenario
        The scenario file.
    pace
        Overrides the scenario's clock.pace.
    seed
        Overrides the scenario's seed.
    overrides
        Other values of the scenario.
    out
        Where run.mcap, summary.json, series.csv, run.png and the processes' logs go.
    in_process
        Run everybody in this process instead; the result is the same, bit by bit.
    as_json
        Print one JSON object instead of text.
    """
    from grex_link.scenario import load
    from grex_sim import report
    from grex_sim.launch import Launch
    from grex_sim.run import check_scenario, simulate_in_process
    from grex_sim.summary import as_json as to_json
    from grex_sim.summary import as_text

    arguments = [*overrides]
    arguments += [f"clock.pace={pace}"] if pace is not None else []
    arguments += [f"seed={seed}"] if seed is not None else []
    config = load(scenario, arguments)
    plan = check_scenario(config)
    folder = _make_folder(out or Path("runs") / f"{scenario.stem}-{_stamp()}")
    with _progress_bar(config.duration_s or plan.duration_s) as progress:
        if in_process:
            summary = simulate_in_process(config, folder, progress)
        else:
            options = [part for value in arguments for part in ("--set", value)]
            with Launch(config, [str(scenario), *options], folder) as launch:
                summary = launch.wait(progress)
    if not summary.recording_fault:
        report.draw(folder, config, plan)
    print(to_json(summary) if as_json else as_text(summary))  # noqa: T201


def sim(scenario: ScenarioFile, overrides: Overrides = (), out: Out = None, as_json: AsJson = False) -> None:  # noqa: FBT002
    """Run the simulator alone: the sea, and the hub of the bus. It waits for the link and all agents.

    Parameters
    ----------
    scenario
        The scenario file, the same for everybody.
    overrides
        The same for everybody, too.
    out
        Where run.mcap, summary.json and series.csv go; nothing is recorded without it.
    as_json
        Print progress and result as lines of JSON.
    """
    from grex_link.log import speak_as
    from grex_link.scenario import load
    from grex_sim.run import simulate
    from grex_sim.summary import as_json as to_json
    from grex_sim.summary import as_text

    speak_as("sim")
    config = load(scenario, overrides)
    folder = None if out is None else _make_folder(out)
    if as_json:
        summary = simulate(config, folder, lambda time_s: print(f'{{"time_s":{time_s}}}', flush=True))  # noqa: T201
        print(f'{{"summary":{to_json(summary)}}}', flush=True)  # noqa: T201
        return
    from grex_agent.mission import plan_mission

    with _progress_bar(config.duration_s or plan_mission(config).duration_s) as progress:
        summary = simulate(config, folder, progress)
    print(as_text(summary))  # noqa: T201


def check(
    scenario: ScenarioFile,
    overrides: Overrides = (),
    out: Annotated[Path, tyro.conf.arg(metavar="PNG")] = Path("plan.png"),
) -> None:
    """Check a scenario without running it: print the plan and the schedule, and draw the tracks.

    Parameters
    ----------
    scenario
        The scenario file.
    overrides
        Other values of the scenario.
    out
        Where the picture goes.
    """
    from grex_link.scenario import load
    from grex_sim import report
    from grex_sim.run import check_scenario

    config = load(scenario, overrides)
    plan = check_scenario(config)
    print(report.plan_text(config, plan))  # noqa: T201
    report.draw_plan(out, config, plan)
    print(f"\nThe scenario is sound. Tracks drawn in {out}")  # noqa: T201


def example() -> None:
    """Print a commented scenario to start from."""
    from importlib.resources import files

    print((files("grex_sim") / "example.toml").read_text(encoding="utf-8"), end="")  # noqa: T201


def table1(as_json: AsJson = False) -> None:  # noqa: FBT002
    """Run the paper's four cases as processes in lockstep, and print Table I beside the paper's.

    Parameters
    ----------
    as_json
        Print one JSON object instead of a table.
    """
    from grex_sim.table1 import run_table

    print(run_table(as_json=as_json))  # noqa: T201


def bench(as_json: AsJson = False) -> None:  # noqa: FBT002
    """Measure speed as ratios in one run: lockstep against a bare Zenoh barrier, one process against many.

    Parameters
    ----------
    as_json
        Print one JSON object instead of a table.
    """
    from grex_sim.bench import run_bench

    print(run_bench(as_json=as_json))  # noqa: T201


def study(
    table: Annotated[Literal["team"], tyro.conf.Positional, tyro.conf.arg(metavar="team")],  # noqa: ARG001 - to name it
    seeds: Annotated[int, tyro.conf.arg(metavar="N")] = 20,
    only: Annotated[tuple[str, ...], tyro.conf.arg(metavar="ROW…")] = (),
    as_json: AsJson = False,  # noqa: FBT002
) -> None:
    """Measure everything that is claimed of team navigation: whole missions over many seeds, on all cores.

    Parameters
    ----------
    table
        Which table; there is this one.
    seeds
        A row is the mean over seeds 1 to N, with its 95 % interval of ± t·s/√n (Student's t: 2.093 for 20 seeds). One
        mission of each row also runs as processes in lockstep, and must end with the same digest. Missions in which
        nothing is random run twice only. The status is 1, and one line says why, if a digest is another, or if a row
        misses what it must reach.
    only
        Some rows, by name; otherwise all, which takes about an hour on two cores.
    as_json
        Print {"rows": [{"row", "value", "interval", "seeds"}]} instead of a table.
    """
    from grex_sim.study.team import run_study

    result = run_study(seeds, only)
    print(result.text(json=as_json), flush=True)  # noqa: T201
    result.judge()


def medium(
    schedule: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="SCHEDULE.csv")],
    config: Annotated[Path, tyro.conf.arg(metavar="LINK.toml")],
    out: Annotated[Path, tyro.conf.arg(metavar="OUTCOMES.csv")],
) -> None:
    """Replay a list of transmissions through the acoustic medium alone: one row per transmission and receiver.

    Parameters
    ----------
    schedule
        Columns time_s, source, payload_bytes.
    config
        Water, modem and nodes; README.md shows one.
    out
        Where the outcomes go.
    """
    from grex_link.replay import replay

    counts = replay(schedule, config, out)
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()) + f"; written to {out}")  # noqa: T201


def modems(
    name: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME]")] = None,
    payload: Annotated[int, tyro.conf.arg(metavar="BYTES")] = 15,
    range_m: Annotated[float, tyro.conf.arg(name="range", metavar="M")] = 500.0,
    craft: Annotated[int, tyro.conf.arg(metavar="N")] = 3,
    as_json: AsJson = False,  # noqa: FBT002
) -> None:
    """List the modems there are, with airtime and age of information; or say all about one of them.

    Parameters
    ----------
    name
        A modem of the list, or the path of your own profile.toml.
    payload
        Length of a message.
    range_m
        Distance of the craft that are farthest apart.
    craft
        Size of the team.
    as_json
        Print JSON instead of text.
    """
    from grex_sim.modem_figures import Use
    from grex_sim.modem_text import show

    print(show(name, Use(payload, range_m, craft), json=as_json))  # noqa: T201


def link_stats(
    run: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")],
    as_json: AsJson = False,  # noqa: FBT002
) -> None:
    """Print what became of every transmission of a run: losses, latency and age of information of each directed link.

    Parameters
    ----------
    run
        The run's folder, or its run.mcap; one that was cut off will do.
    as_json
        Print one JSON object instead of text.
    """
    import msgspec

    from grex_sim.link_stats import link_stats as read_stats
    from grex_sim.link_stats_text import as_text

    stats = read_stats(run)
    print(msgspec.json.encode(stats).decode() if as_json else as_text(stats))  # noqa: T201


LINK_STATS = "link stats"

COMMANDS: dict[str, Callable[..., Any]] = {
    "run": run,
    "check": check,
    "campaign": campaign,
    "report": report,
    "replay": replay,
    "export": export,
    "table1": table1,
    "bench": bench,
    "study": study,
    "medium": medium,
    "modems": modems,
    "view": view,
    "topics": topics,
    "echo": echo,
    "hz": hz,
    "example": example,
    "agent": agent,
    "modem": modem,
    "frontseat": frontseat,
    "autopilot": autopilot,
    "link": link,
    # A name of two words, as which `_join` passes `grex link stats`: `grex link` itself takes a scenario.
    LINK_STATS: link_stats,
    "sim": sim,
    "task": task,
}


def main() -> None:
    """Entry point of ``grex``."""
    sys.path.append(str(Path.cwd()))  # plug-ins beside the scenario
    run_process(
        lambda: tyro.extras.subcommand_cli_from_dict(
            COMMANDS,
            args=_join(sys.argv[1:]),
            prog="grex",
            description="Team navigation and control for craft that share a sound channel.",
            config=(tyro.conf.FlagCreatePairsOff,),
        )
    )


def _join(arguments: Sequence[str]) -> list[str]:
    """Make one argument of a command of two words."""
    words = LINK_STATS.split()
    return [LINK_STATS, *arguments[2:]] if [*arguments[:2]] == words else [*arguments]


def _stamp() -> str:
    return dt.datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")


def _make_folder(path: Path) -> Path:
    from grex_link.errors import ConfigError

    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError("--out", f"cannot make the folder {path}: {error.strerror}") from None
    return path


@contextmanager
def _progress_bar(duration_s: float) -> Iterator[Callable[[float], None]]:
    """Show mission time and real-time factor while a run lasts; nothing when standard error is no terminal."""
    import time

    from tqdm import tqdm

    start = time.monotonic()
    with tqdm(
        total=round(duration_s),
        unit="s",
        disable=not sys.stderr.isatty(),
        bar_format="{percentage:3.0f}% |{bar}| {n_fmt}/{total_fmt} s  {desc} [{elapsed}<{remaining}]",
    ) as bar:

        def update(time_s: float) -> None:
            bar.set_description_str(f"{time_s / max(time.monotonic() - start, 1e-3):.0f} x real time", refresh=False)
            bar.update(round(time_s) - bar.n)

        yield update
