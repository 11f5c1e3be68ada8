"""Properties of the modem port: books that balance, one end for every ticket, payloads whole or not at all."""

import random
from collections import Counter

from fuzzing import INPUTS, spoiled
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from grex_agent.modem.fragments import DONE_MAX, PARTIAL_MAX, Reassembly, data_bytes, split
from grex_agent.modem.port import ModemPort
from grex_link.messages import (
    BadFrame,
    Happening,
    ModemEvent,
    ModemStatus,
    RangeRequest,
    RangeResult,
    Received,
    Transmit,
    TxEvent,
)
from grex_link.profile import load_profile
from grex_link.tdma import Schedule, Slot
from grex_link.units import NS

TEAM = ["auv1", "auv2", "auv3"]
QUEUE_MAX = 4
REASONS = ["busy", "off", "no_ack", "size", "error", ""]
STATUSES = ["QUEUED", "IN_PROGRESS", "SENT", "DELIVERED", "FAILED"]


class Port(RuleBasedStateMachine):
    """A port, an agent that asks for anything, and a modem that says anything, in any order."""

    @initialize(
        name=st.sampled_from(["s2c_im", "janus", "waterlinked_m64", "seatrac_x150", "grex2008"]),
        messages=st.integers(1, 3),
        message_bytes=st.sampled_from([0, 16, 64]),
        size=st.integers(2, 3),
    )
    def begin(self, name: str, messages: int, message_bytes: int, size: int) -> None:
        mac = Schedule((Slot("auv1", 0, NS),), 5 * NS, messages, message_bytes)
        self.port = ModemPort("auv1", TEAM[:size], load_profile(name), mac, queue_max=QUEUE_MAX)
        self.now_ns = self.high_ns = 0
        self.expected: set[int] = set()
        self.told: dict[int, list[str]] = {}
        self.asked: set[int] = set()
        self.openings: list[int] = []

    def hear(self, happenings: list[Happening]) -> None:
        """Note what the agent is told of each ticket; nothing may come after its end."""
        for happening in happenings:
            if not isinstance(happening, TxEvent | RangeResult):
                continue
            told = self.told.setdefault(happening.ticket, [])
            assert not told or told[-1] != "end"
            word = "range" if isinstance(happening, RangeResult) else happening.status
            assert word not in told
            told.append(word)
            if word in {"FAILED", "DELIVERED", "range"} or (word == "SENT" and happening.ticket not in self.asked):
                told.append("end")

    @rule(
        size=st.integers(0, 80) | st.sampled_from([5, 8, 15, 300, 5000]),
        first=st.sampled_from([0x00, 0x13, 0xF0]),
        destination=st.sampled_from(["", "", "auv2", "auv3", "auv1", "nobody"]),
        priority=st.integers(-1, 2),
        ttl_s=st.none() | st.floats(-1.0, 20.0),
        key=st.sampled_from([None, None, "a", "b"]),
        acknowledge=st.booleans(),
    )
    def send(self, size, first, destination, priority, ttl_s, key, acknowledge) -> None:
        payload = bytes([first]) * size
        ticket = self.port.send(payload, self.now_ns, destination, priority=priority, ttl_s=ttl_s, supersede_key=key,
                                acknowledge=acknowledge)  # fmt: skip
        self.expected.add(ticket)
        if acknowledge:
            self.asked.add(ticket)
        self.hear(self.port.take_events())

    @rule(destination=st.sampled_from(["", "auv2", "auv1"]), ttl_s=st.none() | st.floats(0.0, 20.0))
    def ask_range(self, destination, ttl_s) -> None:
        self.expected.add(self.port.range(destination, self.now_ns, ttl_s=ttl_s))
        self.hear(self.port.take_events())

    @rule(size=st.sampled_from([0, 15, 300, 70000]))
    def land(self, size) -> None:
        self.expected.add(self.port.next_ticket)
        self.port.send_by_land(bytes(size), self.now_ns)
        self.hear(self.port.take_events())

    @rule(
        step_ns=st.integers(1, 12 * NS),
        ahead_ns=st.integers(0, 6 * NS),
        size=st.none() | st.integers(0, 80) | st.sampled_from([5, 8, 15]),
    )
    def step(self, step_ns, ahead_ns, size) -> None:
        """Some windows overlap, as ahead of the step as they look."""

        def pull(room: int) -> bytes | None:
            if size is None:
                return None
            self.expected.add(self.port.next_ticket)
            return bytes(size)

        requests = self.port.open_slots(self.now_ns, self.now_ns + step_ns + ahead_ns, pull)
        assert all(isinstance(each, RangeRequest) or len(each.payload) > 0 for each in requests)
        total = self.port.transmissions
        assert [each.seq for each in requests] == list(range(total - len(requests), total))
        assert [each.t_ns for each in requests] == sorted(each.t_ns for each in requests)
        self.openings += [each.t_ns for each in requests if each.t_ns % (5 * NS) == 0]
        assert len(set(self.openings)) == len(self.openings)
        self.now_ns += step_ns
        self.hear(self.port.take_events())

    @rule(back_ns=st.integers(0, 20 * NS))
    def set_back(self, back_ns) -> None:
        self.now_ns = max(self.now_ns - back_ns, 0)

    @rule(seq=st.integers(-1, 30), status=st.sampled_from(STATUSES), reason=st.sampled_from(REASONS))
    def modem_says(self, seq, status, reason) -> None:
        self.told_by_modem(TxEvent(seq, status, reason))

    @precondition(lambda self: self.port.transmissions)
    @rule(back=st.integers(1, 4), status=st.sampled_from(["SENT", "SENT", "DELIVERED", "FAILED"]))
    def modem_says_of_late(self, back, status) -> None:
        self.told_by_modem(TxEvent(self.port.transmissions - back, status, "busy" if status == "FAILED" else ""))

    @rule(back=st.integers(1, 4), range_m=st.none() | st.floats(0.0, 1e4))
    def modem_ranges(self, back, range_m) -> None:
        self.told_by_modem(RangeResult(self.port.transmissions - back, "auv2", range_m))

    @rule(word=st.sampled_from(["ready", "off", "rebooted", "error"]))
    def modem_is(self, word) -> None:
        self.told_by_modem(ModemStatus(word))

    @rule(payload=st.binary(max_size=30), source=st.sampled_from([*TEAM, "", "stranger"]))
    def modem_hears(self, payload, source) -> None:
        self.told_by_modem(Received(source, payload))

    def told_by_modem(self, happening: Happening) -> None:
        heard = self.port.on_event(ModemEvent(0, self.now_ns, happening))
        self.hear(heard)
        assert self.port.take_events() == []

    @invariant()
    def books_balance(self) -> None:
        """Every request is in exactly one of the books, and the queue never has more than it has room for."""
        if not hasattr(self, "port"):
            return
        ledger = self.port.ledger(self.now_ns)
        ended = sum(ledger.refused.values()) + ledger.superseded + ledger.expired
        assert ledger.requested == ended + ledger.queued + ledger.started == len(self.expected)
        assert ledger.slots_owned == ledger.slots_used + ledger.slots_skipped
        assert 0 <= ledger.queued <= QUEUE_MAX
        assert sum(ledger.failed.values()) <= ledger.started

    def teardown(self) -> None:
        """Left alone, with a modem that has nothing more to say, the port tells the end of every ticket."""
        if not hasattr(self, "port"):
            return
        for tick in range(2500):
            self.port.open_slots(self.now_ns, self.now_ns + NS, lambda room: None)
            self.now_ns += NS
            if tick % 100 == 0:
                self.hear(self.port.take_events())
        self.hear(self.port.take_events())
        assert set(self.told) == self.expected
        assert all(told[-1] == "end" for told in self.told.values()), self.told


