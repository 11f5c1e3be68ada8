"""Payloads longer than a modem carries go in fragments, and come together again.

A frame on the air is *plain*, a payload as it is, or a *fragment* of one. It is plain if it has the length of a team
state (15, 8 or 5 bytes), or if its first 4 bits are not all ones; else it is a fragment. So a team state of any form is
always plain, and stays what it was for those who know no fragments. A fragment never has one of these lengths, and a
payload of another length that begins with 4 ones goes as a fragment even when it would fit.

=======  ====  ======================================================================================
field    bits  of a fragment
=======  ====  ======================================================================================
mark     4     15
pad      1     1: a zero byte follows the header, or else the fragment had the length of a team state
index    5     place of this fragment in the payload
last     5     index of the last fragment
message  9     number of the payload, modulo 512
check    8     CRC-32 of the whole payload, its lowest 8 bits
data           1 byte or more
=======  ====  ======================================================================================

Fragments of a payload have the same source, message, last and check: what a sender numbers anew after it has been
restarted is not mixed with what it sent before.
"""

import zlib
from dataclasses import dataclass, field

from grex_link.units import NS
from grex_link.wire import BYTES

FRAGMENTS_MAX = 32
HEADER_BYTES = 4
MESSAGES = 512
#: How many payloads can be incomplete at once; of more, that which has waited longest is given up.
PARTIAL_MAX = 32
#: How many payloads are remembered, so that none comes out twice.
DONE_MAX = 128

_STATE_LENGTHS = frozenset(BYTES.values())
_MARK = 0xF

#: Source, message, last, check.
Key = tuple[str, int, int, int]


def is_plain(frame: bytes) -> bool:
    """Whether a frame is a payload as it is."""
    return len(frame) in _STATE_LENGTHS or not frame or frame[0] >> 4 != _MARK


def data_bytes(frame_max_bytes: int) -> int:
    """Most bytes of a payload in one fragment; 0 if the modem's frames are too short for any."""
    longest = frame_max_bytes - 1 if frame_max_bytes in _STATE_LENGTHS else frame_max_bytes
    return max(longest - HEADER_BYTES, 0)


def split(payload: bytes, frame_max_bytes: int, message: int) -> tuple[bytes, ...]:
    """Make frames of a payload.

    Parameters
    ----------
    payload : bytes
        One byte or more.
    frame_max_bytes : int
        Longest frame.
    message : int
        Number of the payload, for its fragments.

    Returns
    -------
    tuple of bytes
        The payload alone if it fits and is plain, else its fragments; empty if it cannot be carried.
    """
    if is_plain(payload) and len(payload) <= frame_max_bytes:
        return (payload,)
    most = data_bytes(frame_max_bytes)
    if not 0 < len(payload) <= most * FRAGMENTS_MAX:
        return ()
    pieces = [payload[start : start + most] for start in range(0, len(payload), most)]
    last, check = len(pieces) - 1, zlib.crc32(payload) & 0xFF
    return tuple(_join(index, last, message % MESSAGES, check, data) for index, data in enumerate(pieces))


@dataclass(slots=True)
class _Partial:
    """A payload of which fragments are still missing."""

    until_ns: int
    data: dict[int, bytes] = field(default_factory=dict)


class Reassembly:
    """Puts payloads together from fragments that come in any order, several times, and mixed with others.

    Parameters
    ----------
    timeout_s : float
        An incomplete payload is given up when no new fragment of it has come for this long; one that has come out is
        remembered as long.

    Attributes
    ----------
    reassembled, abandoned, bad : int
        Payloads that came out, payloads given up, and fragments that were none or did not fit together.
    """

    def __init__(self, timeout_s: float) -> None:
        self._timeout_ns = round(timeout_s * NS)
        self._partial: dict[Key, _Partial] = {}
        self._done: dict[Key, int] = {}
        self.reassembled = self.abandoned = self.bad = 0

    @property
    def until_ns(self) -> int | None:
        """When the next incomplete payload is given up; None if there is none."""
        return min((partial.until_ns for partial in self._partial.values()), default=None)

    def take(self, source: str, frame: bytes, now_ns: int) -> bytes | None:
        """Take a frame; return the payload that is whole with it, or None.

        Parameters
        ----------
        source : str
            Who sent it.
        frame : bytes
            Any bytes.
        now_ns : int
            Time of its arrival.
        """
        if is_plain(frame):
            return frame
        read = _read(frame)
        if read is None:
            self.bad += 1
            return None
        self.expire(now_ns)
        (message, last, check), index, data = read
        key = (source, message, last, check)
        if key in self._done:
            return None
        partial = self._partial.get(key) or self._begin(key, now_ns)
        if index not in partial.data:
            partial.data[index] = data
            partial.until_ns = now_ns + self._timeout_ns
        return self._finish(key, partial, now_ns) if len(partial.data) > last else None

    def expire(self, now_ns: int) -> None:
        """Give up what has been incomplete for too long."""
        for key in [key for key, partial in self._partial.items() if partial.until_ns <= now_ns]:
            del self._partial[key]
            self.abandoned += 1
        for key in [key for key, until_ns in self._done.items() if until_ns <= now_ns]:
            del self._done[key]

    def _begin(self, key: Key, now_ns: int) -> _Partial:
        if len(self._partial) >= PARTIAL_MAX:
            del self._partial[min(self._partial, key=lambda each: self._partial[each].until_ns)]
            self.abandoned += 1
        partial = self._partial[key] = _Partial(now_ns + self._timeout_ns)
        return partial

    def _finish(self, key: Key, partial: _Partial, now_ns: int) -> bytes | None:
        del self._partial[key]
        payload = b"".join(partial.data[index] for index in range(len(partial.data)))
        if zlib.crc32(payload) & 0xFF != key[-1]:
            self.bad += 1
            return None
        if len(self._done) >= DONE_MAX:
            del self._done[next(iter(self._done))]
        self._done[key] = now_ns + self._timeout_ns
        self.reassembled += 1
        return payload


def _join(index: int, last: int, message: int, check: int, data: bytes) -> bytes:
    pad = HEADER_BYTES + len(data) in _STATE_LENGTHS
    header = _MARK << 28 | pad << 27 | index << 22 | last << 17 | message << 8 | check
    return header.to_bytes(HEADER_BYTES, "big") + bytes(pad) + data


def _read(frame: bytes) -> tuple[tuple[int, int, int], int, bytes] | None:
    """Read (message, last, check), index and data; None if this is no fragment as `_join` makes them."""
    header = int.from_bytes(frame[:HEADER_BYTES], "big")
    pad, index, last = header >> 27 & 1, header >> 22 & 31, header >> 17 & 31
    data = frame[HEADER_BYTES + pad :]
    if not data or index > last or frame[HEADER_BYTES : HEADER_BYTES + pad] != bytes(pad):
        return None
    if pad != (HEADER_BYTES + len(data) in _STATE_LENGTHS):
        return None
    return (header >> 8 & (MESSAGES - 1), last, header & 0xFF), index, data
