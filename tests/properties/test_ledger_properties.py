"""Properties of the ledger: whatever happens in the water, the books balance, and age is the true integral."""

import random
from collections import Counter
from itertools import permutations

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_link.ledger import EDGES_S, Ledger, begun, faults
from grex_link.messages import LinkEvent, LinkLedger
from grex_link.units import NS

TEAM = ("auv1", "auv2", "auv3", "auv4")
MS = NS // 1000
REASONS = ["missed_snr", "missed_busy", "lost_collision", "lost_burst"]
OUTCOMES = ["delivered", "overheard", *REASONS]

#: Start (ms), source, purpose, airtime (ms); and for each receiver: outcome, delay (ms).
TRANSMISSION = st.tuples(
    st.integers(0, 100_000),
    st.integers(0, 3),
    st.sampled_from(["data", "data", "data", "ping", "answer", "ack", "land", "refused"]),
    st.integers(1, 3000),
    st.lists(st.tuples(st.sampled_from(OUTCOMES), st.integers(0, 60_000)), min_size=3, max_size=3),
)
TRAFFIC = st.lists(TRANSMISSION, max_size=30)


def lines(traffic) -> list[LinkEvent]:
    """Write the log of some traffic, in the order of time; starts come before outcomes."""
    log: list[LinkEvent] = []
    for seq, (start_ms, place, purpose, airtime_ms, fates) in enumerate(traffic):
        source, start_ns = TEAM[place], start_ms * MS
        mates = [craft for craft in TEAM if craft != source]
        if purpose == "refused":
            log.append(LinkEvent(start_ns, "refused", source, seq, "", 9, "busy"))
            continue
        linked = mates[: 1 + seq % 2] if purpose == "land" else mates
        asked_by = mates[0] if purpose in {"answer", "ack"} else ""
        log += [
            LinkEvent(start_ns, "started", source, seq, to, 9, "", purpose, asked_by, airtime_ms * MS)
            for to in (linked if purpose == "land" else [""])
        ]
        for mate, (fate, delay_ms) in zip(linked, fates, strict=False):
            kind, reason = ("lost", fate) if fate in REASONS else (fate, "")
            lasting_ns = (airtime_ms + delay_ms) * MS
            log.append(
                LinkEvent(start_ns + lasting_ns, kind, source, seq, mate, 9, reason, purpose, asked_by, lasting_ns)
            )
    return sorted(log, key=lambda line: (line.t_ns, line.kind != "started"))


def ledger_of(log: list[LinkEvent], t_ns: int, team=TEAM) -> LinkLedger:
    """Draw up the ledger of the lines before a time."""
    ledger = Ledger(team)
    for line in log:
        if line.t_ns < t_ns:
            ledger.note(line)
    return ledger.snapshot(t_ns)


@given(TRAFFIC, st.integers(0, 200_000))
def test_the_books_balance_at_any_time(traffic, t_ms: int) -> None:
    """At any time every transmission has one outcome at each receiver or is on its way there, and no more."""
    log = lines(traffic)
    ledger = ledger_of(log, t_ms * MS)
    assert faults(ledger, {}) == []
    landed = Counter((line.source, line.destination, line.kind) for line in log if line.t_ns < t_ms * MS)
    sent = Counter((line.source, line.destination) for line in log if line.t_ns < t_ms * MS and line.kind == "started")
    for path in ledger.paths:
        ends = path.source, path.destination
        assert path.sent == sent[path.source, ""] + sent[ends]
        assert path.delivered == landed[*ends, "delivered"]
        assert path.overheard == landed[*ends, "overheard"]
        assert sum(path.lost.values()) == landed[*ends, "lost"]


@given(TRAFFIC)
def test_every_request_is_begun_once(traffic) -> None:
    """Data, pings, land and refusals are as many as were requested; in the end nothing is on its way."""
    ledger = ledger_of(lines(traffic), 10**15)
    asked = Counter(TEAM[place] for _, place, purpose, _, _ in traffic if purpose not in {"answer", "ack"})
    assert {source.craft: begun(source) for source in ledger.sources} == {craft: asked[craft] for craft in TEAM}
    assert all(path.on_the_way == 0 for path in ledger.paths)
    assert all(source.oldest_on_the_way_s == 0.0 for source in ledger.sources)


@given(TRAFFIC, st.data())
def test_a_lost_or_doubled_line_is_found(traffic, data) -> None:
    """Leaving out a start, or entering an outcome twice, does not go unnoticed; nor does an outcome left out."""
    log = lines(traffic)
    if not log:
        return
    line = data.draw(st.sampled_from(log))
    place = log.index(line)
    if line.kind == "refused":
        return
    left_out = ledger_of([*log[:place], *log[place + 1 :]], 10**15)
    assert faults(left_out, {})
    if line.kind != "started":
        assert faults(ledger_of([*log[:place], line, *log[place:]], 10**15), {})


@given(TRAFFIC, st.lists(st.integers(0, 10**9), max_size=5))
def test_a_ledger_is_the_same_whenever_it_was_looked_at(traffic, looks: list[int]) -> None:
    """Snapshots on the way change nothing in a later one, nor does a trip through a recording."""
    log = lines(traffic)
    watched = Ledger(TEAM)
    for number, line in enumerate(log):
        watched.note(msgspec.json.decode(msgspec.json.encode(line), type=LinkEvent))
        if number in looks or number % 3 == 0:
            watched.snapshot(line.t_ns)
    end_ns = 10**12
    assert watched.snapshot(end_ns) == ledger_of(log, end_ns)
    published = ledger_of(log, end_ns)
    assert msgspec.json.decode(msgspec.json.encode(published), type=LinkLedger) == published
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(published), type=LinkLedger) == published


