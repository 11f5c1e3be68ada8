"""Energy of sound: source level times airtime."""

import pytest

from grex_link.energy import sound_energy_j, sound_power_w
from grex_link.profile import load_profile


def test_one_watt():
    """170.8 dB re 1 µPa at 1 m is one watt, and 10 dB more is ten."""
    assert sound_power_w(170.8) == pytest.approx(1.0)
    assert sound_power_w(180.8) == pytest.approx(10.0)


def test_energy_is_power_times_time():
    """184 dB for 0.311 s are 6.5 J."""
    assert sound_energy_j(load_profile("s2c_im"), 0.311) == pytest.approx(10**1.32 * 0.311)


def test_a_modem_without_acoustics_has_no_energy():
    """The paper's modem has no source level, and nothing is made up."""
    assert sound_energy_j(load_profile("grex2008"), 10.0) is None
