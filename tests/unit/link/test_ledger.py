"""The books of the water: counts, latency, the saw of age, and what the identities find."""

import msgspec
import pytest

from grex_link.ledger import BINS, EDGES_S, FORGOTTEN_S, Ledger, begun, faults
from grex_link.messages import LinkEvent, LinkLedger, PathLedger, PortLedger
from grex_link.units import NS

TEAM = ("auv1", "auv2", "auv3")


def started(t_s, source="auv1", seq=0, *, purpose="data", asked_by="", to="", lasting_s=1.0, size=15):
    """Begin a transmission."""
    t_ns = round(t_s * NS)
    return LinkEvent(t_ns, "started", source, seq, to, size, "", purpose, asked_by, round(lasting_s * NS))


def delivered(t_s, latency_s, to="auv2", source="auv1", seq=0, *, purpose="data", asked_by=""):
    """Deliver what was sent a latency ago."""
    t_ns = round(t_s * NS)
    return LinkEvent(t_ns, "delivered", source, seq, to, 15, "", purpose, asked_by, round(latency_s * NS))


def lost(t_s, reason, to="auv2", source="auv1", seq=0, *, purpose="data"):
    """Lose it."""
    return LinkEvent(round(t_s * NS), "lost", source, seq, to, 15, reason, purpose)


def book(*events, t_s=100.0, team=TEAM) -> LinkLedger:
    """Draw up the ledger of some lines."""
    ledger = Ledger(team)
    for event in events:
        ledger.note(event)
    return ledger.snapshot(round(t_s * NS))


def path(ledger, name="auv1>auv2") -> PathLedger:
    """Find one directed link."""
    (found,) = [path for path in ledger.paths if f"{path.source}>{path.destination}" == name]
    return found


def at(*bins_and_values, zero=0):
    """Build a histogram that is zero but for some bins."""
    values = [zero] * BINS
    for place, value in bins_and_values:
        values[place] = value
    return values


def port(**changes) -> PortLedger:
    """Build a port at which five payloads were requested and started, with changes."""
    plain = PortLedger(0, 5, {}, 0, 0, 0, 5, {}, 0, 0, 0, 0, 0, 0)
    return msgspec.structs.replace(plain, **changes)


def test_edges() -> None:
    """The edges of the bins double from a tenth of a second to several minutes."""
    assert EDGES_S[:4] == (0.1, 0.2, 0.4, 0.8)
    assert (EDGES_S[-1], BINS) == (409.6, 14)


def test_every_pair_is_a_link() -> None:
    """Every ordered pair of craft has its row, in the order of the team, even if nothing was ever sent."""
    ledger = book(t_s=60.0)
    assert ledger.t_ns == 60 * NS
    assert [source.craft for source in ledger.sources] == list(TEAM)
    assert [(path.source, path.destination) for path in ledger.paths] == [
        ("auv1", "auv2"),
        ("auv1", "auv3"),
        ("auv2", "auv1"),
        ("auv2", "auv3"),
        ("auv3", "auv1"),
        ("auv3", "auv2"),
    ]
    silent = path(ledger)
    assert (silent.sent, silent.latency_mean_s, silent.age_mean_s) == (0, -1.0, -1.0)
    assert sum(silent.latency_counts) == sum(silent.age_seconds) == 0


def test_one_transmission() -> None:
    """A transmission counts for its source, and until they have happened its outcomes are on the way."""
    ledger = book(started(10.0, lasting_s=0.5, size=20), delivered(10.8, 0.8), t_s=11.0)
    source = ledger.sources[0]
    assert (source.started, source.purposes, source.airtime_s, source.bytes_sent) == (1, {"data": 1}, 0.5, 20)
    assert source.oldest_on_the_way_s == 1.0
    heard, unheard, other = path(ledger), path(ledger, "auv1>auv3"), path(ledger, "auv2>auv1")
    assert (heard.sent, heard.delivered, heard.on_the_way) == (1, 1, 0)
    assert (unheard.sent, unheard.delivered, unheard.on_the_way) == (1, 0, 1)
    assert (other.sent, other.on_the_way) == (0, 0)


