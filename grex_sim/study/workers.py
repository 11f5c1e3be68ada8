"""Does the jobs of a study for all seeds, over all cores."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, TypeAlias

from grex_link.errors import GrexError
from grex_link.process import LAUNCHER_VARIABLE, collect_rarely, die_with_launcher
from grex_sim.study.figures import Job

#: What every job gave, seed by seed from 1 on.
Results: TypeAlias = dict[Job, list[Any]]
_NICE = 10


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
        Names what could not be run.
    """
    with _pool() as pool:
        first = _run(pool, [(job, seed) for job in jobs for seed in (1, 2)], done)
        drawn = [job for job in jobs if _differ(first[job, 1], first[job, 2])]
        rest = [(job, seed) for job in drawn for seed in range(3, seeds + 1)]
        both = first | _run(pool, rest, done, len(first))
    return {job: [both[job, seed if job in drawn or seed == 1 else 2] for seed in range(1, seeds + 1)] for job in jobs}


def _run(
    pool: ProcessPoolExecutor,
    work: Sequence[tuple[Job, int]],
    done: Callable[[int, int], None],
    before: int = 0,
) -> dict[tuple[Job, int], Any]:
    results: dict[tuple[Job, int], Any] = {}
    futures: dict[Future[Any], tuple[Job, int]] = {}
    total = before + len(work)
    done(before, total)
    with _undisturbed():
        for job, seed in work:
            futures[pool.submit(_do, job, seed)] = job, seed
    for future in as_completed(futures):
        job, seed = futures[future]
        try:
            results[job, seed] = future.result()
        except GrexError as error:
            raise GrexError(f"{job}, seed {seed}: {error}") from error
        except BrokenProcessPool:
            raise GrexError("a process of the study was killed; is there enough memory?") from None
        done(before + len(results), total)
    return results


def _differ(one: Any, other: Any) -> bool:
    return bool(getattr(one, "digest", one) != getattr(other, "digest", other))


def _do(job: Job, seed: int) -> Any:
    try:
        return job.run(seed)
    except GrexError as error:
        # As it is, it could not be sent: its constructor wants more than it keeps.
        raise GrexError(str(error)) from None


@contextmanager
def _pool() -> Iterator[ProcessPoolExecutor]:
    """Start as many processes as there are cores; none is left, nor finishes its work, when something goes wrong."""
    pool = ProcessPoolExecutor(
        len(os.sched_getaffinity(0)), multiprocessing.get_context("spawn"), _begin, (os.getpid(),)
    )
    try:
        yield pool
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _begin(launcher: int) -> None:
    """Make a process step back for others, look for little garbage, and end with the one that started it."""
    os.nice(max(0, _NICE - os.nice(0)))
    os.environ[LAUNCHER_VARIABLE] = str(launcher)
    die_with_launcher()
    collect_rarely()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Start processes that never see Ctrl-C, which is for the one that started them; here it waits meanwhile."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
