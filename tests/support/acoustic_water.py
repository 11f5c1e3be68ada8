"""The acoustic medium for tests: craft that stay where they are put, and a plain modem."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from grex_link.acoustic_medium import AcousticMedium
from grex_link.config import CraftConfig, Scenario, TrackList, Tracks
from grex_link.link_config import LinkConfig
from grex_link.medium import Due
from grex_link.messages import LinkEvent, Pose, RangeRequest, Transmit, Truth
from grex_link.profile import ModemProfile, Threshold
from grex_link.units import NS

FOREVER_NS = 10**18

Place = tuple[float, float, float]

#: One second on the air, loud, and two of equal level spoil each other.
PLAIN = ModemProfile(
    title="plain",
    payload_max_bytes=64,
    airtime_fixed_s=1.0,
    airtime_per_byte_s=0.0,
    frequency_hz=25_000.0,
    bandwidth_hz=4_000.0,
    source_level_db=185.0,
    reception=Threshold(3.0),
    sources=[],
    assumed=[],
)


#: Nothing but acoustics.
STILL = LinkConfig()


def plain(**changes: Any) -> ModemProfile:
    """Return the plain modem with some fields changed."""
    return msgspec.structs.replace(PLAIN, **changes)


def triangle(side_m: float) -> dict[str, Place]:
    """Three craft, each as far from the others."""
    return {"a": (0.0, 0.0, 0.0), "b": (side_m, 0.0, 0.0), "c": (side_m / 2, side_m * math.sqrt(0.75), 0.0)}


def truth(places: Mapping[str, Sequence[float]], t_s: float = 0.0, surge_mps: float = 0.0) -> Truth:
    """Return the true poses of craft that head north."""
    poses = [Pose(craft, *place, 0.0, 0.0, 0.0, surge_mps) for craft, place in places.items()]
    return Truth(0, round(t_s * NS), poses)


class AcousticWater:
    """A medium, numbering the requests of every craft by itself.

    Parameters
    ----------
    places : mapping of str to (float, float, float)
        Where the craft are, NED, metres.
    profile : ModemProfile
        Everybody's modem.
    link : LinkConfig
        The water.
    seed : int
        Seed of the scenario.
    craft : mapping of str to CraftConfig
        Clocks and noise of some of the craft.
    """

    def __init__(
        self,
        places: Mapping[str, Place],
        profile: ModemProfile = PLAIN,
        link: LinkConfig = STILL,
        seed: int = 1,
        craft: Mapping[str, CraftConfig] | None = None,
    ) -> None:
        team = {name: CraftConfig() for name in places} | dict(craft or {})
        mission = Tracks(craft={name: TrackList((0.0, 0.0, 0.0), ()) for name in places})
        self.scenario = Scenario(seed=seed, mission=mission, link=link, craft=team)
        self.medium = AcousticMedium(self.scenario, profile)
        self.medium.place(truth(places))
        self._sent = dict.fromkeys(places, 0)

    def send(self, source: str, t_s: float, payload: bytes = b"?", destination: str = "", **more: Any) -> int:
        """Request a transmission for a true time; return its number."""
        number, t_ns = self._next(source), round(t_s * NS)
        self.medium.request(source, Transmit(number, t_ns, payload, destination, **more), t_ns)
        return number

    def ping(self, source: str, t_s: float, destination: str) -> int:
        """Request a range for a true time; return the number of the request."""
        number, t_ns = self._next(source), round(t_s * NS)
        self.medium.request(source, RangeRequest(number, t_ns, destination), t_ns)
        return number

    def run(self, until_s: float | None = None) -> list[LinkEvent]:
        """Work through everything up to a time and return the new lines of the log."""
        until_ns = FOREVER_NS if until_s is None else round(until_s * NS)
        self.medium.advance(until_ns)
        return self.medium.log(until_ns)

    def events(self) -> list[Due]:
        """Work through everything and return the modem events."""
        self.medium.advance(FOREVER_NS)
        return self.medium.events(FOREVER_NS)

    def _next(self, source: str) -> int:
        self._sent[source] += 1
        return self._sent[source] - 1


def fates(log: Sequence[LinkEvent]) -> dict[tuple[str, int, str], str]:
    """Return (source, number, receiver) → "" if it was whole there, or why it was not; data only."""
    return {
        (line.source, line.seq, line.destination): line.reason
        for line in log
        if line.kind in {"delivered", "overheard", "lost"} and line.purpose == "data"
    }
