"""The compact payload: a team state in 15, 8 or 5 bytes, bit-packed.

=========  ====  =====  ====  ==================================================================
field      full  short  tiny  unit
=========  ====  =====  ====  ==================================================================
type       4                  1
source     4     4      4     place in the team, modulo 16
time       16    12     10    full: 0.05 s, modulo 3276.8 s; short and tiny: 0.5 s, modulo
                              2048 s and 512 s; unwrapped to the receiver's clock
north      17    14           full: 0.125 m, short: 1 m; ±8192 m in the mission frame
east       17    14           as north
depth      12                 0.1 m, 0 … 409.5 m
speed      8                  0.02 m/s, 0 … 5.1 m/s
heading    9                  360/512 degrees
track      8     8      8     number of the present track
theta      12    12     12    degree of execution of that track (eq. 1), 1/4095
sigma      5                  class c: at most 0.1 m · 2^(c/2)
flags      8                  bit 0: navigation valid; bit 1: on a task of its own, not to be waited for;
                              bits 2–7: which messages of the mates are missing, see
                              `grex_agent.team.acknowledgement`
=========  ====  =====  ====  ==================================================================

The full form has 120 bits, the short one 64. The tiny one has 34, what a JANUS packet carries, and is filled up to 5
bytes with zeros. The form is known by the length; only the full one has a type.

The time is that at which the state was valid. Θ travels with its track, never alone across a track change. What a form
does not carry is NaN in the state that is read; the receiver finds it in the plan of the mate.
"""

import math
from typing import Any, Literal

import bitstruct
import msgspec

from grex_link.errors import WireError

Form = Literal["full", "short", "tiny"]

#: The forms of a team state, the fullest first.
FORMS: tuple[Form, ...] = ("full", "short", "tiny")
#: What a form takes on the air, and how many bytes hold it.
BITS: dict[Form, int] = {"full": 120, "short": 64, "tiny": 34}
BYTES: dict[Form, int] = {"full": 15, "short": 8, "tiny": 5}
TEAM_STATE_BYTES = BYTES["full"]
POSITION_STEP_M = 0.125
TIME_STEP_S = 0.05
SHORT_POSITION_STEP_M = 1.0
SHORT_TIME_STEP_S = 0.5
NAVIGATION_VALID = 1
ON_TASK = 2
#: Where in the flags is what has been heard, and how many bits.
HEARD_SHIFT, HEARD_BITS = 2, 6


def compiled(layout: str) -> Any:
    """Compile the layout of a payload of another file; bitstruct is known here only."""
    return bitstruct.compile(layout)


_FULL = bitstruct.compile("u4u4u16s17s17u12u8u9u8u12u5u8")
_SHORT = bitstruct.compile("u4u12s14s14u8u12")
_TINY = bitstruct.compile("u4u10u8u12u6")
_FORM_OF_LENGTH = {size: form for form, size in BYTES.items()}
_TYPE_TEAM_STATE = 1


class TeamState(msgspec.Struct, frozen=True, gc=False):
    """Where a craft is and how far it has come, as it tells its mates."""

    source: int
    """Place of the sender in the team, from 0 (on the air modulo 16)."""
    t_s: float
    """Mission time at which this was valid."""
    north_m: float
    east_m: float
    depth_m: float
    speed_mps: float
    heading_rad: float
    track: int
    theta: float
    sigma_m: float
    flags: int = NAVIGATION_VALID
    form: Form = "full"
    """Form it was read from: position (tiny), depth, speed, heading and sigma (short and tiny) are NaN if not told."""


def choose_form(bits_max: int, wanted: str = "auto") -> Form:
    """Choose the form of the team state for a modem.

    Parameters
    ----------
    bits_max : int
        Bits of the modem's longest payload (`ModemProfile.bits_max`).
    wanted : str
        A form, or ``auto`` for the fullest that the modem carries.

    Raises
    ------
    WireError
        If the form wanted does not fit, or none does, or there is no such form.
    """
    allowed = [form for form in FORMS if wanted in {"auto", form}]
    if not allowed:
        raise WireError(f"there is no form {wanted!r} of the team state; there are: auto, {', '.join(FORMS)}")
    for form in allowed:
        if BITS[form] <= bits_max:
            return form
    raise WireError(f"the {form} team state has {BITS[form]} bits and the modem carries {bits_max}")


