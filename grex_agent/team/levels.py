"""Estimators of two levels: one filter a mate (case c), and what the mates think of oneself besides (case d).

They are the same for every model of a mate's motion; a class of a module beside this one names its model.
"""

from collections.abc import Sequence
from typing import Any

from grex_agent.mission import CraftPlan
from grex_agent.team.interface import Own, Report, TeamContext
from grex_agent.team.mate import MateFilter, MateModel
from grex_link.messages import MateBelief
from grex_link.wire import TeamState


class FirstLevelOf:
    """One estimator a mate; inside them the mates are taken to know the own present position (GREX 2008, case c).

    Parameters
    ----------
    context : TeamContext
        Plan and parameters.
    """

    def __init__(self, context: TeamContext) -> None:
        self._context = context
        self._mates = {craft: self._filter(craft) for craft in context.plan.craft if craft != context.craft}

    def model(self, context: TeamContext, plan: CraftPlan) -> MateModel[Any]:
        """Build the model of a mate that follows a plan."""
        raise NotImplementedError

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Advance, work in what was heard, and say what is believed; see `TeamEstimator`."""
        del sent
        self._advance(now_s, heard)
        self._drive(own.progress)
        return self._beliefs(now_s)

    def prepare(self, next_s: float) -> None:
        """Predict to the time of the next step in advance; see `TeamEstimator`."""
        for mate in self._mates.values():
            mate.advance(next_s)

    def _filter(self, craft: str) -> MateFilter[Any]:
        scenario = self._context.scenario
        model = self.model(self._context, self._context.plan.craft[craft])
        return MateFilter(model, scenario.team.kalman.memory_s, scenario.clock.tick_s)

    def _advance(self, now_s: float, heard: Sequence[Report]) -> None:
        for mate in self._mates.values():
            mate.advance(now_s)
        for report in heard:
            self._mates[report.craft].correct(report.state)

    def _drive(self, own_as_seen: float) -> list[float]:
        """Tell every mate's model how far the others are, oneself as the mates see it; return how far the mates are."""
        progress = [mate.progress for mate in self._mates.values()]
        for place, mate in enumerate(self._mates.values()):
            mate.drive([own_as_seen, *progress[:place], *progress[place + 1 :]])
        return progress

    def _beliefs(self, now_s: float) -> list[MateBelief]:
        return [mate.belief(craft, now_s) for craft, mate in self._mates.items()]


class SecondLevelOf(FirstLevelOf):
    """Besides, an estimator of what the mates believe about oneself, which drives their models (GREX 2008, case d).

    It is corrected only by the own messages, at the moment the modem says that they have left: that is when the mates
    have them, if they have them. The paper draws one such estimator a mate; all mates are taken to hear the same
    messages and to see the others alike, so they would be equal, and one stands for all.

    Parameters
    ----------
    context : TeamContext
        Plan and parameters.
    """

    def __init__(self, context: TeamContext) -> None:
        super().__init__(context)
        self._own_as_seen = self._filter(context.craft)
        self._own_progress = 0.0

    @property
    def doubt_m(self) -> float:
        """How far the mates are thought to be wrong about the own place, metres along the path."""
        tracks = self._context.plan.craft[self._context.craft].tracks
        track = tracks[min(max(int(self._own_progress), 0), len(tracks) - 1)]
        return abs(self._own_progress - self._own_as_seen.progress) * track.length_m

    @property
    def owes(self) -> bool:
        """Whether something is to be said in any case: nothing ever is."""
        return False

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Advance, work in what was heard and sent, and say what is believed; see `TeamEstimator`."""
        self._own_progress = own.progress
        self._advance(now_s, heard)
        self._own_as_seen.advance(now_s)
        for state in sent:
            self._own_as_seen.correct(state)
        self._own_as_seen.drive(self._drive(self._own_as_seen.progress))
        return self._beliefs(now_s)

    def prepare(self, next_s: float) -> None:
        """Predict to the time of the next step in advance; see `TeamEstimator`."""
        super().prepare(next_s)
        self._own_as_seen.advance(next_s)
