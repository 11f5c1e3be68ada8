"""Random draws that are a hash of what they are for, so that the order of events cannot change a result."""

import hashlib
import math

_SCALE = 2.0**-64


def uniform(seed: int, *purpose: object) -> float:
    """Return a number in [0, 1) that depends on nothing but its arguments.

    Parameters
    ----------
    seed : int
        Seed of the run or of the link.
    *purpose
        What the draw is for: purpose, who, sequence number.
    """
    return int.from_bytes(_digest(seed, purpose)[:8], "big") * _SCALE


def normal(seed: int, *purpose: object) -> tuple[float, float]:
    """Return two independent draws from the standard normal distribution (Box–Muller); see `uniform`."""
    digest = _digest(seed, purpose)
    radius = math.sqrt(-2.0 * math.log((int.from_bytes(digest[:8], "big") + 1) * _SCALE))
    angle = 2.0 * math.pi * int.from_bytes(digest[8:], "big") * _SCALE
    return radius * math.cos(angle), radius * math.sin(angle)


def _digest(seed: int, purpose: tuple[object, ...]) -> bytes:
    return hashlib.blake2b(repr((seed, purpose)).encode(), digest_size=16).digest()
