"""The port: what is asked of it, what goes to the modem and when, and how every ticket ends."""

from collections.abc import Callable

import msgspec
import pytest

from grex_agent.modem.flights import ANSWER_NS, REBOOT_NS
from grex_agent.modem.port import ModemPort
from grex_link.messages import (
    BadFrame,
    Happening,
    ModemEvent,
    ModemStatus,
    RangeRequest,
    RangeResult,
    Received,
    Request,
    Transmit,
    TxEvent,
)
from grex_link.profile import ModemProfile, load_profile
from grex_link.tdma import Schedule, Slot
from grex_link.units import NS

TEAM = ["auv1", "auv2", "auv3"]
STATE = b"\x10" + bytes(14)
S2C = load_profile("s2c_im")


def slots(messages: int = 1, message_bytes: int = 64) -> Schedule:
    """auv1 has the first second of every ten."""
    return Schedule((Slot("auv1", 0, NS), Slot("auv2", 3 * NS, NS)), 10 * NS, messages, message_bytes)


def make(profile: ModemProfile = S2C, team: list[str] = TEAM, messages: int = 1, **more) -> ModemPort:
    return ModemPort("auv1", team, profile, slots(messages), **more)


def nothing(max_bytes: int) -> None:
    return None


def state(max_bytes: int) -> bytes:
    return STATE


