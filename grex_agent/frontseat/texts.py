"""STATUSTEXT: what an autopilot says in words, in pieces of fifty characters."""

from dataclasses import dataclass, field

from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.outputs import Note

_PIECE = 50
#: A text of which a piece is missing is shown after this long, seconds.
_PATIENCE_S = 2.0


@dataclass(slots=True)
class _Parts:
    since_s: float
    severity: int
    pieces: dict[int, str] = field(default_factory=dict)


class StatusTexts:
    """Joins pieces to lines for the log.

    Attributes
    ----------
    last : str
        The newest line.
    last_s : float
        When it came.
    """

    def __init__(self) -> None:
        self._open: dict[tuple[int, int], _Parts] = {}
        self.last = ""
        self.last_s = -1e9

    def on_message(self, message: Mavlink, now_s: float) -> list[Note]:
        """Take one STATUSTEXT, and return what is complete."""
        text = _plain(message.text)
        if not message.id:
            return [self._line(text, message.severity, now_s)]
        key = message.get_srcComponent(), message.id
        parts = self._open.setdefault(key, _Parts(now_s, message.severity))
        parts.pieces[message.chunk_seq] = text
        return self._finish(key, now_s) if self._complete(parts) else []

    def on_time(self, now_s: float) -> list[Note]:
        """Return texts of which a piece is missing, when they have waited long enough."""
        late = [key for key, parts in self._open.items() if now_s - parts.since_s > _PATIENCE_S]
        return [note for key in late for note in self._finish(key, now_s)]

    @staticmethod
    def _complete(parts: _Parts) -> bool:
        last = max(parts.pieces)
        return len(parts.pieces) == last + 1 and len(parts.pieces[last]) < _PIECE

    def _finish(self, key: tuple[int, int], now_s: float) -> list[Note]:
        parts = self._open.pop(key)
        pieces = [parts.pieces.get(number, "…") for number in range(max(parts.pieces) + 1)]
        return [self._line("".join(pieces), parts.severity, now_s)]

    def _line(self, text: str, severity: int, now_s: float) -> Note:
        self.last, self.last_s = text, now_s
        return Note(f"autopilot: {text}", "warn" if severity <= mavlink.MAV_SEVERITY_WARNING else "info")


def _plain(text: str | bytes) -> str:
    """Nothing but printable characters, whatever came over the wire."""
    words = text.decode("ascii", "replace") if isinstance(text, bytes) else text
    return "".join(letter if letter.isprintable() else "?" for letter in words.partition("\0")[0])