Port.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestPort = Port.TestCase
TestPort.__doc__ = "The books balance after any sequence, and every ticket has one end, the last that is told of it."


@given(st.data(), st.integers(6, 70), st.lists(st.binary(min_size=1, max_size=60), min_size=1, max_size=4))
@settings(deadline=None)
def test_fragments_in_any_order(data, frame_max_bytes: int, payloads: list[bytes]) -> None:
    """Payloads cut up, mixed, shuffled and repeated come out as they were, each once, and no others."""
    payloads = [payload for payload in payloads if len(payload) <= 32 * data_bytes(frame_max_bytes)]
    frames = [frame for number, payload in enumerate(payloads) for frame in split(payload, frame_max_bytes, number)]
    whole = sum(split(payload, frame_max_bytes, 0) == (payload,) for payload in payloads)
    plain = [frame for frame in frames if frame in payloads and len(split(frame, frame_max_bytes, 0)) == 1]
    again = [frame for frame in frames if frame not in plain]
    order = data.draw(st.permutations(frames + again))
    reassembly = Reassembly(120.0)
    out = [payload for frame in order if (payload := reassembly.take("auv2", frame, 0)) is not None]
    assert Counter(out) == Counter(payloads)
    assert reassembly.reassembled == len(payloads) - whole
    assert (reassembly.abandoned, reassembly.bad) == (0, 0)


