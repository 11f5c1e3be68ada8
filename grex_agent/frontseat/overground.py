"""Velocity over ground of a craft that is told its positions: how it goes through the water, and what carries it.

What a fix says of speed is through the water, along the bow. Current and sway are what the positions show besides:

    drift = Δposition / Δt - mean(speed · bow),     velocity = speed · bow + drift

over the last seconds. A turn or a change of speed is in it at once, the drift is as good as the positions are.
"""

import math
from collections import deque
from typing import NamedTuple

from grex_link.messages import Fix

#: Seconds of the autopilot over which the drift is measured; less than the least, and it is not known.
_WINDOW_S = 10.0
_LEAST_S = 2.0
#: What positions do not show of it: a heading that is wrong by some degrees, a speed by some per cent.
_LEAST_SIGMA_MPS = 0.1
_RELATIVE_SIGMA = 0.1


class Velocity(NamedTuple):
    """Velocity over ground, m/s, and the standard deviation of each of its axes."""

    north_mps: float
    east_mps: float
    sigma_mps: float


class _Sample(NamedTuple):
    at_s: float
    north_m: float
    east_m: float
    #: What it has gone through the water since the first one.
    through_north_m: float
    through_east_m: float
    sigma_m: float


class OverGround:
    """See the module's docstring. Times are seconds of the autopilot."""

    def __init__(self) -> None:
        self._samples: deque[_Sample] = deque()
        self._bow = 0.0, 0.0

    def reset(self) -> None:
        """Forget everything: there is a gap."""
        self._samples.clear()

    def on_fix(self, fix: Fix, passed_s: float) -> None:
        """Take a fix that came so long after the one before."""
        before = self._bow
        self._bow = fix.speed_mps * math.cos(fix.heading_rad), fix.speed_mps * math.sin(fix.heading_rad)
        if not self._samples:
            self._samples.append(_Sample(0.0, fix.north_m, fix.east_m, 0.0, 0.0, fix.sigma_m))
            return
        last = self._samples[-1]
        through = [passed_s * (old + new) / 2.0 for old, new in zip(before, self._bow, strict=True)]
        self._samples.append(
            _Sample(
                last.at_s + passed_s,
                fix.north_m,
                fix.east_m,
                last.through_north_m + through[0],
                last.through_east_m + through[1],
                fix.sigma_m,
            )
        )
        while self._samples[-1].at_s - self._samples[1].at_s >= _WINDOW_S:
            self._samples.popleft()

    @property
    def velocity(self) -> Velocity | None:
        """How it moves as of the last fix; None before the positions have shown it."""
        if not self._samples:
            return None
        first, last = self._samples[0], self._samples[-1]
        passed_s = last.at_s - first.at_s
        if passed_s < _LEAST_S:
            return None
        north_mps = (last.north_m - first.north_m - last.through_north_m + first.through_north_m) / passed_s
        east_mps = (last.east_m - first.east_m - last.through_east_m + first.through_east_m) / passed_s
        model_mps = max(_LEAST_SIGMA_MPS, _RELATIVE_SIGMA * math.hypot(*self._bow))
        sigma_mps = math.hypot(first.sigma_m / passed_s, last.sigma_m / passed_s, model_mps)
        return Velocity(self._bow[0] + north_mps, self._bow[1] + east_mps, sigma_mps)
