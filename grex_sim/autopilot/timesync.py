"""How a PX4 turns the time stamp of somebody else into its own time: it asks with TIMESYNC until it has converged.

Read in PX4's source (src/lib/timesync), not measured: the smoothing of the offset is left out.
"""

#: That many answers, 50 s of them, and stamps are translated; before that a message is as old as its arrival.
_CONVERGED = 500
_ROUND_TRIP_MAX_S = 0.01
_DEVIATION_MAX_S = 0.1
_DEVIATIONS_MAX = 5
_STAMP_OFF_MAX_S = 1.0


class StampSync:
    """Offset of another's clock. Times are the autopilot's own since its start, seconds.

    Attributes
    ----------
    answers : int
        How many answers have been taken since the last reset.
    """

    def __init__(self) -> None:
        self.answers = 0
        self._offset_s = 0.0
        self._deviations = 0

    def on_answer(self, theirs_s: float, asked_s: float, age_s: float) -> None:
        """Take an answer to TIMESYNC.

        Parameters
        ----------
        theirs_s : float
            What the other's clock showed.
        asked_s : float
            When the question was sent.
        age_s : float
            Now.
        """
        # It counts in microseconds.
        if not 0.0 <= round(age_s - asked_s, 6) < _ROUND_TRIP_MAX_S:
            return
        offset_s = (asked_s + age_s) / 2.0 - theirs_s
        if self.answers >= _CONVERGED and abs(offset_s - self._offset_s) > _DEVIATION_MAX_S:
            self._deviations += 1
            if self._deviations > _DEVIATIONS_MAX:
                self.answers = self._deviations = 0
            return
        self._offset_s, self._deviations = offset_s, 0
        self.answers += 1

    def usable(self, stamp_s: float, age_s: float) -> bool:
        """Whether a stamp of the other's clock is one that the estimator can place, now at `age_s`."""
        return self.answers < _CONVERGED or abs(stamp_s + self._offset_s - age_s) <= _STAMP_OFF_MAX_S
