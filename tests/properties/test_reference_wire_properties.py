"""Properties of the payload of the shared reference: what is packed comes back, what arrives is read or refused."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grex_link import wire
from grex_link.errors import WireError
from grex_link.reference_wire import VERSIONS, Limit, ReferenceWord, is_newer, pack, size_bytes, unpack

LIMITS = st.builds(Limit, st.integers(0, VERSIONS), st.none() | st.floats(0.0, 3.1))
WORDS = st.builds(
    ReferenceWord,
    source=st.integers(0, 15),
    t_s=st.floats(0.0, 1e6),
    hold_s=st.floats(0.0, 1e5),
    lag_s=st.floats(-51.2, 51.1),
    limits=st.lists(LIMITS, min_size=1, max_size=60).map(tuple),
    asks=st.booleans(),
)


@given(WORDS, st.floats(-250.0, 250.0), st.floats(-1600.0, 1600.0))
def test_round_trip(word, age_s, hold_apart_s):
    """Every field comes back within its step, whatever the receiver's time (4 min) and hold (26 min apart)."""
    read = unpack(pack(word), len(word.limits), word.t_s + age_s, word.hold_s + hold_apart_s)
    assert (read.source, read.asks) == (word.source, word.asks)
    assert read.t_s == pytest.approx(word.t_s, abs=0.2501)
    assert -1e-4 <= word.hold_s - read.hold_s <= 0.0501
    assert read.lag_s == pytest.approx(word.lag_s, abs=0.0501)
    assert [limit.version for limit in read.limits] == [limit.version for limit in word.limits]
    for told, limit in zip(read.limits, word.limits, strict=True):
        if limit.speed_mps is None:
            assert told.speed_mps is None
        else:
            assert told.speed_mps == pytest.approx(limit.speed_mps, abs=0.0251)


@given(WORDS)
def test_what_was_read_is_packed_to_the_same_bytes(word):
    """Passed on unchanged it stays the same: an echo does not make the hold grow."""
    read = unpack(pack(word), len(word.limits), word.t_s, word.hold_s)
    assert pack(read) == pack(word)


@given(st.binary(max_size=70), st.integers(1, 60))
@example(b"\x10" * 9, 3)
def test_any_bytes_are_read_or_refused(payload, craft):
    """Whatever is heard is a word whose numbers are numbers, or it is refused."""
    try:
        word = unpack(payload, craft, 100.0, 3.0)
    except WireError:
        return
    assert len(payload) == size_bytes(craft)
    assert payload[0] >> 4 == 2
    assert len(word.limits) == craft
    assert all(map(math.isfinite, (word.t_s, word.hold_s, word.lag_s)))


@given(st.integers(1, 200))
def test_it_is_never_taken_for_a_team_state(craft):
    """No team makes it as long as a team state; each craft more takes 9 bits."""
    size = size_bytes(craft)
    assert size not in wire.BYTES.values()
    assert 0 <= 8 * size - (45 + 9 * craft) < 16


def test_three_craft_take_nine_bytes():
    """The word of a team of three has 72 bits and no padding."""
    assert size_bytes(3) == 9
    assert 45 + 9 * 3 == 72


@given(st.integers(1, VERSIONS), st.integers(1, 3))
def test_versions_come_round(version, later):
    """A version up to three later is newer, and the older one is not; anything is newer than nothing."""
    after = (version - 1 + later) % VERSIONS + 1
    assert is_newer(after, version)
    assert not is_newer(version, after)
    assert not is_newer(version, version)
    assert is_newer(version, 0)
    assert not is_newer(0, version)


@pytest.mark.parametrize("fields", [{"t_s": math.nan}, {"hold_s": math.inf}, {"lag_s": math.nan}])
def test_what_is_no_number_is_refused(fields):
    """A value that is no number is not told."""
    word = {"source": 0, "t_s": 1.0, "hold_s": 0.0, "lag_s": 0.0, "limits": (Limit(),)} | fields
    with pytest.raises(WireError, match="not a number"):
        pack(ReferenceWord(**word))


def test_a_version_that_does_not_exist_is_refused():
    """Versions above 7 do not fit."""
    with pytest.raises(WireError, match="version"):
        pack(ReferenceWord(0, 1.0, 0.0, 0.0, (Limit(8),)))
