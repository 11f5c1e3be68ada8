"""Whether the craft's position is believed: said when that changes, and why. Pure."""

from grex_agent.frontseat.outputs import Estimate, Note, warn
from grex_agent.frontseat.timesync import older

#: Without a valid position for longer than this, seconds of the autopilot, a craft is not to be steered. By then the
#: agent has held it for a while (5 s), a boat's own failsafe has had its turn (8 s), and an estimator without aiding
#: has given up dead reckoning (14 s): a velocity means nothing to it any more.
LOST_S = 15.0


class Belief:
    """See the module's docstring. Times are ours, seconds."""

    def __init__(self) -> None:
        self._valid: bool | None = None
        self._misplaced = False
        self._good_s = -1e9

    def lost(self, now_s: float, rate: float) -> bool:
        """Whether it has not been valid for long; ``rate`` is the autopilot's seconds in one of ours."""
        return older(now_s - self._good_s, rate, LOST_S)

    def look(self, estimate: Estimate, now_s: float, *, linked: bool, misplaced: bool) -> list[Note]:
        """Say what has changed.

        Parameters
        ----------
        estimate : Estimate
            Where the craft is now.
        now_s : float
            Time.
        linked : bool
            Whether the autopilot is heard; nothing can be asked of one that is not, so that time does not count.
        misplaced : bool
            Whether it is too far from the datum, which a person has to put right: said even if there was no valid
            position before.
        """
        if estimate.valid or not linked:
            self._good_s = now_s
        doubted_anew = misplaced and not self._misplaced and not estimate.valid
        self._misplaced = misplaced
        if estimate.valid == self._valid and not doubted_anew:
            return []
        first, self._valid = self._valid is None, estimate.valid
        if estimate.valid:
            return [Note(f"its position is valid, to {estimate.sigma_m:.1f} m")]
        said = f"no valid position: {estimate.reason}"
        return [Note(said) if first and not misplaced else warn(said)]
