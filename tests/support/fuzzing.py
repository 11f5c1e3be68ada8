"""How many inputs a fuzz test takes: a taste in CI, ``GREX_FUZZ=1000000`` for the whole meal."""

import os
import random

INPUTS = int(os.environ.get("GREX_FUZZ", "20000"))


def spoiled(draw: random.Random, good: bytes) -> bytes:
    """Return a payload with bits turned, bytes cut off, put in or repeated; or nothing but noise."""
    kind = draw.randrange(6)
    data = bytearray(good)
    if kind == 0 or not data:
        return draw.randbytes(draw.randrange(0, 80))
    place = draw.randrange(len(data))
    if kind == 1:
        data[place] ^= 1 << draw.randrange(8)
    elif kind == 2:
        del data[place:]
    elif kind == 3:
        data[place:place] = draw.randbytes(draw.randrange(1, 9))
    elif kind == 4:
        data *= 2
    return bytes(data)