def test_what_has_landed_everywhere_is_no_longer_on_the_way() -> None:
    """With its last outcome a transmission is over."""
    ledger = book(started(10.0), delivered(11.0, 1.0), lost(12.0, "missed_snr", "auv3"))
    assert ledger.sources[0].oldest_on_the_way_s == 0.0
    assert all(path.on_the_way == 0 for path in ledger.paths)


def test_losses_and_refusals_by_reason() -> None:
    """Losses are counted by link and reason, refusals by craft and reason; reasons come in the alphabet's order."""
    events = [started(t_s, seq=t_s) for t_s in range(4)]
    reasons = ["missed_snr", "lost_burst", "missed_snr", "lost_collision"]
    events += [lost(10.0, reason, seq=seq) for seq, reason in enumerate(reasons)]
    events += [
        LinkEvent(0, "refused", "auv2", seq, "", 9, reason) for seq, reason in enumerate(["size", "busy", "size"])
    ]
    ledger = book(*events)
    assert list(path(ledger).lost.items()) == [("lost_burst", 1), ("lost_collision", 1), ("missed_snr", 2)]
    assert path(ledger, "auv1>auv3").lost == {}
    assert list(ledger.sources[1].refused.items()) == [("busy", 1), ("size", 2)]
    assert (ledger.sources[1].started, begun(ledger.sources[1])) == (0, 3)


def test_answers_are_transmissions_but_no_requests() -> None:
    """A modem's own answer has airtime and outcomes, is told apart by who asked, and is no request of its craft."""
    answers = [started(5.0, "auv2", purpose="answer", asked_by=mate, lasting_s=0.25) for mate in ("auv1", "auv3")]
    first = delivered(6.0, 1.0, "auv1", "auv2", purpose="answer", asked_by="auv1")
    ledger = book(*answers, first)
    source = ledger.sources[1]
    assert (source.started, source.purposes, source.airtime_s, begun(source)) == (2, {"answer": 2}, 0.5, 0)
    back = path(ledger, "auv2>auv1")
    assert (back.sent, back.delivered, back.on_the_way) == (2, 1, 1)
    assert (back.latency_mean_s, back.age_mean_s) == (1.0, -1.0)


def test_overheard() -> None:
    """What was for somebody else is no loss, no delivery, and no news."""
    overheard = LinkEvent(11 * NS, "overheard", "auv1", 0, "auv3", 15)
    ledger = book(started(10.0), delivered(11.0, 1.0), overheard)
    heard = path(ledger, "auv1>auv3")
    assert (heard.overheard, heard.delivered, heard.on_the_way, heard.age_mean_s) == (1, 0, 0, -1.0)
    assert faults(ledger, {}) == []


def test_latency() -> None:
    """Latencies are averaged and sorted into bins; one that is an edge lies above it."""
    latencies = [0.05, 0.1, 0.399, 500.0]
    events = [started(t_s, seq=t_s) for t_s in range(4)]
    events += [delivered(600.0 + n, latency_s, seq=n) for n, latency_s in enumerate(latencies)]
    link = path(book(*events, t_s=700.0))
    assert link.latency_counts == at((0, 1), (1, 1), (2, 1), (13, 1))
    assert link.latency_mean_s == pytest.approx(sum(latencies) / 4)


def test_age_begins_with_the_first_delivery() -> None:
    """From its delivery a datagram ages: one second old at 11 s, five at 15 s, through the bins on the way."""
    link = path(book(started(10.0), delivered(11.0, 1.0), t_s=15.0))
    # Edges 1.6 and 3.2: 0.6 s in [0.8, 1.6), 1.6 s in [1.6, 3.2), 1.8 s in [3.2, 6.4).
    assert link.age_seconds == at((4, 0.6), (5, 1.6), (6, 1.8), zero=0.0)
    assert link.age_mean_s == 3.0


def test_age_falls_to_the_latency_of_what_is_newer() -> None:
    """The saw of two deliveries, by hand: 1 → 11 in ten seconds, then 2 → 6 in four."""
    events = [started(10.0), delivered(11.0, 1.0), started(19.0, seq=1), delivered(21.0, 2.0, seq=1)]
    link = path(book(*events, t_s=25.0))
    assert link.age_mean_s == pytest.approx((10 * 6.0 + 4 * 4.0) / 14)
    assert sum(link.age_seconds) == pytest.approx(14.0)
    assert link.age_seconds[7] == pytest.approx(11.0 - 6.4)


