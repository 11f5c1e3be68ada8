"""Does the jobs of a study for all seeds, over all cores."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from grex_link.errors import GrexError
from grex_sim.campaign.engine import Outcome, carry_out
from grex_sim.campaign.pool import LocalPool, cores
from grex_sim.study.figures import Job

#: What every job gave, seed by seed from 1 on.
Results: TypeAlias = dict[Job, list[Any]]


class Run(NamedTuple):
    """A job at one seed."""

    job: Job
    seed: int

    @property
    def key(self) -> str:
        """Its name among the runs."""
        return f"{self.job}, seed {self.seed}"


def do_run(run: Run) -> dict[str, Any]:
    """Do it, in a worker."""
    return {"result": run.job.run(run.seed)}


def run_jobs(jobs: Sequence[Job], seeds: int, done: Callable[[int, int], None]) -> Results:
    """Do every job for seeds 1 to `seeds`.

    A mission in which nothing is drawn at random is the same for every seed: when the first two seeds end with the same
    digest, the others are taken to be the same as well.

    Parameters
    ----------
    jobs : sequence of Job
        Each once.
    seeds : int
        At least 2.
    done : callable
        Told now and then how many runs are done, of how many.

    Raises
    ------
    GrexError
        Names the first run that failed; the others are given up.
    """
    found = _Found(done)
    with LocalPool(do_run, cores()) as pool:
        found.expect(first := [Run(job, seed) for job in jobs for seed in (1, 2)])
        carry_out(first, pool, found, found.tell)
        drawn = [job for job in jobs if _differ(found.result(job, 1), found.result(job, 2))]
        found.expect(rest := [Run(job, seed) for job in drawn for seed in range(3, seeds + 1)])
        carry_out(rest, pool, found, found.tell)
    seeds_done = {job: range(1, seeds + 1) if job in drawn else [1, *[2] * (seeds - 1)] for job in jobs}
    return {job: [found.result(job, seed) for seed in seeds_done[job]] for job in jobs}


class _Found:
    """What the runs gave, and how many there are."""

    def __init__(self, done: Callable[[int, int], None]) -> None:
        self._done = done
        self._results: dict[str, Any] = {}
        self._total = 0

    def expect(self, runs: Sequence[Run]) -> None:
        """Hear of more runs to come."""
        self._total += len(runs)
        self._done(len(self._results), self._total)

    def add(self, outcome: Outcome) -> None:
        """Keep what a run gave; one that failed is the end of the study."""
        if outcome.figures is None:
            raise GrexError(f"{outcome.key}: {outcome.fault}")
        self._results[outcome.key] = outcome.figures["result"]

    def tell(self, _: Outcome) -> None:
        """Say how far it is."""
        self._done(len(self._results), self._total)

    def result(self, job: Job, seed: int) -> Any:
        """Look up what a job gave at a seed."""
        return self._results[Run(job, seed).key]


def _differ(one: Any, other: Any) -> bool:
    return bool(getattr(one, "digest", one) != getattr(other, "digest", other))
