"""Craft that move exactly as an estimator thinks: its model, with every error drawn from the deviation it is told.

`along_track` thinks of a surge loop with an error that wanders slowly, `biased_planar` of a velocity that follows the
order at once with the same error, the paper's estimators of that without an error, and the baselines of a share of the
planned speed with an error that stays.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

from grex_agent.coordination import SpeedController
from grex_agent.guidance import TrackKeeping
from grex_agent.mission import CraftPlan
from grex_agent.team.planar import Follower
from grex_link import draws
from grex_link.config import Scenario


class Told(NamedTuple):
    """What a craft would say of itself: with the noise that its mates reckon with."""

    north_m: float
    east_m: float
    speed_mps: float
    sigma_m: float


class Plant(Protocol):
    """A craft on its one track.

    Attributes
    ----------
    distance_m : float
        How far it has come, truly.
    """

    distance_m: float

    def step(self, progress: float, mates: Sequence[float]) -> None:
        """Move for a second, by the law, with what it believes of its mates."""

    def place(self) -> tuple[float, float]:
        """Return true north and east, metres."""

    def tell(self, now: int) -> Told:
        """Measure itself."""


class Draws:
    """Standard normal numbers of one craft, each for a purpose and a time."""

    def __init__(self, key: tuple[int, str]) -> None:
        self._seed, self._who = key

    def pair(self, purpose: str, now: int = 0) -> tuple[float, float]:
        """Two independent ones."""
        return draws.normal(self._seed, "study", purpose, self._who, now)


class Surging:
    """As `along_track` thinks: a surge loop, an error that wanders, and a little noise."""

    def __init__(self, scenario: Scenario, plan: CraftPlan, law: SpeedController, key: tuple[int, str]) -> None:
        self._model, self._sigma = scenario.team.speed_model, scenario.team.kalman.fix_sigma_m
        self._track, self._law, self._draws, self._now = plan.tracks[0], law, Draws(key), 0
        place, speed = self._draws.pair("start")
        self.distance_m = self._sigma * place
        self._speed = self._track.speed_mps + self._model.told_sigma_mps * speed
        self._error = self._model.error_relative * self._draws.pair("error")[0]

    def step(self, progress: float, mates: Sequence[float]) -> None:
        """Move; see `Plant`."""
        self._now += 1
        model = self._model
        noise, error_noise = self._draws.pair("speed", self._now)
        ordered = self._law.speed(self._track.speed_mps, progress, mates)
        gain, keep = 1.0 - math.exp(-1.0 / model.lag_s), math.exp(-1.0 / model.error_time_s)
        faster = self._speed + gain * ((1.0 + self._error) * ordered - self._speed) + model.noise_mps * noise
        self.distance_m += (self._speed + faster) / 2.0
        self._speed = faster
        self._error = keep * self._error + model.error_relative * math.sqrt(1.0 - keep * keep) * error_noise

    def place(self) -> tuple[float, float]:
        """On the track; see `Plant`."""
        return self._track.point(self.distance_m / self._track.length_m)

    def tell(self, now: int) -> Told:
        """Measure place and speed; see `Plant`."""
        place, speed = self._draws.pair("told", now)
        point = self._track.point((self.distance_m + self._sigma * place) / self._track.length_m)
        return Told(*point, self._speed + self._model.told_sigma_mps * speed, self._sigma)


class Planar:
    """As the planar filters think: a velocity that follows what guidance and law order, with noise, and a speed error.

    With `error_relative` 0 it is the paper's model.
    """

    def __init__(
        self,
        scenario: Scenario,
        plan: CraftPlan,
        law: SpeedController,
        key: tuple[int, str],
        *,
        error_relative: float,
    ) -> None:
        self._kalman, self._draws, self._now = scenario.team.kalman, Draws(key), 0
        self._track = plan.tracks[0]
        self._follower = Follower(plan, TrackKeeping(scenario.guidance), law)
        self._relative = error_relative
        self._keep = math.exp(-1.0 / scenario.team.speed_model.error_time_s)
        north, east, course = plan.start
        sigma, (to_north, to_east) = self._kalman.fix_sigma_m, self._draws.pair("start")
        self._at = north + sigma * to_north, east + sigma * to_east
        speed, noise = self._track.speed_mps, self._draws.pair("velocity", 0)
        faster = self._kalman.velocity_process_sigma_mps
        self._velocity = speed * math.cos(course) + faster * noise[0], speed * math.sin(course) + faster * noise[1]
        self._error = error_relative * self._draws.pair("error")[0]
        self.distance_m = self._along()

    def step(self, progress: float, mates: Sequence[float]) -> None:
        """Move; see `Plant`."""
        del progress
        self._now += 1
        kalman = self._kalman
        speed, course = self._follower.order(self._follower.stand(*self._at, 0), mates)
        wanted = (1.0 + self._error) * speed * math.cos(course), (1.0 + self._error) * speed * math.sin(course)
        gain = min(kalman.velocity_transfer_per_s, 1.0)
        places, velocities = self._draws.pair("place", self._now), self._draws.pair("velocity", self._now)
        pairs = list(zip(self._at, self._velocity, places, strict=True))
        self._at = _two(at + moves + kalman.position_process_sigma_m * noise for at, moves, noise in pairs)
        self._velocity = _two(
            (1.0 - gain) * moves + gain * want + kalman.velocity_process_sigma_mps * noise
            for moves, want, noise in zip(self._velocity, wanted, velocities, strict=True)
        )
        fresh = self._relative * math.sqrt(1.0 - self._keep**2) * self._draws.pair("error", self._now)[0]
        self._error = self._keep * self._error + fresh
        self.distance_m = self._along()

    def place(self) -> tuple[float, float]:
        """Where it is; see `Plant`."""
        return self._at

    def tell(self, now: int) -> Told:
        """Measure the place; see `Plant`."""
        sigma, (north, east) = self._kalman.fix_sigma_m, self._draws.pair("told", now)
        return Told(self._at[0] + sigma * north, self._at[1] + sigma * east, self._velocity[0], sigma)

    def _along(self) -> float:
        return self._track.locate(*self._at).theta * self._track.length_m


class Steady:
    """As the baselines think: a share of the planned speed, with an error that stays as it is."""

    def __init__(
        self, scenario: Scenario, plan: CraftPlan, key: tuple[int, str], *, share: float, error_relative: float
    ) -> None:
        self._sigma, self._track, self._draws = scenario.team.kalman.fix_sigma_m, plan.tracks[0], Draws(key)
        start, error = self._draws.pair("start")
        self.distance_m = self._sigma * start
        self._speed = (share + error_relative * error) * self._track.speed_mps

    def step(self, progress: float, mates: Sequence[float]) -> None:
        """Move; see `Plant`."""
        del progress, mates
        self.distance_m += self._speed

    def place(self) -> tuple[float, float]:
        """On the track; see `Plant`."""
        return self._track.point(self.distance_m / self._track.length_m)

    def tell(self, now: int) -> Told:
        """Measure the place; see `Plant`."""
        measured = self.distance_m + self._sigma * self._draws.pair("told", now)[0]
        return Told(*self._track.point(measured / self._track.length_m), abs(self._speed), self._sigma)


def build_plant(scenario: Scenario, plan: CraftPlan, law: SpeedController, key: tuple[int, str]) -> Plant:
    """Build a craft that moves as the scenario's estimator thinks."""
    estimator, wanders = scenario.team.estimator, scenario.team.speed_model.error_relative
    if estimator.startswith("along_track"):
        return Surging(scenario, plan, law, key)
    if estimator == "hold_last":
        return Steady(scenario, plan, key, share=0.0, error_relative=1.0)
    if estimator == "dead_reckoning":
        return Steady(scenario, plan, key, share=1.0, error_relative=wanders)
    biased = estimator.startswith("biased_planar")
    return Planar(scenario, plan, law, key, error_relative=wanders if biased else 0.0)


def _two(numbers: Iterable[float]) -> tuple[float, float]:
    one, other = numbers
    return one, other
