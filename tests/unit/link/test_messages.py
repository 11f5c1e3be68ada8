"""Messages come out of the bus as they went in, and no message that is none gets through."""

import msgspec
import pytest

from grex_link import messages as m

FIX = m.Fix(12, 12_000_000_000, 1.5, -2.5, 3.0, -0.5, 1.0, 0.1, valid=False, modem_events=4)
POSE = m.Pose("auv1", 1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 1.0)
TRUTH = m.Truth(12, 12_000_000_000, [POSE])
STATE = m.AgentState(
    12, 12_000_000_000, 3, 0.25, -0.5, 1.0, 1.1, 0.01, [m.MateBelief("auv2", 1.0, 2.0, 3.5, 0.4, 7.0)], ["stale_fix"], 2
)
LINE = m.LinkEvent(12, "lost", "auv1", 3, "auv2", 15, "loss")

EVERY = [
    FIX,
    m.Setpoint(12, 12_000_000_000, "hold", 0.5, 1.0, 3.0, transmissions=2),
    m.Transmit(3, 12, b"\x00\xff"),
    m.ModemEvent(0, 22, m.Received("auv1", b"\x00\xff")),
    m.ModemEvent(1, 22, m.TxEvent(3, "FAILED", "busy")),
    m.AgentStates([STATE]),
    TRUTH,
    m.Advance([m.Step(TRUTH, [1, 0, 2])]),
    m.LinkReport(12, [[22], [], [22, 32]], [LINE]),
    m.Clock("start", 1_700_000_000_000_000_000),
]


@pytest.mark.parametrize("message", EVERY, ids=lambda message: type(message).__name__)
def test_there_and_back(message: m.Message) -> None:
    """A message comes back equal from MessagePack and from JSON, floats to the last bit."""
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=type(message)) == message
    assert msgspec.json.decode(msgspec.json.encode(message), type=type(message)) == message


@pytest.mark.parametrize("message", EVERY, ids=lambda message: type(message).__name__)
def test_cannot_be_changed(message: m.Message) -> None:
    """A message that several participants share in one process cannot be changed by any."""
    with pytest.raises(AttributeError):
        setattr(message, message.__struct_fields__[0], None)


def test_newer_writer() -> None:
    """A field that this version does not know is skipped."""
    fields = msgspec.to_builtins(FIX) | {"field_of_tomorrow": [1, {"x": 2}]}
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(fields), type=m.Fix) == FIX


@pytest.mark.parametrize(
    ("kind", "wrong"),
    [
        (m.Fix, {"tick": "12"}),
        (m.Fix, {}),
        (m.Setpoint, {"mode": "fly"}),
        (m.Clock, {"phase": "pause"}),
        (m.ModemEvent, {"event": {"type": "range", "m": 3.0}}),
    ],
)
def test_wrong_message(kind: type, wrong: dict) -> None:
    """A message with a missing field, a wrong type or a word nobody knows does not decode."""
    good = next(message for message in EVERY if isinstance(message, kind))
    fields = msgspec.to_builtins(good) | wrong if wrong else {}
    with pytest.raises(msgspec.ValidationError):
        msgspec.msgpack.decode(msgspec.msgpack.encode(fields), type=kind)
