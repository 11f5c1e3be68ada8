"""``grex campaign``: what is asked for, who does it, and what is shown of it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from grex_link.console import Overrides, ScenarioFile

if TYPE_CHECKING:
    from grex_sim.campaign.definition import Cell, Definition
    from grex_sim.campaign.engine import Executor, Outcome
    from grex_sim.campaign.journal import Journal

Vary = Annotated[
    tyro.conf.UseAppendAction[tuple[str, ...]],
    tyro.conf.arg(metavar="PATH=VALUE,VALUE", help="Fly every one of these values; may be repeated for other paths."),
]


def campaign(
    scenario: ScenarioFile,
    seeds: Annotated[int, tyro.conf.arg(metavar="N")] = 20,
    vary: Vary = (),
    overrides: Overrides = (),
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None,
    workers: Annotated[int | None, tyro.conf.arg(metavar="N")] = None,
    scheduler: Annotated[str | None, tyro.conf.arg(metavar="tcp://HOST:PORT")] = None,
) -> None:
    """Fly a scenario many times, varied, on all cores; the same command goes on with a campaign that was cut off.

    Parameters
    ----------
    scenario
        The scenario file.
    seeds
        How often each combination of values is flown: with the scenario's seed, the next one, and so on.
    vary
        What varies; all combinations are flown.
    overrides
        Other values of the scenario, for all runs.
    out
        Folder of journal, results (runs.parquet) and picture; default campaigns/NAME.
    workers
        How many runs at a time on this machine; all cores if left out.
    scheduler
        Address of a Dask scheduler whose workers fly the runs instead.
    """
    from grex_link.errors import ConfigError, GrexError
    from grex_sim.campaign.journal import Journal
    from grex_sim.campaign.picture import PICTURE_FILE, draw
    from grex_sim.campaign.results import RESULTS_FILE, cell_results, rows, write_rows
    from grex_sim.campaign.text import as_table, failures, rate
    from grex_sim.parquet import need_parquet

    if seeds < 1 or (workers is not None and workers < 1):
        raise ConfigError("--seeds" if seeds < 1 else "--workers", "must be 1 or more")
    definition, cells = _define(scenario, overrides, vary, seeds)
    need_parquet()
    folder = out or Path("campaigns") / scenario.stem
    with Journal(folder, definition) as journal:
        flown, wall_s, who = _fly(cells, seeds, journal, workers, scheduler)
        found = rows(cells, seeds, journal.outcomes)
        write_rows(folder / RESULTS_FILE, found, cells)
        results = cell_results(cells, found)
        draw(folder / PICTURE_FILE, definition.scenario.title, results)
    lines = [*as_table(results), *([rate(found, flown, wall_s, who)] if flown else []), *failures(found)]
    print("\n".join([*lines, f"files in {folder}"]))  # noqa: T201
    if failed := sum(row["failed"] for row in found):
        raise GrexError(f"{failed} of {len(found)} runs failed; the same command tries them again")


def _define(
    file: Path, overrides: tuple[str, ...], vary: tuple[str, ...], seeds: int
) -> "tuple[Definition, list[Cell]]":
    """Read and check everything, so that a fault is found before anything starts."""
    from importlib.metadata import version

    from grex_link.errors import ConfigError
    from grex_link.scenario import load
    from grex_sim.campaign.definition import Definition, make_cells, parse_vary
    from grex_sim.campaign.own_files import own_files
    from grex_sim.run import check_in_process

    varied = parse_vary(vary)
    cells = make_cells(lambda values: load(file, [*overrides, *values]), varied)
    for cell in cells:
        if not cell.scenario.clock.lockstep:
            raise ConfigError("$.clock.pace", "a campaign flies in lockstep only")
        check_in_process(cell.scenario)
    named = own_files([cell.scenario for cell in cells])
    return Definition(load(file, overrides), varied, seeds, version("grex"), named), cells


def _fly(
    cells: "list[Cell]", seeds: int, journal: "Journal", workers: int | None, scheduler: str | None
) -> tuple[int, float, str]:
    """Fly what has not been flown: (how many runs, wall seconds, on what)."""
    from grex_link import clock
    from grex_link.errors import GrexError
    from grex_link.process import INTERRUPTED
    from grex_sim.campaign.definition import make_jobs
    from grex_sim.campaign.engine import carry_out

    jobs = make_jobs(cells, seeds)
    todo = [job for job in jobs if job.key not in journal.done]
    if not todo:
        return 0, 0.0, ""
    start = clock.monotonic_s()
    try:
        with _executor(workers, scheduler) as (executor, who), _progress(len(jobs), len(jobs) - len(todo)) as tell:
            carry_out(todo, executor, journal, tell)
    except KeyboardInterrupt:
        interrupted = GrexError(
            f"interrupted: {len(journal.done)} of {len(jobs)} runs are kept in {journal.path.parent}; "
            "the same command goes on from there"
        )
        interrupted.exit_status = INTERRUPTED
        raise interrupted from None
    return len(todo), clock.monotonic_s() - start, who


@contextmanager
def _executor(workers: int | None, scheduler: str | None) -> "Iterator[tuple[Executor, str]]":
    """Open what does the jobs, and say what that is."""
    from grex_sim.campaign.flight import fly

    if scheduler is not None:
        from grex_sim.campaign.cluster import Cluster

        with Cluster(fly, scheduler) as cluster:
            yield cluster, f"the cluster at {scheduler}"
        return
    from grex_sim.campaign.pool import LocalPool, cores

    count = workers or cores()
    with LocalPool(fly, count) as pool:
        yield pool, f"{count} processes"


@contextmanager
def _progress(total: int, done: int) -> "Iterator[Callable[[Outcome], None]]":
    """Show how many runs are done and how long the others will take; nothing when standard error is no terminal."""
    from tqdm import tqdm

    with tqdm(total=total, initial=done, unit="run", smoothing=0.05, disable=not sys.stderr.isatty()) as bar:
        failed = 0

        def tell(outcome: "Outcome") -> None:
            nonlocal failed
            if outcome.figures is None:
                failed += 1
                bar.set_postfix_str(f"{failed} failed", refresh=False)
            bar.update()

        yield tell
