"""Along-track filters as rows of arrays, with a history that takes messages however late they are.

All rows are predicted together, step by step. A message concerns one row: it is worked in at the time it speaks of, and
that row alone is done anew from there, with every other message at its own place. So the result does not depend on the
order of arrival (GREX 2008, eq. 11), and what a message costs does not depend on the number of rows.

Everybody is driven by the progress of everybody else. Of that only sums and the single values are kept for each step,
so that the laws that need no more (`speeds`) cost the same for every row.

The first rows are the mates. Those behind them are oneself, as a mate thinks: one for all the mates, or one for each.
"""

from collections import deque
from collections.abc import Callable, Sequence
from itertools import islice, pairwise
from operator import attrgetter

import numpy as np
import numpy.typing as npt

from grex_agent.coordination import SpeedController, TeamSpeeds
from grex_agent.gaussian import Gaussian
from grex_agent.mission import CraftPlan
from grex_agent.team.along_track_step import SAME_TIME_S, Others, Said, Step, packed, unpacked
from grex_agent.team.path_length import Located, PathLengths
from grex_agent.team.speed_model import SpeedModel
from grex_link.wire import TeamState

Array = npt.NDArray[np.float64]
#: What a message does to the state of its row.
Update = Callable[[Gaussian, TeamState], Gaussian]

#: Step of progress over which the law is differentiated.
_NUDGE = 1e-3
_HERE_AND_FURTHER = np.array([[0.0], [_NUDGE]])
#: Where the variances of s, v and β are in a column of `Step.x`.
_SS, _VV, _BB = 3, 7, 11


