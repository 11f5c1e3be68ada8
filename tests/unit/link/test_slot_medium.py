"""The paper's channel: ten seconds a message, one speaker at a time, every mate hears it or loses it."""

import math
from collections import Counter

import pytest
from slot_water import SlotWater

from grex_link.messages import LinkEvent, Received, Transmit, TxEvent
from grex_link.profile import ModemProfile
from grex_link.units import NS

TEAM = ["auv1", "auv2", "auv3"]
FOREVER = 10**18


def water(loss: float = 0.0, seed: int = 1) -> SlotWater:
    return SlotWater(TEAM, loss, seed)


def send(medium: SlotWater, source: str, t_s: float, seq: int = 0, size: int = 15) -> None:
    medium.transmit(source, Transmit(seq, round(t_s * NS), bytes(size)))


def outcomes(medium: SlotWater) -> list[tuple[str, str, int, str]]:
    return [(line.kind, line.source, line.seq, line.destination) for line in medium.log(FOREVER)]


def test_delivery_at_the_end_of_the_slot() -> None:
    """A message sent at 12 s is with every mate at 22 s, and never with its sender."""
    medium = water()
    medium.transmit("auv2", Transmit(7, 12 * NS, b"fifteen bytes.."))
    heard = Received("auv2", b"fifteen bytes..")
    expected = [(22 * NS, "auv1", heard), (22 * NS, "auv2", TxEvent(7, "SENT")), (22 * NS, "auv3", heard)]
    assert medium.events(FOREVER) == expected


def test_log_of_a_delivery() -> None:
    """The log tells when a transmission started, and its outcome at each receiver."""
    medium = water()
    send(medium, "auv1", 12.0, seq=4)
    assert medium.log(FOREVER) == [
        LinkEvent(12 * NS, "started", "auv1", 4, "", 15, lasting_ns=10 * NS),
        LinkEvent(22 * NS, "delivered", "auv1", 4, "auv2", 15, lasting_ns=10 * NS),
        LinkEvent(22 * NS, "delivered", "auv1", 4, "auv3", 15, lasting_ns=10 * NS),
    ]


def test_events_before_a_time() -> None:
    """Events are taken strictly before a time, and each once."""
    medium = water()
    send(medium, "auv1", 12.0)
    assert medium.events(22 * NS) == []
    assert len(medium.events(22 * NS + 1)) == 3
    assert medium.events(FOREVER) == []


def test_log_before_a_time() -> None:
    """Log lines are taken strictly before a time, and each once."""
    medium = water()
    send(medium, "auv1", 12.0)
    assert medium.log(12 * NS) == []
    assert [line.kind for line in medium.log(22 * NS)] == ["started"]
    assert [line.kind for line in medium.log(FOREVER)] == ["delivered"] * 2
    assert medium.log(FOREVER) == []


def test_next_event() -> None:
    """The time of the next event is known, and that there is none."""
    medium = water()
    assert medium.next_event_ns() is None
    send(medium, "auv1", 12.0)
    send(medium, "auv2", 22.0)
    assert medium.next_event_ns() == 12 * NS
    medium.advance(22 * NS)
    assert medium.next_event_ns() == 22 * NS
    medium.events(22 * NS + 1)
    assert medium.next_event_ns() == 32 * NS
    medium.events(FOREVER)
    assert medium.next_event_ns() is None


def test_busy_water() -> None:
    """Who begins while another is on the air is refused, is told so, and is heard by nobody."""
    medium = water()
    send(medium, "auv1", 12.0)
    send(medium, "auv2", 21.999999999, seq=3)
    events = medium.events(FOREVER)
    assert events[-1] == (31_999_999_999, "auv2", TxEvent(3, "FAILED", "busy"))
    assert [event.source for _, _, event in events if isinstance(event, Received)] == ["auv1", "auv1"]
    refused = [line for line in medium.log(FOREVER) if line.kind == "refused"]
    assert refused == [LinkEvent(21_999_999_999, "refused", "auv2", 3, "", 15, "busy")]


def test_water_free_again() -> None:
    """At the nanosecond at which one message ends the next may begin."""
    medium = water()
    send(medium, "auv1", 12.0)
    send(medium, "auv2", 22.0)
    assert Counter(kind for kind, *_ in outcomes(medium)) == {"started": 2, "delivered": 4}


def test_refusal_does_not_occupy_the_water() -> None:
    """A refused transmission keeps nobody else from speaking."""
    medium = water()
    send(medium, "auv1", 12.0)
    send(medium, "auv2", 21.0)
    send(medium, "auv3", 22.0)
    assert ("started", "auv3", 0, "") in outcomes(medium)


@pytest.mark.parametrize(("size", "kind"), [(0, "started"), (32, "started"), (33, "refused")])
def test_size(size: int, kind: str) -> None:
    """A payload of 32 bytes goes out, one of 33 is refused and leaves the water free."""
    medium = water()
    send(medium, "auv1", 12.0, size=size)
    first = medium.log(12 * NS + 1)[0]
    assert (first.kind, first.size_bytes, first.reason) == (kind, size, "size" if kind == "refused" else "")
    send(medium, "auv2", 12.0)
    assert ("started", "auv2", 0, "") in outcomes(medium) or kind == "started"


