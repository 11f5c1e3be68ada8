"""Speed over ground of craft that make less, or more, than they are asked for: a slow integral puts that right. Pure.

asked = wanted + trim,  d trim / dt = (wanted - made good) / T

It learns only on a steady course at a steady speed; what is made good while speeding up or turning says nothing.
"""

import math

from grex_agent.path import wrap

_TIME_S = 10.0
#: Most of the wanted speed that the trim may add or take away.
_SHARE_MAX = 0.4
#: Wait after a change of wanted speed by more than this, and then for so long.
_STEP_MPS = 0.2
_SETTLE_S = 6.0
_LEAST_MPS = 0.2
_COURSE_MAX_RAD = 0.35
#: A gap in the calls does not count for more.
_STEP_MAX_S = 1.0


class SpeedTrim:
    """See the module's docstring; times are the autopilot's, seconds."""

    def __init__(self) -> None:
        self._trim_mps = 0.0
        #: Below zero: the first wanted speed is a change, too.
        self._wanted_mps = -1.0
        self._settled_s = math.inf
        self._then_s = 0.0

    def reset(self) -> None:
        """Forget what has been learnt."""
        self._trim_mps, self._wanted_mps = 0.0, -1.0

    def asked_mps(
        self, wanted_mps: float, course_rad: float, made_good: tuple[float, float] | None, t_s: float
    ) -> float:
        """Find the speed to ask for.

        Parameters
        ----------
        wanted_mps, course_rad : float
            What the agent wants over ground.
        made_good : (float, float) or None
            Velocity north and east that is made good, m/s; None if it is not known.
        t_s : float
            Time by the autopilot's clock.
        """
        step_s, self._then_s = min(max(t_s - self._then_s, 0.0), _STEP_MAX_S), t_s
        if wanted_mps < _LEAST_MPS:
            return wanted_mps
        if abs(wanted_mps - self._wanted_mps) > _STEP_MPS:
            self._wanted_mps, self._settled_s = wanted_mps, t_s + _SETTLE_S
        if made_good is not None and t_s >= self._settled_s and _on_course(made_good, course_rad):
            self._trim_mps += step_s / _TIME_S * (wanted_mps - math.hypot(*made_good))
        most = _SHARE_MAX * wanted_mps
        self._trim_mps = min(max(self._trim_mps, -most), most)
        return wanted_mps + self._trim_mps


def _on_course(made_good: tuple[float, float], course_rad: float) -> bool:
    north, east = made_good
    return abs(wrap(math.atan2(east, north) - course_rad)) < _COURSE_MAX_RAD
