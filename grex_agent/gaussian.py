"""Mean and covariance of a small state: prediction through a Jacobian, update with one number at a time."""

from typing import TypeAlias

import msgspec
import numpy as np

Matrix: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


class Gaussian(msgspec.Struct, frozen=True, gc=False):
    """A state with its covariance; the arrays are never changed."""

    mean: tuple[float, ...]
    covariance: Matrix


def propagate(mean: tuple[float, ...], before: Matrix, jacobian: Matrix, noise: Matrix) -> Gaussian:
    """Predict: the new mean as computed by the model, J P Jᵀ + Q."""
    return Gaussian(mean, jacobian @ before @ jacobian.T + noise)


def update(x: Gaussian, index: int, innovation: float, variance: float) -> Gaussian:
    """Work in a measurement of one component: Kalman gain, and the covariance in Joseph's form, which stays definite.

    Parameters
    ----------
    x : Gaussian
        Before.
    index : int
        Which component is measured.
    innovation : float
        Measured less expected.
    variance : float
        Of the measurement; positive.
    """
    p = x.covariance
    gain = p[:, index] / (p[index, index] + variance)
    shrink = np.eye(len(x.mean))
    shrink[:, index] -= gain
    mean = tuple(value + share * innovation for value, share in zip(x.mean, gain.tolist(), strict=True))
    return Gaussian(mean, shrink @ p @ shrink.T + variance * np.outer(gain, gain))


def update_along(x: Gaussian, row: Matrix, innovation: float, variance: float) -> Gaussian:
    """Work in one number that is measured of several components; see `update`.

    Parameters
    ----------
    x : Gaussian
        Before.
    row : ndarray, shape (n,)
        Derivatives of the measurement by the components.
    innovation, variance : float
        See `update`.
    """
    p = x.covariance
    across = p @ row
    gain = across / (float(row @ across) + variance)
    shrink = np.eye(len(x.mean)) - np.outer(gain, row)
    mean = tuple(value + share * innovation for value, share in zip(x.mean, gain.tolist(), strict=True))
    return Gaussian(mean, shrink @ p @ shrink.T + variance * np.outer(gain, gain))
