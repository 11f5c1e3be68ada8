"""One mate as its observer models it: a copy of its manoeuvre processor, guidance and controller about a Kalman filter.

The history keeps, for every step, the state before any message, the message if there was one, and the progress of the
others that drove the model. A message that arrives late is put where it belongs and everything after it is done anew,
with every other message at its own place: the result does not depend on the order of arrival (GREX 2008, eq. 11).
"""

import math
from collections import deque
from collections.abc import Sequence
from itertools import islice

import msgspec

from grex_agent.coordination import SpeedController
from grex_agent.guidance import TrackKeeping
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import CraftPlan
from grex_agent.path import Place, Track
from grex_agent.team.kalman import PlanarModel, PlanarState, Recalculation
from grex_link.messages import MateBelief
from grex_link.wire import TeamState

_SAME_TIME_S = 1e-6


class Entry(msgspec.Struct):
    """One step of a mate's history."""

    t_s: float
    """Mission time."""
    prior: PlanarState
    """State before the message of this time, if there is one."""
    state: PlanarState
    """State after it."""
    number: int
    """Number of the track that state is on."""
    track: Track
    place: Place
    progress: float
    """Track number plus Θ."""
    others: Sequence[float]
    """Progress of everybody else, as this mate is thought to see it."""
    message: TeamState | None = None
    """What the mate said of this time."""


class MateFilter:
    """Estimates one mate from its plan, its control law and its rare messages.

    Parameters
    ----------
    plan : CraftPlan
        The mate's tracks.
    guidance : TrackKeeping
        Its track keeping.
    controller : SpeedController
        Its coordination law.
    model : PlanarModel
        KF 1.
    recalculation : Recalculation
        KF 2, shared with other mates.
    memory_s, tick_s : float
        How far back a message may reach, and the length of a step.
    """

    def __init__(
        self,
        plan: CraftPlan,
        guidance: TrackKeeping,
        controller: SpeedController,
        model: PlanarModel,
        recalculation: Recalculation,
        memory_s: float,
        tick_s: float,
    ) -> None:
        self._guidance = guidance
        self._controller = controller
        self._model = model
        self._recalculation = recalculation
        self._memory_s = memory_s
        self._tick_s = tick_s
        self._processor = ManoeuvreProcessor(plan)
        north, east, course = plan.start
        speed = plan.tracks[0].speed_mps
        start = PlanarState(
            north,
            east,
            speed * math.cos(course),
            speed * math.sin(course),
            model.fix_noise,
            0.0,
            model.velocity_noise,
        )
        self._history: deque[Entry] = deque([self._located(0.0, start, ())])
        self._heard_s: float | None = None

    @property
    def progress(self) -> float:
        """Estimated progress now: track number plus Θ."""
        return self._history[-1].progress

    @property
    def state(self) -> PlanarState:
        """Estimated state now."""
        return self._history[-1].state

    def belief(self, craft: str, now_s: float) -> MateBelief:
        """Say what is believed now; the age is -1 if nothing has been heard."""
        entry = self._history[-1]
        state = entry.state
        age_s = -1.0 if self._heard_s is None else now_s - self._heard_s
        return MateBelief(craft, state.north, state.east, entry.progress, math.sqrt(state.pp), age_s)

    def advance(self, now_s: float) -> None:
        """KF 1: predict up to a time, in steps of a tick where more has passed.

        A prediction that was made in advance, for a later time than it turns out to be, is taken back.
        """
        history = self._history
        last = history[-1]
        while last.t_s > now_s + _SAME_TIME_S and len(history) > 1:
            history.pop()
            last = history[-1]
            self._processor.go_to(last.number)
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
        """KF 2: work in a message at the time it speaks of, and recalculate from there.

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

    def _append(self, last: Entry, t_s: float) -> Entry:
        u_north, u_east = self._order(last)
        prior = self._model.predict(last.state, u_north, u_east, t_s - last.t_s)
        entry = self._located(t_s, prior, last.others)
        self._history.append(entry)
        return entry

    def _order(self, entry: Entry) -> tuple[float, float]:
        """Wanted velocity û of the mate: its guidance and its controller (eq. 2) at the estimated place."""
        track = entry.track
        speed = self._controller.speed(track.speed_mps, entry.progress, entry.others)
        course = self._guidance.course(track, entry.place)
        return speed * math.cos(course), speed * math.sin(course)

    def _located(self, t_s: float, prior: PlanarState, others: Sequence[float]) -> Entry:
        """Make an entry of a predicted state; leaves the processor on its track."""
        processor = self._processor
        place = processor.follow(prior.north, prior.east)
        return Entry(t_s, prior, prior, processor.number, processor.track, place, processor.progress, others)

    def _relocate(self, entry: Entry) -> None:
        """Find track, place and progress of an entry whose state has changed; leaves the processor on that track."""
        processor = self._processor
        entry.place = processor.follow(entry.state.north, entry.state.east)
        entry.number, entry.track = processor.number, processor.track
        entry.progress = processor.progress

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
        before = history[index]
        u_north, u_east = self._order(before)
        prior = self._model.predict(before.state, u_north, u_east, t_s - before.t_s)
        history.insert(index + 1, self._located(t_s, prior, before.others))
        return index + 1

    def _recalculate(self, index: int) -> None:
        """Go through the history from an entry with a message on, with every message at its place."""
        entries = list(islice(self._history, index, None))
        kf2 = self._recalculation
        kf2.start(entries[0].prior)
        for entry, following in zip(entries, [*entries[1:], None], strict=True):
            entry.state = entry.prior
            if entry.message is not None:
                kf2.update(entry.message.north_m, entry.message.east_m)
                entry.state = kf2.state
                # The mate knows its own track best; without this an estimate that ran ahead could never come back.
                self._processor.go_to(entry.message.track)
            self._relocate(entry)
            if following is not None:
                kf2.predict(*self._order(entry), following.t_s - entry.t_s)
                following.prior = kf2.state
