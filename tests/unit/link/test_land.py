"""Cable and radio beside the water."""

import math

from acoustic_water import FOREVER_NS, NS, AcousticWater, triangle

from grex_link.land import WaterAndLand
from grex_link.link_config import LandConfig, LinkConfig
from grex_link.messages import RangeRequest, Received, Transmit, TxEvent

MANY = 20_000


def on_land(*links: LandConfig) -> tuple[WaterAndLand, AcousticWater]:
    water = AcousticWater(triangle(750.0), link=LinkConfig(land=links))
    return WaterAndLand(water.scenario, water.medium), water


def by_land(number: int, t_s: float, size: int = 10) -> Transmit:
    return Transmit(number, round(t_s * NS), bytes(size), by_land=True)


def test_a_land_link_is_quick() -> None:
    """By land a payload is there after latency and length over rate, both ways, while the water knows nothing of it."""
    medium, _ = on_land(LandConfig(("a", "b"), latency_s=0.05, rate_bps=1000.0))
    medium.request("a", by_land(0, 1.0), NS)
    medium.request("b", by_land(0, 2.0), 2 * NS)
    medium.advance(FOREVER_NS)
    events = [(t_ns, who, type(event)) for t_ns, who, event in medium.events(FOREVER_NS)]
    assert events == [
        (1_000_000_000, "a", TxEvent),
        (1_130_000_000, "b", Received),
        (2_000_000_000, "b", TxEvent),
        (2_130_000_000, "a", Received),
    ]
    assert {(line.kind, line.purpose) for line in medium.log(FOREVER_NS)} == {
        ("started", "land"),
        ("delivered", "land"),
    }


def test_a_land_link_carries_to_whom_it_is_addressed() -> None:
    """What is for one of two linked craft comes to that one, with the address; for somebody not linked it fails."""
    medium, _ = on_land(LandConfig(("a", "b"), latency_s=0.05), LandConfig(("a", "c"), latency_s=0.05))
    medium.request("a", Transmit(0, NS, b"x", "c", by_land=True), NS)
    medium.request("b", Transmit(0, NS, b"x", "c", by_land=True), NS)
    medium.advance(FOREVER_NS)
    events = [(who, event) for _, who, event in medium.events(FOREVER_NS)]
    assert events == [
        ("a", TxEvent(0, "SENT")),
        ("b", TxEvent(0, "FAILED", "address")),
        ("c", Received("a", b"x", "c")),
    ]


def test_who_has_no_land_link() -> None:
    """Who is linked with nobody is told that there is no such address."""
    medium, _ = on_land(LandConfig(("a", "b"), latency_s=0.05))
    medium.request("c", by_land(0, 1.0), NS)
    medium.advance(FOREVER_NS)
    assert [(who, event) for _, who, event in medium.events(FOREVER_NS)] == [("c", TxEvent(0, "FAILED", "address"))]
    assert [(line.kind, line.source, line.reason, line.purpose) for line in medium.log(FOREVER_NS)] == [
        ("refused", "c", "address", "land")
    ]


def test_land_links_lose_their_share() -> None:
    """Of 20 000 payloads by land the share asked for is lost, and what comes through is in the order it was sent."""
    medium, _ = on_land(LandConfig(("a", "b"), latency_s=0.05, loss=0.2))
    for number in range(MANY):
        medium.request("a", by_land(number, 0.1 * number), round(0.1 * number * NS))
    medium.advance(FOREVER_NS)
    arrived = [t_ns for t_ns, who, _ in medium.events(FOREVER_NS) if who == "b"]
    assert arrived == sorted(arrived)
    assert abs(len(arrived) / MANY - 0.8) < 4.0 * math.sqrt(0.16 / MANY)


def test_water_beside_land() -> None:
    """What does not go by land goes through the water, and events of both come in the order of time."""
    medium, _ = on_land(LandConfig(("a", "b"), latency_s=0.05))
    medium.request("a", Transmit(0, 0, b"wet"), 0)
    medium.request("a", by_land(1, 0.5), NS // 2)
    medium.request("c", RangeRequest(0, 5 * NS, "a"), 5 * NS)
    medium.advance(FOREVER_NS)
    events = medium.events(FOREVER_NS)
    times = [t_ns for t_ns, *_ in events]
    assert times == sorted(times)
    payloads = [(who, event.payload) for _, who, event in events if isinstance(event, Received)]
    assert payloads == [("b", bytes(10)), ("b", b"wet"), ("c", b"wet")]
