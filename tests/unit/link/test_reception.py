"""What becomes of a packet: error figures are read as they are written, and stay probabilities."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_link.profile import (
    BitErrors,
    ErrorTable,
    InterferenceTable,
    ModemProfile,
    Protocol,
    RangeTable,
    Threshold,
    load_profile,
    profile_names,
)
from grex_link.reception import Curve, Reception

TABLE = ErrorTable(sinr_db=(-2.0, 0.0, 4.0), per=(1.0, 0.5, 0.1))
PROFILES = [load_profile(name) for name in profile_names()]
LEVELS = st.floats(allow_nan=False)
SIZES = st.integers(0, 4096)


def modem(reception, **fields):
    """Make a profile of error figures and little else."""
    return ModemProfile(
        title="test", payload_max_bytes=4096, airtime_fixed_s=1.0, airtime_per_byte_s=0.0, frequency_hz=25e3,
        bandwidth_hz=4e3, source_level_db=180.0, reception=reception, sources=[], assumed=[], **fields,
    )  # fmt: skip


def rate(reception, sinr_db, size_bytes=15):
    """Packet error rate of a model."""
    return Reception(modem(reception)).packet_error_rate(sinr_db, size_bytes)


# -- packet error rate --------------------------------------------------------------------------------------------


def test_threshold():
    """At the threshold a packet is whole, and just below it is not."""
    assert rate(Threshold(sinr_db=3.0), 3.0) == 0.0
    assert rate(Threshold(sinr_db=3.0), math.nextafter(3.0, -math.inf)) == 1.0


@pytest.mark.parametrize(
    ("sinr_db", "per"),
    [(-math.inf, 1.0), (-2.0, 1.0), (-1.0, 0.75), (0.0, 0.5), (1.0, 0.4), (4.0, 0.1), (9.0, 0.1), (math.inf, 0.1)],
)
def test_table(sinr_db, per):
    """A table is linear between its points and held beyond them, whatever the length of the packet."""
    assert rate(TABLE, sinr_db) == pytest.approx(per, abs=1e-15)
    assert rate(TABLE, sinr_db, 4096) == rate(TABLE, sinr_db, 1)


@pytest.mark.parametrize(("size_bytes", "frames"), [(0, 1), (1, 1), (64, 1), (65, 2), (192, 3)])
def test_frames(size_bytes, frames):
    """Where the table is one of frames, a payload needs all of its own."""
    table = ErrorTable(sinr_db=TABLE.sinr_db, per=TABLE.per, frame_bytes=64)
    assert rate(table, 4.0, size_bytes) == pytest.approx(1.0 - 0.9**frames, abs=1e-15)


@pytest.mark.parametrize(
    ("modulation", "sinr_db"), [("bpsk", 9.588), ("dpsk", 10.342), ("fsk", 13.352)]
)  # each where its BER is 1e-5: 9.6, 10.3 and 13.4 dB in Proakis's figures
def test_bit_errors(modulation, sinr_db):
    """A modulation has its published bit error rate, a processing gain shifts it, and every bit must be whole."""
    one_byte = 1.0 - (1.0 - 1e-5) ** 8
    assert rate(BitErrors(modulation=modulation), sinr_db, 1) == pytest.approx(one_byte, rel=2e-3)
    assert rate(BitErrors(modulation=modulation, gain_db=20.0), sinr_db - 20.0, 1) == pytest.approx(one_byte, rel=2e-3)
    assert rate(BitErrors(modulation=modulation), sinr_db, 1250) == pytest.approx(1.0 - math.exp(-0.1), rel=2e-3)


def test_bit_errors_far_out():
    """With no signal every other bit is wrong; with a loud one none is, and no power overflows."""
    for modulation in ("bpsk", "dpsk", "fsk"):
        model = BitErrors(modulation=modulation)
        assert rate(model, -math.inf, 1) == pytest.approx(1.0 - 0.5**8)
        assert rate(model, -math.inf, 0) == 0.0
        assert rate(model, 1e6) == rate(model, math.inf) == 0.0


def test_protocol():
    """In the protocol model a packet that nobody drowns is whole."""
    model = Protocol(communication_m=1.0, detection_m=1.0, interference_m=1.0)
    assert (rate(model, 0.0), rate(model, -0.001), rate(model, 10.0)) == (0.0, 1.0, 0.0)


MODELS = st.one_of(
    st.sampled_from([profile.reception for profile in PROFILES if profile.reception is not None]),
    st.builds(BitErrors, modulation=st.sampled_from(["bpsk", "dpsk", "fsk"]), gain_db=st.floats(-300.0, 300.0)),
    st.builds(
        lambda start, steps, rates, frame: ErrorTable(
            sinr_db=tuple(start + place * steps for place in range(len(rates))),
            per=tuple(sorted(rates, reverse=True)),
            frame_bytes=frame,
        ),
        st.floats(-50.0, 50.0),
        st.floats(1e-3, 20.0),
        st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8),
        st.none() | st.integers(1, 300),
    ),
)


@given(MODELS, LEVELS, SIZES)
def test_a_rate_is_a_probability(model, sinr_db, size_bytes):
    """No level and no length, not even an endless one, gives less than 0 or more than 1."""
    assert 0.0 <= rate(model, sinr_db, size_bytes) <= 1.0


@given(MODELS, LEVELS, LEVELS, SIZES, SIZES)
def test_more_signal_is_never_worse(model, one_db, other_db, one_bytes, other_bytes):
    """A stronger signal is never lost more often, and a longer payload never less."""
    assert rate(model, max(one_db, other_db), one_bytes) <= rate(model, min(one_db, other_db), one_bytes)
    assert rate(model, one_db, min(one_bytes, other_bytes)) <= rate(model, one_db, max(one_bytes, other_bytes))


# -- tables of delivery -------------------------------------------------------------------------------------------


def test_without_tables():
    """A profile without tables loses nothing to range or interference as such."""
    reception = Reception(modem(Threshold(sinr_db=0.0)))
    assert reception.range_delivery(1e9) == 1.0
    assert reception.interference_delivery(-1e9) == 1.0


@pytest.mark.parametrize(
    ("range_m", "share"), [(0.0, 0.9), (10.0, 0.9), (15.0, 0.8), (20.0, 0.7), (100.0, 0.5), (100.1, 0.0), (1e9, 0.0)]
)
def test_range(range_m, share):
    """Share over range: held before the first point, linear, nothing beyond the last."""
    table = RangeTable(range_m=(10.0, 20.0, 100.0), pdr=(0.9, 0.7, 0.5))
    assert Reception(modem(TABLE, range_pdr=table)).range_delivery(range_m) == pytest.approx(share, abs=1e-15)


@pytest.mark.parametrize(
    ("sir_db", "share"),
    [(-math.inf, 0.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 0.2), (2.0, 0.4), (2.5, 0.7), (3.0, 1.0), (80.0, 1.0)],
)
def test_interference(sir_db, share):
    """Share over interference: nothing before a first point of nothing, linear, held beyond the last."""
    table = InterferenceTable(sir_db=(0.0, 2.0, 3.0), pdr=(0.0, 0.4, 1.0))
    assert Reception(modem(TABLE, interference_pdr=table)).interference_delivery(sir_db) == pytest.approx(share)


def test_no_interference():
    """Without interference nothing is lost to it, even if the table does not end at 1."""
    table = InterferenceTable(sir_db=(0.0, 2.0), pdr=(0.0, 0.9))
    assert Reception(modem(TABLE, interference_pdr=table)).interference_delivery(math.inf) == 1.0


@given(st.sampled_from(PROFILES), st.floats(0.0, 1e7), LEVELS)
def test_shares_are_shares(profile, range_m, sir_db):
    """No profile that comes with GREX ever delivers less than nothing or more than all."""
    reception = Reception(profile)
    assert 0.0 <= reception.range_delivery(range_m) <= 1.0
    assert 0.0 <= reception.interference_delivery(sir_db) <= 1.0


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(0.0, 1.0)), min_size=1, max_size=9, unique_by=lambda p: p[0]))
def test_a_curve_goes_through_its_points(points):
    """A curve has its points' values at their places."""
    places, values = zip(*sorted(points), strict=True)
    curve = Curve(places, values)
    assert [curve(place) for place in places] == pytest.approx(values, abs=1e-9)