def sampled_ages(log: list[LinkEvent], source: str, destination: str, times_ns: np.ndarray) -> np.ndarray:
    """Ages at some times by looking through everything that has arrived by then; NaN before there is anything."""
    news = [
        (line.t_ns, line.t_ns - line.lasting_ns)
        for line in log
        if (line.source, line.destination, line.kind) == (source, destination, "delivered")
        and line.purpose in {"data", "land"}
    ]
    ages = np.full(len(times_ns), np.nan)
    for place, t_ns in enumerate(times_ns):
        arrived = [sent_ns for arrival_ns, sent_ns in news if arrival_ns <= t_ns]
        if arrived:
            ages[place] = (t_ns - max(arrived)) / NS
    return ages


@given(st.lists(TRANSMISSION, min_size=1, max_size=12))
def test_age_is_the_integral_of_what_sampling_sees(traffic) -> None:
    """Sampled in the middle of each of many steps, age has the same mean and the same seconds in each bin."""
    log = lines(traffic)
    step_ns, end_ns = 20 * MS, 170 * NS
    times_ns = np.arange(step_ns // 2, end_ns, step_ns)
    ledger = ledger_of(log, end_ns)
    for path in ledger.paths[:4]:
        ages = sampled_ages(log, path.source, path.destination, times_ns)
        heard = ages[~np.isnan(ages)]
        if not len(heard):
            assert path.age_mean_s == -1.0 or sum(path.age_seconds) < 0.02
            continue
        seconds = np.histogram(heard, [0.0, *EDGES_S, np.inf])[0] * step_ns / NS
        # A step may straddle a jump or an edge: a step for each tooth and edge at most.
        assert np.abs(seconds - path.age_seconds).max() <= step_ns / NS * (len(log) + 2)
        assert sum(path.age_seconds) == pytest.approx(sum(seconds), abs=step_ns / NS)
        assert path.age_mean_s == pytest.approx(heard.mean(), abs=0.05 + 2.0 * step_ns / NS)


def cycles(p: float, count: int, airtime_s: int = 10, cycle_s: int = 30) -> LinkLedger:
    """Three craft in turn, ten seconds each, over and over; each reception succeeds with a probability."""
    draw = random.Random(4)
    team = TEAM[:3]
    ledger = Ledger(team)
    for n in range(count):
        for place, source in enumerate(team):
            start_ns = (n * cycle_s + place * airtime_s) * NS
            ledger.note(LinkEvent(start_ns, "started", source, n, "", 15, lasting_ns=airtime_s * NS))
            for mate in team:
                if mate != source:
                    kind = "delivered" if draw.random() < p else "lost"
                    end_ns = start_ns + airtime_s * NS
                    ledger.note(LinkEvent(end_ns, kind, source, n, mate, 15, lasting_ns=airtime_s * NS))
    return ledger.snapshot((count * cycle_s + airtime_s) * NS)


def test_age_of_the_paper_s_cycle() -> None:
    """Ten seconds a message, thirty a cycle, nothing lost: exactly T + C/2 = 25 s over whole cycles."""
    for path in cycles(1.0, 400).paths:
        assert path.age_mean_s == pytest.approx(25.0, abs=0.02)
        assert path.age_seconds[:7] == [0.0] * 7
    one = Ledger(TEAM[:2])
    for n in range(4):
        one.note(LinkEvent(n * 30 * NS, "started", "auv1", n, "", 15, lasting_ns=10 * NS))
        one.note(LinkEvent((n * 30 + 10) * NS, "delivered", "auv1", n, "auv2", 15, lasting_ns=10 * NS))
    assert one.snapshot(130 * NS).paths[0].age_mean_s == 25.0


def test_law_of_age_under_losses() -> None:
    """With success p the mean age is T + C(1/p - 1/2): 32.5 s at 0.8, four standard errors about 24 000 receptions."""
    p, count = 0.8, 4000
    ledger = cycles(p, count)
    assert 6 * count >= 20_000
    ages = [path.age_mean_s for path in ledger.paths]
    # Mean over time of a renewal reward: variance by the delta method, X geometric, area 10X·30 + (30X)²/2.
    x = np.arange(1, 200)
    pmf = p * (1 - p) ** (x - 1)
    duration, area = 30.0 * x, 300.0 * x + 450.0 * x**2
    residual = area - 32.5 * duration
    error = np.sqrt((pmf * residual**2).sum() * p * count * 6) / (30.0 * count * 6)
    assert (pmf * area).sum() / (pmf * duration).sum() == pytest.approx(32.5)
    assert abs(np.mean(ages) - 32.5) < 4.0 * error
    assert error < 0.25


def test_every_pair_once() -> None:
    """A ledger has each ordered pair once, whatever the size of the team."""
    for size in range(1, 5):
        paths = Ledger(TEAM[:size]).snapshot(0).paths
        assert [(path.source, path.destination) for path in paths] == list(permutations(TEAM[:size], 2))
