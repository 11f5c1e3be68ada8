"""Any order and any echo comes back as it was, to half a step; anything else is refused, not misread."""

from hypothesis import given
from hypothesis import strategies as st

from grex_link.errors import WireError
from grex_link.task_wire import REASONS, STATUSES, Echo, Order, pack_echo, pack_order, unpack_echo, unpack_order
from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface

COORDINATE = st.floats(-8191.0, 8191.0)
PLACE = st.tuples(COORDINATE, COORDINATE, st.floats(0.0, 409.0))
SPEED = st.floats(0.05, 6.3)
LASTING = st.floats(0.0, 4090.0)
THEN = st.sampled_from(["return", "surface", "hold"])
SHAPE = st.sampled_from(["circle", "box"])
TASKS = st.one_of(
    st.builds(GoTo, PLACE, SPEED),
    st.builds(Follow, st.integers(0, 255), SPEED),
    st.builds(Hold, LASTING),
    st.builds(Inspect, PLACE, st.floats(1.0, 4090.0), st.floats(0.5, 127.0), SHAPE, SPEED, THEN),
    st.builds(Surface, LASTING, SPEED),
    st.builds(Return, SPEED),
)


@given(st.integers(0, 15), st.integers(0, 255), TASKS)
def test_round_trip(to, number, task):
    """An order is read as it was packed, each value to half its step, and is then packed to the same bytes."""
    payload = pack_order(Order(to, number, task))
    read = unpack_order(payload)
    assert (read.to, read.number, type(read.task)) == (to, number, type(task))
    assert pack_order(read) == payload
    steps = {"speed_mps": 0.025, "for_s": 4.0, "radius_m": 0.25}
    for field in task.__struct_fields__:
        was, came = getattr(task, field), getattr(read.task, field)
        if field == "at_ned_m":
            assert all(abs(a - b) <= half + 1e-9 for a, b, half in zip(was, came, (0.0625, 0.0625, 0.05), strict=True))
        elif field in steps:
            assert abs(was - came) <= steps[field] + 1e-9
        else:
            assert was == came
    if hasattr(task, "for_s"):
        assert bool(task.for_s) == bool(read.task.for_s)


@given(st.integers(0, 15), st.integers(0, 255), st.integers(0, 2**24 - 1), st.sampled_from(STATUSES),
       st.sampled_from(REASONS))  # fmt: skip
def test_echo_round_trip(to, number, its_hash, status, reason):
    """An echo is read as it was packed."""
    echo = Echo(to, number, its_hash, status, reason)
    assert unpack_echo(pack_echo(echo)) == echo


MAIL = st.one_of(
    st.binary(max_size=20),
    st.binary(min_size=11, max_size=11).map(lambda rest: b"\x30" + rest),
    st.binary(min_size=5, max_size=5).map(lambda rest: b"\x40" + rest),
)


@given(MAIL)
def test_any_bytes_are_read_or_refused(payload):
    """Bytes are an order that packs to the same bytes, or are refused; the same with echoes."""
    for unpack, pack in ((unpack_order, pack_order), (unpack_echo, pack_echo)):
        try:
            read = unpack(payload)
        except WireError:
            continue
        assert pack(read) == payload
