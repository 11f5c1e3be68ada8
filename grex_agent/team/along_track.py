"""Estimators of the mates on their own paths, which know that a mate has a speed error.

A craft that keeps its track moves in one dimension. State x = [s, v, β]: distance along the plan (m), speed (m/s), and
speed error as a share of the speed ordered. With u the mate's own order (eq. 2) at its progress, and its surge loop,

    v ← v + clip((1 - exp(-dt/T))·((1 + β)·u - v), ± a_max·dt),   s ← s + dt·(v_old + v_new)/2,   β ← exp(-dt/τ)·β

The Jacobian contains ∂u/∂s: the mate corrects itself by its true progress, and so an error of s dies out as its own
coordination does. β is a Gauss–Markov process of given deviation and time constant, which makes its process noise;
v has a small one for what is unknown of u. A message measures s and v.

The filters of all mates are rows of arrays (`along_track_rows`), so that fifty cost little more than three.
"""

import math
from collections.abc import Sequence

import numpy as np

from grex_agent.gaussian import Gaussian, update
from grex_agent.mission import CraftPlan
from grex_agent.team.acknowledgement import SentMessages
from grex_agent.team.along_track_rows import AlongTrackRows
from grex_agent.team.interface import Own, Report, TeamContext
from grex_agent.team.path_length import PathLength
from grex_agent.team.speed_model import SpeedModel
from grex_link.messages import MateBelief
from grex_link.wire import TeamState


class AlongTrackUpdate:
    """What a message does to the state of one mate.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    speed : SpeedModel
        How it keeps its speed.
    """

    def __init__(self, plan: CraftPlan, speed: SpeedModel) -> None:
        self._path = PathLength(plan)
        self._speed = speed

    def __call__(self, state: Gaussian, message: TeamState) -> Gaussian:
        """Work in the distance told, and the speed if the message has one."""
        if message.form == "full":
            planned = self._path.tracks[self._path.number(state.mean[0])].speed_mps
            state = self._speed.hear_speed(state, message.speed_mps, state.mean[1], planned, 1, 2)
        distance, variance = self._path.told(message)
        return update(state, 0, distance - state.mean[0], variance)


class AlongTrackFirst:
    """Along-track filters of the mates; they are taken to know the own present position (as in case c).

    Parameters
    ----------
    context : TeamContext
        Plan and parameters.
    """

    def __init__(self, context: TeamContext) -> None:
        self._context = context
        self._mates = [craft for craft in context.plan.craft if craft != context.craft]
        self._row_of = {craft: row for row, craft in enumerate(self._mates)}
        #: When each mate last said what has been worked in; −∞ as long as it has been silent.
        self._heard_s = np.full(len(self._mates), -math.inf)
        self._silent = np.ones(len(self._mates), dtype=bool)
        team = context.scenario.team
        speed = SpeedModel(team.speed_model)
        plans = [context.plan.craft[craft] for craft in self._modelled()]
        updates = [AlongTrackUpdate(plan, speed) for plan in plans]
        self._rows = AlongTrackRows(
            plans,
            len(self._mates),
            updates,
            context.controller,
            speed,
            start_variance_m2=team.kalman.fix_sigma_m**2,
            memory_s=team.kalman.memory_s,
            tick_s=context.scenario.clock.tick_s,
        )

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Advance, work in what was heard, and say what is believed; see `TeamEstimator`."""
        del sent
        self._rows.advance(now_s)
        self._hear(heard)
        self._rows.drive(own.progress)
        return self._beliefs(now_s)

    def prepare(self, next_s: float) -> None:
        """Predict to the time of the next step in advance; see `TeamEstimator`."""
        self._rows.advance(next_s)

    # -- inside -------------------------------------------------------------------------------------------------

    def _modelled(self) -> list[str]:
        return self._mates

    def _hear(self, heard: Sequence[Report]) -> None:
        for report in heard:
            row = self._row_of[report.craft]
            if self._rows.correct(row, report.state):
                self._heard_s[row] = max(self._heard_s[row], report.state.t_s)
                self._silent[row] = False

    def _beliefs(self, now_s: float) -> list[MateBelief]:
        rows = self._rows
        north, east = rows.points()
        age = now_s - self._heard_s
        age[self._silent] = -1.0
        numbers = (array.tolist() for array in (north, east, rows.progress, rows.sigma_m, age))
        return list(map(MateBelief, self._mates, *numbers))  # rows of oneself, the last ones, have no mate to go with


class AlongTrack(AlongTrackFirst):
    """Besides, what the mates think of oneself: the last rows (as in case d, see `grex_agent.team.levels`).

    Where the mates say what they have heard, there is a row for each of them, as the paper draws it; an own message is
    taken to have been heard by all when it has left, and is taken back from the row of a mate that turns out not to
    have it. Otherwise one row stands for all, and what has left has been heard.

    Parameters
    ----------
    context : TeamContext
        Plan and parameters.
    """

    def __init__(self, context: TeamContext) -> None:
        acknowledgements = context.acknowledgements
        self._many = acknowledgements is not None
        super().__init__(context)
        memory_s = context.scenario.team.kalman.memory_s
        self._sent = None if acknowledgements is None else SentMessages(acknowledgements, memory_s)
        self._own_progress = 0.0

    @property
    def doubt_m(self) -> float:
        """How far some mate is thought to be wrong about the own place, metres along the path."""
        tracks = self._context.plan.craft[self._context.craft].tracks
        track = tracks[min(max(int(self._own_progress), 0), len(tracks) - 1)]
        seen = self._rows.progress[len(self._mates) :]
        return float(np.abs(self._own_progress - seen).max(initial=0.0)) * track.length_m

    @property
    def owes(self) -> bool:
        """Whether something is to be said in any case: nothing ever is."""
        return False

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Advance, work in what was heard and sent, and say what is believed; see `TeamEstimator`."""
        self._own_progress = own.progress
        self._rows.advance(now_s)
        for state in sent:
            self._leave(state, now_s)
        for report in heard:
            self._learn(report)
        self._hear(heard)
        self._rows.drive(None)
        return self._beliefs(now_s)

    # -- inside -------------------------------------------------------------------------------------------------

    def _modelled(self) -> list[str]:
        return [*self._mates, *[self._context.craft] * (len(self._mates) if self._many else 1)]

    def _leave(self, state: TeamState, now_s: float) -> None:
        """Work in an own message that has left: every mate has it, as far as is known."""
        for row in range(len(self._mates), self._rows.count):
            self._rows.correct(row, state)
        if self._sent is not None:
            self._sent.leave(state, now_s)

    def _learn(self, report: Report) -> None:
        """Take back what a mate has not heard."""
        if self._sent is None:
            return
        mate = self._row_of[report.craft]
        for news in self._sent.learn(report):
            self._rows.amend(len(self._mates) + mate, mate, news.message, heard=news.heard)
