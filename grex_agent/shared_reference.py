"""The coordination law of the shared reference: every craft tracks its own copy of it, and tells how it gets on.

    v = v'·(y + k_ref·(τ_ref - τ_own))

y is the speed of the reference, τ_own the plan time of the own place, and v' what the plan needs at the place where the
craft will be when its surge has followed. No estimator of the mates is in the loop: what is believed of them comes from
their words. A craft that has fallen behind and does not catch up finds out what speed it can make, tells it, and goes
on trying to run at planned speed until it can. The law has no integral that could wind up, and keeps the speed limits.
"""

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from grex_agent.mission import TeamPlan
from grex_agent.plan_time import PlanTime
from grex_agent.team.interface import Own
from grex_agent.team_reference import TeamReference
from grex_link.config import Scenario
from grex_link.messages import MateBelief
from grex_link.reference_wire import LIMIT_STEP_MPS, VERSIONS, Limit, ReferenceWord

#: Over so many seconds the own speed is measured, to find out whether a craft keeps up.
_WINDOW_S = 5.0
#: A craft that makes this share of the speed it needs keeps up.
_KEEPS_UP = 0.97
#: A limit is told anew when it is off by more.
_LIMIT_OFF_MPS = 1.5 * LIMIT_STEP_MPS


class Heard(NamedTuple):
    """A word of the reference and whose it is."""

    craft: str
    word: ReferenceWord


class OwnAbility:
    """Finds out whether the craft keeps up, and what speed it makes if it does not.

    Parameters
    ----------
    time : PlanTime
        The plan.
    craft : str
        Whose ability.
    deadband_s : float
        So far it may be behind.
    """

    def __init__(self, time: PlanTime, craft: str, deadband_s: float) -> None:
        self._time = time
        self._craft = craft
        self._deadband_s = deadband_s
        self._passed: deque[tuple[float, float]] = deque()
        self.limit_mps: float | None = None

    def see(self, now_s: float, plan_s: float, lag_s: float, rate: float) -> None:
        """Take the own plan time, how far it is ahead of the reference, and how fast that runs."""
        passed = self._passed
        if passed and now_s <= passed[-1][0]:
            return
        passed.append((now_s, plan_s))
        while len(passed) > 2 and now_s - passed[1][0] >= _WINDOW_S:
            passed.popleft()
        elapsed_s = now_s - passed[0][0]
        if elapsed_s < _WINDOW_S:
            return
        made = (plan_s - passed[0][1]) / elapsed_s
        if self.limit_mps is None:
            falls_behind = lag_s < -self._deadband_s and made < _KEEPS_UP * rate
        else:
            falls_behind = made < _KEEPS_UP
        self.limit_mps = max(made, 0.0) * self._time.speed(self._craft, plan_s) if falls_behind else None


