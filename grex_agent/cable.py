"""The guard of a cable between two craft: the one that is ahead waits before the cable is taut."""

import math
from collections.abc import Sequence

from grex_agent.mission import TeamPlan
from grex_agent.team.interface import Own
from grex_link.config import Scenario
from grex_link.messages import MateBelief

#: The guard acts at this share of the length, because what is believed of a mate is late, and a craft does not stop
#: at once.
SHARE = 0.9


class CableGuard:
    """Says when a craft has to wait for the one at the other end of its cable.

    The two keep together by their plan and one Θ, as all members do; the guard is for when that fails. The one with
    more progress holds until the distance is believed to be below `SHARE` of the length again; of two with equal
    progress it is the first of the team. So one of them always goes on, and the team does not come to a standstill.

    Parameters
    ----------
    scenario : Scenario
        Cables and the order of the team.
    craft : str
        Whose guard.
    plan : TeamPlan
        How deep everybody is.
    """

    def __init__(self, scenario: Scenario, craft: str, plan: TeamPlan) -> None:
        self._limits: dict[str, tuple[float, bool]] = {}
        self._plans = plan.everybody
        self._own = self._plans[craft]
        team = list(scenario.craft)
        for land in scenario.link.land:
            if land.length_m is not None and craft in land.between:
                (mate,) = {*land.between} - {craft}
                self._limits[mate] = SHARE * land.length_m, team.index(craft) < team.index(mate)

    def taut(self, own: Own, beliefs: Sequence[MateBelief]) -> bool:
        """Whether this craft has to hold now; depths are those planned at the progress of each."""
        for belief in beliefs:
            if belief.craft not in self._limits:
                continue
            limit_m, first = self._limits[belief.craft]
            mate = self._plans[belief.craft]
            apart = math.hypot(
                own.north_m - belief.north_m,
                own.east_m - belief.east_m,
                self._own.depth(own.progress) - mate.depth(belief.progress),
            )
            ahead = own.progress > belief.progress or (own.progress == belief.progress and first)
            if apart > limit_m and ahead:
                return True
        return False
