"""Sound in sea water: how fast it is, what is left of it, and what it has to be heard above.

All formulas take floats or NumPy arrays of shapes that broadcast, and give the broadcast shape (a NumPy scalar for
scalars). Levels are dB re 1 µPa, spectrum levels dB re 1 µPa²/Hz.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from grex_link.errors import ConfigError
from grex_link.link_config import FixedNoise, WaterConfig

Vector = NDArray[np.float64]
Numbers = float | Vector

#: Depths are held within these for Mackenzie's polynomial: below the deepest trench it would run away.
_SHALLOWEST_M, _DEEPEST_M = 0.0, 11_000.0
#: Gauss–Legendre on [0, 1]: the mean slowness is exact to rounding over any depth in the sea.
_NODES, _WEIGHTS = (0.5 * points for points in np.polynomial.legendre.leggauss(5))
_NODES = _NODES + 0.5


def sound_speed_mackenzie(temperature_c: Numbers, salinity_ppt: Numbers, depth_m: Numbers) -> Vector:
    """Speed of sound in sea water.

    Mackenzie, "Nine-term equation for sound speed in the oceans", J. Acoust. Soc. Am. 70 (1981) 807–812; for 2–30 °C,
    25–40 ‰ and down to 8000 m, with a standard error of 0.07 m/s.

    Parameters
    ----------
    temperature_c : float or array
        Degrees Celsius.
    salinity_ppt : float or array
        Parts per thousand.
    depth_m : float or array
        Below the surface, metres.

    Returns
    -------
    array
        Metres a second.
    """
    t, d = np.asarray(temperature_c, dtype=float), np.asarray(depth_m, dtype=float)
    salt = np.asarray(salinity_ppt, dtype=float) - 35.0
    of_temperature = 1448.96 + t * (4.591 + t * (-5.304e-2 + t * 2.374e-4))
    of_depth = d * (1.630e-2 + d * (1.675e-7 - 7.139e-13 * t * d))
    speed: Vector = of_temperature + salt * (1.340 - 1.025e-2 * t) + of_depth
    return speed


def absorption_ainslie_mccolm(
    frequency_khz: Numbers, temperature_c: Numbers, salinity_ppt: Numbers, ph: Numbers, depth_km: Numbers
) -> Vector:
    """Absorption of sound in sea water: boric acid, magnesium sulphate, and the water itself.

    Ainslie and McColm, "A simplified formula for viscous and chemical absorption in sea water", J. Acoust. Soc. Am.
    103 (1998) 1671–1672; within 10 % of Francois and Garrison from 100 Hz to 1 MHz.

    Parameters
    ----------
    frequency_khz : float or array
        Kilohertz.
    temperature_c : float or array
        Degrees Celsius.
    salinity_ppt : float or array
        Parts per thousand.
    ph : float or array
        Acidity.
    depth_km : float or array
        Below the surface, kilometres.

    Returns
    -------
    array
        dB a kilometre.
    """
    acid, sulphate, viscous = _absorption_terms(frequency_khz, temperature_c, salinity_ppt, ph)
    return _at_depth(acid, sulphate, viscous, depth_km)


def absorption_thorp(frequency_khz: Numbers) -> Vector:
    """Absorption of sound after Thorp, with the water's own term: what many network simulators reckon with.

    Thorp, J. Acoust. Soc. Am. 42 (1967) 270, in dB a kilometre as Urick and Brekhovskikh and Lysanov give it; for 4 °C
    at 1 km depth.

    Parameters
    ----------
    frequency_khz : float or array
        Kilohertz.

    Returns
    -------
    array
        dB a kilometre.
    """
    squared = np.asarray(frequency_khz, dtype=float) ** 2
    return 0.11 * squared / (1.0 + squared) + 44.0 * squared / (4100.0 + squared) + 2.75e-4 * squared + 0.003


def transmission_loss(range_m: Numbers, spreading: Numbers, absorption_db_per_km: Numbers) -> Vector:
    """Transmission loss k·10·log10 r + α·r/1000; spreading begins at one metre (acoustic-link §2).

    Parameters
    ----------
    range_m : float or array
        Length of the path, metres.
    spreading : float or array
        k: 1 cylindrical, 1.5 practical, 2 spherical.
    absorption_db_per_km : float or array
        α.

    Returns
    -------
    array
        dB.
    """
    length = np.asarray(range_m, dtype=float)
    spread = np.asarray(spreading) * 10.0 * np.log10(np.maximum(length, 1.0))
    loss: Vector = spread + absorption_db_per_km * length / 1000.0
    return loss


def noise_psd_wenz(frequency_khz: Numbers, wind_mps: Numbers, shipping: Numbers) -> Vector:
    """Ambient noise of the sea: turbulence, shipping, wind and heat together.

    Wenz's curves in Coates's formulas (R. F. W. Coates, "Underwater Acoustic Systems", 1989; Stojanovic, WUWNet 2006).

    Parameters
    ----------
    frequency_khz : float or array
        Kilohertz, above 0.
    wind_mps : float or array
        Wind speed, metres a second.
    shipping : float or array
        Activity, from 0 to 1.

    Returns
    -------
    array
        Spectrum level, dB re 1 µPa²/Hz.
    """
    f = np.asarray(frequency_khz, dtype=float)
    log = np.log10(f)
    turbulence = 17.0 - 30.0 * log
    ships = 40.0 + 20.0 * (np.asarray(shipping) - 0.5) + 26.0 * log - 60.0 * np.log10(f + 0.03)
    waves = 50.0 + 7.5 * np.sqrt(wind_mps) + 20.0 * log - 40.0 * np.log10(f + 0.4)
    heat = -15.0 + 20.0 * log
    power = sum(10.0 ** (level / 10.0) for level in (turbulence, ships, waves, heat))
    together: Vector = 10.0 * np.log10(power)
    return together


class Water:
    """The water between modems of one band.

    Parameters
    ----------
    config : WaterConfig
        Speed of sound, absorption, spreading, noise.
    frequency_hz : float
        Centre of the band.
    bandwidth_hz : float
        Its width.
    spreading : float or None
        Takes the place of the config's exponent.
    noise_psd_db : float or None
        Takes the place of the config's noise, dB re 1 µPa²/Hz.

    Attributes
    ----------
    spreading : float
        Exponent in use.
    noise_db : float
        Ambient noise in the band, dB re 1 µPa: the spectrum level at its centre and 10 log10 of its width.

    Raises
    ------
    ConfigError
        If the layers of the sound speed profile are not in order from above to below.
    """

    def __init__(
        self,
        config: WaterConfig,
        frequency_hz: float,
        bandwidth_hz: float,
        *,
        spreading: float | None = None,
        noise_psd_db: float | None = None,
    ) -> None:
        self.spreading = config.spreading if spreading is None else spreading
        self._frequency_khz = frequency_hz / 1000.0
        self._config = config
        self._layers = Layers(config.layers) if config.layers else None
        self._terms = self._absorption()
        psd_db = self._ambient_psd_db() if noise_psd_db is None else noise_psd_db
        self.noise_db = psd_db + 10.0 * math.log10(bandwidth_hz)

    def delay_s(self, range_m: Numbers, depth_a_m: Numbers, depth_b_m: Numbers) -> Vector:
        """Time that sound takes on the straight path between two depths.

        Parameters
        ----------
        range_m : float or array
            Length of the path, metres.
        depth_a_m, depth_b_m : float or array
            Depths of its ends, metres.

        Returns
        -------
        array
            Seconds.
        """
        length = np.asarray(range_m, dtype=float)
        if self._layers is not None:
            return length * self._layers.mean_slowness(depth_a_m, depth_b_m)
        if self._config.sound_speed == "mackenzie":
            return length * self._mackenzie_slowness(depth_a_m, depth_b_m)
        return length / self._config.sound_speed

    def loss_db(self, range_m: Numbers, mean_depth_m: Numbers = 0.0) -> Vector:
        """Transmission loss of a path, with the absorption at its mean depth, dB.

        Parameters
        ----------
        range_m : float or array
            Length of the path, metres.
        mean_depth_m : float or array
            Metres.
        """
        return transmission_loss(range_m, self.spreading, self.absorption_db_per_km(mean_depth_m))

    def absorption_db_per_km(self, depth_m: Numbers = 0.0) -> Vector:
        """Absorption at the centre of the band, dB a kilometre."""
        if self._config.absorption == "thorp":
            return self._terms[0]
        return _at_depth(*self._terms, np.asarray(depth_m, dtype=float) / 1000.0)

    def _absorption(self) -> tuple[Vector, Vector, Vector]:
        config, none = self._config, np.asarray(0.0)
        if config.absorption == "thorp":
            return absorption_thorp(self._frequency_khz), none, none
        return _absorption_terms(self._frequency_khz, config.temperature_c, config.salinity_ppt, config.ph)

    def _ambient_psd_db(self) -> float:
        noise = self._config.noise
        if isinstance(noise, FixedNoise):
            return noise.psd_db
        return float(noise_psd_wenz(self._frequency_khz, noise.wind_mps, noise.shipping))

    def _mackenzie_slowness(self, depth_a_m: Numbers, depth_b_m: Numbers) -> Vector:
        start, end = np.asarray(depth_a_m, dtype=float), np.asarray(depth_b_m, dtype=float)
        config = self._config
        depth_m = start + np.multiply.outer(_NODES, end - start)
        depth_m = np.minimum(np.maximum(depth_m, _SHALLOWEST_M), _DEEPEST_M)
        speed_mps = sound_speed_mackenzie(config.temperature_c, config.salinity_ppt, depth_m)
        return np.asarray(np.tensordot(_WEIGHTS, 1.0 / speed_mps, 1))


class Layers:
    """A sound speed profile: linear between its points, constant above the first and below the last.

    Parameters
    ----------
    points : sequence of (float, float)
        Depth in metres and speed in metres a second, from above to below.

    Raises
    ------
    ConfigError
        If a point is not below the one before it.
    """

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        for number, (upper, lower) in enumerate(pairwise(points), start=1):
            if lower[0] <= upper[0]:
                raise ConfigError(
                    f"$.link.water.layers[{number}]", f"{lower[0]:g} m is not below {upper[0]:g} m: from above to below"
                )
        depth_m, speed_mps = np.array(points, dtype=float).T
        self._depth_m, self._speed_mps = depth_m, speed_mps
        # One row a layer, with the open ones at both ends; shape (layers, 1) meets paths of shape (n,).
        self._top_m = np.concatenate([[-np.inf], depth_m])[:, None]
        self._bottom_m = np.concatenate([depth_m, [np.inf]])[:, None]
        self._known_m = np.concatenate([depth_m[:1], depth_m])[:, None]
        self._known_mps = np.concatenate([speed_mps[:1], speed_mps])[:, None]
        self._gradient = np.concatenate([[0.0], np.diff(speed_mps) / np.diff(depth_m), [0.0]])[:, None]

    def mean_slowness(self, depth_a_m: Numbers, depth_b_m: Numbers) -> Vector:
        """Mean of 1/c on the straight path between two depths, seconds a metre.

        Exact: over a height h within a layer of gradient g that begins at speed c, the mean is ln(1 + g·h/c)/(g·h).
        """
        start, end = np.broadcast_arrays(np.asarray(depth_a_m, dtype=float), np.asarray(depth_b_m, dtype=float))
        upper, lower = np.minimum(start, end), np.maximum(start, end)
        from_m = np.maximum(upper.ravel(), self._top_m)
        height = np.maximum(np.minimum(lower.ravel(), self._bottom_m) - from_m, 0.0)
        inside = np.where(height > 0.0, from_m, self._known_m)
        speed = self._known_mps + self._gradient * (inside - self._known_m)
        change = self._gradient * height / speed
        bent = change != 0.0
        shape = np.ones_like(change)
        np.divide(np.log1p(change), change, out=shape, where=bent)
        total = (height / speed * shape).sum(axis=0).reshape(upper.shape)
        level = lower == upper
        here = 1.0 / np.interp(upper, self._depth_m, self._speed_mps)
        slowness: Vector = np.where(level, here, total / np.where(level, 1.0, lower - upper))
        return slowness


def _absorption_terms(
    frequency_khz: Numbers, temperature_c: Numbers, salinity_ppt: Numbers, ph: Numbers
) -> tuple[Vector, Vector, Vector]:
    """Absorption by boric acid, by magnesium sulphate and by the water at the surface, dB a kilometre each."""
    squared, t = np.asarray(frequency_khz, dtype=float) ** 2, np.asarray(temperature_c, dtype=float)
    salt = np.asarray(salinity_ppt, dtype=float) / 35.0
    boron_khz = 0.78 * np.sqrt(salt) * np.exp(t / 26.0)
    magnesium_khz = 42.0 * np.exp(t / 17.0)
    acid = 0.106 * boron_khz * squared / (squared + boron_khz**2) * np.exp((np.asarray(ph) - 8.0) / 0.56)
    sulphate = 0.52 * (1.0 + t / 43.0) * salt * magnesium_khz * squared / (squared + magnesium_khz**2)
    return acid, sulphate, 4.9e-4 * squared * np.exp(-t / 27.0)


def _at_depth(acid: Vector, sulphate: Vector, viscous: Vector, depth_km: Numbers) -> Vector:
    """All three at a depth, which the acid does not feel; above the surface there is no less pressure than at it."""
    depth = np.maximum(np.asarray(depth_km, dtype=float), 0.0)
    absorption: Vector = acid + sulphate * np.exp(-depth / 6.0) + viscous * np.exp(-depth / 17.0)
    return absorption
