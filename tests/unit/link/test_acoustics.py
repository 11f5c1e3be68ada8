"""Sound in sea water, against published figures and against the same formulas worked out in other ways."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_link.acoustics import (
    Layers,
    Water,
    absorption_ainslie_mccolm,
    absorption_thorp,
    noise_psd_wenz,
    sound_speed_mackenzie,
    transmission_loss,
)
from grex_link.errors import ConfigError
from grex_link.link_config import FixedNoise, WaterConfig, WenzNoise

PROFILE = ((5.0, 1512.0), (20.0, 1497.5), (21.0, 1485.0), (60.0, 1485.0), (200.0, 1489.25))
DEPTHS = st.floats(-5.0, 400.0)


def francois_garrison(f, t, salt, ph, depth_m):
    """Absorption after Francois and Garrison (1982), from which Ainslie and McColm's was made; up to 20 °C."""
    c = 1412.0 + 3.21 * t + 1.19 * salt + 0.0167 * depth_m
    kelvin = 273.0 + t
    acid, f1 = 8.86 / c * 10.0 ** (0.78 * ph - 5.0), 2.8 * np.sqrt(salt / 35.0) * 10.0 ** (4.0 - 1245.0 / kelvin)
    sulphate = 21.44 * salt / c * (1.0 + 0.025 * t) * (1.0 - 1.37e-4 * depth_m + 6.2e-9 * depth_m**2)
    f2 = 8.17 * 10.0 ** (8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (salt - 35.0))
    viscous = (4.937e-4 - 2.59e-5 * t + 9.11e-7 * t**2 - 1.5e-8 * t**3) * (
        1.0 - 3.83e-5 * depth_m + 4.9e-10 * depth_m**2
    )
    return acid * f1 * f**2 / (f1**2 + f**2) + sulphate * f2 * f**2 / (f2**2 + f**2) + viscous * f**2


def summed(speed_mps, start_m, end_m, steps=400_000):
    """Mean slowness by the trapezoidal rule."""
    depth_m = np.linspace(start_m, end_m, steps + 1)
    slowness = 1.0 / speed_mps(depth_m)
    return (slowness[1:] + slowness[:-1]).sum() / 2.0 / steps


# -- formulas -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("temperature_c", "salinity_ppt", "depth_m", "speed_mps", "within"),
    [
        (25.0, 35.0, 1000.0, 1550.744, 5e-4),  # published: the check of Mackenzie's equation
        (17.0, 33.6, 1.0, 1511.2, 0.05),  # published: two examples that come with an Octave function of it
        (3.51, 33.51, 1200.0, 1482.3, 0.05),
        (0.0, 35.0, 0.0, 1448.96, 1e-12),  # the equation's own constant
        (2.0, 25.0, 8000.0, 1585.1257056, 1e-7),  # recomputed with 40 decimal digits
        (30.0, 40.0, 4000.0, 1617.0356120, 1e-7),
        (10.0, 38.5, 120.0, 1496.0930497, 1e-7),
    ],
)
def test_sound_speed(temperature_c, salinity_ppt, depth_m, speed_mps, within):
    """Mackenzie's equation gives the published speeds, and at its limits what 40 decimal digits give."""
    assert sound_speed_mackenzie(temperature_c, salinity_ppt, depth_m) == pytest.approx(speed_mps, abs=within)


@pytest.mark.parametrize(
    ("water", "db_per_km"),
    [
        ((25.0, 10.0, 35.0, 8.0, 0.0), 5.10732279),
        ((25.0, 10.0, 35.0, 8.1, 0.1), 5.05086126),
        ((10.0, 4.0, 34.5, 7.9, 1.0), 0.98116544),
        ((62.5, 18.0, 38.0, 8.1, 0.02), 21.52118636),
        ((1.0, 0.0, 30.0, 7.7, 5.0), 0.03441891),
        ((300.0, 25.0, 36.0, 8.2, 0.5), 121.00881949),
    ],
)
def test_absorption(water, db_per_km):
    """Ainslie and McColm's formula gives what 40 decimal digits give (recomputed, not published)."""
    assert absorption_ainslie_mccolm(*water) == pytest.approx(db_per_km, abs=1e-8)


def test_absorption_is_near_its_model():
    """It stays within 10 % of Francois and Garrison from 1 to 500 kHz, as its authors say."""
    f, t, depth_m = np.meshgrid(np.geomspace(1.0, 500.0, 40), np.linspace(-2.0, 20.0, 12), np.linspace(0.0, 2000.0, 5))
    ours = absorption_ainslie_mccolm(f, t, 35.0, 8.0, depth_m / 1000.0)
    assert np.abs(ours / francois_garrison(f, t, 35.0, 8.0, depth_m) - 1.0).max() < 0.10


def test_absorption_against_another_toolbox():
    """The 10.71 dB that arlpy publishes for 1 km at 50 kHz (Francois and Garrison, 27 °C) are ours within 10 %."""
    assert absorption_ainslie_mccolm(50.0, 27.0, 35.0, 8.1, 0.01) == pytest.approx(10.71, rel=0.10)


