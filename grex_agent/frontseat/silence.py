"""Whether an autopilot is heard: the link is lost after three seconds of its time without a word. Pure."""

from grex_agent.frontseat.outputs import Note, warn
from grex_agent.frontseat.timesync import older

_SILENCE_S = 3.0


class Silence:
    """See the module's docstring. Times are ours, seconds.

    Attributes
    ----------
    linked : bool
        Whether the autopilot is heard.
    """

    def __init__(self) -> None:
        self._heard_s = 0.0
        self.linked = True

    def on_message(self, now_s: float) -> list[Note]:
        """Take a sign of life."""
        self._heard_s = now_s
        was, self.linked = self.linked, True
        return [] if was else [Note("the autopilot is heard again")]

    def look(self, now_s: float, rate: float) -> list[Note]:
        """Find out whether it has fallen silent; ``rate`` is its seconds in one of ours."""
        if not self.linked or not older(now_s - self._heard_s, rate, _SILENCE_S):
            return []
        self.linked = False
        return [warn(f"the autopilot has been silent for {_SILENCE_S:g} s: no set-points are sent until it is heard")]
