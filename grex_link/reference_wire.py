"""The compact payload of the shared reference: how far a craft holds the plan back, and who cannot keep up.

=========  ====  ==========================================================================
field      bits  unit
=========  ====  ==========================================================================
type       4     2
source     4     place in the team, modulo 16
time       10    0.5 s, modulo 512 s; unwrapped to the receiver's clock
hold       16    0.05 s, modulo 3276.8 s; unwrapped to the receiver's own hold
lag        10    0.1 s, -51.2 … 51.1 s
asks       1     whether an answer is wanted: somebody has not said yet that it knows the newest limit
                 then for every craft of the team in its order, the sender included:
version    3     1 … 7 in turn, of the newest word of that craft's limit; 0: never heard of
limit      6     0.05 m/s; 63: none
=========  ====  ==========================================================================

That is 9 bytes for three craft, and 9 bits for each more. Where the length would be that of a team state, for two and
for eight craft, a byte of zeros is added.
"""

import math

import bitstruct
import msgspec

from grex_link import wire
from grex_link.errors import WireError

TYPE = 2
TIME_STEP_S = 0.5
HOLD_STEP_S = 0.05
LAG_STEP_S = 0.1
LIMIT_STEP_MPS = 0.05
#: Versions count 1 … 7 and begin again; 0 is for nothing heard.
VERSIONS = 7
_TIMES, _HOLDS, _NO_LIMIT = 1 << 10, 1 << 16, 63
_HEAD = "u4u4u10u16s10u1"
_HEAD_BITS, _CRAFT_BITS = 45, 9


class Limit(msgspec.Struct, frozen=True, gc=False):
    """What the sender knows of one craft's newest word about the speed that it can make."""

    version: int = 0
    """1 … 7 in turn; 0: never heard of."""
    speed_mps: float | None = None
    """The most over ground; None: it keeps up."""


class ReferenceWord(msgspec.Struct, frozen=True, gc=False):
    """What a craft tells of the shared reference."""

    source: int
    """Place of the sender in the team, from 0 (on the air modulo 16)."""
    t_s: float
    """Mission time at which this was valid."""
    hold_s: float
    """How far its copy of the reference is behind the clock."""
    lag_s: float
    """How far it is ahead of its copy, seconds of the plan; negative behind."""
    limits: tuple[Limit, ...]
    """For every craft in the order of the team."""
    asks: bool = False
    """Whether it wants an answer: somebody has not said yet that it knows the sender's newest limit."""


def size_bytes(craft: int) -> int:
    """Length of the payload in a team of so many craft, bytes."""
    size = -(-(_HEAD_BITS + _CRAFT_BITS * craft) // 8)
    return size + (size in wire.BYTES.values())


def limit_steps(speed_mps: float | None) -> int:
    """Return a limit as it is on the air; one that is too high to be told is none."""
    if speed_mps is None:
        return _NO_LIMIT
    return min(max(round(speed_mps / LIMIT_STEP_MPS), 0), _NO_LIMIT)


def pack(word: ReferenceWord) -> bytes:
    """Pack a word; the lag is limited to its range, and the hold rounded down, so that echoes do not make it grow.

    Raises
    ------
    WireError
        If a value is no number or a version none of 0 … 7.
    """
    if not all(map(math.isfinite, (word.t_s, word.hold_s, word.lag_s))):
        raise WireError("a value of the reference is not a number")
    told = [(limit.version, limit_steps(limit.speed_mps)) for limit in word.limits]
    if not all(0 <= version <= VERSIONS for version, _ in told):
        raise WireError("a version does not fit in 3 bits")
    lag = min(max(round(word.lag_s / LAG_STEP_S), -512), 511)
    payload: bytes = _format(len(told)).pack(
        TYPE,
        word.source % 16,
        round(word.t_s / TIME_STEP_S) % _TIMES,
        math.floor(word.hold_s / HOLD_STEP_S + 1e-6) % _HOLDS,
        lag,
        word.asks,
        *(number for pair in told for number in pair),
    )
    return payload.ljust(size_bytes(len(told)), b"\0")


def unpack(payload: bytes, craft: int, now_s: float, hold_s: float) -> ReferenceWord:
    """Unpack a word.

    Parameters
    ----------
    payload : bytes
        What was heard.
    craft : int
        Size of the team.
    now_s, hold_s : float
        The receiver's mission time and hold; those of the word are the nearest that fit.

    Raises
    ------
    WireError
        If this is no word of the reference of such a team.
    """
    if len(payload) != size_bytes(craft):
        raise WireError(f"the reference of {craft} craft has {size_bytes(craft)} bytes, not {len(payload)}")
    kind, source, time, hold, lag, asks, *told = _format(craft).unpack(payload)
    if kind != TYPE:
        raise WireError(f"payload type {kind} is not a reference")
    limits = tuple(
        Limit(version, None if steps == _NO_LIMIT else steps * LIMIT_STEP_MPS)
        for version, steps in zip(told[::2], told[1::2], strict=True)
    )
    return ReferenceWord(
        source,
        _nearest(time, _TIMES, now_s / TIME_STEP_S) * TIME_STEP_S,
        _nearest(hold, _HOLDS, hold_s / HOLD_STEP_S) * HOLD_STEP_S,
        lag * LAG_STEP_S,
        limits,
        bool(asks),
    )


def is_newer(version: int, than: int) -> bool:
    """Whether one version comes after another, at most three after it: what was missed for longer cannot be told."""
    if not version or not than:
        return bool(version)
    return 1 <= (version - than) % VERSIONS <= VERSIONS // 2


def _nearest(steps: int, modulus: int, about: float) -> int:
    """Find the number that is `steps` modulo `modulus` and nearest to another."""
    near = round(about)
    return near - ((near - steps + modulus // 2) % modulus - modulus // 2)


def _format(craft: int) -> bitstruct.CompiledFormat:
    return bitstruct.compile(_HEAD + "u3u6" * craft)