def test_what_is_older_and_comes_later_is_no_news() -> None:
    """A datagram that was sent before the newest one, or is the same again, leaves the age alone."""
    events = [started(0.0), started(10.0, seq=1), delivered(11.0, 1.0, seq=1)]
    alone = path(book(*events, t_s=30.0))
    late = path(book(*events, delivered(20.0, 20.0, seq=0), t_s=30.0))
    assert late.age_seconds == alone.age_seconds
    assert (late.age_mean_s, late.delivered) == (alone.age_mean_s, 2)


def test_age_beyond_the_last_edge() -> None:
    """What is older than the last edge is in the open bin."""
    link = path(book(started(0.0), delivered(409.6, 409.6), t_s=1409.6))
    assert link.age_seconds == at((13, 1000.0), zero=0.0)
    assert link.age_mean_s == 909.6


def test_only_states_are_news() -> None:
    """Pings, answers and acknowledgements are deliveries, but carry no state; what comes by land does."""
    for purpose, news in (("data", True), ("land", True), ("ping", False), ("answer", False), ("ack", False)):
        link = path(book(started(0.0, purpose=purpose, to="auv2" if purpose == "land" else ""),
                         delivered(1.0, 1.0, purpose=purpose)))  # fmt: skip
        assert link.delivered == 1
        assert (link.age_mean_s > 0.0) is news


def test_land_goes_to_those_it_is_linked_with() -> None:
    """Over land a transmission has an outcome at its destination only, no airtime under water, and one request."""
    events = [started(1.0, purpose="land", to=mate, lasting_s=0.1) for mate in ("auv2", "auv3")]
    events += [started(5.0, seq=1, purpose="land", to="auv2"), delivered(1.2, 0.2, purpose="land")]
    ledger = book(*events)
    source = ledger.sources[0]
    assert (source.started, source.airtime_s, source.bytes_sent) == (0, 0.0, 0)
    assert (source.by_land, source.land_requests, begun(source)) == (3, 2, 2)
    assert [(p.sent, p.on_the_way) for p in ledger.paths[:2]] == [(2, 1), (1, 1)]
    assert faults(ledger, {}) == []


def test_land_and_water_of_the_same_number() -> None:
    """A request number may be on the water and over land at once: their outcomes are not mixed up."""
    events = [started(1.0), started(1.0, purpose="land", to="auv2"), lost(2.0, "lost_land", purpose="land")]
    ledger = book(*events)
    assert (path(ledger).sent, path(ledger).on_the_way, path(ledger, "auv1>auv3").on_the_way) == (2, 1, 1)


def test_looking_changes_nothing() -> None:
    """However often the ledger is drawn up on the way, the last one is the same."""
    events = [started(0.0), delivered(1.1, 1.1), started(7.3, seq=1), delivered(9.9, 2.6, seq=1)]
    ledger = Ledger(TEAM)
    for event in events:
        ledger.note(event)
        ledger.snapshot(event.t_ns)
    assert ledger.snapshot(50 * NS) == book(*events, t_s=50.0)


def test_one_craft_alone() -> None:
    """A craft without a team transmits to nobody, and nothing is on its way."""
    ledger = book(started(0.0), team=["auv1"])
    assert ledger.sources[0].started == 1
    assert (ledger.paths, ledger.sources[0].oldest_on_the_way_s, faults(ledger, {})) == ([], 0.0, [])


def test_stranger() -> None:
    """A line of a craft that is not of the team is not silently counted."""
    with pytest.raises(KeyError):
        book(started(0.0, "auv9"))


def test_two_outcomes_at_one_receiver() -> None:
    """A transmission that is delivered twice, or delivered and lost, is found."""
    for second in (delivered(12.0, 2.0), lost(12.0, "lost_noise")):
        (fault,) = faults(book(started(10.0), delivered(11.0, 1.0), second), {})
        assert fault.startswith("auv1>auv2: sent 1, but ")


