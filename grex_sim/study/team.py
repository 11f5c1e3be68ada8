"""`grex study team`: every claim about team navigation as a row of a table."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from grex_link.errors import ConfigError, GrexError
from grex_sim.launch import Launch
from grex_sim.study.all_rows import ROWS
from grex_sim.study.figures import Flight, Job, mean_and_interval
from grex_sim.study.table import Result, Row, as_json, as_text
from grex_sim.study.workers import Results, run_jobs

#: Says what is being done, and how far it is.
Progress = Callable[[str, int, int], None]
_FIRST_SEED = 1


class Study(NamedTuple):
    """What a study came to.

    Attributes
    ----------
    results : list of Result
        Row by row.
    mismatches : list of str
        Rows whose run as processes ended with another digest than the one in memory, and both digests.
    """

    results: list[Result]
    mismatches: list[str]

    def text(self, *, json: bool) -> str:
        """Print it, for programs or for people."""
        return as_json(self.results) if json else as_text(self.results)

    def judge(self) -> None:
        """Say whether all is as it must be.

        Raises
        ------
        GrexError
            Names the rows that have another digest as processes, and those that miss their targets.
        """
        faults = []
        if self.mismatches:
            faults.append("NOT THE SAME RESULT in memory and as processes: " + "; ".join(self.mismatches))
        if missed := [each.missed() for each in self.results if not each.met]:
            faults.append("MISSED: " + "; ".join(missed))
        if faults:
            raise GrexError(". ".join(faults))


def choose(rows: Sequence[Row], only: Sequence[str]) -> list[Row]:
    """Choose rows by name; without names, all.

    Raises
    ------
    ConfigError
        If there is no such row.
    """
    known = {row.name: row for row in rows}
    for name in only:
        if name not in known:
            raise ConfigError("--only", f"unknown row {name!r}; there are {', '.join(known)}")
    return [row for row in rows if not only or row.name in only]


def run_study(seeds: int, only: Sequence[str] = (), rows: Sequence[Row] = ROWS) -> Study:
    """Measure rows over seeds 1 to `seeds`, and hold one mission of each against a run as processes.

    Raises
    ------
    ConfigError
        If a row or a scenario is not there or cannot work.
    GrexError
        If a run broke off.
    """
    if seeds < 2:
        raise ConfigError("--seeds", f"{seeds} is too few: an interval takes two at least")
    chosen = choose(rows, only)
    jobs = list(dict.fromkeys(job for row in chosen for job in row.figure.jobs))
    for job in jobs:
        job.check()
    with _progress_line() as progress:
        results = run_jobs(jobs, seeds, lambda done, total: progress("runs in memory", done, total))
        mismatches = _compare(chosen, results, progress)
    return Study([_result(row, results, seeds) for row in chosen], mismatches)


def _result(row: Row, results: Results, seeds: int) -> Result:
    columns = zip(*(results[job] for job in row.figure.jobs), strict=True)
    mean, interval = mean_and_interval([row.figure.value(*column) for column in columns])
    return Result(row, mean, interval, seeds)


def _compare(rows: Sequence[Row], results: Results, progress: Progress) -> list[str]:
    """Run the first mission of each row as processes in lockstep, with one seed; say where the digest is another."""
    first: dict[Job, str] = {}
    for row in rows:
        first.setdefault(row.figure.jobs[0], row.name)
    flights = {job: name for job, name in first.items() if isinstance(job, Flight)}
    mismatches = []
    for number, (flight, name) in enumerate(flights.items()):
        progress("runs as processes", number, len(flights))
        there, here = _digest_of_processes(flight), results[flight][0].digest
        if there != here:
            mismatches.append(f"{name}: digest {here} in memory, but {there} as processes")
    return mismatches


def _digest_of_processes(flight: Flight) -> str:
    scenario = flight.load(_FIRST_SEED)
    options = [part for value in flight.arguments(_FIRST_SEED) for part in ("--set", value)]
    with (
        TemporaryDirectory(prefix="grex-study-") as folder,
        Launch(scenario, [str(flight.file), *options], Path(folder)) as launch,
    ):
        return launch.wait(lambda _: None).digest


@contextmanager
def _progress_line() -> Iterator[Progress]:
    """Show what is being done and how long it will take; nothing when standard error is no terminal."""
    from tqdm import tqdm

    with tqdm(
        total=1,
        leave=False,
        disable=not sys.stderr.isatty(),
        bar_format="{desc} |{bar}| {n_fmt}/{total_fmt} [{elapsed}<{remaining}]",
    ) as bar:

        def update(what: str, done: int, total: int) -> None:
            if done == 0:
                bar.reset(total)
                bar.set_description_str(what, refresh=False)
            bar.total = total
            bar.update(done - bar.n)

        yield update
