"""What an agent may rely on, whatever modem it has: one contract of modem/tx and modem/rx, for all modems alike.

auv1 ── 300 m ── auv2 ── 300 m ── auv3      at rate 0: 32 bytes in 4.2 s
"""

import pytest
from modem_benches import EmulatedBench, SerialBench

from grex_link.messages import BadFrame, ModemStatus, RangeRequest, RangeResult, Received, Transmit, TxEvent

NS = 1_000_000_000
PLACES = {"auv1": (0.0, 0.0, 10.0), "auv2": (0.0, 300.0, 10.0), "auv3": (0.0, 600.0, 10.0)}
SCENARIO = """
[link]
profile = "{profile}"
{link}
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 300, 0]
auv3 = [0, 600, 0]
[craft.auv1]
[craft.auv2]
[craft.auv3]
"""


@pytest.fixture(params=[EmulatedBench, SerialBench], ids=["emulated", "serial"])
def bench(request):
    """A function that sets up a team on one kind of modem."""
    benches = []

    def make(link: str = "", profile: str = "umodem_fsk0"):
        benches.append(request.param(SCENARIO.format(profile=profile, link=link), PLACES))
        return benches[-1]

    yield make
    for one in benches:
        assert_in_order(one)
        one.close()


def assert_in_order(bench) -> None:
    """Events are numbered from 0 without a gap, and their times never run back."""
    for events in bench.events.values():
        assert [event.seq for event in events] == list(range(len(events)))
        times = [event.t_ns for event in events]
        assert times == sorted(times)
        assert min(times, default=0) >= 0


def off(craft: str, start_s: float, end_s: float) -> str:
    return f'outages = [{{ craft = "{craft}", start_s = {start_s}, end_s = {end_s} }}]'


def told(bench, craft: str, kind: type, after_s: float = 0.0) -> list:
    return [e.event for e in bench.events[craft] if isinstance(e.event, kind) and e.t_ns >= after_s * NS]


def ends(bench, craft: str) -> list[tuple[int, str, str]]:
    return [(event.ticket, event.status, event.reason) for event in told(bench, craft, TxEvent)]


def when(bench, craft: str, kind: type) -> float:
    return next(event.t_ns for event in bench.events[craft] if isinstance(event.event, kind)) / NS


def test_a_broadcast_is_heard_by_all(bench):
    """What is sent to everyone is SENT, and arrives at all mates with its source, at the time sound needs."""
    team = bench()
    team.send("auv1", Transmit(0, 10 * NS, b"to everyone"))
    team.run(9)
    assert told(team, "auv2", Received) == []
    team.run(20)
    assert ends(team, "auv1") == [(0, "SENT", "")]
    for mate in ("auv2", "auv3"):
        (heard,) = told(team, mate, Received)
        assert (heard.source, heard.payload, heard.destination) == ("auv1", b"to everyone", "")
        assert 60.0 < heard.rssi_db < 185.0
    assert when(team, "auv1", TxEvent) == pytest.approx(14.2, abs=0.01)
    # Airtime 4.2 s, 0.2 s a 300 m, 0.2 s to decode.
    assert when(team, "auv2", Received) == pytest.approx(14.6, abs=0.02)
    assert when(team, "auv3", Received) == pytest.approx(14.8, abs=0.02)


@pytest.mark.parametrize(
    "payload",
    [b"\0", b"\x80", b"x\0\0", b"x" * 15, b"x" * 31, b"x" * 32, b"\0" * 32, b"x\x80" * 10, bytes(range(32))],
    ids=lambda payload: f"{len(payload)} bytes from {payload[:2].hex()}",
)
def test_a_payload_arrives_as_it_left(bench, payload):
    """Whatever a payload contains, and whatever it is padded with on its way, it arrives as it was."""
    team = bench()
    team.send("auv3", Transmit(0, 2 * NS, payload))
    team.run(10)
    assert [event.payload for event in told(team, "auv1", Received)] == [payload]


def test_a_packet_of_several_frames(bench):
    """A payload of three frames is one message."""
    team = bench(profile="umodem_psk1")
    payload = bytes(range(192))
    team.send("auv1", Transmit(0, 2 * NS, payload))
    team.send("auv1", Transmit(1, 20 * NS, payload[:100]))
    team.run(40)
    assert ends(team, "auv1") == [(0, "SENT", ""), (1, "SENT", "")]
    assert [event.payload for event in told(team, "auv3", Received)] == [payload, payload[:100]]


def test_an_acknowledged_message(bench):
    """SENT, then DELIVERED; only the one it is for gets it."""
    team = bench()
    team.send("auv1", Transmit(0, 2 * NS, b"to auv2", "auv2", acknowledge=True))
    team.run(40)
    assert ends(team, "auv1") == [(0, "SENT", ""), (0, "DELIVERED", "")]
    assert [(event.source, event.payload, event.destination) for event in told(team, "auv2", Received)] == [
        ("auv1", b"to auv2", "auv2")
    ]
    assert told(team, "auv3", Received) == []


def test_no_acknowledgement(bench):
    """If the one it is for is off, it is SENT and then FAILED no_ack."""
    team = bench(off("auv2", 1.0, 1000.0))
    team.send("auv1", Transmit(0, 2 * NS, b"to auv2", "auv2", acknowledge=True))
    team.run(60)
    assert ends(team, "auv1") == [(0, "SENT", ""), (0, "FAILED", "no_ack")]