def test_outcome_of_nothing() -> None:
    """An outcome of what was never sent is found."""
    assert faults(book(lost(1.0, "lost_noise")), {}) == [
        "auv1>auv2: sent 0, but 0 delivered, 0 overheard, 1 lost and 0 on the way"
    ]


def test_outcome_of_another_transmission() -> None:
    """An outcome under a wrong number does not stand in for the one that is missing."""
    assert len(faults(book(started(0.0, seq=4), delivered(1.0, 1.0, seq=5)), {})) == 1


def test_an_outcome_that_never_comes() -> None:
    """A transmission that is on its way for longer than anything can be has been forgotten."""
    events = [started(0.0), delivered(1.0, 1.0)]
    assert faults(book(*events, t_s=FORGOTTEN_S), {}) == []
    assert faults(book(*events, t_s=FORGOTTEN_S + 1), {}) == ["auv1: a transmission has had no outcome for 601 s"]


def test_a_ledger_that_does_not_agree_with_itself() -> None:
    """Latencies that are not as many as deliveries, and land lines that are on no link, are found."""
    ledger = book(started(0.0), delivered(1.0, 1.0), lost(1.0, "lost_noise", "auv3"))
    paths = [msgspec.structs.replace(ledger.paths[0], latency_counts=at((3, 2))), *ledger.paths[1:]]
    broken = msgspec.structs.replace(ledger, paths=paths)
    assert faults(broken, {}) == ["auv1>auv2: 1 delivered, 2 latencies"]
    sources = [msgspec.structs.replace(ledger.sources[0], by_land=4), *ledger.sources[1:]]
    broken = msgspec.structs.replace(ledger, sources=sources)
    assert faults(broken, {}) == ["auv1: sent 4 by land, 0 on its links"]


@pytest.mark.parametrize("fate", ["superseded", "expired", "queued", "refused"])
def test_fates_of_what_was_requested(fate: str) -> None:
    """At a port every request is refused, superseded, expired, queued or started, and nothing else."""
    nothing = book(*(started(t_s, seq=t_s) for t_s in range(5)))
    amount = {"size": 1, "overflow": 1} if fate == "refused" else 2
    assert faults(nothing, {"auv1": port(requested=7, **{fate: amount})}) == []
    (fault,) = faults(nothing, {"auv1": port(**{fate: amount})})
    assert fault.startswith("auv1: requested 5, but ")


def test_port_and_modem() -> None:
    """What a port has started its modem has begun or refused, but for what it has in hand."""
    refused = LinkEvent(9 * NS, "refused", "auv1", 9, "", 15, "busy")
    ping = started(8.0, seq=8, purpose="ping")
    land = [started(7.0, seq=7, purpose="land", to=mate) for mate in ("auv2", "auv3")]
    answer = started(9.5, seq=0, purpose="answer", asked_by="auv3")
    ledger = book(started(0.0), started(1.0, seq=1), *land, ping, refused, answer)
    assert faults(ledger, {"auv1": port()}) == []
    assert faults(ledger, {"auv1": port(requested=6, started=6)}) == []
    assert faults(ledger, {"auv1": port(requested=7, started=7)}, in_hand=2) == []
    assert faults(ledger, {"auv1": port(requested=7, started=7)}) == [
        "auv1: its port has started 7, its modem has begun 5"
    ]
    assert faults(ledger, {"auv1": port(requested=4, started=4)}) == [
        "auv1: its port has started 4, its modem has begun 5"
    ]


def test_fragments() -> None:
    """Where payloads go in fragments a modem begins more than its port starts, and never less."""
    ledger = book(*(started(t_s, seq=t_s) for t_s in range(5)))
    fragmenting = {"auv1": port(requested=2, started=2), "auv2": port(requested=0, started=0, reassembled=1)}
    assert faults(ledger, fragmenting) == []
    fragmenting["auv1"] = port(requested=9, started=9)
    assert faults(ledger, fragmenting) == ["auv1: its port has started 9, its modem has begun 5"]


def test_a_modem_that_is_no_emulated_one() -> None:
    """A port whose craft the link does not know is only compared with itself."""
    assert faults(book(), {"boat": port()}) == []
