"""What the modem has heard, as payloads: fragments are put together, what is none of ours is counted."""

import msgspec

from grex_agent.modem.fragments import Reassembly
from grex_link.messages import BadFrame, Happening, Received


class Inbox:
    """See the module's docstring.

    Parameters
    ----------
    reassembly_timeout_s : float
        See `Reassembly`.
    fragments : bool
        Whether there are any on this modem; without, every frame is a payload.

    Attributes
    ----------
    reassembly : Reassembly
        With its counts.
    """

    def __init__(self, reassembly_timeout_s: float, *, fragments: bool) -> None:
        self._fragments = fragments
        self._bad_frames = 0
        self.reassembly = Reassembly(reassembly_timeout_s)

    @property
    def bad_frames(self) -> int:
        """Frames that the modem could not decode, and fragments that were none."""
        return self._bad_frames + self.reassembly.bad

    def on_received(self, event: Received, t_ns: int) -> list[Happening]:
        """Take a frame; return the payload that is whole with it, with what the modem measured of this frame."""
        if not self._fragments:
            return [event]
        bad = self.reassembly.bad
        payload = self.reassembly.take(event.source, event.payload, t_ns)
        if payload is None:
            return [BadFrame("fragment")] if self.reassembly.bad > bad else []
        return [event if payload is event.payload else msgspec.structs.replace(event, payload=payload)]

    def on_bad_frame(self, event: BadFrame) -> list[Happening]:
        """Count what could not be decoded."""
        self._bad_frames += 1
        return [event]
