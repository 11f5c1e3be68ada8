"""Whether a range that surprises is an outlier, its mate is wrong, or the own position is.

A single one is an outlier; so are those of a mate that surprise less, but always the same way, while there is somebody
else to ask. Several in a row of one mate are that mate's fault – it tells a wrong position, its transponder is faulty –
as long as the ranges to anybody else fit. It is left out then, also if a range of it happens to fit: it has to fit as
often as it did not before it is trusted again. Only when all who have been ranged to lately disagree is it the own
position, and the one who disagreed most does not put it right. Who ranges to one mate alone has nobody to ask, and
believes that mate rather than itself, because it is the one of the two that drifts.
"""

from typing import Literal, NamedTuple

#: So many outliers in a row are none.
_WRONG_AFTER = 5
#: Ranges of one mate that surprise the same way, on average over about nine, by so many of their sigmas do not fit.
_MEAN_OF, _LEANS = 0.2, 1.4
#: Who has not been ranged to for longer has no say.
_LATELY_S = 300.0


class _Mate(NamedTuple):
    """What ranges to a mate have been like."""

    t_s: float
    """Time of the newest."""
    outliers: int = 0
    """In a row; of a mate that is not trusted, less those that have fitted since."""
    trusted: bool = True
    leaning: float = 0.0
    """Sliding mean of the surprises that passed the limit, each in its sigmas."""


class Gate:
    """See the module's docstring.

    Parameters
    ----------
    limit : float
        Greatest square of the surprise, in sigmas, of a good range.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._mates: dict[str, _Mate] = {}

    def judge(self, mate: str, t_s: float, surprise: float) -> Literal["good", "outlier", "wrong"]:
        """Judge a range to a mate at a time: use it, leave it out, or set the own position free and use it.

        Parameters
        ----------
        mate : str
            To whom.
        t_s : float
            When, mission time, seconds.
        surprise : float
            Measured less expected range over the standard deviation of that.
        """
        last_s, outliers, trusted, leaning = self._mates.get(mate, _Mate(t_s))
        fits = surprise * surprise <= self._limit
        if fits:
            leaning += _MEAN_OF * (surprise - leaning)
            fits = abs(leaning) <= _LEANS or not self._has_company(mate, t_s)
        outliers = outliers + 1 if not fits else 0 if trusted else outliers - 1
        trusted = not outliers or (trusted and outliers < _WRONG_AFTER)
        self._mates[mate] = _Mate(max(t_s, last_s), outliers, trusted, leaning)
        if not outliers:
            return "good"
        if fits or not self._own_position_is_wrong(mate):
            return "outlier"
        # Who disagreed most of several has to win its trust back.
        for name, each in self._mates.items():
            self._mates[name] = each if each.outliers > outliers else _Mate(each.t_s)
        return "wrong"

    def _has_company(self, mate: str, t_s: float) -> bool:
        """Whether anybody else has been ranged to lately."""
        return any(name != mate and t_s - each.t_s <= _LATELY_S for name, each in self._mates.items())

    def _own_position_is_wrong(self, mate: str) -> bool:
        """Whether all ranged to lately disagree; of several, enough of them without the one who disagrees most."""
        newest_s = max(each.t_s for each in self._mates.values())
        counts = sorted(each.outliers for each in self._mates.values() if newest_s - each.t_s <= _LATELY_S)
        if len(counts) == 1:
            return counts[0] >= _WRONG_AFTER
        is_the_loudest = self._mates[mate].outliers > counts[-2]
        return counts[0] > 0 and sum(counts[:-1]) >= _WRONG_AFTER and not is_the_loudest
