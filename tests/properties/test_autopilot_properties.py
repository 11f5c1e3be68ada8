"""Nothing that comes over a link ends a simulated autopilot."""

import math

import pytest
from autopilots import START
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as dialect

from grex_sim.autopilot.brain import Settings
from grex_sim.autopilot.codec import Codec
from grex_sim.autopilot.commands import _HANDLERS as COMMANDS
from grex_sim.autopilot.core import Autopilot
from grex_sim.autopilot.family import load_family
from grex_sim.autopilot.framing import Framer
from grex_sim.autopilot.hearing import _HANDLERS as HEARD
from grex_sim.autopilot.message import Message

KINDS = {kind.msgname: kind for kind in dialect.mavlink_map.values()}
BITS = {"int8_t": 8, "int16_t": 16, "int32_t": 32, "int64_t": 64}
NAMES = (
    "WP_SPEED",
    "SYSID_MYGCS",
    "COM_OF_LOSS_T",
    "RO_SPEED_LIM",
    "GREX_LOSS",
    "GREX_JUMP",
    "GREX_PILOT",
    "GREX_LATE",
)
FLOATS = st.floats(width=32) | st.sampled_from([0.0, 1.0, 2.0, 4.0, 33.0, math.nan, math.inf, -1.0, 3e38])


def value(kind: str, length: int):
    if kind == "char":
        return st.sampled_from(NAMES)
    one = FLOATS
    if kind.removeprefix("u") in BITS:
        bits = BITS[kind.removeprefix("u")]
        least, most = (0, 2**bits - 1) if kind.startswith("u") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        one = st.integers(least, most) | st.integers(0, min(most, 20))
    return st.lists(one, min_size=length, max_size=length) if length else one


@st.composite
def messages(draw):
    name = draw(st.sampled_from(sorted(HEARD)))
    kind = KINDS[name]
    lengths = dict(zip(kind.ordered_fieldnames, kind.array_lengths, strict=True))
    fields = {n: draw(value(t, lengths[n])) for n, t in zip(kind.fieldnames, kind.fieldtypes, strict=True)}
    for target in {"target_system", "target"} & set(fields):
        fields[target] = draw(st.sampled_from([0, 1]))
    if "command" in fields:
        fields["command"] = draw(st.sampled_from(sorted(COMMANDS)))
    if "coordinate_frame" in fields:
        fields["coordinate_frame"] = draw(st.sampled_from([1, 6, 7, 8, 9]))
    return Message(name, fields, 255, 190)


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
@given(several=st.lists(messages(), max_size=6), silent=st.booleans())
def test_no_message_ends_it(family, several, silent):
    """Whatever the fields of the messages it knows, it goes on, and what it says can be packed."""
    pilot = Autopilot(Settings(family=load_family(family), place=START, ready_s=0.2, epoch_unix_s=1.8e9))
    codec = Codec(1)
    now = 0.3
    for message in several:
        pilot.heard(message, 0, now)
        now += 0.2 if silent else 0.04
        for out in pilot.step(now):
            assert isinstance(out.message, bytes) or codec.pack(out.message)
    for out in pilot.step(now + 0.3):
        assert isinstance(out.message, bytes) or codec.pack(out.message)


@given(noise=st.lists(st.binary(max_size=60), max_size=4), cut=st.integers(1, 40))
def test_garbage_never_costs_the_messages_after_it(noise, cut):
    """Whatever bytes come between them and however all is cut, enough messages later one is read again."""
    beat = Codec(1).pack(Message("ATTITUDE", {"yaw": 1.0}))
    data = b"".join(piece + beat for piece in noise) + beat * 20
    reader = Codec(2)
    read = [m.name for start in range(0, len(data), cut) for m in reader.read(data[start : start + cut])]
    assert set(read) == {"ATTITUDE"}
    assert len(read) >= 8


@given(data=st.binary(max_size=600))
def test_every_byte_is_counted(data):
    """A framer that accepts nothing drops every byte but those that may still become a frame."""
    framer = Framer()
    assert list(framer.cut(data, lambda _: None)) == []
    framer.end()
    assert framer.dropped == len(data)