class SharedReference:
    """The law, and what it makes of the mates' words; see the module's docstring, `SpeedController`, `TeamEstimator`.

    Parameters
    ----------
    scenario : Scenario
        Parameters.
    craft : str
        Whose law it is.
    plan : TeamPlan
        Of everybody.
    """

    def __init__(self, scenario: Scenario, craft: str, plan: TeamPlan) -> None:
        team = scenario.team
        self._craft = craft
        self._team = list(plan.craft)
        self._time = PlanTime(plan)
        self._config = team.reference
        self._ahead_s = team.speed_model.lag_s
        self._speed_min_mps, self._speed_max_mps = team.speed_min_mps, team.speed_max_mps
        self._reference = TeamReference(self._craft, self._time, self._team, self._config)
        self._ability = OwnAbility(self._time, self._craft, self._config.deadband_s)
        self._now_s = self._own_plan_s = 0.0
        self._limit = Limit(1)
        self._answers = False

    # -- as an estimator ----------------------------------------------------------------------------------------

    def step(self, now_s: float, own: Own, sent: Sequence[ReferenceWord], heard: Sequence[Heard]) -> list[MateBelief]:
        """Run the reference on to a time, take what was sent and heard, and say where the mates are thought to be."""
        reference = self._reference
        reference.advance(now_s)
        for word in sent:
            reference.take(self._craft, word)
        for craft, word in heard:
            self._hear(craft, word)
        self._now_s, self._own_plan_s = now_s, self._time.at(own.progress)
        self._ability.see(now_s, self._own_plan_s, self.lag_s, reference.rate)
        return [self._belief(mate) for mate in self._team if mate != self._craft]

    def _belief(self, craft: str) -> MateBelief:
        told = self._reference.told(craft)
        plan_s = self._reference.plan_s if told is None else self._now_s - told.behind_s
        north, east = self._time.point(craft, plan_s)
        age_s = -1.0 if told is None else self._now_s - told.t_s
        return MateBelief(craft, north, east, self._time.progress(plan_s), 0.0, age_s)

    # -- as a controller ----------------------------------------------------------------------------------------

    @property
    def hold_s(self) -> float:
        """How far the own copy of the reference is behind the clock."""
        return self._reference.hold_s

    @property
    def reference(self) -> float:
        """Progress of the reference, as the own copy has it: track number plus Θ."""
        return self._time.progress(self._reference.plan_s)

    @property
    def lag_s(self) -> float:
        """How far the craft is ahead of the reference, seconds of the plan; negative behind."""
        return self._own_plan_s - self._reference.plan_s

    def speed(self, planned_mps: float, own: float, mates: Sequence[float]) -> float:
        """Order a speed; see `SpeedController`."""
        del planned_mps, own, mates
        # Who cannot keep up goes on trying, even ahead of the reference: only so it sees that it can.
        tries = self._ability.limit_mps is not None
        lag_s = min(self.lag_s, 0.0) if tries else self.lag_s
        share = (1.0 if tries else self._reference.rate) - self._config.gain_per_s * lag_s
        speed = share * self._time.speed(self._craft, self._own_plan_s + share * self._ahead_s)
        return min(max(speed, self._speed_min_mps), self._speed_max_mps)

    # -- what is told -------------------------------------------------------------------------------------------

    @property
    def doubt_m(self) -> float:
        """How far what the mates believe of the own place is from the truth, metres along the path."""
        told = self._reference.told(self._craft)
        believed_s = self._reference.plan_s if told is None else self._now_s - told.behind_s
        return abs(self._own_plan_s - believed_s) * self._time.speed(self._craft, self._own_plan_s)

    @property
    def owes(self) -> bool:
        """Whether something is to be said in any case: a limit that is new or not known to all, or an answer."""
        return self._answers or self._limit_now() != self._limit or self._unknown_to_some()

    def word(self) -> ReferenceWord:
        """Say what is to be told now."""
        self._limit = self._limit_now()
        self._answers = False
        limits = tuple(self._limit if mate == self._craft else self._reference.limit(mate) for mate in self._team)
        place = self._team.index(self._craft)
        return ReferenceWord(place, self._now_s, self.hold_s, self.lag_s, limits, self._unknown_to_some())

    # -- inside -------------------------------------------------------------------------------------------------

    def _hear(self, craft: str, word: ReferenceWord) -> None:
        """Take a mate's word; one who asks, or whose reference is ahead of the own one, is answered."""
        self._reference.take(craft, word)
        told = self._reference.told(craft)
        if word.asks or (told is not None and told.asked_s < self.hold_s - self._config.deadband_s):
            self._answers = True

    def _limit_now(self) -> Limit:
        """Return the own limit, in a new version if what was said of it does not hold any more."""
        said, now_mps = self._limit.speed_mps, self._ability.limit_mps
        if said == now_mps or (said is not None and now_mps is not None and abs(said - now_mps) <= _LIMIT_OFF_MPS):
            return self._limit
        return Limit(self._limit.version % VERSIONS + 1, now_mps)

    def _unknown_to_some(self) -> bool:
        """Whether a mate that is there has not said that it knows the own limit, if that was ever any but none."""
        if self._limit == Limit(1):
            return False
        place = self._team.index(self._craft)
        told = [self._reference.told(mate) for mate in self._reference.mates]
        return any(word is None or word.knows[place].version != self._limit.version for word in told)
