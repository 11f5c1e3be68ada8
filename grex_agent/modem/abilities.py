"""What can be asked of a modem, and how a payload goes through it: whole, in fragments, or not at all."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass

from grex_agent.modem.fragments import FRAGMENTS_MAX, data_bytes, split
from grex_agent.modem.queue import Item
from grex_link.messages import BROADCAST
from grex_link.profile import ModemProfile
from grex_link.units import NS

#: Cable and radio take longer payloads.
LAND_BYTES_MAX = 65535


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What can be asked of a port.

    Attributes
    ----------
    payload_max_bytes, payload_max_bits : int
        Longest payload that goes whole.
    message_max_bytes : int
        Longest payload in fragments.
    broadcast, acknowledges : bool
        Whether one transmission is for all; whether a destination can be asked to acknowledge.
    addresses_max : int or None
        How many modems can have an address.
    two_way_ranging, one_way_ranging : bool
        Whether ranges can be asked for; whether they come with what is received.
    """

    payload_max_bytes: int
    payload_max_bits: int
    message_max_bytes: int
    broadcast: bool
    acknowledges: bool
    addresses_max: int | None
    two_way_ranging: bool
    one_way_ranging: bool


class Abilities:
    """What can be asked of the modem of one craft.

    Parameters
    ----------
    profile : ModemProfile
        The modem.
    mates : sequence of str
        Whom it can address.
    message_bytes : int
        Longest message there is time for; 0 for no limit.

    Attributes
    ----------
    frame_max_bytes : int
        Longest frame.
    fragments : bool
        Whether there are any: a modem whose payload is no whole number of bytes has payloads of a kind of its own.
    """

    def __init__(self, profile: ModemProfile, mates: Sequence[str], message_bytes: int) -> None:
        self._profile = profile
        self._mates = mates
        self._number: int | None = None
        # A padded packet that is quite full cannot say whether its end is padding.
        most = profile.payload_max_bytes - (profile.frame_bytes is not None)
        self.frame_max_bytes = min(most, message_bytes or sys.maxsize)
        self.fragments = profile.bits_max >= 8 * profile.payload_max_bytes

    def capabilities(self) -> Capabilities:
        """Say it in numbers."""
        profile, most = self._profile, self.frame_max_bytes
        return Capabilities(
            payload_max_bytes=most,
            payload_max_bits=min(profile.bits_max, 8 * most),
            message_max_bytes=max(most, FRAGMENTS_MAX * data_bytes(most) if self.fragments else 0),
            broadcast=profile.broadcast,
            acknowledges=profile.acknowledges,
            addresses_max=profile.addresses_max,
            two_way_ranging=profile.ranging.two_way,
            one_way_ranging=profile.ranging.one_way,
        )

    def addressed(self, destination: str) -> str:
        """Address what is for everybody: of two that have no broadcast, one sends it to the other."""
        pair = destination == BROADCAST and not self._profile.broadcast and len(self._mates) == 1
        return self._mates[0] if pair else destination

    def refusal(self, item: Item) -> str:
        """Say why a request cannot be: ``address``, ``error`` (the modem has no such thing) or ``size``; else ''."""
        profile, for_all = self._profile, item.destination == BROADCAST
        if item.destination not in self._mates and not for_all:
            return "address"
        if for_all and (not profile.broadcast or item.answered):
            return "address"
        if (item.acknowledge and not profile.acknowledges) or (item.ranging and not profile.ranging.two_way):
            return "error"
        return "" if item.frames else "size"

    def frames(self, payload: bytes, now_ns: int) -> tuple[bytes, ...]:
        """Make frames of a payload for the water; none if it cannot be carried."""
        if self.fragments:
            return self._split(payload, self.frame_max_bytes, now_ns)
        beyond = max(8 * len(payload) - self._profile.bits_max, 0)
        fits = 0 < len(payload) <= self.frame_max_bytes and not int.from_bytes(payload, "big") & ((1 << beyond) - 1)
        return (payload,) if fits else ()

    def land_frame(self, payload: bytes, now_ns: int) -> tuple[bytes, ...]:
        """Make the frame of a payload for cable and radio; none if it is empty or too long."""
        if not self.fragments:
            return (payload,) if 0 < len(payload) <= LAND_BYTES_MAX else ()
        frames = self._split(payload, LAND_BYTES_MAX, now_ns)
        return frames if len(frames) == 1 else ()

    def _split(self, payload: bytes, frame_max_bytes: int, now_ns: int) -> tuple[bytes, ...]:
        """Make frames; the numbers of payloads begin with the time, so that after a restart they are others."""
        number = now_ns // NS if self._number is None else self._number
        frames = split(payload, frame_max_bytes, number) if payload else ()
        if frames not in ((), (payload,)):
            self._number = number + 1
        return frames
