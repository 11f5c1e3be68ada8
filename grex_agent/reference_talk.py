"""What a craft tells its mates of the shared reference, and what it makes of what they tell."""

import msgspec

from grex_agent.shared_reference import Heard, SharedReference
from grex_link import reference_wire
from grex_link.errors import WireError
from grex_link.messages import Received
from grex_link.reference_wire import ReferenceWord


class ReferenceTalk:
    """Packs own words of the reference and reads those of the mates.

    Parameters
    ----------
    craft : str
        Whose talk it is.
    team : list of str
        All craft, in their order.
    reference : SharedReference
        Its hold tells which hold is meant.

    Attributes
    ----------
    bad_frames : int
        Datagrams that were no word of a mate.
    """

    def __init__(self, craft: str, team: list[str], reference: SharedReference) -> None:
        self._craft = craft
        self._team = team
        self._reference = reference
        self.bad_frames = 0

    def pack(self, word: ReferenceWord, form: str | None = None) -> tuple[bytes, ReferenceWord]:
        """Pack an own word, which has one form only: what goes on the air, and what the mates will read.

        Raises
        ------
        WireError
            If it cannot be told.
        """
        del form
        payload = reference_wire.pack(word)
        return payload, reference_wire.unpack(payload, len(self._team), word.t_s, word.hold_s)

    def read(self, event: Received, now_s: float) -> Heard | None:
        """Read what was heard; None, and counted, if it is no word of a mate."""
        try:
            word = reference_wire.unpack(event.payload, len(self._team), now_s, self._reference.hold_s)
            place = self._team.index(event.source)
        except (WireError, ValueError):
            self.bad_frames += 1
            return None
        if event.source == self._craft or place % 16 != word.source:
            self.bad_frames += 1
            return None
        if word.t_s > now_s:
            # The mate's clock is ahead of ours. It cannot be from the future, so it counts as of now.
            word = msgspec.structs.replace(word, t_s=now_s)
        return Heard(event.source, word)
