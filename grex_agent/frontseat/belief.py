"""Whether the craft's position is believed: said when that changes, and why. Pure."""

from grex_agent.frontseat.outputs import Estimate, Note, warn


class Belief:
    """See the module's docstring."""

    def __init__(self) -> None:
        self._valid: bool | None = None
        self._misplaced = False

    def look(self, estimate: Estimate, *, misplaced: bool) -> list[Note]:
        """Say what has changed.

        Parameters
        ----------
        estimate : Estimate
            Where the craft is now.
        misplaced : bool
            Whether it is too far from the datum, which a person has to put right: said even if there was no valid
            position before.
        """
        doubted_anew = misplaced and not self._misplaced and not estimate.valid
        self._misplaced = misplaced
        if estimate.valid == self._valid and not doubted_anew:
            return []
        first, self._valid = self._valid is None, estimate.valid
        if estimate.valid:
            return [Note(f"its position is valid, to {estimate.sigma_m:.1f} m")]
        said = f"no valid position: {estimate.reason}"
        return [Note(said) if first and not misplaced else warn(said)]
