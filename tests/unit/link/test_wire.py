"""The compact payload: every bit where the table says, every value as near as its step allows."""

import math
from contextlib import suppress

import msgspec
import pytest

from grex_link.errors import WireError
from grex_link.wire import BITS, BYTES, FORMS, NAVIGATION_VALID, TEAM_STATE_BYTES, TeamState, choose_form, pack, unpack

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


@pytest.mark.parametrize("size", [0, 1, 4, 6, 7, 9, 14, 16, 32])
def test_wrong_length(size: int) -> None:
    """Anything but 15, 8 or 5 bytes is refused, with all the lengths."""
    with pytest.raises(WireError, match=f"15, 8 or 5 bytes, not {size}$"):
        unpack(b"\x13" * size, now_s=12.0)


@pytest.mark.parametrize("kind", [0, 2, 15])
def test_wrong_type(kind: int) -> None:
    """15 bytes of another type are refused, with the type."""
    payload = bytes([kind << 4 | 3]) + pack(STATE)[1:]
    with pytest.raises(WireError, match=f"type {kind} "):
        unpack(payload, now_s=12.0)


# -- short and tiny ----------------------------------------------------------------------------------------------

#: Bits and values of STATE in the short form, by hand: time in steps of 0.5 s, places in steps of 1 m.
SHORT_FIELDS = [(4, 3), (12, 200), (14, 12), (14, 2**14 - 25), (8, 5), (12, 819)]
TINY_FIELDS = [(4, 3), (10, 200), (8, 5), (12, 819), (6, 0)]


def side_by_side(fields: list[tuple[int, int]]) -> bytes:
    whole = 0
    for bits, value in fields:
        whole = whole << bits | value
    return whole.to_bytes(sum(bits for bits, _ in fields) // 8, "big")


def test_short_layout() -> None:
    """The short form's fields lie side by side in exactly 8 bytes."""
    assert pack(STATE, "short") == side_by_side(SHORT_FIELDS)
    assert pack(STATE, "short").hex() == "30c80033fe705333"


def test_tiny_layout() -> None:
    """The tiny form's 34 bits lie side by side, and 6 zeros fill them up to 5 bytes."""
    assert pack(STATE, "tiny") == side_by_side(TINY_FIELDS)
    assert pack(STATE, "tiny").hex() == "332014ccc0"


def test_sizes() -> None:
    """Forms have 120, 64 and 34 bits, in as many bytes as hold them."""
    assert BITS == {"full": 120, "short": 64, "tiny": 34}
    assert {form: len(pack(STATE, form)) for form in FORMS} == BYTES == {form: -(-BITS[form] // 8) for form in FORMS}
    assert TEAM_STATE_BYTES == 15


def test_form_is_known_by_length() -> None:
    """What is read says which form it came in; the full form is what nobody has to ask for."""
    assert [unpack(pack(STATE, form), 100.0).form for form in FORMS] == list(FORMS)
    assert pack(STATE) == pack(STATE, "full")


@pytest.mark.parametrize(
    ("form", "not_told"),
    [
        ("full", set()),
        ("short", {"depth_m", "speed_mps", "heading_rad", "sigma_m"}),
        ("tiny", {"north_m", "east_m", "depth_m", "speed_mps", "heading_rad", "sigma_m"}),
    ],
)
def test_what_a_form_does_not_tell(form, not_told: set[str]) -> None:
    """What a form does not carry is NaN, never a number that could be taken for one; all else is there."""
    read = unpack(pack(STATE, form), 100.0)
    numbers = {name: getattr(read, name) for name in STATE.__struct_fields__ if name != "form"}
    assert {name for name, value in numbers.items() if math.isnan(value)} == not_told
    assert (read.source, read.t_s, read.track, read.flags) == (3, 100.0, 5, NAVIGATION_VALID)
    assert read.theta == pytest.approx(819 / 4095)


def test_short_position() -> None:
    """The short form tells places to the nearest metre."""
    read = unpack(pack(but(north_m=-8191.4, east_m=100.6), "short"), 100.0)
    assert (read.north_m, read.east_m) == (-8191.0, 101.0)


@pytest.mark.parametrize("metres", [8191.5, -8191.5, math.nan, math.inf])
def test_outside_the_frame_of_the_short_form(metres: float) -> None:
    """What does not fit into the short form's frame is refused; the tiny form tells no place and does not mind."""
    with pytest.raises(WireError, match=r"^east .* outside the mission frame"):
        pack(but(east_m=metres), "short")
    assert len(pack(but(east_m=metres), "tiny")) == 5


@pytest.mark.parametrize(("form", "half_s"), [("short", 1024.0), ("tiny", 256.0)])
@pytest.mark.parametrize("t_s", [0.0, 511.5, 512.0, 2047.5, 2048.0, 1e6])
def test_short_times_are_unwrapped(form, half_s: float, t_s: float) -> None:
    """Of the times that fit, that nearest to the receiver's clock is read, up to half the range away."""
    for age_s in (-half_s / 2, 0.0, 30.0, half_s - 1.0):
        assert unpack(pack(but(t_s=t_s), form), t_s + age_s).t_s == pytest.approx(t_s, abs=0.2501)
    assert unpack(pack(but(t_s=t_s), form), t_s + half_s + 1.0).t_s == pytest.approx(t_s + 2 * half_s, abs=0.2501)


@pytest.mark.parametrize("bit", range(6))
def test_padding_of_the_tiny_form(bit: int) -> None:
    """5 bytes whose last 6 bits are not zero are no tiny state."""
    payload = bytearray(pack(STATE, "tiny"))
    payload[-1] |= 1 << bit
    with pytest.raises(WireError, match="6 zeros, not"):
        unpack(bytes(payload), 100.0)


@pytest.mark.parametrize("form", ["short", "tiny"])
def test_invalid_navigation_needs_flags(form) -> None:
    """A form without flags does not tell a state whose navigation is not valid: it would be read as valid."""
    with pytest.raises(WireError, match=f"{form} .* not valid"):
        pack(but(flags=0), form)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "fault", [{"track": 256}, {"track": -1}, {"t_s": math.nan}, {"theta": math.inf}, {"t_s": math.inf}]
)
def test_no_form_tells_nonsense(form, fault) -> None:
    """A track that does not fit, and a time or Θ that is no number, are refused in every form."""
    with pytest.raises(WireError):
        pack(but(**fault), form)


@pytest.mark.parametrize(
    ("bits_max", "wanted", "form"),
    [
        (120, "auto", "full"), (64, "auto", "short"), (63, "auto", "tiny"), (34, "auto", "tiny"),
        (119, "auto", "short"), (512, "tiny", "tiny"), (512, "short", "short"), (120, "full", "full"),
    ],
)  # fmt: skip
def test_choose_form(bits_max: int, wanted: str, form: str) -> None:
    """The fullest form that the modem carries is chosen, unless another is wanted."""
    assert choose_form(bits_max, wanted) == form


@pytest.mark.parametrize(
    ("bits_max", "wanted", "said"),
    [
        (33, "auto", "tiny team state has 34 bits and the modem carries 33"),
        (64, "full", "full team state has 120 bits"),
        (34, "short", "short team state has 64 bits"),
        (512, "huge", "there is no form 'huge'"),
    ],
)
def test_no_form_fits(bits_max: int, wanted: str, said: str) -> None:
    """A form that does not fit is refused with both numbers, one that is not there with those that are."""
    with pytest.raises(WireError, match=said):
        choose_form(bits_max, wanted)