def run(port: ModemPort, from_s: float, before_s: float, pull: Callable = nothing) -> list[Request]:
    """Step through a time in tenths of a second."""
    steps = range(round(from_s * 10), round(before_s * 10))
    return [request for tick in steps for request in port.open_slots(tick * NS // 10, (tick + 1) * NS // 10, pull)]


def say(port: ModemPort, happening: Happening, t_s: float = 1.0) -> list[Happening]:
    return port.on_event(ModemEvent(0, round(t_s * NS), happening))


def ends(port: ModemPort) -> list[tuple[int, str]]:
    """Reasons of the tickets that have failed, as the port itself has said."""
    return [(event.ticket, event.reason) for event in port.take_events() if event.status == "FAILED"]


def books(port: ModemPort):
    """The ledger, its identity checked."""
    ledger = port.ledger(0)
    ended = sum(ledger.refused.values()) + ledger.superseded + ledger.expired
    assert ledger.requested == ended + ledger.queued + ledger.started
    assert ledger.slots_owned == ledger.slots_used + ledger.slots_skipped
    return ledger


# -- slots -----------------------------------------------------------------------------------------------------


def test_life_of_a_payload() -> None:
    """A payload is queued, handed over at the opening of the own slot, and sent when the modem says so."""
    port = make()
    run(port, 0.0, 1.0)
    ticket = port.send(b"hello", 1 * NS, "auv2")
    assert port.take_events() == [TxEvent(ticket, "QUEUED")]
    assert run(port, 1.0, 9.9) == []
    assert run(port, 9.9, 15.0) == [Transmit(0, 10 * NS, b"hello", "auv2")]
    assert port.take_events() == [TxEvent(ticket, "IN_PROGRESS")]
    assert say(port, TxEvent(0, "SENT")) == [TxEvent(ticket, "SENT")]
    assert (books(port).started, books(port).failed, port.transmissions) == (1, {}, 1)


def test_state_is_pulled_when_the_slot_is_granted() -> None:
    """The own state is asked for once in every own slot and no earlier, with the room there is."""
    port = make()
    asked = []
    requests = run(port, 0.0, 25.0, lambda room: asked.append(room) or STATE)
    assert asked == [64, 64, 64]
    assert requests == [Transmit(seq, seq * 10 * NS, STATE) for seq in range(3)]
    assert (books(port).requested, books(port).started, books(port).slots_used) == (3, 3, 3)


def test_ticket_of_the_state() -> None:
    """During a pull the port says which ticket the state will have, whatever was requested before."""
    port = make()
    port.send(b"x" * 20, 0, "nobody")
    known = []
    run(port, 0.0, 5.0, lambda room: known.append(port.next_ticket) or STATE)
    assert known == [1]
    assert port.take_events()[-1] == TxEvent(1, "IN_PROGRESS")
    assert say(port, TxEvent(0, "SENT")) == [TxEvent(1, "SENT")]


def test_nothing_to_tell() -> None:
    """A slot for which there is nothing to tell is skipped."""
    port = make()
    assert run(port, 0.0, 25.0) == []
    assert (books(port).slots_owned, books(port).slots_skipped, books(port).requested) == (3, 3, 0)


def test_order_in_a_slot() -> None:
    """Higher priorities go first, then the state, then the oldest; one after another by airtime and turnaround."""
    port = make(messages=4)
    for priority in (0, 1, 0, 5):
        port.send(bytes([priority]) * 10, 0, priority=priority)
    requests = run(port, 0.0, 1.0, state)
    assert [request.payload[0] for request in requests] == [5, 1, 0x10, 0]
    gap_ns = S2C.airtime_ns(10) + round(S2C.turnaround_s * NS)
    assert [request.t_ns for request in requests[:3]] == [0, gap_ns, 2 * gap_ns]
    assert requests[3].t_ns == 2 * gap_ns + S2C.airtime_ns(15) + round(S2C.turnaround_s * NS)
    assert books(port).queued == 1


def test_pull_priority() -> None:
    """The state has the priority it was given: with a lower one, what waits goes before it."""
    port = make(pull_priority=-1)
    port.send(b"x" * 10, 0)
    assert [request.payload for request in run(port, 0.0, 15.0, state)] == [b"x" * 10, STATE]


def test_state_that_does_not_fit() -> None:
    """A state longer than a frame is refused for its size, never cut into fragments; the slot goes to what waits."""
    port = make()
    waiting = port.send(b"x" * 10, 0)
    requests = run(port, 0.0, 1.0, lambda room: bytes(65))
    assert [request.payload for request in requests] == [b"x" * 10]
    assert ends(port) == [(waiting + 1, "size")]
    assert (books(port).refused, books(port).requested) == ({"size": 1}, 2)


def test_mac_limits_the_message() -> None:
    """What there is no time for in a slot does not go whole, even if the modem would take it."""
    port = ModemPort("auv1", TEAM, S2C, slots(message_bytes=20))
    room = []
    port.send(b"x" * 30, 0)
    requests = run(port, 0.0, 25.0, room.append)
    assert room[0] == 20
    assert [len(request.payload) for request in requests] == [20, 18]
    assert port.capabilities().payload_max_bytes == 20


def test_ranging_is_the_last_of_its_slot() -> None:
    """What the modem waits for an answer after is the last of its slot, and the only such."""
    port = make(messages=3)
    first, _ = port.range("auv2", 0), port.range("auv3", 0)
    port.send(b"x" * 10, 0)
    requests = run(port, 0.0, 1.0, state)
    assert [type(request) for request in requests] == [Transmit, Transmit, RangeRequest]
    assert requests[2].destination == "auv2"
    assert requests[2].t_ns > requests[1].t_ns
    assert say(port, RangeResult(2, "auv2", 123.4)) == [RangeResult(first, "auv2", 123.4)]
    assert books(port).queued == 1


# -- what waits ------------------------------------------------------------------------------------------------


def test_supersede() -> None:
    """Of payloads with the same key only the newest is sent; the older fails, and says why."""
    port = make()
    old = port.send(b"old......", NS, supersede_key="depth")
    port.send(b"other....", NS)
    port.send(b"new......", NS, supersede_key="depth")
    assert ends(port) == [(old, "superseded")]
    assert [request.payload for request in run(port, 1.0, 25.0)] == [b"new......", b"other...."]
    assert books(port).superseded == 1


@pytest.mark.parametrize(("ttl_s", "goes"), [(9.0, True), (8.999, False)])
def test_ttl_counts_to_the_start(*, ttl_s: float, goes: bool) -> None:
    """A payload whose ttl ends before its transmission starts is not sent; what starts with its end is."""
    port = make()
    run(port, 0.0, 1.0)
    ticket = port.send(b"x" * 10, 1 * NS, ttl_s=ttl_s)
    assert bool(run(port, 1.0, 12.0)) is goes
    assert ends(port) == ([] if goes else [(ticket, "expired")])
    assert books(port).expired == (not goes)


def test_ttl_counts_to_its_place_in_the_slot() -> None:
    """A payload in time for the opening, but not for its place behind another, is not sent."""
    port = make(messages=2)
    port.send(b"x" * 60, 0, priority=1)
    late = port.send(b"y" * 10, 0, ttl_s=0.5)
    assert [request.payload for request in run(port, 0.0, 1.0)] == [b"x" * 60]
    assert ends(port) == [(late, "expired")]


def test_ttl_of_a_ranging_behind_others() -> None:
    """A ranging whose ttl ends while the slot's other messages are on the air is not asked for."""
    port = make(messages=2)
    late = port.range("auv2", 0, ttl_s=0.5)
    port.send(b"x" * 60, 0)
    assert [type(request) for request in run(port, 0.0, 1.0)] == [Transmit]
    assert ends(port) == [(late, "expired")]


def test_expires_without_a_slot() -> None:
    """What has waited for too long fails then, not only when a slot opens."""
    port = make()
    run(port, 0.0, 1.0)
    ticket = port.send(b"x" * 10, NS, ttl_s=2.0)
    run(port, 1.0, 2.9)
    assert ends(port) == []
    run(port, 2.9, 3.3)
    assert ends(port) == [(ticket, "expired")]


def test_overflow() -> None:
    """Of a full queue the lowest priority and newest fails, never silently."""
    port = make(queue_max=2)
    tickets = [port.send(b"x" * 10, 0, priority=priority) for priority in (0, 1, 0, 2)]
    assert ends(port) == [(tickets[2], "overflow"), (tickets[0], "overflow")]
    assert books(port).refused == {"overflow": 2}


# -- refusals --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("destination", "acknowledge", "profile", "reason"),
    [
        ("nobody", False, "s2c_im", "address"),
        ("auv1", False, "s2c_im", "address"),
        ("", True, "s2c_im", "address"),
        ("", False, "s2c_burst", "address"),
        ("auv2", True, "janus", "error"),
    ],
)
def test_refused(*, destination: str, acknowledge: bool, profile: str, reason: str) -> None:
    """What the modem could not do is refused at once, with the reason."""
    port = make(load_profile(profile))
    ticket = port.send(bytes(5), 0, destination, acknowledge=acknowledge)
    assert port.take_events() == [TxEvent(ticket, "FAILED", reason)]
    assert run(port, 0.0, 15.0) == []
    assert books(port).refused == {reason: 1}


@pytest.mark.parametrize(
    ("destination", "profile", "reason"),
    [("auv2", "janus", "error"), ("", "s2c_im", "address"), ("auv1", "s2c_im", "address")],
)
def test_range_refused(destination: str, profile: str, reason: str) -> None:
    """A ranging that the modem cannot do, or to nobody, is refused at once, with the reason."""
    port = make(load_profile(profile))
    ticket = port.range(destination, 0)
    assert ends(port) == [(ticket, reason)]
    assert books(port).refused == {reason: 1}


@pytest.mark.parametrize(
    ("profile", "size", "goes"),
    [("s2c_im", 0, False), ("s2c_im", 1920, True), ("s2c_im", 1921, False), ("janus", 6, False), ("janus", 5, True)],
)
def test_size(*, profile: str, size: int, goes: bool) -> None:
    """Nothing at all, and more than all fragments carry, is refused for its size; a JANUS packet has no fragments."""
    port = make(load_profile(profile))
    ticket = port.send(bytes(size), 0)
    assert ends(port) == ([] if goes else [(ticket, "size")])
    assert port.capabilities().message_max_bytes == {"s2c_im": 1920, "janus": 5}[profile]


@pytest.mark.parametrize(("last", "reasons"), [(0x40, []), (0x20, ["size"]), (0x01, ["size"])])
def test_bits(last: int, reasons: list[str]) -> None:
    """Of a modem of 34 bits the last 6 of 5 bytes must be zero: they would not arrive."""
    port = make(load_profile("janus"))
    port.send(bytes([0xFF, 0xFF, 0xFF, 0xFF, last]), 0)
    assert [reason for _, reason in ends(port)] == reasons


def test_pair_without_broadcast() -> None:
    """Of a pair whose modems have no broadcast, what is for everybody goes to the other."""
    port = make(load_profile("waterlinked_m64"), ["auv1", "auv2"])
    assert run(port, 0.0, 1.0, lambda room: STATE[:room]) == [Transmit(0, 0, STATE[:8], "auv2")]


def test_capabilities() -> None:
    """The port can do what its modem's profile says."""
    capabilities = make(load_profile("seatrac_x150")).capabilities()
    assert (capabilities.payload_max_bytes, capabilities.payload_max_bits) == (31, 248)
    assert (capabilities.addresses_max, capabilities.acknowledges, capabilities.broadcast) == (15, True, True)
    assert (capabilities.two_way_ranging, capabilities.one_way_ranging) == (True, False)
    assert make(load_profile("janus")).capabilities().payload_max_bits == 34


# -- fragments -------------------------------------------------------------------------------------------------


def long_on_its_way(port: ModemPort, **more) -> tuple[int, list[Request]]:
    """A payload of three fragments, all handed to the modem."""
    ticket = port.send(bytes(150), 0, "auv2", **more)
    requests = run(port, 0.0, 25.0)
    assert [request.t_ns for request in requests] == [0, 10 * NS, 20 * NS]
    port.take_events()
    return ticket, requests


def test_fragments_are_sent_when_all_are() -> None:
    """A long payload is sent when the last of its fragments is, in whatever order they are said to be."""
    port = make()
    ticket, _ = long_on_its_way(port)
    assert say(port, TxEvent(2, "SENT")) == say(port, TxEvent(0, "SENT")) == []
    assert say(port, TxEvent(0, "SENT")) == []  # said twice
    assert say(port, TxEvent(1, "SENT")) == [TxEvent(ticket, "SENT")]
    assert (books(port).requested, books(port).started, port.transmissions) == (1, 1, 3)


def test_fragments_are_delivered_when_all_are() -> None:
    """A long payload that is acknowledged is sent when all fragments are, and delivered when all are."""
    port = make()
    ticket, requests = long_on_its_way(port, acknowledge=True)
    assert all(request.acknowledge for request in requests)
    said = [say(port, TxEvent(seq, status)) for status in ("SENT", "SENT", "DELIVERED") for seq in range(3)]
    assert [happening for each in said for happening in each] == [TxEvent(ticket, "SENT"), TxEvent(ticket, "DELIVERED")]
    assert port.strays == 0


def test_one_fragment_fails() -> None:
    """As soon as one fragment fails the payload has failed: the others are not sent any more."""
    port = make()
    ticket = port.send(bytes(150), 0)
    run(port, 0.0, 1.0)
    assert say(port, TxEvent(0, "FAILED", "busy")) == [TxEvent(ticket, "FAILED", "busy")]
    assert run(port, 1.0, 25.0) == []
    assert say(port, TxEvent(0, "SENT")) == []
    assert (books(port).failed, books(port).started, books(port).queued, port.strays) == ({"busy": 1}, 1, 0, 1)


def test_what_has_begun_is_finished() -> None:
    """A long payload that has begun is neither superseded nor expired; its successor waits for it."""
    port = make()
    port.send(b"a" * 70, 0, supersede_key="k", ttl_s=1.0)
    run(port, 0.0, 1.0)
    port.send(b"b" * 20, NS, supersede_key="k")
    requests = run(port, 1.0, 25.0)
    assert [request.payload[-1:] for request in requests] == [b"a", b"b"]
    assert ends(port) == []


def test_from_port_to_port() -> None:
    """What one port sends in fragments comes out of another as it was, once, with what the modem has measured."""
    sender, receiver = make(), make()
    payload = bytes(range(150))
    sender.send(payload, 0)
    requests = run(sender, 0.0, 25.0)
    heard = [say(receiver, Received("auv2", each.payload, snr_db=float(each.seq))) for each in requests]
    assert heard == [[], [], [Received("auv2", payload, snr_db=2.0)]]
    assert [say(receiver, Received("auv2", each.payload)) for each in requests] == [[], [], []]
    assert books(receiver).reassembled == 1


def test_reassembly_timeout() -> None:
    """A payload whose fragments stay away is given up in its time and counted, though no slot opens."""
    sender, receiver = make(), ModemPort("auv3", TEAM, S2C, Schedule((), 10 * NS))
    sender.send(bytes(150), 0)
    (first, *_) = run(sender, 0.0, 25.0)
    run(receiver, 0.0, 1.0)
    say(receiver, Received("auv1", first.payload), t_s=1.0)
    run(receiver, 1.0, 121.0)
    assert books(receiver).abandoned == 0
    run(receiver, 121.0, 121.2)
    assert books(receiver).abandoned == 1


def test_bad_frames() -> None:
    """What the modem could not decode, and what only looks like a fragment, are told to the agent and counted."""
    port = make()
    assert say(port, BadFrame("crc")) == [BadFrame("crc")]
    assert say(port, Received("auv2", b"\xff" * 6)) == [BadFrame("fragment")]
    assert books(port).bad_frames == 2


def test_no_fragments_on_a_modem_of_bits() -> None:
    """On a modem without fragments everything heard is a payload."""
    event = Received("auv2", b"\xff" * 4)
    assert say(make(load_profile("janus")), event) == [event]


# -- what the modem says, or does not ----------------------------------------------------------------------------


def test_acknowledged() -> None:
    """With an acknowledgement asked for, sent is not the end: that is delivered, or not acknowledged."""
    for end in (TxEvent(0, "DELIVERED"), TxEvent(0, "FAILED", "no_ack")):
        port = make()
        port.send(b"x" * 10, 0, "auv2", acknowledge=True)
        run(port, 0.0, 1.0)
        port.take_events()
        assert say(port, TxEvent(0, "SENT")) == [TxEvent(0, "SENT")]
        assert say(port, end) == [end]
        assert say(port, end) == []
        assert (port.strays, books(port).failed) == (1, {"no_ack": 1} if end.status == "FAILED" else {})


def test_unasked_delivery() -> None:
    """A modem that says delivered where nobody asked says that it has left."""
    port = make()
    run(port, 0.0, 1.0, state)
    assert say(port, TxEvent(0, "DELIVERED")) == [TxEvent(0, "SENT")]


def test_no_range() -> None:
    """A ranging that nobody answered ends with no range, counted; what the modem says after that is not heard."""
    port = make()
    ticket = port.send(b"x" * 10, 0, "nobody") + 1
    assert port.range("auv2", 0) == ticket
    run(port, 0.0, 1.0)
    assert say(port, TxEvent(0, "SENT")) == say(port, TxEvent(0, "DELIVERED")) == []
    assert say(port, RangeResult(0, "auv2", None)) == [RangeResult(ticket, "auv2", None)]
    assert say(port, TxEvent(0, "FAILED", "busy")) == []
    assert (books(port).failed, port.strays) == ({"no_ack": 1}, 1)


@pytest.mark.parametrize(
    "stray",
    [TxEvent(7, "SENT"), TxEvent(7, "FAILED", "busy"), RangeResult(7, "auv2", 3.0), RangeResult(0, "auv2", 3.0)],
)
def test_strays(stray: Happening) -> None:
    """What the modem says of a request there is not, or is no ranging, is counted and told to nobody."""
    port = make()
    run(port, 0.0, 1.0, state)
    assert say(port, stray) == []
    assert (port.strays, books(port).failed) == (1, {})


def test_modem_falls_silent() -> None:
    """A request of which the modem never says the end fails in its time: nothing is in progress for ever."""
    port = make()
    run(port, 0.0, 1.0, state)
    port.take_events()
    run(port, 1.0, ANSWER_NS / NS)
    assert ends(port) == []
    run(port, ANSWER_NS / NS, ANSWER_NS / NS + 0.2)
    assert ends(port) == [(0, "error")]
    assert books(port).failed == {"error": 1}


def test_reboot() -> None:
    """What was in progress when the modem was restarted fails soon, unless the modem still says its end."""
    port = make(messages=2)
    port.send(b"x" * 10, 0)
    run(port, 0.0, 1.0, state)
    port.take_events()
    status = ModemStatus("rebooted", "watchdog")
    assert say(port, status, t_s=1.0) == [status]
    assert say(port, TxEvent(0, "FAILED", "off"), t_s=1.0) == [TxEvent(1, "FAILED", "off")]
    run(port, 1.0, 1.0 + REBOOT_NS / NS)
    assert ends(port) == []
    run(port, 1.0 + REBOOT_NS / NS, 1.2 + REBOOT_NS / NS)
    assert ends(port) == [(0, "error")]


def test_reboot_before_the_start() -> None:
    """A request that starts after the reboot is not touched by it; other states of the modem change nothing."""
    port = make()
    port.open_slots(9 * NS, 11 * NS, state)
    port.take_events()
    for word in ("rebooted", "off", "error", "ready"):
        assert say(port, ModemStatus(word), t_s=9.5) == [ModemStatus(word)]
    run(port, 11.0, 60.0)
    assert ends(port) == []


# -- other ways --------------------------------------------------------------------------------------------------


def test_by_land() -> None:
    """What goes over cable or radio goes at once, whatever the modem's frames, numbered and counted like the rest."""
    port = make(load_profile("janus"))
    request = port.send_by_land(bytes(300), 2 * NS)
    assert request == Transmit(0, 2 * NS, bytes(300), by_land=True)
    assert say(port, TxEvent(0, "SENT")) == [TxEvent(0, "SENT")]
    assert port.send_by_land(b"", 2 * NS) is None
    assert port.send_by_land(bytes(65536), 2 * NS) is None
    assert books(port).refused == {"size": 2}


def test_by_land_can_be_told_from_a_fragment() -> None:
    """What looks like a fragment comes over land as it was, too."""
    sender, receiver = make(), make()
    request = sender.send_by_land(b"\xff" * 300, 0)
    assert say(receiver, Received("auv2", request.payload)) == [Received("auv2", b"\xff" * 300)]
    assert sender.send_by_land(bytes(65536), 0) is None
    assert ends(sender) == [(1, "size")]


def test_clock_set_back() -> None:
    """A clock set back by GPS brings no slot a second time."""
    port = make()
    assert len(run(port, 0.0, 10.5, state)) == 2
    assert run(port, 9.0, 19.9, state) == []
    assert len(run(port, 19.9, 20.5, state)) == 1


def test_requests_go_over_the_bus() -> None:
    """What the port asks of the modem is what the bus carries."""
    port = make(messages=2)
    port.range("auv2", 0)
    for request in run(port, 0.0, 1.0, state):
        assert msgspec.msgpack.decode(msgspec.msgpack.encode(request), type=Request) == request


def test_numbers_of_payloads() -> None:
    """Payloads in fragments are numbered from the time of the first, modulo 512: a restart gives other numbers."""
    port = make(messages=4)
    port.send(bytes(100), 600 * NS)
    port.send(bytes(100), 600 * NS)
    requests = run(port, 600.0, 601.0)
    assert [int.from_bytes(each.payload[:4], "big") >> 8 & 511 for each in requests] == [88, 88, 89, 89]
