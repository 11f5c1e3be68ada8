"""A craft's copy of the reference that the team shares.

The reference is the plan, held back: its plan time is τ = t - H, and the *hold* H never shrinks, so that Θ of the
reference never runs backwards. Two things make H grow:

* a craft that cannot keep up tells the speed c it can make; the reference then runs at y = min(1, c / v'), v' being
  the speed that the plan needs of that craft, and so its lag does not grow while nothing is heard;
* a craft that has fallen behind asks for the hold W = H - lag that it needs; H follows it, at k·(W - H) and never so
  fast that the reference runs at less than y_min. Every word also asks for the hold that its sender has itself, and so
  all copies come to agree on the greatest.

Both last from a craft's word until its next one. A word counts at the sender, too, only when it has left: then the
mates have it, if they have it. A mate that has been silent for long is no longer waited for; what it has held back so
far stays held. A craft that hears of no mate follows the clock, and makes up what it has lost.
"""

import math
from collections.abc import Iterable

import msgspec

from grex_agent.plan_time import PlanTime
from grex_link.coordination_config import ReferenceConfig
from grex_link.reference_wire import Limit, ReferenceWord, is_newer

_SAME_TIME_S = 1e-9
_STEP_S = 1.0


class Told(msgspec.Struct):
    """What one craft has told."""

    t_s: float
    """Time of its newest word."""
    asked_s: float
    """Hold that it asked for, carried on to now."""
    behind_s: float
    """How far it is thought to be behind the clock now."""
    knows: tuple[Limit, ...]
    """What it knew of everybody's limit."""


class TeamReference:
    """See the module's docstring. Times are mission times, seconds.

    Parameters
    ----------
    craft : str
        Whose copy this is.
    time : PlanTime
        The plan.
    team : iterable of str
        All craft, in their order.
    config : ReferenceConfig
        Gains and limits.

    Attributes
    ----------
    hold_s : float
        H.
    """

    def __init__(self, craft: str, time: PlanTime, team: Iterable[str], config: ReferenceConfig) -> None:
        self._craft = craft
        self._time = time
        self._team = list(team)
        self._config = config
        self._told: dict[str, Told] = {}
        self._limits = dict.fromkeys(self._team, Limit())
        self._alive_s: dict[str, float] = {}
        self._now_s = 0.0
        self.hold_s = 0.0

    @property
    def plan_s(self) -> float:
        """Plan time τ of the reference."""
        return self._now_s - self.hold_s

    @property
    def rate(self) -> float:
        """How fast the reference runs now, seconds of the plan a second."""
        return 1.0 - self._growth(_STEP_S)[1] / _STEP_S

    @property
    def mates(self) -> list[str]:
        """Mates that are there: heard, or newly heard of, not too long ago."""
        oldest_s = self._now_s - self._config.silence_s
        return [craft for craft, t_s in self._alive_s.items() if t_s >= oldest_s]

    def told(self, craft: str) -> Told | None:
        """Return what a craft has told, oneself included."""
        return self._told.get(craft)

    def limit(self, craft: str) -> Limit:
        """Return the newest word of a craft's limit."""
        return self._limits[craft]

    def advance(self, now_s: float) -> None:
        """Run on to a time."""
        while now_s - self._now_s > _SAME_TIME_S:
            self._step(min(now_s - self._now_s, _STEP_S))

    def take(self, craft: str, word: ReferenceWord) -> None:
        """Take a craft's word: a mate's as it is heard, the own one when it has left."""
        before = self._told.get(craft)
        if before is not None and word.t_s < before.t_s:
            return
        self._learn(craft, word)
        behind_s = word.hold_s - word.lag_s
        asked_s = behind_s if word.lag_s < -self._config.deadband_s else word.hold_s
        since_s = max(self._now_s - word.t_s, 0.0) * self._loss(self.plan_s)
        self._told[craft] = Told(word.t_s, asked_s + since_s, behind_s + since_s, word.limits)

    # -- inside -------------------------------------------------------------------------------------------------

    def _learn(self, craft: str, word: ReferenceWord) -> None:
        """Take what a word says of everybody's limit: of its own craft in any case, of others what is newer."""
        for mate, limit in zip(self._team, word.limits, strict=True):
            newer = is_newer(limit.version, self._limits[mate].version)
            if mate == craft or (mate != self._craft and newer):
                self._limits[mate] = limit
                if mate != self._craft:
                    self._alive_s[mate] = max(self._alive_s.get(mate, 0.0), word.t_s)

    def _waited_for(self) -> list[str]:
        """Who may hold the reference back: the mates that are there, and oneself if there are any."""
        mates = self.mates
        return [self._craft, *mates] if mates else []

    def _loss(self, plan_s: float) -> float:
        """By how much the reference runs slower than the plan because somebody cannot keep up."""
        return 1.0 - min((self._share(craft, plan_s) for craft in self._waited_for()), default=1.0)

    def _growth(self, dt: float) -> tuple[float, float]:
        """How much the hold grows over a step: for limits, and in all."""
        loss_s = self._loss(self.plan_s) * dt
        asked = [self._told[craft].asked_s for craft in self._waited_for() if craft in self._told]
        missing_s = max(max(asked, default=0.0) - self.hold_s, 0.0)
        more_s = loss_s + missing_s * (1.0 - math.exp(-self._config.yield_gain_per_s * dt))
        return loss_s, min(more_s, (1.0 - self._config.yield_min) * dt)

    def _share(self, craft: str, plan_s: float) -> float:
        """Share of the plan's speed that a craft can make."""
        most = self._limits[craft].speed_mps
        return 1.0 if most is None else min(1.0, most / self._time.speed(craft, plan_s))

    def _step(self, dt: float) -> None:
        loss_s, more_s = self._growth(dt)
        left = math.exp(-self._config.gain_per_s * dt)
        for craft, told in self._told.items():
            told.asked_s += loss_s
            lag_s = told.behind_s - self.hold_s
            share = self._share(craft, self.plan_s)
            # A craft makes up its lag if it can; if it cannot, it is carried on at its limit, never ahead of the rest.
            limited_s = told.behind_s + (1.0 - share) * dt
            followed_s = self.hold_s + more_s
            told.behind_s = max(limited_s, followed_s) if share < 1.0 else followed_s + lag_s * left
        self._now_s += dt
        self.hold_s += more_s
