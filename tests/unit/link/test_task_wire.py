"""Orders in 12 bytes and echoes in 6: literal bytes, limits, and what is refused."""

import pytest

from grex_link import wire
from grex_link.errors import WireError
from grex_link.task_wire import (
    ECHO_BYTES,
    KINDS,
    ORDER_BYTES,
    REASONS,
    STATUSES,
    Echo,
    Order,
    hash_of,
    is_order,
    is_task_mail,
    pack_echo,
    pack_order,
    unpack_echo,
    unpack_order,
)
from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface, Task, type_of

INSPECT = Inspect((180.0, -40.0, 12.0), 120.0, 12.0, "box", 1.0, "surface")


def test_an_order_on_the_air():
    """An order has these 12 bytes: type 3, to, number, kind, then, shape, place, depth, duration, radius, speed."""
    payload = pack_order(Order(3, 7, INSPECT))
    fields = [
        (3, 4), (3, 4), (7, 8), (3, 3), (1, 2), (1, 1), (1440, 17), (-320, 17), (120, 12), (30, 10), (24, 8), (20, 7),
        (0, 3),
    ]  # fmt: skip
    bits = "".join(format(value % (1 << width), f"0{width}b") for value, width in fields)
    assert payload == int(bits, 2).to_bytes(12, "big")
    assert unpack_order(payload) == Order(3, 7, INSPECT)


def test_an_echo_on_the_air():
    """An echo has these 6 bytes: type 4, to, number, 24 bits of hash, status, reason."""
    payload = pack_echo(Echo(2, 200, 0xABCDEF, "refused", "depth"))
    assert payload == bytes([0x42, 200, 0xAB, 0xCD, 0xEF, 0x13])
    assert unpack_echo(payload) == Echo(2, 200, 0xABCDEF, "refused", "depth")


@pytest.mark.parametrize(
    "task",
    [GoTo((1.0, -2.0, 3.0), 0.5), Follow(255, 1.5), Hold(0.0), Hold(40.0), Surface(8.0, 2.0), Return(1.0), INSPECT],
    ids=type_of,
)
def test_every_kind_of_task_travels(task: Task):
    """What is told in whole steps comes as it was told."""
    assert unpack_order(pack_order(Order(0, 0, task))).task == task


def test_kinds_and_words_have_room():
    """All kinds of task have a number, all statuses and reasons have room."""
    assert set(KINDS) == set(Task.__args__)
    assert len(KINDS) <= 8
    assert max(len(STATUSES), len(REASONS)) <= 16


def test_no_length_is_that_of_a_team_state():
    """Neither can be taken for a team state, nor a team state for one of them."""
    assert not {ORDER_BYTES, ECHO_BYTES} & set(wire.BYTES.values())
    assert not any(is_task_mail(bytes([0x30] + [0] * (size - 1))) for size in wire.BYTES.values())
    assert is_task_mail(pack_order(Order(0, 0, Return())))
    assert is_order(pack_order(Order(0, 0, Return())))
    echo = pack_echo(Echo(0, 0, 0, "done"))
    assert is_task_mail(echo)
    assert not is_order(echo)
    assert not is_task_mail(b"")


@pytest.mark.parametrize(
    ("task", "word"),
    [
        (GoTo((9000.0, 0.0, 0.0)), "north"),
        (GoTo((0.0, -8200.0, 0.0)), "east"),
        (GoTo((0.0, 0.0, -1.0)), "depth"),
        (GoTo((0.0, 0.0, 410.0)), "depth"),
        (GoTo((float("nan"), 0.0, 0.0)), "north"),
        (Hold(5000.0), "duration"),
        (Return(7.0), "speed"),
        (Inspect((0.0, 0.0, 0.0), radius_m=200.0), "radius"),
    ],
)
def test_what_does_not_fit_is_refused(task: Task, word: str):
    """A task that would come as another one is not sent: one line says which value is wrong and what would do."""
    with pytest.raises(WireError, match=word):
        pack_order(Order(0, 0, task))


def test_a_short_time_is_not_made_endless():
    """A hold of a second is rounded up to a step, because none would be for ever."""
    assert unpack_order(pack_order(Order(0, 0, Hold(1.0)))).task == Hold(4.0)


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        bytes(11),
        bytes(12),
        bytes([0x30, 0, 7 << 5, *[0] * 9]),
        pack_order(Order(0, 0, INSPECT))[:-1] + b"\xff",
        bytes([0x40, 0, 0, 0, 0, 0]),
    ],
    ids=["empty", "short", "type", "kind", "zeros", "echo"],
)
def test_what_is_no_order_is_refused(payload: bytes):
    """Other lengths, types, kinds and padding are no orders."""
    with pytest.raises(WireError):
        unpack_order(payload)


@pytest.mark.parametrize("payload", [bytes(6), bytes([0x40, 0, 0, 0, 0, 0xF0]), bytes([0x40, 0, 0, 0, 0, 0x0F]), b""])
def test_what_is_no_echo_is_refused(payload: bytes):
    """Other lengths, types, statuses and reasons are no echoes."""
    with pytest.raises(WireError):
        unpack_echo(payload)


def test_the_hash_is_of_every_byte():
    """An order that differs in any byte has another hash."""
    payload = pack_order(Order(1, 2, INSPECT))
    others = {hash_of(payload[:n] + bytes([payload[n] ^ 1]) + payload[n + 1 :]) for n in range(len(payload))}
    assert hash_of(payload) not in others
    assert len(others) == len(payload)