class AlongTrackRows:
    """The along-track filters of several craft.

    Parameters
    ----------
    plans : sequence of CraftPlan
        Whose tracks each row is on: the mates, then oneself as the mates think.
    mates : int
        How many mates there are.
    updates : sequence of Update
        What a message does to each row.
    controller : SpeedController
        The law they all follow; if it has a method `speeds`, that is used for all rows at once.
    speed : SpeedModel
        How they keep their speed.
    start_variance_m2 : float
        Of their places at the beginning.
    memory_s, tick_s : float
        How far back a message may reach, and the length of a step.

    Attributes
    ----------
    count : int
        How many rows there are.
    """

    def __init__(
        self,
        plans: Sequence[CraftPlan],
        mates: int,
        updates: Sequence[Update],
        controller: SpeedController,
        speed: SpeedModel,
        *,
        start_variance_m2: float,
        memory_s: float,
        tick_s: float,
    ) -> None:
        self._paths = PathLengths(plans)
        self._mates = mates
        self.count = len(plans)
        self._updates = updates
        self._law = controller
        self._law_of_all = controller.speeds if isinstance(controller, TeamSpeeds) else None
        self._speed = speed
        self._memory_s = memory_s
        self._tick_s = tick_s
        config = speed.config
        x = np.zeros((12, len(plans)))
        x[1] = [plan.tracks[0].speed_mps for plan in plans]
        x[_SS], x[_VV], x[_BB] = start_variance_m2, config.told_sigma_mps**2, config.error_relative**2
        self._history = deque([Step(0.0, x)])
        self._located: Located | None = None

    @property
    def progress(self) -> Array:
        """Track number plus Θ of each row now, shape (n,)."""
        return self._locate().progress

    @property
    def sigma_m(self) -> Array:
        """Standard deviation of the distance along the plan of each row now, shape (n,)."""
        sigma: Array = np.sqrt(self._history[-1].x[_SS])
        return sigma

    def state(self, row: int) -> Gaussian:
        """[s, v, β] of a row now, with covariance."""
        return self._history[-1].row(row)

    def points(self) -> tuple[Array, Array]:
        """North and east of each row now, metres: on its plan."""
        return self._locate().points()

    def advance(self, now_s: float) -> None:
        """Predict all rows up to a time (KF 1), in steps of a tick where more has passed.

        A prediction that was made in advance, for a later time than it turns out to be, is taken back.
        """
        history = self._history
        while history[-1].t_s > now_s + SAME_TIME_S and len(history) > 1:
            history.pop()
            self._located = None
        while now_s - history[-1].t_s > 1.5 * self._tick_s:
            self._append(history[-1].t_s + self._tick_s)
        if now_s - history[-1].t_s > SAME_TIME_S:
            self._append(now_s)
        while now_s - history[0].t_s > self._memory_s:
            history.popleft()

    def drive(self, own: float | None) -> None:
        """Let everybody know how far the others are; it holds until told anew.

        Parameters
        ----------
        own : float or None
            How far oneself is; None if the last rows say what the mates think of that.
        """
        progress = self.progress
        seen = progress[self._mates :] if own is None else np.array((own,))
        self._history[-1].others = Others(progress, seen, self._mates)

    def correct(self, row: int, message: TeamState) -> bool:
        """Work a message into a row at the time it speaks of, and recalculate that row from there (KF 2).

        Returns
        -------
        bool
            False if it speaks of a time too long ago, or of the future.
        """
        index = self._place_for(message.t_s)
        if index is None:
            return False
        self._put_in(index, row, message)
        self._recalculate(index, row)
        self._located = None
        return True

    def amend(self, own: int, mate: int, message: TeamState, *, heard: bool) -> None:
        """Do two rows anew, because a mate has heard an own message after all, or has not heard it.

        Both are done together from the time of the message on, each driven by the other: the mate has gone by what it
        thinks of oneself.

        Parameters
        ----------
        own, mate : int
            The row of oneself as that mate thinks, and of the mate.
        message : TeamState
            The own message.
        heard : bool
            Whether it has been heard.
        """
        history = self._history
        index = next((i for i in reversed(range(len(history))) if history[i].says(own, message)), None)
        if heard and index is None:
            index = self._place_for(message.t_s)
            if index is not None:
                self._put_in(index, own, message)
        if index is None:  # too long ago
            return
        states = {row: history[index].before(row) for row in (own, mate)}
        if not heard:
            said = [each for each in history[index].said[own] if each.message.t_s != message.t_s]
            history[index].said[own] = said
        self._recalculate_pair(index, own, mate, states)
        self._located = None

    # -- prediction ---------------------------------------------------------------------------------------------

    def _locate(self) -> Located:
        if self._located is None:
            self._located = self._paths.locate(self._history[-1].x[0])
        return self._located

    def _append(self, t_s: float) -> None:
        last, located = self._history[-1], self._locate()
        x = self._predict(last.x, self._order_all(located, last.others), t_s - last.t_s, located)
        self._history.append(Step(t_s, x, last.others))
        self._located = None

    def _predict_row(self, row: int, state: Gaussian, others: Others | None, dt: float) -> Gaussian:
        x = packed(state)[:, None]
        located = self._paths.locate_row(row, state.mean[0])
        return unpacked(self._predict(x, self._one_by_one([row], located, others), dt, located)[:, 0])

    def _predict(self, x: Array, orders: Array, dt: float, located: Located) -> Array:
        """Predict some rows over `dt` seconds: the new mean by the model, its covariance by J P Jᵀ + Q.

        With v' = λ·x the new speed, linearised, the new distance is s + dt/2·(v + v').
        """
        ordered, nudged = orders
        after, by_speed, by_order, by_error = self._speed.step_all(x[1], ordered, x[2], dt)
        keep, error_noise = self._speed.fading(dt)
        half = dt / 2.0
        jacobian = np.zeros((3, 3, x.shape[1]))
        distance, driven = jacobian[0], jacobian[1]
        np.divide(by_order * (nudged - ordered), _NUDGE * located.length_m, out=driven[0])  # λ
        driven[1], driven[2] = by_speed, by_error
        np.multiply(driven, half, out=distance)
        distance[0] += 1.0
        distance[1] += half
        jacobian[2, 2] = keep
        new = np.empty_like(x)
        np.add(x[0], half * (x[1] + after), out=new[0])
        new[1] = after
        np.multiply(x[2], keep, out=new[2])
        before, covariance = x[3:].reshape(3, 3, -1), new[3:].reshape(3, 3, -1)
        np.einsum("ikn,lkn->iln", np.einsum("ijn,jkn->ikn", jacobian, before), jacobian, out=covariance)
        new[_VV] += self._speed.config.noise_mps**2 * dt
        new[_BB] += error_noise
        return new

    def _order_all(self, located: Located, others: Others | None) -> Array:
        """Speeds that all rows order, and those they would order a little further on; shape (2, n)."""
        progress = located.progress
        if self._law_of_all is None:
            return self._one_by_one(range(len(progress)), located, others)
        here_and_further = progress + _HERE_AND_FURTHER
        if others is None:
            return self._law_of_all(located.planned_mps, here_and_further, np.zeros_like(progress), 0)
        return self._law_of_all(located.planned_mps, here_and_further, others.sums(), others.mates)

    def _one_by_one(self, rows: Sequence[int], located: Located, others: Others | None) -> Array:
        law, orders = self._law.speed, np.empty((2, len(rows)))
        for place, row in enumerate(rows):
            planned, progress = float(located.planned_mps[place]), float(located.progress[place])
            mates = [] if others is None else others.of(row)
            orders[:, place] = law(planned, progress, mates), law(planned, progress + _NUDGE, mates)
        return orders

    # -- messages -----------------------------------------------------------------------------------------------

    def _place_for(self, t_s: float) -> int | None:
        """Index of the last step that is not after a time."""
        history = self._history
        index = len(history) - 1
        while index >= 0 and history[index].t_s > t_s + SAME_TIME_S:
            index -= 1
        if index < 0 or t_s > history[-1].t_s + self._tick_s:
            return None
        return index

    def _put_in(self, index: int, row: int, message: TeamState) -> None:
        """Put a message among those said between a step and the next; it takes the place of one of the same time."""
        step = self._history[index]
        t_s = step.t_s if index == len(self._history) - 1 else message.t_s
        said = step.said.setdefault(row, [])
        for other in said:
            if abs(other.t_s - t_s) <= SAME_TIME_S:
                other.message = message
                return
        said.append(Said(t_s, message, step.row(row)))
        said.sort(key=attrgetter("t_s"))

    def _recalculate(self, index: int, row: int) -> None:
        """Go through the history of a row from a step on, with every message at its place."""
        entries = list(islice(self._history, index, None))
        state = self._at(entries[0], row, entries[0].before(row))
        for entry, following in pairwise(entries):
            state, t_s = self._between(entry, row, state)
            state = self._predict_row(row, state, entry.others, following.t_s - t_s)
            state = self._at(following, row, state)

    def _recalculate_pair(self, index: int, own: int, mate: int, states: dict[int, Gaussian]) -> None:
        """Go through the history of a mate and of oneself as it thinks, and let each know how far the other is."""
        entries = list(islice(self._history, index, None))
        for entry, following in pairwise(entries):
            for row, state in states.items():
                states[row] = self._at(entry, row, state)
            if entry.others is not None:
                progress = (self._paths.locate_row(row, states[row].mean[0]).progress[0] for row in (mate, own))
                entry.others = entry.others.put(mate, *progress)
            for row, at in states.items():
                state, t_s = self._between(entry, row, at)
                states[row] = self._predict_row(row, state, entry.others, following.t_s - t_s)
        for row, state in states.items():
            self._at(entries[-1], row, state)

    def _at(self, step: Step, row: int, state: Gaussian) -> Gaussian:
        """Work in what was said of the time of a step, and note the state."""
        for said in step.said.get(row, ()):
            if said.t_s <= step.t_s + SAME_TIME_S:
                said.prior = state
                state = self._updates[row](state, said.message)
        step.put(row, state)
        return state

    def _between(self, step: Step, row: int, state: Gaussian) -> tuple[Gaussian, float]:
        """Work in what was said of times after a step; return the state, and the time it has come to."""
        t_s = step.t_s
        for said in step.said.get(row, ()):
            if said.t_s > step.t_s + SAME_TIME_S:
                said.prior = self._predict_row(row, state, step.others, said.t_s - t_s)
                state, t_s = self._updates[row](said.prior, said.message), said.t_s
        return state, t_s
