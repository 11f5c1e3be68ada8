"""Draws are hashes of what they are for: uniform, normal, and independent of everything else."""

import math

import numpy as np
import pytest

from grex_link import draws

N = 20_000


def uniforms(*purpose) -> np.ndarray:
    return np.array([draws.uniform(1, *purpose, number) for number in range(N)])


def test_uniform_range_and_moments() -> None:
    """Uniform draws lie in [0, 1) and have the mean and variance of the uniform distribution."""
    values = uniforms("loss", "auv1")
    assert values.min() >= 0.0
    assert values.max() < 1.0
    assert abs(values.mean() - 0.5) < 4 * math.sqrt(1 / 12 / N)
    assert abs(values.var() - 1 / 12) < 4 * math.sqrt(1 / 180 / N)


def test_uniform_fills_the_interval_evenly() -> None:
    """Each twentieth of [0, 1) gets its share."""
    counts, _ = np.histogram(uniforms("loss", "auv1"), bins=20, range=(0.0, 1.0))
    assert np.all(np.abs(counts - N / 20) < 4 * math.sqrt(N / 20 * 0.95))


def test_successive_draws_are_independent() -> None:
    """One draw says nothing about the next number's, nor about the same number's of somebody else."""
    first, second = uniforms("loss", "auv1"), uniforms("loss", "auv2")
    for one, other in ((first[:-1], first[1:]), (first, second)):
        assert abs(np.corrcoef(one, other)[0, 1]) < 4 / math.sqrt(N)


def test_normal_moments() -> None:
    """Both normal draws have mean 0, variance 1, kurtosis 3, and are not correlated."""
    pairs = np.array([draws.normal(1, "white", "auv1", number) for number in range(N)])
    for values in pairs.T:
        assert abs(values.mean()) < 4 / math.sqrt(N)
        assert abs(values.var() - 1.0) < 4 * math.sqrt(2 / N)
        assert abs(np.mean(values**4) - 3.0) < 4 * math.sqrt(96 / N)
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 4 / math.sqrt(N)


def test_order_does_not_matter() -> None:
    """A draw is the same whatever has been drawn before it."""
    forward = [draws.uniform(7, "loss", number) for number in range(100)]
    backward = [draws.uniform(7, "loss", number) for number in reversed(range(100))]
    assert forward == backward[::-1]


def test_different_purposes_differ() -> None:
    """Seed, purpose, who, number and their order each make another draw; so do 1 and "1"."""
    keys = [(1, "a", "b", 1), (2, "a", "b", 1), (1, "c", "b", 1), (1, "a", "c", 1), (1, "a", "b", 2), (1, "b", "a", 1)]
    keys += [(1, "a", "b", "1"), (1, "ab", 1), (1, "a", "b"), (1, "a", "b", 1, "")]
    assert len({draws.uniform(*key) for key in keys}) == len(keys)
    assert len({draws.normal(*key) for key in keys}) == len(keys)


def test_same_in_every_version() -> None:
    """A seed gives the same run on every machine and in every version."""
    assert draws.uniform(1, "loss", "auv1", 0, "auv2") == 0.22626232048471007
    assert draws.normal(1, "white", "auv1", 0) == pytest.approx((0.025359237046038482, -0.16341609227315615), abs=1e-12)


def test_uniform_is_below_one_for_every_hash(monkeypatch) -> None:
    """Even the largest hash gives a draw below 1, or a probability of 1 would not be certain."""
    monkeypatch.setattr(draws, "_digest", lambda *_: b"\xff" * 16)
    assert draws.uniform(1, "loss") < 1.0


@pytest.mark.parametrize("digest", [b"\x00" * 16, b"\xff" * 16])
def test_normal_is_finite_for_every_hash(monkeypatch, digest: bytes) -> None:
    """The smallest and the largest hash give finite normal draws."""
    monkeypatch.setattr(draws, "_digest", lambda *_: digest)
    assert all(math.isfinite(value) for value in draws.normal(1, "white"))
