"""The local executor: a process a core, spawned, each with a pipe of its own.

A worker that dies takes one job with it, which is named, and is replaced. Nothing is shared between workers, so none
can leave a lock behind; and they end with their parent, even if that is killed.
"""

import os
import signal
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing import connection, get_context
from types import TracebackType
from typing import Any, Self

from grex_link.process import collect_rarely, die_with
from grex_sim.campaign.engine import Keyed, Outcome, Work, do

#: Workers step back for whatever else the machine does.
_NICE = 10


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalPool:
    """Workers on this machine; use as a context manager, which leaves none behind.

    Parameters
    ----------
    work : callable
        What is done with each job.
    workers : int
        How many at a time.
    """

    def __init__(self, work: Work, workers: int) -> None:
        self._work = work
        self._count = workers
        self._workers: list[_Worker] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for worker in self._workers:
            worker.kill()

    def outcomes(self, jobs: Sequence[Keyed]) -> Iterator[Outcome]:
        """Do jobs, as many at a time as there are workers; see `Executor`."""
        waiting = deque(jobs)
        while len(self._workers) < min(self._count, len(jobs)):
            self._workers.append(_Worker(self._work))
        busy: dict[Any, _Worker] = {}
        idle = list(self._workers)
        while waiting or busy:
            while waiting and idle:
                worker = idle.pop()
                worker.give(waiting.popleft())
                busy[worker.pipe] = worker
            for pipe in connection.wait(list(busy)):
                worker = busy.pop(pipe)
                outcome = worker.take()
                if outcome.deserted:
                    worker = self._replace(worker)
                idle.append(worker)
                yield outcome

    def _replace(self, dead: "_Worker") -> "_Worker":
        self._workers.remove(dead)
        worker = _Worker(self._work)
        self._workers.append(worker)
        return worker


class _Worker:
    """One process, and the job it is at."""

    def __init__(self, work: Work) -> None:
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, work, os.getpid()), daemon=True)
        self._key = ""
        # Ctrl-C goes to all processes of a terminal. It is this one's to answer: a worker is born deaf to it.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        theirs.close()

    def give(self, job: Keyed) -> None:
        """Hand over a job; if the worker has died in the meantime, `take` will say so."""
        self._key = job.key
        try:
            self.pipe.send(job)
        except BrokenPipeError:
            return

    def take(self) -> Outcome:
        """Take the outcome of the job; that of a worker that died names how."""
        try:
            outcome: Outcome = self.pipe.recv()
        except (EOFError, OSError):
            return Outcome(self._key, None, self._obituary(), deserted=True)
        return outcome

    def kill(self) -> None:
        """End it, whatever it does; it holds nothing that could be lost."""
        self._process.kill()
        self._process.join()
        self.pipe.close()

    def _obituary(self) -> str:
        self.kill()
        status = self._process.exitcode or 0
        return (
            f"its worker was killed by {signal.Signals(-status).name}"
            if status < 0
            else (f"its worker ended with status {status}")
        )


def _serve(pipe: Any, work: Work, parent: int) -> None:
    """Be a worker, until there is nobody to work for."""
    die_with(parent)
    os.nice(max(0, _NICE - os.nice(0)))
    collect_rarely()
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        pipe.send(do(work, job))
