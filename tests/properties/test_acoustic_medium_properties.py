"""Properties of the acoustic medium: nothing is early, nobody speaks twice at once, the books are complete."""

import math
from collections import Counter
from itertools import pairwise

import msgspec
from acoustic_water import FOREVER_NS, PLAIN, AcousticWater, plain
from hypothesis import given
from hypothesis import strategies as st

from grex_link.acoustic_medium import AcousticMedium
from grex_link.link_config import BurstConfig, JammerConfig, LinkConfig, OutageConfig, ShadowingConfig
from grex_link.messages import LinkEvent, RangeRequest, Request, Transmit
from grex_link.profile import ErrorTable, ModemProfile, Ranging
from grex_link.units import NS

TEAM = ["a", "b", "c", "d"]
#: Two in one place, one half a second away, one that only just hears them.
PLACES = {"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 0.0), "c": (0.0, 750.0, 30.0), "d": (3000.0, -400.0, 10.0)}
DELAY_NS = {
    (source, receiver): round(math.dist(PLACES[source], PLACES[receiver]) / 1500.0 * NS)
    for source in TEAM
    for receiver in TEAM
}

#: A modem with everything that takes time.
BUSY_MODEM = plain(
    airtime_per_byte_s=0.05,
    acknowledges=True,
    transmit_latency_s=0.1,
    decode_latency_s=0.2,
    turnaround_s=0.3,
    reception=ErrorTable((0.0, 30.0), (1.0, 0.0)),
    ranging=Ranging(two_way=True, one_way=True, sigma_m=0.5, reply_s=0.4, ping_bytes=2),
)
PROFILES = st.sampled_from([PLAIN, BUSY_MODEM])

CALM = LinkConfig()
ROUGH = LinkConfig(
    loss=0.1,
    burst=BurstConfig(loss=0.2, mean_length_s=3.0),
    shadowing=ShadowingConfig(sigma_db=6.0),
    jammers=(JammerConfig((0.0, 700.0, 0.0), 170.0, 4.0, 9.0),),
)
OUTAGES = msgspec.structs.replace(ROUGH, outages=(OutageConfig("b", 3.0, 6.5), OutageConfig("c", 5.0, 7.0)))
LINKS = st.sampled_from([CALM, ROUGH, OUTAGES])

#: (milliseconds since the request before, who, to whom, payload bytes; -1 for a range); half of the gaps tie.
WISHES = st.lists(
    st.tuples(
        st.sampled_from([0, 0, 500, 1000]) | st.integers(0, 3000),
        st.sampled_from(TEAM),
        st.sampled_from(["", "", *TEAM]),
        st.sampled_from([-1, -1, 0, 1, 2, 4, 8, 8, 70]),
        st.booleans(),
    ),
    max_size=20,
)

Wanted = list[tuple[str, Request]]


def wanted(wishes) -> Wanted:
    t_ns, numbers, made = 0, Counter(), []
    for gap_ms, source, destination, size, acknowledge in wishes:
        t_ns += gap_ms * NS // 1000
        number = numbers[source]
        numbers[source] += 1
        if size < 0:
            made.append((source, RangeRequest(number, t_ns, destination)))
        else:
            made.append((source, Transmit(number, t_ns, bytes(size), destination, acknowledge)))
    return made


def medium_of(profile: ModemProfile, link: LinkConfig, requests: Wanted = ()) -> AcousticMedium:
    medium = AcousticWater(PLACES, profile, link).medium
    for source, request in requests:
        medium.request(source, request, request.t_ns)
    return medium


def everything(medium: AcousticMedium) -> bytes:
    medium.advance(FOREVER_NS)
    return msgspec.msgpack.encode((medium.log(FOREVER_NS), medium.events(FOREVER_NS)))


def log_of(profile: ModemProfile, link: LinkConfig, requests: Wanted) -> list[LinkEvent]:
    medium = medium_of(profile, link, requests)
    medium.advance(FOREVER_NS)
    return medium.log(FOREVER_NS)


def which(line: LinkEvent) -> tuple[str, int, str, str]:
    return line.source, line.seq, line.purpose, line.asked_by


@given(PROFILES, LINKS, WISHES)
def test_every_transmission_has_one_outcome_at_each_receiver(profile: ModemProfile, link: LinkConfig, wishes) -> None:
    """Each request starts or is refused; whatever starts, answers included, has one outcome at each of the others."""
    requests = wanted(wishes)
    log = log_of(profile, link, requests)
    own = Counter((line.source, line.seq) for line in log if line.kind in {"started", "refused"} and not line.asked_by)
    assert own == Counter((source, request.seq) for source, request in requests)
    started = Counter(which(line) for line in log if line.kind == "started")
    assert all(times == 1 for times in started.values())
    outcomes = Counter((*which(line), line.destination) for line in log if line.kind not in {"started", "refused"})
    assert outcomes == Counter((*packet, mate) for packet in started for mate in TEAM if mate != packet[0])


@given(PROFILES, LINKS, WISHES)
def test_nothing_arrives_early(profile: ModemProfile, link: LinkConfig, wishes) -> None:
    """What is heard takes exactly delay, airtime and decoding; what is missed is missed when it arrives, not before."""
    log = log_of(profile, link, wanted(wishes))
    begun = {which(line): line for line in log if line.kind == "started"}
    for line in log:
        if line.kind in {"started", "refused"}:
            continue
        start = begun[which(line)]
        arrives_ns = start.t_ns + DELAY_NS[line.source, line.destination]
        ends_ns = arrives_ns + start.lasting_ns
        if line.kind in {"delivered", "overheard"}:
            assert line.t_ns == ends_ns + round(profile.decode_latency_s * NS)
            assert line.lasting_ns == line.t_ns - start.t_ns
        elif line.reason.startswith(("missed", "out")):
            assert line.t_ns == arrives_ns
        elif line.reason.startswith("aborted"):
            # A modem that goes off while it decodes notices when the payload does not come out.
            decoded = line.reason == "aborted_off" and line.t_ns == ends_ns + round(profile.decode_latency_s * NS)
            assert decoded or arrives_ns <= line.t_ns < ends_ns
        elif line.reason == "lost_cut":
            assert arrives_ns <= line.t_ns < ends_ns
        else:
            assert line.t_ns == ends_ns


@given(PROFILES, LINKS, WISHES)
def test_no_event_before_its_cause(profile: ModemProfile, link: LinkConfig, wishes) -> None:
    """What was taken before a request is made stays complete: a request changes nothing before its own time."""
    requests = wanted(wishes)
    medium = medium_of(profile, link)
    events, log = [], []
    for source, request in requests:
        medium.advance(request.t_ns)
        events += medium.events(request.t_ns)
        log += medium.log(request.t_ns)
        medium.request(source, request, request.t_ns)
        assert medium.next_event_ns() >= request.t_ns
    medium.advance(FOREVER_NS)
    events += medium.events(FOREVER_NS)
    log += medium.log(FOREVER_NS)
    assert msgspec.msgpack.encode((log, events)) == everything(medium_of(profile, link, requests))
    times = [t_ns for t_ns, *_ in events]
    assert times == sorted(times)
    times = [line.t_ns for line in log]
    assert times == sorted(times)


@given(PROFILES, LINKS, WISHES, st.integers(0, 20))
def test_causality(profile: ModemProfile, link: LinkConfig, wishes, kept: int) -> None:
    """Later requests never change earlier events."""
    requests = wanted(wishes)
    if kept >= len(requests):
        return
    until_ns = requests[kept][1].t_ns
    books = []
    for some in (requests, requests[:kept]):
        medium = medium_of(profile, link, some)
        medium.advance(until_ns)
        books.append((medium.log(until_ns), medium.events(until_ns)))
    assert books[0] == books[1]


@given(PROFILES, st.sampled_from([CALM, ROUGH]), WISHES)
def test_nobody_makes_two_sounds_at_once(profile: ModemProfile, link: LinkConfig, wishes) -> None:
    """Two sounds of one node, answers and acknowledgements included, never overlap, and turnaround lies between."""
    log = log_of(profile, link, wanted(wishes))
    for craft in TEAM:
        sounds = sorted((line.t_ns, line.lasting_ns) for line in log if line.kind == "started" and line.source == craft)
        rest_ns = round(profile.turnaround_s * NS)
        assert all(start + lasting + rest_ns <= later for (start, lasting), (later, _) in pairwise(sounds))


@given(PROFILES, LINKS, WISHES, st.randoms(use_true_random=False))
def test_order_of_the_requests(profile: ModemProfile, link: LinkConfig, wishes, chance) -> None:
    """Requests in any order give the byte-identical log and events."""
    requests = wanted(wishes)
    shuffled = list(requests)
    chance.shuffle(shuffled)
    assert everything(medium_of(profile, link, shuffled)) == everything(medium_of(profile, link, requests))


@given(PROFILES, LINKS, WISHES, st.lists(st.integers(0, 3000), max_size=30))
def test_portions(profile: ModemProfile, link: LinkConfig, wishes, portions_ms: list[int]) -> None:
    """Worked through in portions of any length, log and events are byte for byte the same."""
    requests = wanted(wishes)
    medium = medium_of(profile, link, requests)
    events, log, t_ns = [], [], 0
    for portion_ms in portions_ms:
        t_ns += portion_ms * NS // 1000
        medium.advance(t_ns)
        events += medium.events(t_ns)
        log += medium.log(t_ns)
        assert medium.next_event_ns() is None or medium.next_event_ns() >= t_ns
    medium.advance(FOREVER_NS)
    log += medium.log(FOREVER_NS)
    events += medium.events(FOREVER_NS)
    assert msgspec.msgpack.encode((log, events)) == everything(medium_of(profile, link, requests))


@given(PROFILES, WISHES, st.integers(0, 10), st.lists(st.integers(0, 30), min_size=1, max_size=5))
def test_draws_are_keyed(profile: ModemProfile, wishes, quiet_s: int, extra: list[int]) -> None:
    """Packets that are sent long after change nothing for those before, and long before nothing for those after."""
    link = LinkConfig(loss=0.5, burst=BurstConfig(loss=0.3, mean_length_s=3.0))
    requests = wanted(wishes)
    shift_ns = (1000 + quiet_s) * NS
    late = [(source, msgspec.structs.replace(request, t_ns=request.t_ns + shift_ns)) for source, request in requests]
    # Numbers from 1000 on, which none of the others has.
    early = [(TEAM[number % 4], Transmit(1000 + number, 20 * t_s * NS, b"")) for number, t_s in enumerate(extra)]
    alone, among = log_of(profile, link, late), log_of(profile, link, late + early)
    assert alone == [line for line in among if line.seq < 1000]
