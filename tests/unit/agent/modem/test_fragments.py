"""Fragments: which frames are some, what they look like, and how payloads come out of them again."""

from itertools import permutations

import pytest

from grex_agent.modem.fragments import (
    DONE_MAX,
    FRAGMENTS_MAX,
    PARTIAL_MAX,
    Reassembly,
    data_bytes,
    is_plain,
    split,
)
from grex_link.units import NS

LONG = bytes(range(100))


def take(reassembly: Reassembly, *frames: bytes, source: str = "auv2", now_s: float = 12.0) -> list[bytes]:
    taken = [reassembly.take(source, frame, round(now_s * NS)) for frame in frames]
    return [payload for payload in taken if payload is not None]


@pytest.mark.parametrize("size", [5, 8, 15])
@pytest.mark.parametrize("first", [0x00, 0x13, 0xF0, 0xFF])
def test_states_are_plain(size: int, first: int) -> None:
    """What has the length of a team state goes as it is, whatever is in it, and comes out at once."""
    payload = bytes([first]) * size
    assert split(payload, 64, 0) == (payload,)
    assert take(Reassembly(120.0), payload, payload) == [payload, payload]


def test_others_are_plain_by_their_first_bits() -> None:
    """A payload of another length goes as it is unless it begins with 4 ones."""
    assert split(b"\xef" * 20, 64, 0) == (b"\xef" * 20,)
    assert is_plain(b"")
    frames = split(b"\xf0" * 20, 64, 0)
    assert [len(frame) for frame in frames] == [24]
    assert take(Reassembly(120.0), *frames) == [b"\xf0" * 20]


def test_layout() -> None:
    """The header is 15, pad, index, last, message and check side by side, before the data."""
    first, second = split(LONG, 64, 300)
    crc = 0xF5  # of bytes 0 … 99, see test_check
    assert first[:4] == (15 << 28 | 0 << 27 | 0 << 22 | 1 << 17 | 300 << 8 | crc).to_bytes(4, "big")
    assert second[:4] == (15 << 28 | 0 << 27 | 1 << 22 | 1 << 17 | 300 << 8 | crc).to_bytes(4, "big")
    assert first[4:] + second[4:] == LONG
    assert (len(first), len(second)) == (64, 44)


def test_check() -> None:
    """The check is CRC-32 (polynomial 0xEDB88320, reflected), bit by bit, its lowest 8 bits."""
    crc = 0xFFFFFFFF
    for byte in LONG:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    assert (crc ^ 0xFFFFFFFF) & 0xFF == split(LONG, 64, 0)[0][3]


