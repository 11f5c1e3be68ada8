"""Messages on their way through the water: where each began, and how it ended at every other craft."""

from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from grex_link.messages import LinkEvent
from grex_link.units import NS

#: After this long, seconds, a message that has no outcome has none: no packet and no detour takes so long.
_FORGOTTEN_S = 300.0
_MOST = 400

Place = tuple[float, float]


@dataclass(slots=True)
class _Sound:
    event: LinkEvent
    place: Place | None
    #: For each receiver when, how and why it ended.
    ends: dict[str, tuple[float, str, str]] = field(default_factory=dict)


class Sounds:
    """Follows every transmission from its start to its outcomes; holds the newest few hundred.

    Parameters
    ----------
    lasting_s : float
        Mission seconds for which a message is shown after its last outcome.
    """

    def __init__(self, lasting_s: float = 4.0) -> None:
        self.lasting_s = lasting_s
        self._sounds: OrderedDict[tuple[str, int, str, str], _Sound] = OrderedDict()
        self.counts = {"started": 0, "delivered": 0, "overheard": 0, "lost": 0, "refused": 0}

    def on_event(self, event: LinkEvent, places: Mapping[str, Place]) -> None:
        """Take one line of the medium's log.

        Parameters
        ----------
        event : LinkEvent
            The line.
        places : mapping
            Where the craft are: north and east, metres.
        """
        self.counts[event.kind] = self.counts.get(event.kind, 0) + 1
        name = (event.source, event.seq, event.purpose, event.asked_by)
        if event.kind in {"started", "refused"}:
            self._sounds[name] = _Sound(event, places.get(event.source))
            if len(self._sounds) > _MOST:
                self._sounds.popitem(last=False)
        elif sound := self._sounds.get(name):
            sound.ends[event.destination] = (event.t_ns / NS, event.kind, event.reason)

    def shown(self, now_s: float, since_s: float | None = None) -> list[dict[str, Any]]:
        """Return what is to be drawn: on the air now, or ended since some time, oldest first; forget the rest.

        Parameters
        ----------
        now_s : float
            Mission time, seconds.
        since_s : float or None
            What has ended before is left out; `lasting_s` ago if None.
        """
        since_s = now_s - self.lasting_s if since_s is None else since_s
        for name in [name for name, sound in self._sounds.items() if _over_s(sound) < since_s]:
            del self._sounds[name]
        return list(self._drawn(now_s))

    def _drawn(self, now_s: float) -> Iterator[dict[str, Any]]:
        for sound in self._sounds.values():
            event = sound.event
            if event.t_ns / NS > now_s:
                continue
            yield {
                "id": f"{event.source}/{event.seq}/{event.purpose}/{event.asked_by}",
                "source": event.source,
                "start_s": event.t_ns / NS,
                "lasting_s": event.lasting_ns / NS,
                "bytes": event.size_bytes,
                "purpose": event.purpose,
                "refused": event.reason if event.kind == "refused" else None,
                "place": sound.place,
                "ends": {who: end for who, end in sound.ends.items() if end[0] <= now_s},
            }


def _over_s(sound: _Sound) -> float:
    """Mission time at which nothing more comes of a message, as far as is known, seconds."""
    start_s, lasting_s = sound.event.t_ns / NS, sound.event.lasting_ns / NS
    if sound.event.kind == "refused":
        return start_s
    if not sound.ends:
        return start_s + lasting_s + _FORGOTTEN_S
    return max(start_s + lasting_s, *(end[0] for end in sound.ends.values()))
