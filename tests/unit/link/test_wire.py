"""The compact payload: every bit where the table says, every value as near as its step allows."""

import math
from contextlib import suppress

import msgspec
import pytest

from grex_link.errors import WireError
from grex_link.wire import NAVIGATION_VALID, TeamState, pack, unpack

STATE = TeamState(
    source=3,
    t_s=100.0,
    north_m=12.5,
    east_m=-25.0,
    depth_m=7.3,
    speed_mps=1.5,
    heading_rad=math.pi / 2,
    track=5,
    theta=819 / 4095,
    sigma_m=0.4,
)

#: Bits and value of each field of STATE, worked out by hand from the table in the module's docstring.
FIELDS = [
    (4, 1),  # type
    (4, 3),  # source
    (16, 2000),  # 100 s in steps of 0.05 s
    (17, 100),  # 12.5 m in steps of 0.125 m
    (17, 2**17 - 200),  # two's complement
    (12, 73),
    (8, 75),
    (9, 128),  # a quarter of 512
    (8, 5),
    (12, 819),
    (5, 4),  # 0.1 m · 2^(4/2)
    (8, 1),
]


def but(**values) -> TeamState:
    return msgspec.structs.replace(STATE, **values)


def back(**values) -> TeamState:
    state = but(**values)
    return unpack(pack(state), state.t_s)


def test_layout() -> None:
    """Fields lie side by side, the first in the highest bits, in exactly 15 bytes."""
    whole = 0
    for bits, value in FIELDS:
        whole = whole << bits | value
    assert sum(bits for bits, _ in FIELDS) == 120
    assert pack(STATE) == whole.to_bytes(15, "big")
    assert pack(STATE).hex() == "1307d000327fce01252d000a666401"


def test_back() -> None:
    """What fits the steps comes back as it was."""
    state = unpack(pack(STATE), now_s=130.0)
    for name in STATE.__struct_fields__:
        assert getattr(state, name) == pytest.approx(getattr(STATE, name), abs=1e-12)


def test_flags() -> None:
    """A state is valid unless it says otherwise; flags keep their eight bits."""
    assert back().flags == NAVIGATION_VALID
    assert back(flags=0).flags == 0
    assert back(flags=0x1A5).flags == 0xA5


@pytest.mark.parametrize(
    ("name", "value", "limit"),
    [
        ("depth_m", -3.0, 0.0),
        ("depth_m", 5000.0, 409.5),
        ("speed_mps", -0.5, 0.0),
        ("speed_mps", 9.0, 5.1),
        ("theta", -0.2, 0.0),
        ("theta", 1.4, 1.0),
        ("sigma_m", 0.0, 0.1),
        ("sigma_m", 1e6, 0.1 * 2**15.5),
    ],
)
def test_limited(name: str, value: float, limit: float) -> None:
    """Depth, speed, Θ and sigma stop at the ends of their range."""
    assert getattr(back(**{name: value}), name) == pytest.approx(limit)


def test_source_wraps() -> None:
    """The place in the team is told modulo 16."""
    assert [back(source=place).source for place in (0, 15, 16, 35)] == [0, 15, 0, 3]


@pytest.mark.parametrize(
    ("heading", "read"),
    [(-math.pi, math.pi), (-math.pi / 2, 1.5 * math.pi), (2 * math.pi - 0.001, 0.0), (7 * math.pi, math.pi)],
)
def test_heading_wraps(heading: float, read: float) -> None:
    """A heading comes back in [0, 2π), whatever turn it was told in."""
    assert back(heading_rad=heading).heading_rad == pytest.approx(read)


@pytest.mark.parametrize("t_s", [0.0, 12.0, 3276.75, 3276.8, 3276.85, 9830.4, 1e6])
@pytest.mark.parametrize("age_s", [-5.0, 0.0, 30.0, 1638.0])
def test_time_is_unwrapped(t_s: float, age_s: float) -> None:
    """The time is the one nearest to the receiver's clock, on both sides of every 3276.8 s."""
    assert unpack(pack(but(t_s=t_s)), now_s=t_s + age_s).t_s == pytest.approx(t_s, abs=0.0251)


def test_time_before_the_mission() -> None:
    """Just after the start, a time just before it is not taken for one 3276.8 s ahead."""
    assert unpack(pack(but(t_s=-0.5)), now_s=1.0).t_s == pytest.approx(-0.5)


def test_older_than_half_the_range() -> None:
    """What is older than 1638.4 s is read as one range younger: the clock cannot know better."""
    assert unpack(pack(but(t_s=100.0)), now_s=1740.0).t_s == pytest.approx(3376.8)


@pytest.mark.parametrize("axis", ["north", "east"])
@pytest.mark.parametrize("metres", [8192.0, -8192.0, 8300.0, 1e9, math.inf, -math.inf, math.nan])
def test_outside_the_frame(axis: str, metres: float) -> None:
    """A position outside ±8192 m, or none at all, is refused by the name of its axis."""
    with pytest.raises(WireError, match=f"^{axis} .* outside the mission frame"):
        pack(but(**{axis + "_m": metres}))


@pytest.mark.parametrize("metres", [8191.875, -8191.875])
def test_edge_of_the_frame(metres: float) -> None:
    """The outermost places of the frame can be told."""
    assert (back(north_m=metres).north_m, back(east_m=metres).east_m) == (metres, metres)


def test_astronomically_far_outside_the_frame() -> None:
    """However far outside a position is, the error is the same."""
    with pytest.raises(WireError):
        pack(but(north_m=1e308))


@pytest.mark.parametrize("name", ["t_s", "depth_m", "speed_mps", "heading_rad", "theta", "sigma_m"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_not_a_number(name: str, value: float) -> None:
    """A value that is no number is limited or refused as a `WireError`; it never ends the agent."""
    with suppress(WireError):
        assert len(pack(but(**{name: value}))) == 15


@pytest.mark.parametrize("track", [256, -1])
def test_track_that_does_not_fit(track: int) -> None:
    """A track number beyond eight bits is refused, not wrapped."""
    with pytest.raises(WireError, match=f"track {track} "):
        pack(but(track=track))


def test_last_track() -> None:
    """Track 255 can be told."""
    assert back(track=255).track == 255


@pytest.mark.parametrize("sigma_m", [0.1, 0.1001, 0.14, 0.15, 0.2, 0.283, 1.0, 31.0, 4634.0])
def test_sigma_is_never_optimistic(sigma_m: float) -> None:
    """The claimed sigma is never less than the real one, and at most √2 times as much."""
    told = back(sigma_m=sigma_m).sigma_m
    assert sigma_m * (1 - 1e-9) <= told <= sigma_m * math.sqrt(2) * (1 + 1e-9)


@pytest.mark.parametrize("size", [0, 1, 14, 16, 32])
def test_wrong_length(size: int) -> None:
    """Anything but 15 bytes is refused, with both lengths."""
    with pytest.raises(WireError, match=f"15 bytes, not {size}$"):
        unpack(b"\x13" * size, now_s=12.0)


@pytest.mark.parametrize("kind", [0, 2, 15])
def test_wrong_type(kind: int) -> None:
    """15 bytes of another type are refused, with the type."""
    payload = bytes([kind << 4 | 3]) + pack(STATE)[1:]
    with pytest.raises(WireError, match=f"type {kind} "):
        unpack(payload, now_s=12.0)
