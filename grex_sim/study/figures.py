"""What a study measures: jobs that are done for every seed, and the one figure that a row makes of them."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.scenario import load
from grex_sim.intervals import student_t
from grex_sim.run import check_scenario, simulate_in_process
from grex_sim.study.consistency import Consistency
from grex_sim.summary import Summary

SCENARIOS = Path(__file__).parents[2] / "deploy" / "scenarios"


class Flight(NamedTuple):
    """A whole mission in memory.

    Attributes
    ----------
    scenario : str
        A file below ``deploy/scenarios``, without ``.toml``.
    overrides : tuple of str
        ``path=value`` each.
    """

    scenario: str
    overrides: tuple[str, ...] = ()

    @property
    def file(self) -> Path:
        """The scenario's file."""
        return SCENARIOS / f"{self.scenario}.toml"

    def arguments(self, seed: int) -> list[str]:
        """Return the overrides, and a seed."""
        return [*self.overrides, f"seed={seed}"]

    def load(self, seed: int) -> Scenario:
        """Read the scenario of a seed.

        Raises
        ------
        ConfigError
            If the file is not there, or the scenario is not sound.
        """
        if not self.file.is_file():
            raise ConfigError(str(self.file), "is not there; run from a checkout of the project, with deploy/scenarios")
        return load(self.file, self.arguments(seed))

    def check(self) -> None:
        """Find a fault before anything flies."""
        check_scenario(self.load(1))

    def run(self, seed: int) -> Summary:
        """Fly it."""
        return simulate_in_process(self.load(seed), None, lambda _: None)


#: Something that gives a result for every seed.
Job: TypeAlias = Flight | Consistency


class Figure(NamedTuple):
    """What a row makes of the results of its jobs at one seed.

    Attributes
    ----------
    jobs : tuple of Job
        What it needs; the first one is what the row is about.
    value : callable
        The results of the jobs, in their order, to one number.
    """

    jobs: tuple[Job, ...]
    value: Callable[..., float]


def deviation(flight: Flight) -> Figure:
    """Take the formation deviation FD of a mission (GREX 2008, eq. 4)."""
    return Figure((flight,), _fd)


def ratio(flight: Flight, to: Flight) -> Figure:
    """Divide FD of a mission by that of another with the same seed."""
    return Figure((flight, to), lambda one, other: _fd(one) / _fd(other))


#: What talk costs, as the summary of a run has it; of energy only modems with a known source level know.
Cost: TypeAlias = Literal["messages_sent", "bytes_sent", "team_sound_j"]


def cost(flight: Flight, what: Cost) -> Figure:
    """Take what is sent in a mission: messages, bytes, or joules of sound."""
    return Figure((flight,), lambda summary: float(getattr(summary, what)))


def cost_share(flight: Flight, of: Flight, what: Cost) -> Figure:
    """Take what is sent in a mission as a share of that in another with the same seed."""
    return Figure((flight, of), lambda one, other: float(getattr(one, what) / getattr(other, what)))


def mean_age(flight: Flight) -> Figure:
    """Take the age of the newest state that a craft has of a mate, mean over time and all directed links, seconds."""
    return Figure((flight,), _mean_age)


def worst_place_error(flight: Flight, craft: Sequence[str]) -> Figure:
    """Take the position error of the worst of some craft, root mean square over a mission, metres."""
    return Figure((flight,), lambda summary: max(float(summary.navigation[each].rms_m) for each in craft))


def nees(job: Consistency) -> Figure:
    """Take the mean normalised estimation error squared (NEES): 1 if the errors are as great as is claimed."""
    return Figure((job,), float)


def mean_and_interval(values: Sequence[float]) -> tuple[float, float]:
    """Mean, and half the width of its 95 % interval: t·s/√n, with Student's t of n - 1 degrees of freedom."""
    number = len(values)
    mean = math.fsum(values) / number
    spread = math.fsum((value - mean) ** 2 for value in values)
    return mean, student_t(number - 1) * math.sqrt(spread / (number - 1) / number)


def _fd(summary: Any) -> float:
    return float(summary.fd)


def _mean_age(summary: Any) -> float:
    ages = [path.age_mean_s for path in summary.paths.values()]
    return float(sum(ages) / len(ages))