def test_sent_says_nothing_of_the_receivers() -> None:
    """A sender whose message nobody gets is told SENT like any other: a broadcast has no acknowledgement."""
    medium = water(loss=1.0)
    send(medium, "auv1", 12.0)
    assert medium.events(FOREVER) == [(22 * NS, "auv1", TxEvent(0, "SENT"))]
    assert [(line.kind, line.reason) for line in medium.log(FOREVER)[1:]] == [("lost", "lost_noise")] * 2


def run(loss: float, seed: int, messages: int) -> list[LinkEvent]:
    medium = water(loss, seed)
    for number in range(messages):
        send(medium, TEAM[number % 3], 10.0 * number, seq=number // 3)
    return [line for line in medium.log(FOREVER) if line.kind in {"delivered", "lost"}]


@pytest.mark.parametrize("loss", [0.01, 0.2, 0.5, 0.9])
def test_share_of_losses(loss: float) -> None:
    """Of 20 000 receptions the asked share is lost, within four standard deviations, on every single link."""
    lines = run(loss, seed=1, messages=10_000)
    assert len(lines) == 20_000
    links: dict[tuple[str, str], list[bool]] = {}
    for line in lines:
        links.setdefault((line.source, line.destination), []).append(line.kind == "lost")
    assert len(links) == 6
    for losses in [[line.kind == "lost" for line in lines], *links.values()]:
        assert abs(sum(losses) / len(losses) - loss) < 4 * math.sqrt(loss * (1 - loss) / len(losses))


def assert_chance(ones: list[LinkEvent], others: list[LinkEvent]) -> None:
    both = sum(one.kind == other.kind == "lost" for one, other in zip(ones, others, strict=True))
    assert abs(both / len(ones) - 0.25) < 4 * math.sqrt(0.25 * 0.75 / len(ones))


def test_receivers_lose_independently() -> None:
    """Two receivers lose the same message as often as chance has it."""
    lines = run(0.5, seed=2, messages=10_000)
    assert_chance(lines[::2], lines[1::2])


def test_senders_lose_independently() -> None:
    """A receiver loses equal numbers of two senders together as often as chance has it."""
    at_auv3 = [line for line in run(0.5, seed=3, messages=10_000) if line.destination == "auv3"]
    of_auv1, of_auv2 = ([line for line in at_auv3 if line.source == source] for source in ("auv1", "auv2"))
    assert_chance(of_auv1[:3000], of_auv2[:3000])


@pytest.mark.parametrize(("loss", "kind"), [(0.0, "delivered"), (1.0, "lost")])
def test_certain_fates(loss: float, kind: str) -> None:
    """With loss 0 everything arrives, with loss 1 nothing."""
    assert {line.kind for line in run(loss, seed=1, messages=1000)} == {kind}


def test_same_seed_same_log() -> None:
    """The same seed gives the same log, another seed another."""
    assert run(0.5, 1, 300) == run(0.5, 1, 300)
    assert run(0.5, 1, 300) != run(0.5, 2, 300)


def test_fate_does_not_depend_on_others() -> None:
    """Whether a message is lost depends on nobody else's traffic."""
    alone, crowded = water(0.5), water(0.5)
    for number in range(100):
        send(crowded, "auv2", 20.0 * number, seq=number)
        send(alone, "auv1", 20.0 * number + 10.0, seq=number)
        send(crowded, "auv1", 20.0 * number + 10.0, seq=number)
    assert [line for line in crowded.log(FOREVER) if line.source == "auv1"] == alone.log(FOREVER)


def test_poses_do_not_matter(truth_at) -> None:
    """In the paper's channel distance plays no part."""
    medium = water(0.5)
    medium.place(truth_at(0))
    send(medium, "auv1", 0.0)
    other = water(0.5)
    send(other, "auv1", 0.0)
    assert medium.log(FOREVER) == other.log(FOREVER)


def test_lookahead() -> None:
    """The medium promises ten seconds in which a transmission causes nothing."""
    assert water().lookahead_ns == 10 * NS


def test_order_at_equal_times() -> None:
    """Events of one time and receiver come in the order of their sources, whatever their airtime."""
    profile = ModemProfile(
        title="a byte a second", payload_max_bytes=64, airtime_fixed_s=1.0, airtime_per_byte_s=1.0,
        one_speaker_at_a_time=True, sources=[], assumed=[],
    )  # fmt: skip
    medium = SlotWater(TEAM, profile=profile)
    send(medium, "auv3", 0.0, size=20)
    send(medium, "auv1", 10.0, size=10)
    at_auv1 = [event for _, craft, event in medium.events(FOREVER) if craft == "auv1"]
    assert at_auv1 == [TxEvent(0, "FAILED", "busy"), Received("auv3", bytes(20))]
