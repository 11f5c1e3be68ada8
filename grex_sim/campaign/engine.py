"""Carries out jobs whatever happens to those who do them: each ends once, in the journal.

The engine knows neither scenarios nor campaigns. A job is anything with a ``key``; an executor does jobs, and says of
each what became of it: the local pool (`grex_sim.campaign.pool`) or a Dask cluster (`grex_sim.campaign.cluster`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import msgspec

from grex_link.errors import GrexError


class Keyed(Protocol):
    """Whatever can be told from others."""

    @property
    def key(self) -> str:
        """Its name among the jobs."""


J = TypeVar("J", bound=Keyed)
#: Does a job and returns its figures: JSON's simple values by name. Must be importable, for it goes to other processes.
Work = Callable[[Any], Mapping[str, Any]]


class Outcome(msgspec.Struct, frozen=True):
    """What became of a job."""

    key: str
    figures: dict[str, Any] | None
    """None if it failed."""
    fault: str = ""
    """Why it failed."""
    deserted: bool = False
    """Whether whoever did it died over it: the job itself may be sound."""


class Executor(Protocol):
    """Does jobs somewhere else, several at a time."""

    def outcomes(self, jobs: Sequence[Any]) -> Iterator[Outcome]:
        """Do jobs, and yield one outcome for each as soon as it is known."""


class Sink(Protocol):
    """Where outcomes are kept; see `grex_sim.campaign.journal`."""

    def add(self, outcome: Outcome) -> None:
        """Keep an outcome."""


def do(work: Work, job: Keyed) -> Outcome:
    """Do one job here; what goes wrong in it is an outcome, too."""
    try:
        return Outcome(job.key, dict(work(job)))
    except GrexError as error:
        return Outcome(job.key, None, str(error))
    except Exception as error:  # noqa: BLE001 - a plug-in may raise anything, and the other jobs go on
        return Outcome(job.key, None, f"{type(error).__name__}: {error}")


def carry_out(jobs: Sequence[J], executor: Executor, sink: Sink, tell: Callable[[Outcome], None]) -> None:
    """Do all jobs; one whose worker died over it is tried once more, when all others are done.

    Parameters
    ----------
    jobs : sequence
        Those that are still to be done.
    executor : Executor
        Who does them.
    sink : Sink
        Takes the final outcome of each, once.
    tell : callable
        Told of each final outcome.
    """
    by_key = {job.key: job for job in jobs}
    again: list[J] = []
    for outcome in executor.outcomes(jobs):
        if outcome.deserted:
            again.append(by_key[outcome.key])
        else:
            sink.add(outcome)
            tell(outcome)
    for outcome in executor.outcomes(again) if again else ():
        final = msgspec.structs.replace(outcome, fault=f"twice: {outcome.fault}") if outcome.deserted else outcome
        sink.add(final)
        tell(final)
