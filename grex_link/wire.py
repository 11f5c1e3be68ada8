"""The compact payload: one team state in 15 bytes, bit-packed.

=========  =====  ==================================================================
field      bits   unit
=========  =====  ==================================================================
type       4      1
source     4      place in the team, modulo 16
time       16     0.05 s, modulo 3276.8 s, unwrapped to the receiver's clock
north      17     0.125 m, ±8192 m in the mission frame
east       17     0.125 m
depth      12     0.1 m, 0 … 409.5 m
speed      8      0.02 m/s, 0 … 5.1 m/s
heading    9      360/512 degrees
track      8      number of the present track
theta      12     degree of execution of that track (eq. 1), 1/4095
sigma      5      class c: at most 0.1 m · 2^(c/2)
flags      8      bit 0: navigation valid
=========  =====  ==================================================================

The time is that at which the state was valid. Θ travels with its track, never alone across a track change.
"""

import math

import bitstruct
import msgspec

from grex_link.errors import WireError

TEAM_STATE_BYTES = 15
POSITION_STEP_M = 0.125
TIME_STEP_S = 0.05
NAVIGATION_VALID = 1

_LAYOUT = bitstruct.compile("u4u4u16s17s17u12u8u9u8u12u5u8")
_TYPE_TEAM_STATE = 1
_TIME_MODULUS = 1 << 16
_POSITION_MAX = (1 << 16) - 1


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


def pack(state: TeamState) -> bytes:
    """Pack a team state into 15 bytes.

    Speed, depth, Θ and sigma are limited to their range; a position outside it is refused, because a mate would be
    misled by kilometres.

    Raises
    ------
    WireError
        For a position outside ±8192 m, a track above 255, or a value that is no number.
    """
    numbers = (state.t_s, state.depth_m, state.speed_mps, state.heading_rad, state.theta, state.sigma_m)
    if not all(map(math.isfinite, numbers)):
        raise WireError("a value of the team state is not a number")
    north, east = _position(state.north_m, "north"), _position(state.east_m, "east")
    if not 0 <= state.track <= 255:
        raise WireError(f"track {state.track} does not fit in 8 bits")
    packed: bytes = _LAYOUT.pack(
        _TYPE_TEAM_STATE,
        state.source % 16,
        round(state.t_s / TIME_STEP_S) % _TIME_MODULUS,
        north,
        east,
        _limited(state.depth_m / 0.1, 4095),
        _limited(state.speed_mps / 0.02, 255),
        round(state.heading_rad / (2.0 * math.pi) * 512) % 512,
        state.track,
        _limited(state.theta * 4095, 4095),
        _sigma_class(state.sigma_m),
        state.flags & 0xFF,
    )
    return packed


def unpack(payload: bytes, now_s: float) -> TeamState:
    """Unpack a team state.

    Parameters
    ----------
    payload : bytes
        Exactly 15 bytes.
    now_s : float
        The receiver's mission time; the state's time is the nearest one that fits.

    Raises
    ------
    WireError
        If this is not a team state.
    """
    if len(payload) != TEAM_STATE_BYTES:
        raise WireError(f"a team state has {TEAM_STATE_BYTES} bytes, not {len(payload)}")
    kind, source, time, north, east, depth, speed, heading, track, theta, sigma, flags = _LAYOUT.unpack(payload)
    if kind != _TYPE_TEAM_STATE:
        raise WireError(f"payload type {kind} is not a team state")
    now_steps = round(now_s / TIME_STEP_S)
    behind = (now_steps - time + _TIME_MODULUS // 2) % _TIME_MODULUS - _TIME_MODULUS // 2
    return TeamState(
        source=source,
        t_s=(now_steps - behind) * TIME_STEP_S,
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


def _position(metres: float, axis: str) -> int:
    if not abs(metres) < (_POSITION_MAX + 0.5) * POSITION_STEP_M:  # so that no number is refused, too
        raise WireError(f"{axis} {metres:.1f} m is outside the mission frame of ±8192 m")
    return round(metres / POSITION_STEP_M)


def _limited(steps: float, most: int) -> int:
    return min(max(round(steps), 0), most)


def _sigma_class(sigma_m: float) -> int:
    return 0 if sigma_m <= 0.1 else min(math.ceil(2.0 * math.log2(sigma_m / 0.1) - 1e-9), 31)
