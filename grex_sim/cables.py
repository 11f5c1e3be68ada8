"""How far apart craft tied by cable have truly been."""

import math

import msgspec

from grex_agent.tasks.check import cables
from grex_link.config import Scenario
from grex_link.messages import Truth


class Cable(msgspec.Struct):
    """One cable over a run; metres."""

    between: tuple[str, str]
    length_m: float
    longest_m: float = 0.0
    """Greatest true distance, in three dimensions."""
    over_steps: int = 0
    """In how many steps it was longer than the cable."""


class CableWatch:
    """Measures all cables of a scenario.

    Parameters
    ----------
    scenario : Scenario
        Names them.

    Attributes
    ----------
    cables : list of Cable
        As measured so far.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.cables = [Cable((first, second), length_m) for _, first, second, length_m in cables(scenario)]
        team = list(scenario.craft)
        self._ends = [tuple(map(team.index, cable.between)) for cable in self.cables]

    def see(self, truth: Truth) -> None:
        """Take the true poses of a step."""
        for cable, (first, second) in zip(self.cables, self._ends, strict=True):
            one, other = truth.poses[first], truth.poses[second]
            apart_m = math.hypot(one.north_m - other.north_m, one.east_m - other.east_m, one.down_m - other.down_m)
            cable.longest_m = max(cable.longest_m, apart_m)
            cable.over_steps += apart_m > cable.length_m
