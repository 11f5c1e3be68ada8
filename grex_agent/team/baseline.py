"""The two ends of the scale: no belief at all (case a), and the truth (case b, on the bench only)."""

from collections.abc import Sequence

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.team.interface import Own, Report, TeamContext
from grex_link.messages import MateBelief, Truth
from grex_link.wire import TeamState


class Unaware:
    """Believes nothing about anybody: every craft keeps its planned speed (GREX 2008, case a)."""

    def __init__(self, context: TeamContext) -> None:
        del context

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Believe nothing."""
        del now_s, own, sent, heard
        return []


class Ideal:
    """Knows every true position (GREX 2008, case b): what no craft can have, to compare with.

    Parameters
    ----------
    context : TeamContext
        Names the own craft and the plan.
    """

    def __init__(self, context: TeamContext) -> None:
        self._mates = {
            craft: ManoeuvreProcessor(plan) for craft, plan in context.plan.craft.items() if craft != context.craft
        }
        self._beliefs: list[MateBelief] = []

    def see(self, truth: Truth) -> None:
        """Take the true poses of this step."""
        self._beliefs = []
        for pose in truth.poses:
            if mate := self._mates.get(pose.craft):
                mate.follow(pose.north_m, pose.east_m)
                self._beliefs.append(
                    MateBelief(pose.craft, pose.north_m, pose.east_m, mate.progress, sigma_m=0.0, age_s=0.0)
                )

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Say the truth."""
        del now_s, own, sent, heard
        return self._beliefs