@pytest.mark.parametrize(
    ("khz", "db_per_km"), [(1.0, 0.06900409), (10.0, 1.18702994), (25.0, 6.10480510), (50.0, 17.46712268)]
)
def test_thorp(khz, db_per_km):
    """Thorp's formula gives what 40 decimal digits give (recomputed; 1.19 dB at 10 kHz is in every textbook)."""
    assert absorption_thorp(khz) == pytest.approx(db_per_km, abs=1e-8)


def test_thorp_is_too_high():
    """In sea water of 10 to 18 °C Thorp's is a fifth to three fifths above Ainslie and McColm's at 11.5 to 26 kHz."""
    f, t = np.meshgrid(np.linspace(11.5, 26.0, 30), np.linspace(10.0, 18.0, 9))
    excess = absorption_thorp(f) / absorption_ainslie_mccolm(f, t, 35.0, 8.0, 0.0) - 1.0
    assert excess.min() == pytest.approx(0.192, abs=0.002)
    assert excess.max() == pytest.approx(0.574, abs=0.002)
    assert excess.mean() == pytest.approx(0.37, abs=0.02)


@pytest.mark.parametrize(
    ("sea", "psd_db"),
    [
        ((25.0, 5.0, 0.5), 38.54807758),
        ((10.0, 0.0, 0.0), 29.33693556),
        ((0.1, 3.0, 1.0), 77.19405589),
        ((0.005, 10.0, 0.5), 86.09202540),
        ((300.0, 2.0, 0.2), 34.56177493),
    ],
)
def test_noise(sea, psd_db):
    """Wenz's four noises together give what 40 decimal digits give (recomputed, not published)."""
    assert noise_psd_wenz(*sea) == pytest.approx(psd_db, abs=1e-8)


def test_noise_against_the_published_rule():
    """Without wind it is within 5 dB of Stojanovic's 50 - 18 log f from 1 to 40 kHz; heat alone rules at 500 kHz."""
    khz = np.geomspace(1.0, 40.0, 30)
    assert np.abs(noise_psd_wenz(khz, 0.0, 0.5) - (50.0 - 18.0 * np.log10(khz))).max() < 5.0
    assert noise_psd_wenz(500.0, 0.0, 0.0) == pytest.approx(-15.0 + 20.0 * np.log10(500.0), abs=0.01)


def test_noise_grows():
    """Wind and ships make it louder."""
    assert (np.diff(noise_psd_wenz(25.0, np.linspace(0.0, 30.0, 50), 0.5)) > 0.0).all()
    assert (np.diff(noise_psd_wenz(0.2, 5.0, np.linspace(0.0, 1.0, 50))) > 0.0).all()


@pytest.mark.parametrize(
    ("range_m", "spreading", "absorption", "loss_db"),
    [(1000.0, 1.5, 5.0, 50.0), (1000.0, 2.0, 0.0, 60.0), (100.0, 1.0, 10.0, 21.0), (1.0, 2.0, 0.0, 0.0),
     (0.5, 1.5, 10.0, 0.005), (0.0, 2.0, 10.0, 0.0)],
)  # fmt: skip
def test_transmission_loss(range_m, spreading, absorption, loss_db):
    """Spreading begins at a metre, absorption at once; both by hand."""
    assert transmission_loss(range_m, spreading, absorption) == pytest.approx(loss_db, abs=1e-12)


# -- water --------------------------------------------------------------------------------------------------------


def test_fixed_speed():
    """With one speed of sound the delay is the range over it, whatever the depths."""
    water = Water(WaterConfig(sound_speed=1480.0), 25_000.0, 4_000.0)
    assert water.delay_s(740.0, 3.0, 90.0) == 0.5
    assert water.delay_s(np.array([0.0, 1480.0]), 0.0, np.array([1.0, 2.0])).tolist() == [0.0, 1.0]


@pytest.mark.parametrize(("start_m", "end_m"), [(0.0, 0.0), (5.0, 40.0), (300.0, 2.0), (0.0, 6000.0)])
def test_mackenzie_speed(start_m, end_m):
    """With Mackenzie's speed the delay is the integral along the path, to 1e-12."""
    water = Water(WaterConfig(sound_speed="mackenzie", temperature_c=14.0, salinity_ppt=38.0), 25_000.0, 4_000.0)
    exact = 7000.0 * summed(lambda depth_m: sound_speed_mackenzie(14.0, 38.0, depth_m), start_m, end_m)
    assert water.delay_s(7000.0, start_m, end_m) == pytest.approx(exact, rel=1e-12)


def test_mackenzie_speed_of_no_sea():
    """Depths that no sea has give a speed that sound can have."""
    water = Water(WaterConfig(sound_speed="mackenzie"), 25_000.0, 4_000.0)
    assert 1400.0 < 1.0 / water.delay_s(1.0, -1e6, 1e6) < 1800.0


