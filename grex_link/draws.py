"""Random draws that are a hash of what they are for, so that the order of events cannot change a result."""

import hashlib
import math

# 53 bits: all that a float holds, so that no draw is rounded up to 1.
_BITS = 53
_SCALE = 2.0**-_BITS


def uniform(seed: int, *purpose: object) -> float:
    """Return a number in [0, 1) that depends on nothing but its arguments.

    Parameters
    ----------
    seed : int
        Seed of the run or of the link.
    *purpose
        What the draw is for: purpose, who, sequence number.
    """
    return _unit(_digest(seed, purpose)[:8])


def normal(seed: int, *purpose: object) -> tuple[float, float]:
    """Return two independent draws from the standard normal distribution (Box–Muller); see `uniform`."""
    digest = _digest(seed, purpose)
    radius = math.sqrt(-2.0 * math.log(1.0 - _unit(digest[:8])))
    angle = 2.0 * math.pi * _unit(digest[8:])
    return radius * math.cos(angle), radius * math.sin(angle)


def _unit(eight_bytes: bytes) -> float:
    return (int.from_bytes(eight_bytes, "big") >> (64 - _BITS)) * _SCALE


def _digest(seed: int, purpose: tuple[object, ...]) -> bytes:
    return hashlib.blake2b(repr((seed, purpose)).encode(), digest_size=16).digest()
