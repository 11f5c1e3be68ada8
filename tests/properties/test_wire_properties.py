"""Properties of the compact payload: whatever is packed comes back, whatever arrives is read or refused."""

import math

from hypothesis import example, given
from hypothesis import strategies as st

from grex_link.errors import WireError
from grex_link.wire import TeamState, pack, unpack

STATES = st.builds(
    TeamState,
    source=st.integers(0, 15),
    t_s=st.floats(0.0, 1e7),
    north_m=st.floats(-8191.9, 8191.9),
    east_m=st.floats(-8191.9, 8191.9),
    depth_m=st.floats(0.0, 409.5),
    speed_mps=st.floats(0.0, 5.1),
    heading_rad=st.floats(-10.0, 10.0),
    track=st.integers(0, 255),
    theta=st.floats(0.0, 1.0),
    sigma_m=st.floats(0.0, 4600.0),
    flags=st.integers(0, 255),
)

#: Half a step of each field, and a little for the arithmetic.
HALF_STEPS = {"north_m": 0.0625, "east_m": 0.0625, "depth_m": 0.05, "speed_mps": 0.01, "theta": 0.5 / 4095}
TINY = 1e-8


@given(STATES, st.floats(-1638.0, 1638.0))
def test_round_trip(state: TeamState, age_s: float) -> None:
    """Every field comes back within half its step, at any time of the mission and any age up to 27 minutes."""
    read = unpack(pack(state), state.t_s + age_s)
    for name, half in HALF_STEPS.items():
        assert abs(getattr(read, name) - getattr(state, name)) <= half + TINY, name
    assert abs(read.t_s - state.t_s) <= 0.025 + TINY
    turn = math.remainder(read.heading_rad - state.heading_rad, 2 * math.pi)
    assert abs(turn) <= math.pi / 512 + TINY
    assert (read.source, read.track, read.flags) == (state.source, state.track, state.flags)


@given(STATES)
def test_size(state: TeamState) -> None:
    """A team state never has another size than 15 bytes."""
    assert len(pack(state)) == 15


@given(STATES)
def test_sigma(state: TeamState) -> None:
    """A mate is never told a smaller sigma than the sender's own, nor one above √2 times it."""
    told = unpack(pack(state), state.t_s).sigma_m
    assert state.sigma_m * (1 - 1e-9) <= told <= max(0.1, state.sigma_m * math.sqrt(2)) * (1 + 1e-9)


@given(STATES)
def test_second_time_is_exact(state: TeamState) -> None:
    """What was once read packs to the same bytes: a state does not wander from hop to hop."""
    payload = pack(state)
    assert pack(unpack(payload, state.t_s)) == payload


@given(st.binary(max_size=40) | st.binary(min_size=15, max_size=15), st.floats(-1e4, 1e7))
@example(b"\x1f" + b"\xff" * 14, 0.0)
def test_any_bytes(payload: bytes, now_s: float) -> None:
    """Any bytes are read as finite numbers within their ranges, or refused as a `WireError`."""
    try:
        state = unpack(payload, now_s)
    except WireError:
        assert len(payload) != 15 or payload[0] >> 4 != 1
        return
    assert len(payload) == 15
    assert abs(state.t_s - now_s) <= 1638.4 + 0.05
    assert max(abs(state.north_m), abs(state.east_m)) <= 8192.0
    assert 0.0 <= state.theta <= 1.0
    assert 0.0 <= state.heading_rad < 2 * math.pi
