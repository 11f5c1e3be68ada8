"""How fast a mate is taken to go by the guard, and how far it is thought to have fallen behind what is believed.

A belief moves by its model from message to message, and jumps by a message. What counts of it here is plan time, of
which a second passes in a second at planned speed: the *rate* is the slower of two,

- that of the belief from step to step, without the jumps;
- that from one message to a later one, with the jumps: a model that knows no speed error always believes in planned
  speed, and only the jumps tell that the mate goes more slowly.

What the mate does less than the belief, by this rate or because its own guard has to hold it back, adds up to a *lag*
from the moment on of which the mate has told last; what it told before is in the belief.
"""

import math
from collections import deque
from dataclasses import dataclass

from grex_agent.plan_time import PlanTime
from grex_link.messages import MateBelief

#: From one message to another at least so many seconds later, a rate is found.
_BETWEEN_S = 15.0
#: The rate from step to step counts as its average over so many seconds: where tracks change a craft needs some time.
_AVERAGE_S = 10.0
#: A mate that makes this share of its planned speed from message to message keeps up; the rest is noise of its fixes.
_KEEPS_UP = 0.95


@dataclass(slots=True)
class _Step:
    """How fast the mate was believed to go in a step that ended at a time, and how fast it is thought to have gone."""

    end_s: float
    step_s: float
    believed: float
    thought: float

    @property
    def lag_s(self) -> float:
        """How much less it has gone than believed, seconds of plan time."""
        return max(self.believed - self.thought, 0.0) * self.step_s


class MatePace:
    """See the module's docstring; one a mate.

    Parameters
    ----------
    time : PlanTime
        Of the team.
    """

    def __init__(self, time: PlanTime) -> None:
        self._time = time
        self._seen_s = math.nan
        self._step_s = self._plan_s = self._age_s = 0.0
        self._believed = self._by_steps = self._by_messages = 1.0
        self._heard: tuple[float, float] | None = None
        self._since_heard: deque[_Step] = deque()
        self._lag_s = 0.0
        self._jumped = False

    @property
    def rate(self) -> float:
        """How fast it is taken to go, as a share of the planned speed."""
        return min(self._by_steps, self._no_faster)

    @property
    def lag_s(self) -> float:
        """How far behind the belief it is taken to be, seconds of plan time."""
        return max(self._lag_s, 0.0)

    def see(self, now_s: float, belief: MateBelief) -> None:
        """Take what is believed of the mate at a step; times in seconds."""
        plan_s = self._time.at(belief.progress)
        age_s = belief.age_s if belief.age_s >= 0.0 else now_s
        step_s = 0.0 if math.isnan(self._seen_s) else now_s - self._seen_s
        if step_s > 0.0:
            self._go_on(now_s, step_s, plan_s, age_s)
        self._seen_s, self._step_s, self._plan_s, self._age_s = now_s, step_s, plan_s, age_s
        while self._since_heard and self._since_heard[0].end_s <= now_s - age_s:
            self._lag_s -= self._since_heard.popleft().lag_s
        if not self._since_heard:
            self._lag_s = 0.0  # What rounding has left of it.

    def held(self, rate: float) -> None:
        """Say how fast it may go at this step: less than `rate` of above, if its guard holds it back."""
        if self._step_s > 0.0:
            thought = min(rate if rate < self.rate else self._no_faster, self._believed)
            self._since_heard.append(_Step(self._seen_s, self._step_s, self._believed, thought))
            self._lag_s += self._since_heard[-1].lag_s

    # -- inside -------------------------------------------------------------------------------------------------

    @property
    def _no_faster(self) -> float:
        return self._by_messages if self._by_messages < _KEEPS_UP else math.inf

    def _go_on(self, now_s: float, step_s: float, plan_s: float, age_s: float) -> None:
        if age_s < self._age_s + 0.5 * step_s and self._age_s > 1.5 * step_s:
            self._hear(now_s, plan_s)
            self._jumped = True
            return
        self._believed = max((plan_s - self._plan_s) / step_s, 0.0)
        self._by_steps += min(step_s / _AVERAGE_S, 1.0) * (self._believed - self._by_steps)
        if self._jumped:
            # Since the mate was heard the belief has gone as fast as it does now, not as fast as it did then.
            for step in self._since_heard:
                step.believed = self._believed
            self._add_up()
            self._jumped = False

    def _hear(self, now_s: float, plan_s: float) -> None:
        """Compare a belief that has just been corrected with one of before."""
        if self._heard is None:
            self._heard = now_s, plan_s
        elif now_s - self._heard[0] >= _BETWEEN_S:
            self._by_messages = max((plan_s - self._heard[1]) / (now_s - self._heard[0]), 0.0)
            self._heard = now_s, plan_s
            for step in self._since_heard:
                step.thought = min(step.thought, self._no_faster)
            self._add_up()

    def _add_up(self) -> None:
        self._lag_s = sum(step.lag_s for step in self._since_heard)