@pytest.mark.parametrize(
    ("start_m", "end_m"),
    [(0.0, 300.0), (300.0, 0.0), (6.0, 19.0), (19.9, 21.3), (30.0, 50.0), (0.0, 4.0), (250.0, 900.0), (4.0, 6.0),
     (20.5, 20.5 + 1e-6), (60.0, 60.001)],
)  # fmt: skip
def test_layers(start_m, end_m):
    """Through layers the delay is the integral along the path, to 1e-9: within, across, above and below them."""
    water = Water(WaterConfig(layers=PROFILE), 25_000.0, 4_000.0)
    depths_m, speeds_mps = np.array(PROFILE).T
    exact = 1000.0 * summed(lambda depth_m: np.interp(depth_m, depths_m, speeds_mps), start_m, end_m)
    assert water.delay_s(1000.0, start_m, end_m) == pytest.approx(exact, rel=1e-9)


@given(DEPTHS, DEPTHS)
def test_layers_have_no_direction(start_m, end_m):
    """The way down takes as long as the way up, and no longer than in the slowest water."""
    layers = Layers(PROFILE)
    down, up = layers.mean_slowness(start_m, end_m), layers.mean_slowness(end_m, start_m)
    assert down == pytest.approx(up, rel=1e-12)
    assert 1.0 / 1512.0 * (1.0 - 1e-12) <= down <= 1.0 / 1485.0 * (1.0 + 1e-12)


@given(DEPTHS, st.floats(-12.0, 1.0))
def test_layers_are_continuous(depth_m, exponent):
    """Two depths that come together have the slowness of the place: no cancellation, however near they are."""
    near_m = depth_m + 10.0**exponent
    here = 1.0 / np.interp(depth_m, *np.array(PROFILE).T)
    steepest = 12.5 / 1485.0**2
    assert abs(Layers(PROFILE).mean_slowness(depth_m, near_m) - here) <= steepest * (near_m - depth_m) + 1e-18


@pytest.mark.parametrize("config", [WaterConfig(), WaterConfig(sound_speed="mackenzie"), WaterConfig(layers=PROFILE)])
def test_arrays_of_any_shape(config):
    """Arrays give what their elements give one by one, in every shape that broadcasts."""
    water = Water(config, 25_000.0, 4_000.0)
    depth_m = np.array([0.0, 7.0, 33.0, 250.0])
    many = water.delay_s(np.full((4, 4), 100.0), depth_m[:, None], depth_m[None, :])
    one_by_one = [[float(water.delay_s(100.0, here, there)) for there in depth_m] for here in depth_m]
    np.testing.assert_allclose(many, one_by_one, rtol=1e-15)
    assert water.delay_s(np.full(4, 100.0), 7.0, depth_m) == pytest.approx(many[1], rel=1e-15)


def test_one_layer():
    """A profile of one point is one speed, and takes the place of the water's."""
    water = Water(WaterConfig(sound_speed=1400.0, layers=((10.0, 1500.0),)), 25_000.0, 4_000.0)
    assert water.delay_s(1500.0, 0.0, 100.0) == 1.0


@pytest.mark.parametrize("second_m", [5.0, 4.0])
def test_layers_out_of_order(second_m):
    """Layers that are not given from above to below are refused with their place."""
    with pytest.raises(ConfigError, match=r"^\$\.link\.water\.layers\[1\]: .* m is not below 5 m"):
        Water(WaterConfig(layers=((5.0, 1500.0), (second_m, 1490.0))), 25_000.0, 4_000.0)


def test_noise_level():
    """The level in the band is the spectrum level and 10 log10 of the width; the profile's overrides the sea's."""
    sea = WaterConfig(noise=WenzNoise(wind_mps=7.0, shipping=0.2))
    assert Water(sea, 12_000.0, 1_000.0).noise_db == pytest.approx(
        float(noise_psd_wenz(12.0, 7.0, 0.2)) + 30.0, abs=1e-12
    )
    assert Water(WaterConfig(noise=FixedNoise(psd_db=50.0)), 12_000.0, 100.0).noise_db == 70.0
    assert Water(sea, 25_000.0, 10_000.0, noise_psd_db=60.0).noise_db == 100.0


def test_loss():
    """Loss has the absorption of the water at the path's mean depth, and the spreading of water or profile."""
    config = WaterConfig(temperature_c=14.0, salinity_ppt=38.0, ph=8.1)
    range_m, depth_m = np.array([10.0, 500.0, 2000.0]), np.array([0.0, 100.0, 1000.0])
    absorption = absorption_ainslie_mccolm(25.0, 14.0, 38.0, 8.1, depth_m / 1000.0)
    for spreading, k in ((None, 1.5), (2.0, 2.0)):
        water = Water(config, 25_000.0, 4_000.0, spreading=spreading)
        np.testing.assert_allclose(
            water.loss_db(range_m, depth_m), transmission_loss(range_m, k, absorption), rtol=1e-14
        )


def test_loss_with_thorp():
    """Thorp's absorption knows no depth."""
    water = Water(WaterConfig(absorption="thorp"), 25_000.0, 4_000.0)
    assert water.loss_db(2000.0, 700.0) == water.loss_db(2000.0)
    assert water.loss_db(2000.0) == pytest.approx(15.0 * np.log10(2000.0) + 2.0 * 6.1048051, abs=1e-7)