@pytest.mark.parametrize("frame_max_bytes", [6, 7, 8, 9, 15, 16, 17, 31, 32, 64])
def test_no_fragment_looks_like_a_state(frame_max_bytes: int) -> None:
    """No fragment has 15, 8 or 5 bytes or more than fit, none is needless, and all payloads come back."""
    most = data_bytes(frame_max_bytes)
    for size in range(1, most * FRAGMENTS_MAX + 1):
        payload = b"\xf5" * size
        frames = split(payload, frame_max_bytes, 7)
        if size in {5, 8, 15} and size <= frame_max_bytes:
            assert frames == (payload,)
            continue
        assert len(frames) == -(-size // most)
        assert all(len(frame) <= frame_max_bytes and len(frame) not in {5, 8, 15} for frame in frames)
        assert take(Reassembly(120.0), *reversed(frames)) == [payload]


@pytest.mark.parametrize(("frame_max_bytes", "most"), [(0, 0), (4, 0), (5, 0), (6, 2), (8, 3), (15, 10), (64, 60)])
def test_what_cannot_be_carried(frame_max_bytes: int, most: int) -> None:
    """More than 32 fragments, or frames that have no room beside the header, carry nothing."""
    assert data_bytes(frame_max_bytes) == most
    assert split(b"\x00" * (most * 32 + 1 + (most == 0) * 60), frame_max_bytes, 0) == ()


def test_any_order_and_duplicates() -> None:
    """A payload comes out once, with the last of its fragments, in whatever order and how often these come."""
    frames = split(LONG, 32, 1)
    assert len(frames) == 4
    for order in permutations(frames):
        reassembly = Reassembly(120.0)
        assert take(reassembly, *order[:-1], *order[:-1]) == []
        assert take(reassembly, order[-1]) == [LONG]
        assert take(reassembly, *order, *order) == []
        assert (reassembly.reassembled, reassembly.abandoned, reassembly.bad) == (1, 0, 0)


def test_interleaved() -> None:
    """Payloads of several sources, and of one source with several numbers, do not get mixed."""
    reassembly = Reassembly(120.0)
    one, two = split(LONG, 32, 1), split(LONG[::-1], 32, 2)
    out = []
    for first, second in zip(one, two, strict=True):
        out += take(reassembly, first, second) + take(reassembly, second, source="auv3")
    assert out == [LONG, LONG[::-1], LONG[::-1]]


def test_number_used_again() -> None:
    """A sender that begins anew with the same number is not mixed with what it had sent before."""
    reassembly = Reassembly(120.0)
    old, new = split(LONG, 32, 0), split(LONG[::-1], 32, 0)
    assert take(reassembly, *old[:2]) == []
    assert take(reassembly, *new) == [LONG[::-1]]


def test_timeout() -> None:
    """What is incomplete is given up when no new fragment has come for the timeout, not when the first is as old."""
    reassembly = Reassembly(120.0)
    frames = split(LONG, 32, 1)
    take(reassembly, frames[0], now_s=0.0)
    assert reassembly.until_ns == 120 * NS
    take(reassembly, frames[1], now_s=100.0)
    take(reassembly, frames[1], now_s=150.0)
    reassembly.expire(219 * NS)
    assert reassembly.abandoned == 0
    reassembly.expire(220 * NS)
    assert (reassembly.abandoned, reassembly.until_ns) == (1, None)
    assert take(reassembly, *frames[2:], now_s=221.0) == []


def test_too_late_by_itself() -> None:
    """A fragment that comes after the timeout completes nothing, even if nobody looked in between."""
    reassembly = Reassembly(120.0)
    frames = split(LONG, 64, 1)
    take(reassembly, frames[0], now_s=0.0)
    assert take(reassembly, frames[1], now_s=120.0) == []
    assert reassembly.abandoned == 1


def test_memory_is_bounded() -> None:
    """However many payloads stay incomplete or come out, a bounded number is kept; the rest is counted."""
    reassembly = Reassembly(1e6)
    for number in range(500):
        take(reassembly, split(LONG, 64, number)[0], source=f"auv{number}", now_s=number)
    assert len(reassembly._partial) == PARTIAL_MAX
    assert reassembly.abandoned == 500 - PARTIAL_MAX
    for number in range(500):
        take(reassembly, *split(LONG, 64, number), source="auv2", now_s=1000.0)
    assert len(reassembly._done) == DONE_MAX


def spoiled_header(**bits: int) -> bytes:
    """A fragment of 20 bytes of data with a header of one's own."""
    value = {"pad": 0, "index": 0, "last": 0, "check": 0} | bits
    header = 15 << 28 | value["pad"] << 27 | value["index"] << 22 | value["last"] << 17 | value["check"]
    return header.to_bytes(4, "big") + bytes(20)


@pytest.mark.parametrize(
    "frame",
    [
        b"\xf0",
        b"\xf0\x00\x00\x00",  # no data
        b"\xf8\x00\x00\x00\x00\x00",  # padded without need
        b"\xff\xff\xff\xff\xff\xff",
        spoiled_header(index=2, last=1),
        spoiled_header(pad=1),
        spoiled_header(check=0x5A),  # not that of the data
    ],
)
def test_no_fragment_of_ours(frame: bytes) -> None:
    """What begins like a fragment and is none, or does not fit its check, is counted and gives nothing."""
    reassembly = Reassembly(120.0)
    assert take(reassembly, frame) == []
    assert (reassembly.bad, reassembly.reassembled, reassembly.until_ns) == (1, 0, None)


def test_pad_must_be_zero() -> None:
    """The byte that pads a fragment is zero, or it is no fragment."""
    (frame,) = split(b"\xf0", 64, 0)  # 4 + 1 bytes would be a tiny state
    assert len(frame) == 6
    assert take(Reassembly(120.0), frame) == [b"\xf0"]
    assert take(Reassembly(120.0), frame[:4] + b"\x01" + frame[5:]) == []
