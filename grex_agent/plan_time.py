"""The plan as time: where a craft should be, how fast, and how far behind its plan a place is, in seconds.

A track takes all craft equally long (where the plan has it differ by less than a per cent, as long as the slowest), so
that one time stands for the same Θ of all of them. Before the first and after the last track the plan goes on.
"""

from bisect import bisect_right
from collections.abc import Mapping
from itertools import accumulate

from grex_agent.mission import CraftPlan, TeamPlan


class PlanTime:
    """Times at which the tracks of a team begin.

    Parameters
    ----------
    plan : TeamPlan
        Of everybody.
    """

    def __init__(self, plan: TeamPlan) -> None:
        self._craft: Mapping[str, CraftPlan] = plan.craft
        together = zip(*(craft.tracks for craft in plan.craft.values()), strict=True)
        self._durations: list[float] = [
            max(track.length_m / track.speed_mps for track in tracks) for tracks in together
        ]
        self._starts = [0.0, *accumulate(self._durations)][:-1]

    def at(self, progress: float) -> float:
        """Plan time of a progress (track number plus Θ), seconds."""
        number = min(max(int(progress), 0), len(self._starts) - 1)
        return self._starts[number] + (progress - number) * self._durations[number]

    def number(self, plan_s: float) -> int:
        """Find the number of the track of a plan time."""
        return max(bisect_right(self._starts, plan_s) - 1, 0)

    def progress(self, plan_s: float) -> float:
        """Track number plus Θ at a plan time."""
        number = self.number(plan_s)
        return number + (plan_s - self._starts[number]) / self._durations[number]

    def speed(self, craft: str, plan_s: float) -> float:
        """Speed over ground that the plan needs of a craft at a plan time, m/s."""
        number = self.number(plan_s)
        length_m: float = self._craft[craft].tracks[number].length_m
        return length_m / self._durations[number]

    def point(self, craft: str, plan_s: float) -> tuple[float, float]:
        """Planned place of a craft at a plan time, north and east, metres."""
        return self._craft[craft].point(self.progress(plan_s))