def pack(state: TeamState, form: Form = "full") -> bytes:
    """Pack a team state into the bytes of a form.

    Speed, depth, Θ and sigma are limited to their range; a position outside it is refused, because a mate would be
    misled by kilometres. What the form does not carry is not looked at, but for this: without flags nobody can be told
    that the navigation is not valid, and so such a state is refused.

    Raises
    ------
    WireError
        For a position outside ±8192 m, a track above 255, a value that is no number, or flags that cannot be told.
    """
    if not (math.isfinite(state.t_s) and math.isfinite(state.theta)):
        raise WireError("a value of the team state is not a number")
    if not 0 <= state.track <= 255:
        raise WireError(f"track {state.track} does not fit in 8 bits")
    if form == "full":
        return _pack_full(state)
    if not state.flags & NAVIGATION_VALID:
        raise WireError(f"the {form} team state cannot say that the navigation is not valid")
    source, theta = state.source % 16, _limited(state.theta * 4095, 4095)
    steps = round(state.t_s / SHORT_TIME_STEP_S)
    if form == "short":
        north = _position(state.north_m, "north", SHORT_POSITION_STEP_M, 8191)
        east = _position(state.east_m, "east", SHORT_POSITION_STEP_M, 8191)
        short: bytes = _SHORT.pack(source, steps % (1 << 12), north, east, state.track, theta)
        return short
    tiny: bytes = _TINY.pack(source, steps % (1 << 10), state.track, theta, 0)
    return tiny


def unpack(payload: bytes, now_s: float) -> TeamState:
    """Unpack a team state of any form.

    Parameters
    ----------
    payload : bytes
        Exactly 15, 8 or 5 bytes, which tells the form.
    now_s : float
        The receiver's mission time; the state's time is the nearest one that fits.

    Raises
    ------
    WireError
        If this is not a team state.
    """
    form = _FORM_OF_LENGTH.get(len(payload))
    if form == "full":
        return _unpack_full(payload, now_s)
    if form == "short":
        source, time, north, east, track, theta = _SHORT.unpack(payload)
        t_s = _unwrapped_s(time, SHORT_TIME_STEP_S, 1 << 12, now_s)
        return _partial("short", source, t_s, north * SHORT_POSITION_STEP_M, east * SHORT_POSITION_STEP_M, track, theta)
    if form == "tiny":
        source, time, track, theta, padding = _TINY.unpack(payload)
        if padding:
            raise WireError(f"a tiny team state ends with 6 zeros, not {padding:06b}")
        t_s = _unwrapped_s(time, SHORT_TIME_STEP_S, 1 << 10, now_s)
        return _partial("tiny", source, t_s, math.nan, math.nan, track, theta)
    raise WireError(f"a team state has 15, 8 or 5 bytes, not {len(payload)}")


def _pack_full(state: TeamState) -> bytes:
    if not all(map(math.isfinite, (state.depth_m, state.speed_mps, state.heading_rad, state.sigma_m))):
        raise WireError("a value of the team state is not a number")
    packed: bytes = _FULL.pack(
        _TYPE_TEAM_STATE,
        state.source % 16,
        round(state.t_s / TIME_STEP_S) % (1 << 16),
        _position(state.north_m, "north", POSITION_STEP_M, 65535),
        _position(state.east_m, "east", POSITION_STEP_M, 65535),
        _limited(state.depth_m / 0.1, 4095),
        _limited(state.speed_mps / 0.02, 255),
        round(state.heading_rad / (2.0 * math.pi) * 512) % 512,
        state.track,
        _limited(state.theta * 4095, 4095),
        _sigma_class(state.sigma_m),
        state.flags & 0xFF,
    )
    return packed


def _unpack_full(payload: bytes, now_s: float) -> TeamState:
    kind, source, time, north, east, depth, speed, heading, track, theta, sigma, flags = _FULL.unpack(payload)
    if kind != _TYPE_TEAM_STATE:
        raise WireError(f"payload type {kind} is not a team state")
    return TeamState(
        source=source,
        t_s=_unwrapped_s(time, TIME_STEP_S, 1 << 16, now_s),
        north_m=north * POSITION_STEP_M,
        east_m=east * POSITION_STEP_M,
        depth_m=depth * 0.1,
        speed_mps=speed * 0.02,
        heading_rad=heading * (2.0 * math.pi / 512),
        track=track,
        theta=theta / 4095,
        sigma_m=0.1 * 2.0 ** (sigma / 2),
        flags=flags,
    )


def _partial(form: Form, source: int, t_s: float, north_m: float, east_m: float, track: int, theta: int) -> TeamState:
    """Build what a form without flags tells: only states with valid navigation are sent in it."""
    nan = math.nan
    return TeamState(source, t_s, north_m, east_m, nan, nan, nan, track, theta / 4095, nan, NAVIGATION_VALID, form)


def _unwrapped_s(time: int, step_s: float, modulus: int, now_s: float) -> float:
    now_steps = round(now_s / step_s)
    behind = (now_steps - time + modulus // 2) % modulus - modulus // 2
    return (now_steps - behind) * step_s


def _position(metres: float, axis: str, step_m: float, most: int) -> int:
    if not abs(metres) < (most + 0.5) * step_m:  # so that no number is refused, too
        raise WireError(f"{axis} {metres:.1f} m is outside the mission frame of ±8192 m")
    return round(metres / step_m)


def _limited(steps: float, most: int) -> int:
    return min(max(round(steps), 0), most)


def _sigma_class(sigma_m: float) -> int:
    return 0 if sigma_m <= 0.1 else min(math.ceil(2.0 * math.log2(sigma_m / 0.1) - 1e-9), 31)
