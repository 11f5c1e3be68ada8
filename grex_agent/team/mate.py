"""One mate as its observer models it: a model of its motion, and a history that takes messages however late they are.

The history keeps, for every step, the state before any message, the message if there was one, and the progress of the
others that drove the model. A message that arrives late is put where it belongs and everything after it is done anew,
with every other message at its own place: the result does not depend on the order of arrival (GREX 2008, eq. 11).
What the state is, how it moves and what a message does to it is the model's affair.
"""

from collections import deque
from collections.abc import Sequence
from itertools import islice, pairwise
from typing import Generic, Protocol, TypeVar

import msgspec

from grex_link.messages import MateBelief
from grex_link.wire import TeamState

_SAME_TIME_S = 1e-6

State = TypeVar("State")


class MateModel(Protocol[State]):
    """How one mate moves and what its messages say: pure functions of an immutable state with its covariance."""

    def start(self) -> State:
        """State at the beginning of the plan."""

    def predict(self, state: State, others: Sequence[float], dt: float) -> State:
        """Predict over `dt` seconds, with the progress of everybody else as the mate is thought to see it."""

    def update(self, state: State, message: TeamState) -> State:
        """Work in a message of the time of the state."""

    def progress(self, state: State) -> float:
        """Track number plus Θ."""

    def position(self, state: State) -> tuple[float, float, float]:
        """North, east and the standard deviation of each, metres."""


class Entry(msgspec.Struct, Generic[State]):
    """One step of a mate's history."""

    t_s: float
    """Mission time."""
    prior: State
    """State before the message of this time, if there is one."""
    state: State
    """State after it."""
    others: Sequence[float]
    """Progress of everybody else, as this mate is thought to see it."""
    message: TeamState | None = None
    """What the mate said of this time."""


class MateFilter(Generic[State]):
    """Estimates one mate from a model of its motion and its rare messages.

    Parameters
    ----------
    model : MateModel
        How it moves.
    memory_s, tick_s : float
        How far back a message may reach, and the length of a step.
    """

    def __init__(self, model: MateModel[State], memory_s: float, tick_s: float) -> None:
        self._model = model
        self._memory_s = memory_s
        self._tick_s = tick_s
        start = model.start()
        self._history: deque[Entry[State]] = deque([Entry(0.0, start, start, ())])
        self._heard_s: float | None = None

    @property
    def progress(self) -> float:
        """Estimated progress now: track number plus Θ."""
        return self._model.progress(self._history[-1].state)

    @property
    def state(self) -> State:
        """Estimated state now."""
        return self._history[-1].state

    def belief(self, craft: str, now_s: float) -> MateBelief:
        """Say what is believed now; the age is -1 if nothing has been heard."""
        state = self.state
        north, east, sigma = self._model.position(state)
        age_s = -1.0 if self._heard_s is None else now_s - self._heard_s
        return MateBelief(craft, north, east, self._model.progress(state), sigma, age_s)

    def advance(self, now_s: float) -> None:
        """Predict up to a time (KF 1), in steps of a tick where more has passed.

        A prediction that was made in advance, for a later time than it turns out to be, is taken back.
        """
        history = self._history
        last = history[-1]
        while last.t_s > now_s + _SAME_TIME_S and len(history) > 1:
            history.pop()
            last = history[-1]
        while now_s - last.t_s > 1.5 * self._tick_s:
            last = self._append(last, last.t_s + self._tick_s)
        if now_s - last.t_s > _SAME_TIME_S:
            self._append(last, now_s)
        while now_s - history[0].t_s > self._memory_s:
            history.popleft()

    def drive(self, others: Sequence[float]) -> None:
        """Say how far the others are, as this mate is thought to see it; it holds until told anew."""
        self._history[-1].others = others

    def correct(self, message: TeamState) -> bool:
        """Work in a message at the time it speaks of, and recalculate from there (KF 2).

        Returns
        -------
        bool
            False if it speaks of a time too long ago, or of the future.
        """
        index = self._place_for(message.t_s)
        if index is None:
            return False
        self._history[index].message = message
        self._heard_s = message.t_s if self._heard_s is None else max(self._heard_s, message.t_s)
        self._recalculate(index)
        return True

    # -- inside -------------------------------------------------------------------------------------------------

    def _append(self, last: Entry[State], t_s: float) -> Entry[State]:
        entry = self._following(last, t_s)
        self._history.append(entry)
        return entry

    def _following(self, before: Entry[State], t_s: float) -> Entry[State]:
        prior = self._model.predict(before.state, before.others, t_s - before.t_s)
        return Entry(t_s, prior, prior, before.others)

    def _place_for(self, t_s: float) -> int | None:
        """Index of the entry of a time; one is put in if the time lies between two steps."""
        history = self._history
        index = len(history) - 1
        while index >= 0 and history[index].t_s > t_s + _SAME_TIME_S:
            index -= 1
        if index < 0 or t_s > history[-1].t_s + self._tick_s:
            return None
        if t_s - history[index].t_s <= _SAME_TIME_S:
            return index
        if index == len(history) - 1:
            return index  # a clock a little ahead of ours: as if it were now
        history.insert(index + 1, self._following(history[index], t_s))
        return index + 1

    def _recalculate(self, index: int) -> None:
        """Go through the history from an entry with a message on, with every message at its place."""
        entries = list(islice(self._history, index, None))
        self._work_in(entries[0])
        for entry, following in pairwise(entries):
            following.prior = self._model.predict(entry.state, entry.others, following.t_s - entry.t_s)
            self._work_in(following)

    def _work_in(self, entry: Entry[State]) -> None:
        entry.state = entry.prior if entry.message is None else self._model.update(entry.prior, entry.message)
