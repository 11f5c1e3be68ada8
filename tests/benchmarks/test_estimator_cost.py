"""What a step of the estimator costs, against one filterpy object a mate that does the same (opt in: -m benchmark)."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from grex_agent.coordination import load_controller
from grex_agent.mission import TeamPlan, plan_mission
from grex_agent.team.along_track import AlongTrack
from grex_agent.team.interface import Own, TeamContext
from grex_agent.team.path_length import PathLength
from grex_agent.team.speed_model import SpeedModel
from grex_link.messages import MateBelief
from grex_link.scenario import decode

pytestmark = [pytest.mark.benchmark, pytest.mark.timeout(300)]
NUDGE = 1e-3


def context(mates: int) -> TeamContext:
    """A craft in a line of mates + 1."""
    formation = {f"auv{n}": [-2.0 * n, 0.5 * n, 0.0] for n in range(mates + 1)}
    scenario = decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation, "leg_length_m": 4000.0},
            "craft": {craft: {} for craft in formation},
            "team": {"estimator": "along_track"},
        }
    )
    return TeamContext("auv0", plan_mission(scenario), scenario, load_controller(scenario.team))


class OneFilterpyObjectEach:
    """The along-track filter without messages, as one would write it with filterpy."""

    def __init__(self, made: TeamContext) -> None:
        plan: TeamPlan = made.plan
        self._law, self._speed = made.controller, SpeedModel(made.scenario.team.speed_model)
        self._craft = [*(craft for craft in plan.craft if craft != made.craft), made.craft]
        self._paths = [PathLength(plan.craft[craft]) for craft in self._craft]
        self._filters = []
        for path in self._paths:
            kalman = KalmanFilter(dim_x=3, dim_z=1)
            kalman.x = np.array([0.0, path.tracks[0].speed_mps, 0.0])
            config = self._speed.config
            kalman.P = np.diag((0.01, config.told_sigma_mps**2, config.error_relative**2))
            self._filters.append(kalman)
        self._total = 0.0

    def step(self, dt: float = 1.0) -> list[MateBelief]:
        """Predict everybody and say what is believed."""
        count, progress_of_all = len(self._filters) - 1, []
        keep, error_noise = self._speed.fading(dt)
        noise, half = np.diag((0.0, self._speed.config.noise_mps**2 * dt, error_noise)), dt / 2.0
        for path, kalman in zip(self._paths, self._filters, strict=True):
            distance, speed, error = kalman.x
            track, progress = path.tracks[path.number(distance)], path.progress(distance)
            ordered, nudged = (
                # The sum of the mates' progress is all the law needs: given as one mate, the rest of them level.
                self._law.speed(track.speed_mps, own, [self._total - progress - (count - 1) * own])
                for own in (progress, progress + NUDGE)
            )
            after, (by_speed, by_order, by_error) = self._speed.step(speed, ordered, error, dt)
            by_distance = by_order * (nudged - ordered) / (NUDGE * track.length_m)
            jacobian = np.array(
                [
                    [1.0 + half * by_distance, half * (1.0 + by_speed), half * by_error],
                    [by_distance, by_speed, by_error],
                    [0.0, 0.0, keep],
                ]
            )
            kalman.predict(F=jacobian, Q=noise)
            kalman.x = np.array([distance + half * (speed + after), after, keep * error])
            progress_of_all.append(path.progress(kalman.x[0]))
        self._total = sum(progress_of_all)
        return [
            MateBelief(craft, *path.point(kalman.x[0]), progress, float(kalman.P[0, 0]) ** 0.5, -1.0)
            for craft, path, kalman, progress in zip(
                self._craft[:-1], self._paths, self._filters, progress_of_all, strict=False
            )
        ]


def cost(one: Callable[[], object], other: Callable[[], object]) -> float:
    """How many times as long a step of one takes as one of the other, where nobody else slows it down.

    The least time of each counts, and they are measured in turns: a machine that is shared has faster and slower spells
    of seconds.
    """
    times = [(best_s(one), best_s(other)) for _ in range(20)]
    return min(each for each, _ in times) / min(each for _, each in times)


def best_s(step: Callable[[], object]) -> float:
    """Least time of four steps over some short rounds."""
    times = []
    for _ in range(40):
        start = time.perf_counter()
        for _ in range(4):
            step()
        times.append(time.perf_counter() - start)
    return min(times)


def both(mates: int) -> tuple[Callable[[], list[MateBelief]], Callable[[], list[MateBelief]]]:
    """A step of the rows of arrays and one of the objects; both go on a second each time they are called."""
    made = context(mates)
    rows, objects, now = AlongTrack(made), OneFilterpyObjectEach(made), [0.0]

    def step() -> list[MateBelief]:
        now[0] += 1.0
        return rows.step(now[0], Own(0.0, 0.0, now[0] / 4000.0), [], [])

    return step, objects.step


def test_they_do_the_same():
    """The two believe the same after a minute, to a millimetre."""
    of_rows, of_objects = both(5)
    for _ in range(60):
        rows, objects = of_rows(), of_objects()
    for row, other in zip(rows, objects, strict=True):
        assert (row.north_m, row.progress, row.sigma_m) == pytest.approx(
            (other.north_m, other.progress, other.sigma_m), abs=1e-3
        )


def test_fifty_mates_cost_a_tenth():
    """At 50 mates a step costs at most a tenth of one filterpy object a mate; ratios for 3, 10 and 50 are printed."""
    ratios = {}
    for mates in (3, 10, 50):
        rows, objects = both(mates)
        ratios[mates] = cost(objects, rows)
    print("filterpy / rows of arrays:", {mates: round(ratio, 1) for mates, ratio in ratios.items()})  # noqa: T201
    assert ratios[50] >= 10.0


def test_the_cost_hardly_grows_with_the_mates():
    """A step for 50 mates takes less than twice as long as one for 3: linear at most, by under 2 % of that for each."""
    three = both(3)[0]
    ten, fifty = (cost(both(mates)[0], three) for mates in (10, 50))
    print(f"rows of arrays, 10 and 50 mates / 3: {ten:.2f}, {fifty:.2f}")  # noqa: T201
    assert fifty <= 2.0
    assert fifty - ten <= 40 * 0.02