def test_busy(bench):
    """What begins while a transmission is under way fails, and the one under way arrives."""
    team = bench()
    team.send("auv1", Transmit(0, 2 * NS, b"first"))
    team.send("auv1", Transmit(1, 4 * NS, b"second"))
    team.send("auv1", RangeRequest(2, 5 * NS, "auv2"))
    team.run(20)
    assert sorted(ends(team, "auv1")) == [(0, "SENT", ""), (1, "FAILED", "busy"), (2, "FAILED", "busy")]
    assert told(team, "auv1", RangeResult) == []
    assert [event.payload for event in told(team, "auv3", Received)] == [b"first"]


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (Transmit(0, 2 * NS, b"x" * 33), "size"),
        (Transmit(0, 2 * NS, b"x", "nobody"), "address"),
        (Transmit(0, 2 * NS, b"x", "auv1"), "address"),
        (Transmit(0, 2 * NS, b"x", "", acknowledge=True), "address"),
        (RangeRequest(0, 2 * NS, "nobody"), "address"),
    ],
)
def test_what_cannot_be_done_is_refused(bench, request_, reason):
    """A payload over the limit, an address that nobody has: FAILED with the reason, nothing on the air."""
    team = bench()
    team.send("auv1", request_)
    team.send("auv1", Transmit(1, 4 * NS, b"next"))
    team.run(20)
    assert ends(team, "auv1") == [(0, "FAILED", reason), (1, "SENT", "")]
    assert [event.payload for event in told(team, "auv2", Received)] == [b"next"]


def test_a_range(bench):
    """A ping measures the distance to within the modem's errors; it is nobody's message."""
    team = bench()
    team.send("auv1", RangeRequest(0, 2 * NS, "auv3"))
    team.run(40)
    (result,) = told(team, "auv1", RangeResult)
    assert (result.ticket, result.destination) == (0, "auv3")
    # σ is 0.3 m, steps are 0.15 m.
    assert result.range_m == pytest.approx(600.0, abs=2.0)
    assert told(team, "auv1", TxEvent) == []
    assert told(team, "auv3", Received) == told(team, "auv2", Received) == []


def test_a_range_that_nobody_answers(bench):
    """A ping to a craft whose modem is off ends without a range, and the next message is sent."""
    team = bench(off("auv3", 1.0, 1000.0))
    team.send("auv1", RangeRequest(0, 2 * NS, "auv3"))
    team.send("auv1", Transmit(1, 60 * NS, b"next"))
    team.run(70)
    assert told(team, "auv1", RangeResult) == [RangeResult(0, "auv3", None)]
    assert ends(team, "auv1") == [(1, "SENT", "")]


def test_a_modem_that_reboots_in_the_middle(bench):
    """What is on the air fails, the agent is told of the reboot, mates hear no message, and then all is well again."""
    team = bench(off("auv1", 4.0, 12.0))
    team.send("auv1", Transmit(0, 2 * NS, b"cut short"))
    team.send("auv1", Transmit(1, 40 * NS, b"whole"))
    team.send("auv2", Transmit(0, 60 * NS, b"answer"))
    team.run(80)
    ((ticket, status, reason), last) = ends(team, "auv1")
    assert (ticket, status) == (0, "FAILED")
    assert reason in {"off", "error"}
    assert last == (1, "SENT", "")
    states = [event.state for event in told(team, "auv1", ModemStatus, after_s=1.0)]
    assert "rebooted" in states
    assert [event.payload for event in told(team, "auv2", Received)] == [b"whole"]
    assert [event.payload for event in told(team, "auv1", Received)] == [b"answer"]


def test_while_the_modem_is_off(bench):
    """A request to a modem that is off ends FAILED, too; what others say meanwhile is not heard."""
    team = bench(off("auv1", 4.0, 60.0))
    team.send("auv1", Transmit(0, 10 * NS, b"in vain"))
    team.send("auv2", Transmit(0, 10 * NS, b"unheard"))
    team.run(80)
    ((ticket, status, reason),) = ends(team, "auv1")
    assert (ticket, status) == (0, "FAILED")
    assert reason in {"off", "error"}
    assert told(team, "auv1", Received) == []
    assert [event.payload for event in told(team, "auv3", Received)] == [b"unheard"]


def test_a_packet_that_cannot_be_decoded(bench):
    """A packet that is spoilt on its way is a bad frame, once, and no message."""
    noise = "jammers = [{ position_ned_m = [0, 610, 10], source_level_db = 200, start_s = 4, end_s = 5 }]"
    team = bench(noise)
    team.send("auv1", Transmit(0, 2 * NS, b"spoilt"))
    team.send("auv1", Transmit(1, 20 * NS, b"whole"))
    team.run(40)
    assert told(team, "auv3", BadFrame) == [BadFrame("corrupt")]
    assert [event.payload for event in told(team, "auv3", Received)] == [b"whole"]


def test_half_duplex(bench):
    """Two that speak at the same time do not hear each other; a request ends for each of them all the same."""
    team = bench()
    team.send("auv1", Transmit(0, 2 * NS, b"one"))
    team.send("auv2", Transmit(0, 2 * NS, b"two"))
    team.run(20)
    assert ends(team, "auv1") == ends(team, "auv2") == [(0, "SENT", "")]
    assert told(team, "auv1", Received) == told(team, "auv2", Received) == []
