"""What the water does to packets, and what modems say: one packet at a time."""

import math

import pytest
from acoustic_water import NS, PLAIN, AcousticWater, fates, plain, triangle, truth

from grex_link.config import CraftConfig, SelfNoiseConfig
from grex_link.link_config import JammerConfig, LinkConfig, OutageConfig, WaterConfig
from grex_link.messages import BadFrame, ModemStatus, Received, TxEvent
from grex_link.profile import Ranging

PAIR = {"a": (0.0, 0.0, 0.0), "b": (750.0, 0.0, 0.0)}


def heard(water: AcousticWater, craft: str) -> list[Received]:
    return [event for _, who, event in water.events() if who == craft and isinstance(event, Received)]


def told(water: AcousticWater, craft: str) -> list[tuple[int, str, str]]:
    """Return what a craft's modem says of its requests, with the time in milliseconds."""
    said = [(t_ns, event) for t_ns, who, event in water.events() if who == craft and isinstance(event, TxEvent)]
    return [(t_ns // 10**6, event.status, event.reason) for t_ns, event in said]


# -- propagation -----------------------------------------------------------------------------------------------------


def test_unit_vector_both_arrive() -> None:
    """Three nodes 50 m apart, packets of 2.0 s: sent at 1 and at 3.001 s both arrive at the third."""
    water = AcousticWater(triangle(50.0), plain(airtime_fixed_s=2.0))
    water.send("a", 1.0)
    water.send("b", 3.001)
    log = fates(water.run())
    assert (log["a", 0, "c"], log["b", 0, "c"]) == ("", "")


def test_unit_vector_both_are_lost() -> None:
    """Three nodes 50 m apart, packets of 2.0 s: sent at 1 and at 2.99 s both are lost at the third."""
    water = AcousticWater(triangle(50.0), plain(airtime_fixed_s=2.0))
    water.send("a", 1.0)
    water.send("b", 2.99)
    log = fates(water.run())
    assert (log["a", 0, "c"], log["b", 0, "c"]) == ("lost_collision", "missed_busy")


def test_latencies_add_up() -> None:
    """A payload is out after transmit latency, delay, airtime and decoding, and the sender is told in between."""
    water = AcousticWater(PAIR, plain(transmit_latency_s=0.25, decode_latency_s=0.125))
    water.send("a", 10.0)
    assert [(t_ns, who) for t_ns, who, _ in water.events()] == [(11_250_000_000, "a"), (11_875_000_000, "b")]


def test_a_craft_that_moves() -> None:
    """The path is that of the moment the sound leaves, on from the last two poses, and the event says how it grows."""
    water = AcousticWater(PAIR)
    for t_s in (1.0, 2.0):
        water.run(t_s)
        water.medium.place(truth({**PAIR, "b": (750.0 + 10.0 * t_s, 0.0, 0.0)}, t_s))
    water.send("a", 2.5)
    events = water.events()
    assert events[-1][0] == round((2.5 + 1.0 + 775.0 / 1500.0) * NS)
    assert events[-1][2].relative_speed_mps == 10.0


def test_layers_of_sound_speed() -> None:
    """Sound takes as long as it does through the layers: ∫dz/c straight down, d/c along a depth."""
    places = {"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 100.0), "c": (0.0, 300.0, 100.0)}
    link = LinkConfig(water=WaterConfig(layers=((0.0, 1500.0), (100.0, 1400.0))))
    water = AcousticWater(places, link=link)
    water.send("b", 0.0)
    lines = {line.destination: line.lasting_ns / NS - 1.0 for line in water.run() if line.kind == "delivered"}
    assert lines["a"] == pytest.approx(math.log(1500.0 / 1400.0), abs=1e-9)
    assert lines["c"] == pytest.approx(300.0 / 1400.0, abs=1e-9)


def test_a_position_that_is_no_number() -> None:
    """A position that is no number is counted, and the craft is taken to go on as it did."""
    water = AcousticWater(PAIR)
    water.medium.place(truth({**PAIR, "b": (760.0, 0.0, 0.0)}, 1.0))
    water.medium.place(truth({**PAIR, "b": (math.nan, 0.0, math.inf)}, 2.0))
    water.send("a", 2.0)
    assert water.medium.bad_positions == 1
    assert water.events()[-1][0] == round((3.0 + 770.0 / 1500.0) * NS)


# -- noise -----------------------------------------------------------------------------------------------------------


def test_own_noise_grows_with_speed() -> None:
    """A craft that makes much noise at speed hears nothing then, and its mates still hear it."""
    noisy = CraftConfig(self_noise=SelfNoiseConfig(level_db=100.0, slope_db_per_mps=20.0))
    water = AcousticWater(PAIR, craft={"b": noisy})
    log = []
    for t_s, speed_mps in ((0.0, 0.0), (10.0, 3.0), (20.0, -3.0), (30.0, math.nan)):
        log += water.run(t_s)
        water.medium.place(truth(PAIR, t_s, speed_mps))
        water.send("a", t_s)
        water.send("b", t_s + 5.0)
    log += water.run()
    assert [fates(log)["a", number, "b"] for number in range(4)] == ["", "missed_snr", "missed_snr", ""]
    assert [fates(log)["b", number, "a"] for number in range(4)] == ["", "", "", ""]


def test_noise_in_the_middle_of_a_packet() -> None:
    """Noise that begins while a receiver is locked spoils the packet, and the SINR says how much."""
    link = LinkConfig(jammers=(JammerConfig((750.0, 0.0, 0.0), 140.0, 1.0, 1.1),))
    water = AcousticWater(PAIR, link=link)
    water.send("a", 0.0)
    (line,) = [line for line in water.run() if line.kind == "lost"]
    level_db = 185.0 - 15.0 * math.log10(750.0) - 0.75 * 4.0
    assert line.reason in {"lost_noise", "lost_collision"}
    assert line.sinr_db == pytest.approx(level_db - 140.0, abs=3.0)
    assert line.t_ns == 1_500_000_000


def test_jammer_window() -> None:
    """A jammer beside a receiver kills its receptions in its window and in no other, and those of no distant craft."""
    jammer = JammerConfig((750.0, 10.0, 0.0), 185.0, 20.0, 40.0)
    water = AcousticWater(
        {**PAIR, "c": (-750.0, 0.0, 0.0)}, plain(reception=PLAIN.reception), LinkConfig(jammers=(jammer,))
    )
    for number in range(30):
        water.send("a", 2.0 * number)
    log = fates(water.run())
    spoiled = {number for number in range(30) if log["a", number, "b"]}
    # Sent at 2·n, there from 2·n + 0.5 to 2·n + 1.5 s; the jammer is there from 20.007 to 40.007 s.
    assert spoiled == set(range(10, 20))
    assert not any(log["a", number, "c"] for number in range(30))


# -- outages ---------------------------------------------------------------------------------------------------------


def test_a_modem_that_reboots_while_it_sends() -> None:
    """What a modem sends as it goes off ends there, is whole nowhere, and it says so; afterwards it sends again."""
    water = AcousticWater(PAIR, link=LinkConfig(outages=(OutageConfig("a", 0.5, 3.0),)))
    water.send("a", 0.0)
    water.send("a", 1.0)
    water.send("a", 3.5)
    events = water.events()
    own = [(t_ns // 10**6, event) for t_ns, who, event in events if who == "a"]
    assert own == [
        (500, TxEvent(0, "FAILED", "off")),
        (500, ModemStatus("off")),
        (1000, TxEvent(1, "FAILED", "off")),
        (3000, ModemStatus("rebooted")),
        (4500, TxEvent(2, "SENT")),
    ]
    others = [(t_ns // 10**6, type(event)) for t_ns, who, event in events if who == "b"]
    assert others == [(1000, BadFrame), (5000, Received)]


@pytest.mark.parametrize(
    ("off_s", "on_s", "reason"),
    [(1.0, 1.2, "aborted_off"), (0.2, 0.8, "missed_off"), (1.55, 2.0, "aborted_off"), (2.0, 3.0, ""), (0.1, 0.4, "")],
)
def test_a_modem_that_reboots_while_it_hears(off_s: float, on_s: float, reason: str) -> None:
    """A packet there from 0.5 to 1.5 s and out at 1.6 s is lost if the modem is off at its start, end or in between."""
    link = LinkConfig(outages=(OutageConfig("b", off_s, on_s),))
    water = AcousticWater(PAIR, plain(decode_latency_s=0.1), link)
    water.send("a", 0.0)
    events, log = water.events(), water.run()
    assert fates(log)["a", 0, "b"] == reason
    assert any(isinstance(event, Received) for _, _, event in events) == (not reason)


# -- requests --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("request_of", "profile", "reason"),
    [
        ({"payload": bytes(65)}, PLAIN, "size"),
        ({"destination": "nobody"}, PLAIN, "address"),
        ({"destination": "a"}, PLAIN, "address"),
        ({}, plain(broadcast=False), "address"),
        ({"acknowledge": True}, plain(acknowledges=True), "address"),
        ({"destination": "b", "acknowledge": True}, PLAIN, "error"),
    ],
)
def test_refusals(request_of: dict, profile, reason: str) -> None:
    """What the modem cannot do is refused with the reason, in the log and to the craft, and nothing is heard of it."""
    water = AcousticWater(PAIR, profile)
    water.send("a", 1.0, **request_of)
    log = water.run()
    assert [(line.kind, line.reason) for line in log] == [("refused", reason)]
    assert [event for *_, event in water.events()] == [TxEvent(0, "FAILED", reason)]


def test_busy_until_turned_around() -> None:
    """A modem is busy until the end of its transmission and its turnaround, and deaf as long; not a nanosecond more."""
    water = AcousticWater(PAIR, plain(turnaround_s=0.5))
    for t_s in (0.0, 0.9, 1.499_999_999, 1.5):
        water.send("a", t_s)
    for t_s in (2.499_999_999, 6.0):  # there at 2.999999999 and 6.5 s; a is deaf until 3.0 s
        water.send("b", t_s)
    log = water.run()
    kinds = [(line.seq, line.kind, line.reason) for line in log if line.source == "a" and not line.destination]
    assert kinds == [(0, "started", ""), (1, "refused", "busy"), (2, "refused", "busy"), (3, "started", "")]
    assert [fates(log)["b", number, "a"] for number in range(2)] == ["missed_halfduplex", ""]


def test_a_unicast_is_overheard() -> None:
    """What is for one craft is heard by all, and told to that one only."""
    water = AcousticWater(triangle(150.0))
    water.send("a", 0.0, destination="b")
    events, log = water.events(), water.run()
    kinds = {line.destination: line.kind for line in log if line.destination}
    assert kinds == {"b": "delivered", "c": "overheard"}
    assert [who for _, who, event in events if isinstance(event, Received)] == ["b"]


def test_a_request_for_the_past() -> None:
    """A request for a time that is over begins at once."""
    water = AcousticWater(PAIR)
    water.run(5.0)
    water.send("a", 1.0)
    assert [line.t_ns for line in water.run() if line.kind == "started"] == [5 * NS]


# -- acknowledgements ------------------------------------------------------------------------------------------------

ACKNOWLEDGING = plain(acknowledges=True, ranging=Ranging(reply_s=0.25, ping_bytes=1))


def test_acknowledgement() -> None:
    """An acknowledged packet is delivered when its acknowledgement is heard: two delays, two airtimes and the reply."""
    water = AcousticWater(PAIR, ACKNOWLEDGING)
    water.send("a", 0.0, destination="b", acknowledge=True)
    assert told(water, "a") == [(1000, "SENT", ""), (3250, "DELIVERED", "")]


def test_no_acknowledgement() -> None:
    """Without an answer the modem says so once, after it has waited as far as it reaches; a late answer is no event."""
    water = AcousticWater({"a": PAIR["a"], "b": (1e6, 0.0, 0.0)}, ACKNOWLEDGING)
    water.send("a", 0.0, destination="b", acknowledge=True)
    (sent, failed) = told(water, "a")
    assert sent == (1000, "SENT", "")
    assert failed[1:] == ("FAILED", "no_ack")
    # 5000 m there and back at no less than 1400 m/s, the answer and the reply.
    assert failed[0] == pytest.approx(1000 + 2 * 5000 / 1.4 + 1000 + 250, abs=1.0)


@pytest.mark.parametrize("off_s", [1.2, 2.5])
def test_a_modem_that_reboots_while_it_waits(off_s: float) -> None:
    """A modem that reboots while it waits for an acknowledgement fails the request, once; the payload is there."""
    water = AcousticWater(PAIR, ACKNOWLEDGING, LinkConfig(outages=(OutageConfig("a", off_s, off_s + 0.1),)))
    water.send("a", 0.0, destination="b", acknowledge=True)
    assert [words for _, *words in told(water, "a")] == [["SENT", ""], ["FAILED", "no_ack"]]
    assert fates(water.run())["a", 0, "b"] == ""