@given(st.binary(min_size=1, max_size=300), st.integers(6, 70), st.data())
def test_missing_fragments(payload: bytes, frame_max_bytes: int, data) -> None:
    """A payload of which a fragment is missing never comes out, and is counted as given up."""
    frames = split(payload, frame_max_bytes, 3)
    if len(frames) < 2:
        return
    missing = data.draw(st.integers(0, len(frames) - 1))
    reassembly = Reassembly(120.0)
    rest = [frame for index, frame in enumerate(frames) if index != missing]
    assert [reassembly.take("auv2", frame, 0) for frame in rest] == [None] * len(rest)
    reassembly.expire(120 * NS)
    assert reassembly.abandoned == 1


def fuzz(inputs: int, seed: int) -> Counter[str]:
    """Feed a port with spoiled frames and whatever a modem could say; count what came of each frame received.

    Nothing may raise, memory must not grow, and every frame is a payload, a part of one, or bad.
    """
    draw = random.Random(seed)
    mac = Schedule((Slot("auv1", 0, NS),), 5 * NS, 2, 64)
    port = ModemPort("auv1", TEAM, load_profile("s2c_im"), mac)
    counts: Counter[str] = Counter()
    frames: list[bytes] = [b""]
    for number in range(inputs):
        t_ns = number * NS // 20
        if number % 10 == 0:
            frames = [*split(draw.randbytes(draw.randrange(1, 300)), 64, draw.randrange(600)), b"\x10" + bytes(14)]
        kind = draw.randrange(10)
        if kind < 8:
            frame = spoiled(draw, draw.choice(frames))
            heard = port.on_event(ModemEvent(number, t_ns, Received(draw.choice([*TEAM, "", "x"]), frame)))
            counts[type(heard[0]).__name__ if heard else "part"] += 1
        elif kind == 8:
            port.on_event(ModemEvent(number, t_ns, TxEvent(draw.randrange(-5, inputs), draw.choice(STATUSES), "")))
        else:
            odd = (RangeResult(draw.randrange(-5, inputs), "?", draw.choice([None, float("nan")])), BadFrame("?"))
            port.on_event(ModemEvent(number, t_ns, draw.choice(odd)))
        port.open_slots(t_ns, t_ns + NS // 20, lambda room: draw.randbytes(draw.randrange(room + 5)))
        port.take_events()
    ledger = port.ledger(0)
    ended = sum(ledger.refused.values()) + ledger.superseded + ledger.expired
    assert ledger.requested == ended + ledger.queued + ledger.started
    assert ledger.bad_frames >= counts["BadFrame"]
    reassembly = port._inbox.reassembly
    assert len(reassembly._partial) <= PARTIAL_MAX
    assert len(reassembly._done) <= DONE_MAX
    counts["reassembled"], counts["abandoned"] = ledger.reassembled, ledger.abandoned
    return counts


def test_fuzz() -> None:
    """Whatever a modem says, nothing raises, everything is counted, and what is whole still comes through."""
    counts = fuzz(INPUTS, seed=11)
    for kind in ("Received", "part", "BadFrame", "reassembled", "abandoned"):
        assert counts[kind] > INPUTS / 1000, (kind, counts)


def test_transmit_is_whole() -> None:
    """No request is larger than the modem takes, for any payload size on any fragmenting modem."""
    for name in ("s2c_im", "seatrac_x150", "waterlinked_m64"):
        profile = load_profile(name)
        for size in (1, 4, 5, 8, 9, 15, 31, 64, 90):
            mac = Schedule((Slot("auv1", 0, NS),), NS)
            port = ModemPort("auv1", TEAM[:2], profile, mac)
            port.send(b"\xff" * size, 0, "auv2")
            receiver, out = ModemPort("auv2", TEAM[:2], profile, mac), []
            for tick in range(60):
                for request in port.open_slots(tick * NS, (tick + 1) * NS, lambda room: None):
                    assert isinstance(request, Transmit)
                    assert len(request.payload) <= profile.payload_max_bytes
                    out += receiver.on_event(ModemEvent(0, tick * NS, Received("auv1", request.payload)))
            assert [happening.payload for happening in out] == [b"\xff" * size]
