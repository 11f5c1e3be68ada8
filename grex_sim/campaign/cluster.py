"""The executor on a Dask cluster: the only user of dask.distributed, which the extra ``cluster`` installs.

Dask gives the jobs of a worker that is gone to the others by itself. A job that takes several workers with it is handed
back as deserted.
"""

from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Any, Self

from grex_link import clock
from grex_link.errors import ConfigError, GrexError
from grex_sim.campaign.engine import Keyed, Outcome, Work, do

_CONNECT_S = 10.0
_WORKERS_S = 30.0
#: How long all workers may be gone, or none may finish anything while none is there.
_DESERTED_S = 60.0
_LOOK_S = 2.0
#: Jobs under way at a time, for each thread of the cluster: enough that nobody waits.
_AHEAD = 4


class Cluster:
    """The workers of a Dask scheduler; use as a context manager.

    Parameters
    ----------
    work : callable
        What is done with each job; GREX must be installed where the workers are.
    address : str
        Of the scheduler, ``tcp://host:port``.

    Raises
    ------
    ConfigError
        If Dask is not installed, or nobody answers there, or there is no worker.
    """

    def __init__(self, work: Work, address: str) -> None:
        try:
            import distributed
        except ModuleNotFoundError:
            raise ConfigError("--scheduler", "needs Dask: pip install 'grex[cluster]'") from None
        self._dask: Any = distributed
        self._work = work
        self._address = address
        try:
            self._client = self._dask.Client(address, timeout=_CONNECT_S)
        except (OSError, ValueError) as error:
            raise ConfigError("--scheduler", f"no Dask scheduler answers at {address} ({_brief(error)})") from None
        try:
            self._client.wait_for_workers(1, timeout=_WORKERS_S)
        except TimeoutError:
            self._client.close()
            raise ConfigError("--scheduler", f"the scheduler at {address} has no workers: start one there") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()

    def outcomes(self, jobs: Sequence[Keyed]) -> Iterator[Outcome]:
        """Do jobs on the workers there are at the time; see `Executor`."""
        waiting = iter(jobs)
        under_way: dict[Any, str] = {}
        alive_at = clock.monotonic_s()
        while True:
            threads = sum(self._client.nthreads().values())
            alive_at = clock.monotonic_s() if threads else alive_at
            self._check(alive_at)
            while len(under_way) < max(1, _AHEAD * threads) and (job := next(waiting, None)) is not None:
                # Not pure: Dask names them, so none is taken for one of an older campaign.
                under_way[self._client.submit(do, self._work, job, pure=False)] = job.key
            if not under_way:
                return
            for future in self._finished(list(under_way)):
                yield self._outcome(under_way.pop(future), future)

    def _finished(self, futures: list[Any]) -> list[Any]:
        """Wait a moment for any to finish."""
        try:
            return list(self._dask.wait(futures, timeout=_LOOK_S, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            return []

    def _outcome(self, key: str, future: Any) -> Outcome:
        error = future.exception()
        if error is None:
            outcome: Outcome = future.result()
            return outcome
        if isinstance(error, ModuleNotFoundError):
            raise ConfigError("--scheduler", f"a worker of {self._address} cannot fly: {error}; install GREX there")
        return Outcome(key, None, f"on the cluster: {_brief(error)}", deserted=True)

    def _check(self, alive_at: float) -> None:
        lost = self._client.status != "running"
        if lost or clock.monotonic_s() - alive_at > _DESERTED_S:
            whom = "the scheduler" if lost else "all workers"
            raise GrexError(f"{whom} of {self._address} left; the same command goes on from what is kept")


def _brief(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
