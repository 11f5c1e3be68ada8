"""Properties of the compact payload: whatever is packed comes back, whatever arrives is read or refused."""

import math
import random

import msgspec
from fuzzing import INPUTS, spoiled
from hypothesis import example, given
from hypothesis import strategies as st

from grex_link.errors import WireError
from grex_link.wire import FORMS, Form, TeamState, pack, unpack

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
NOWS = st.floats(-1e4, 1e7)


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


#: How far from the receiver's clock a state's time can be read, seconds.
HALF_RANGE_S = {"full": 1638.4, "short": 1024.0, "tiny": 256.0}


def check_any_bytes(payload: bytes, now_s: float) -> bool:
    """Read a payload or see it refused for a reason; say whether it was read."""
    try:
        state = unpack(payload, now_s)
    except WireError:
        sound = {15: payload[0] >> 4 == 1, 8: True, 5: payload[-1] & 0x3F == 0} if payload else {}
        assert not sound.get(len(payload), False)
        return False
    assert len(payload) == {"full": 15, "short": 8, "tiny": 5}[state.form]
    assert abs(state.t_s - now_s) <= HALF_RANGE_S[state.form] + 0.5
    assert 0 <= state.source <= 15
    assert 0 <= state.track <= 255
    assert 0.0 <= state.theta <= 1.0
    if state.form != "tiny":
        assert max(abs(state.north_m), abs(state.east_m)) <= 8192.0
    if state.form == "full":
        assert 0.0 <= state.heading_rad < 2 * math.pi
    return True


@given(st.binary(max_size=40) | st.sampled_from([5, 8, 15]).flatmap(lambda n: st.binary(min_size=n, max_size=n)), NOWS)
@example(b"\x1f" + b"\xff" * 14, 0.0)
@example(b"\xff" * 8, 0.0)
@example(b"\xff" * 4 + b"\xc0", 0.0)
def test_any_bytes(payload: bytes, now_s: float) -> None:
    """Any bytes are read as numbers within their ranges, or refused as a `WireError`."""
    check_any_bytes(payload, now_s)


@given(STATES, st.sampled_from(["short", "tiny"]), st.floats(-0.99, 0.99))
def test_round_trip_of_less(state: TeamState, form: Form, age: float) -> None:
    """Time, place, track and Θ come back from the smaller forms within half their steps, up to the age each allows."""
    state = msgspec.structs.replace(
        state, flags=state.flags | 1, north_m=state.north_m * 0.999, east_m=state.east_m * 0.999
    )
    half_s = {"short": 1024.0, "tiny": 256.0}[form]
    read = unpack(pack(state, form), state.t_s + age * half_s)
    assert abs(read.t_s - state.t_s) <= 0.25 + TINY
    assert abs(read.theta - state.theta) <= 0.5 / 4095 + TINY
    assert (read.source, read.track, read.form) == (state.source, state.track, form)
    if form == "short":
        assert max(abs(read.north_m - state.north_m), abs(read.east_m - state.east_m)) <= 0.5 + TINY
    assert pack(read, form) == pack(state, form)


def test_fuzz() -> None:
    """Thousands of spoiled states are read within their ranges or refused, and there are many of both."""
    draw = random.Random(5)
    read = 0
    for _ in range(INPUTS):
        state = TeamState(
            draw.randrange(16), draw.uniform(0, 1e5), 1.0, 2.0, 3.0, 1.0, 1.0, draw.randrange(256), 0.5, 1.0
        )
        read += check_any_bytes(spoiled(draw, pack(state, draw.choice(FORMS))), draw.uniform(0, 1e5))
    assert 0.1 * INPUTS < read < 0.9 * INPUTS
