"""Means with their 95 % intervals."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_CONFIDENCE = 0.95
#: Values that are all the same have an interval of rounding errors.
_ROUNDING = 1e-12
#: Of a series whose values follow from each other: enough batches for an interval, long enough to be independent.
_BATCHES = 20


class Estimate(NamedTuple):
    """A mean of n values and the half-width of its interval; NaN where the values do not give it."""

    mean: float
    half: float
    n: int

    def __str__(self) -> str:
        if not self.n:
            return "-"
        half = 0.0 if self.half < _ROUNDING * abs(self.mean) else self.half
        return f"{self.mean:.4g} ± {half:.2g}" if math.isfinite(self.half) else f"{self.mean:.4g}"


def student_t(freedom: int) -> float:
    """Find the quantile of Student's t between the negative of which and itself 95 % lie, for degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + _CONFIDENCE / 2))


def mean_of(values: Sequence[float]) -> Estimate:
    """Estimate the mean of independent values by Student's t; those that are no number are left out."""
    finite = np.array([value for value in values if math.isfinite(value)], dtype=float)
    n = len(finite)
    if n == 0:
        return Estimate(math.nan, math.nan, 0)
    if n == 1:
        return Estimate(float(finite[0]), math.nan, 1)
    return Estimate(float(finite.mean()), student_t(n - 1) * float(finite.std(ddof=1)) / math.sqrt(n), n)


def mean_of_series(series: NDArray[np.float64]) -> Estimate:
    """Estimate the mean of a series whose values depend on those before: the interval is that of batch means."""
    finite = series[np.isfinite(series)]
    if len(finite) < 2 * _BATCHES:
        return Estimate(float(finite.mean()) if len(finite) else math.nan, math.nan, len(finite))
    batches = mean_of([float(batch.mean()) for batch in np.array_split(finite, _BATCHES)])
    return Estimate(float(finite.mean()), batches.half, len(finite))
