"""The link as a node: complete before it acts, the same whatever the order of arrival, and on time at live paces."""

import random
from collections.abc import Sequence
from itertools import accumulate

import pytest

from grex_link import clock
from grex_link.config import Scenario
from grex_link.emulator import Emulator
from grex_link.errors import FaultError, GrexError
from grex_link.ledger import Ledger, faults
from grex_link.messages import (
    Advance,
    Clock,
    LinkLedger,
    LinkReport,
    ModemEvent,
    Presence,
    Received,
    Step,
    Transmit,
    TxEvent,
)
from grex_link.units import NS

TEAM = ("auv1", "auv2", "auv3")
TICKS = 120

#: Requests of each tick: mostly in the own slots, some that meet a busy water, some in the same instant.
REQUESTS = {0: [0], 4: [1], 10: [1], 20: [2, 0], 30: [0, 1, 2], 41: [0], 42: [1], 50: [1, 1], 70: [2], 80: [0], 95: [1]}


def traffic(truth_at) -> tuple[list[tuple[str, Transmit]], list[Step]]:
    """Every transmission of the run, and its steps with the counts."""
    sent: list[tuple[str, Transmit]] = []
    numbers = [0, 0, 0]
    steps = []
    for tick in range(TICKS):
        for half, place in enumerate(REQUESTS.get(tick, [])):
            t_ns = tick * NS + (half % 2) * NS // 2
            sent.append((TEAM[place], Transmit(numbers[place], t_ns, bytes([place, tick]))))
            numbers[place] += 1
        steps.append(Step(truth_at(tick), list(numbers)))
    return sent, steps


def windows(steps: Sequence[Step], lengths: Sequence[int]) -> list[Advance]:
    ends = list(accumulate(lengths))
    return [Advance(list(steps[end - length : end])) for end, length in zip(ends, lengths, strict=True)]


def feed(scenario: Scenario, outlet, arrivals) -> Emulator:
    emulator = Emulator(scenario, outlet)
    for topic, craft, message in arrivals:
        emulator.handle(topic, craft, message)
    return emulator


def story(outlet) -> dict:
    """What has become of a run, whatever reports it came in."""
    reports = outlet.of("report")
    return {
        "log": [line for report in reports for line in report.log],
        "announced": [[t for report in reports for t in report.modem_events[place]] for place in range(3)],
        "events": {craft: outlet.of("modem_rx", craft) for craft in TEAM},
        "through": reports[-1].through_tick,
    }


def reference(scenario: Scenario, outlet, truth_at) -> dict:
    """The run with every transmission there in good time, one step a window."""
    sent, steps = traffic(truth_at)
    arrivals = [("modem_tx", craft, request) for craft, request in sent]
    feed(scenario, outlet, arrivals + [("advance", "", Advance([step])) for step in steps])
    return story(outlet)


def test_one_message(make, outlet, truth_at) -> None:
    """A transmission at tick 12 becomes numbered events at 22 s, told to the hub with the tick they are final in."""
    step = Step(truth_at(12), [0, 1, 0])
    feed(make(), outlet, [("modem_tx", "auv2", Transmit(0, 12 * NS, b"x")), ("advance", "", Advance([step]))])
    assert outlet.of("modem_rx", "auv1") == [ModemEvent(0, 22 * NS, Received("auv2", b"x"))]
    assert outlet.of("modem_rx", "auv2") == [ModemEvent(0, 22 * NS, TxEvent(0, "SENT"))]
    (report,) = outlet.of("report")
    assert (report.through_tick, report.modem_events) == (12, [[22 * NS], [22 * NS], [22 * NS]])
    assert [line.kind for line in report.log] == ["started"]


def test_waits_for_what_was_counted(make, outlet, truth_at) -> None:
    """A tick is worked through when the last counted transmission is there, and not before."""
    emulator = feed(make(), outlet, [("advance", "", Advance([Step(truth_at(0), [1, 2, 0])]))])
    emulator.handle("modem_tx", "auv2", Transmit(1, 500_000_000, b"c"))
    emulator.handle("modem_tx", "auv1", Transmit(0, 0, b"a"))
    assert outlet.all == []
    emulator.handle("modem_tx", "auv2", Transmit(0, 0, b"b"))
    assert [report.through_tick for report in outlet.of("report")] == [0]


def test_reports_as_far_as_complete(make, outlet, truth_at) -> None:
    """Of a window that misses a transmission, the ticks before it are reported, the rest when it has come."""
    steps = [Step(truth_at(tick), [int(tick >= 3), 0, 0]) for tick in range(6)]
    emulator = feed(make(), outlet, [("advance", "", Advance(steps))])
    emulator.handle("modem_tx", "auv1", Transmit(0, 3 * NS, b"x"))
    assert [report.through_tick for report in outlet.of("report")] == [2, 5]


def test_transmission_of_a_later_tick_waits(make, outlet, truth_at) -> None:
    """A transmission that is there too early takes no part before the tick that counts it."""
    emulator = feed(make(), outlet, [("modem_tx", "auv1", Transmit(0, 5 * NS, b"x"))])
    emulator.handle("advance", "", Advance([Step(truth_at(0), [0, 0, 0])]))
    assert (outlet.of("report")[0].log, outlet.of("modem_rx", "auv2")) == ([], [])


def test_only_what_is_final_is_handed_out(make, outlet, truth_at) -> None:
    """An event at the very end of the lookahead waits for the next tick: another may still join it."""
    emulator = feed(make(), outlet, [("modem_tx", "auv1", Transmit(0, 1 * NS, b"x"))])
    emulator.handle("advance", "", Advance([Step(truth_at(0), [1, 0, 0])]))
    assert outlet.of("modem_rx", "auv2") == []
    emulator.handle("advance", "", Advance([Step(truth_at(1), [1, 0, 0])]))
    assert outlet.of("modem_rx", "auv2") == [ModemEvent(0, 11 * NS, Received("auv1", b"x"))]


def test_every_tick_is_reported(make, outlet, truth_at) -> None:
    """A tick in which nothing happens is reported all the same: the hub waits for it."""
    feed(make(), outlet, [("advance", "", Advance([Step(truth_at(0), [0, 0, 0])]))])
    assert outlet.all == [("report", "", LinkReport(0, [[], [], []], []))]


@pytest.mark.parametrize("shuffle", range(10))
def test_order_of_arrival_within_a_tick(make, outlet, truth_at, shuffle: int) -> None:
    """The transmissions of one tick give the same reports in whatever order they and the tick arrive."""
    arrivals = [("modem_tx", craft, Transmit(0, 250_000_000, b"x")) for craft in TEAM]
    arrivals += [("modem_tx", "auv3", Transmit(1, 0, b"y")), ("advance", "", Advance([Step(truth_at(0), [1, 1, 2])]))]
    random.Random(shuffle).shuffle(arrivals)
    feed(make("link.loss=0.5"), outlet, arrivals)
    (report,) = outlet.of("report")
    assert [(line.kind, line.source, line.seq) for line in report.log] == [
        ("started", "auv3", 1),
        ("refused", "auv1", 0),
        ("refused", "auv2", 0),
        ("refused", "auv3", 0),
    ]
    assert report.modem_events[2] == [10 * NS, 10_250_000_000]


@pytest.mark.parametrize("shuffle", range(10))
def test_order_of_arrival_within_a_run(make, outlet, truth_at, shuffle: int) -> None:
    """A whole run is the same however its transmissions are delayed against the ticks and against each other."""
    expected = reference(make("link.loss=0.3"), type(outlet)(), truth_at)
    draw = random.Random(shuffle)
    sent, steps = traffic(truth_at)
    arrivals = [("modem_tx", craft, request) for craft, request in sent]
    draw.shuffle(arrivals)
    for position, window in zip(
        sorted(draw.choices(range(len(arrivals) + 1), k=24)), windows(steps, [5] * 24), strict=True
    ):
        arrivals.insert(position + steps.index(window.steps[0]) // 5, ("advance", "", window))
    feed(make("link.loss=0.3"), outlet, arrivals)
    assert story(outlet) == expected


@pytest.mark.parametrize("lengths", [[5] * 24, [1, 9] * 12, [120], [60, 1, 59]])
def test_length_of_windows(make, outlet, truth_at, lengths: list[int]) -> None:
    """Windows of any length give the same events, numbers and log."""
    expected = reference(make("link.loss=0.3"), type(outlet)(), truth_at)
    sent, steps = traffic(truth_at)
    arrivals = [("modem_tx", craft, request) for craft, request in sent]
    feed(make("link.loss=0.3"), outlet, arrivals + [("advance", "", window) for window in windows(steps, lengths)])
    assert story(outlet) == expected


def test_what_the_run_contains(make, outlet, truth_at) -> None:
    """The run that the tests above compare has deliveries, losses and refusals in it, in the order of time."""
    run = reference(make("link.loss=0.3"), outlet, truth_at)
    assert {line.kind for line in run["log"]} == {"started", "delivered", "lost", "refused"}
    assert [line.t_ns for line in run["log"]] == sorted(line.t_ns for line in run["log"])
    assert run["through"] == TICKS - 1


def test_numbers_and_announcements(make, outlet, truth_at) -> None:
    """Each craft's events are numbered from 0 in the order of time, and announced to the hub one by one."""
    run = reference(make("link.loss=0.3"), outlet, truth_at)
    for place, craft in enumerate(TEAM):
        events = run["events"][craft]
        assert [event.seq for event in events] == list(range(len(events)))
        assert [event.t_ns for event in events] == run["announced"][place] == sorted(run["announced"][place])


def test_nothing_comes_late(make, outlet, truth_at) -> None:
    """What was not announced through a tick is at least the lookahead away from the next one."""
    reference(make("link.loss=0.3"), outlet, truth_at)
    final_ns = 0
    for report in outlet.of("report"):
        assert all(t_ns >= final_ns for times in report.modem_events for t_ns in times)
        final_ns = (report.through_tick + 1) * NS + 10 * NS


def test_events_are_out_before_their_report(make, outlet, truth_at) -> None:
    """The hub never hears of an event that has not been published."""
    reference(make(), outlet, truth_at)
    published = announced = 0
    for topic, _, message in outlet.all:
        if topic == "modem_rx":
            published += 1
        elif topic == "report":
            announced += sum(map(len, message.modem_events))
            assert announced == published


def test_repeated_transmission(make, outlet, truth_at) -> None:
    """A transmission that comes twice is made once."""
    request = ("modem_tx", "auv1", Transmit(0, 0, b"x"))
    advances = [("advance", "", Advance([Step(truth_at(tick), [1, 0, 0])])) for tick in range(2)]
    feed(make(), outlet, [request, request, advances[0], request, advances[1]])
    assert len(outlet.of("modem_rx", "auv2")) == 1


def test_seed_of_the_link(make, outlet, truth_at) -> None:
    """The link draws from the scenario's seed, unless it has its own."""

    def log(*seeds: str) -> list:
        return reference(make("link.loss=0.5", *seeds), type(outlet)(), truth_at)["log"]

    assert log("seed=1") != log("seed=2")
    assert log("seed=1") == log("seed=2", "link.seed=1")


def test_lockstep_reads_no_clock(make, outlet, truth_at) -> None:
    """In lockstep the link waits for messages only, even after the start, and on a deadline does nothing."""
    emulator = feed(make(), outlet, [("clock", "link", Clock("start", clock.unix_ns()))])
    emulator.handle("modem_tx", "auv1", Transmit(0, 0, b"x"))
    emulator.handle("truth", "", truth_at(0))
    emulator.on_deadline()
    assert (emulator.wall_s_to_deadline(), outlet.all) == (None, [])


def test_bye(make, outlet) -> None:
    """The link is done when the mission is over, and then does not miss the simulator."""
    emulator = Emulator(make(), outlet)
    assert not emulator.done
    emulator.handle("clock", "link", Clock("bye"))
    emulator.handle("presence", "sim", Presence("sim", alive=False, scenario="x"))
    assert emulator.done


def test_simulator_lost(make, outlet) -> None:
    """A simulator that goes without saying goodbye is a fault with a name; the coming and going of others is not."""
    emulator = Emulator(make(), outlet)
    emulator.handle("presence", "auv1", Presence("auv1", alive=False, scenario="x"))
    emulator.handle("presence", "sim", Presence("sim", alive=True, scenario="x"))
    with pytest.raises(FaultError, match=r"^sim left the bus without saying goodbye before the first tick$"):
        emulator.handle("presence", "sim", Presence("sim", alive=False, scenario="x"))


def live(make, outlet, age_s: float, pace: str = "live") -> Emulator:
    """An emulator in a mission that began some time ago."""
    emulator = Emulator(make(f"clock.pace={pace}"), outlet)
    emulator.handle("clock", "link", Clock("start", clock.unix_ns() - round(age_s * NS)))
    return emulator


def test_live_simulator_lost(make, outlet) -> None:
    """At a live pace the fault says at what time of the mission it was."""
    with pytest.raises(FaultError, match=r"at mission time \d+\.\d s$") as caught:
        live(make, outlet, 12.0).handle("presence", "sim", Presence("sim", alive=False, scenario="x"))
    assert caught.value.time_s >= 12.0


def test_live_hands_out_what_is_due(make, outlet, truth_at) -> None:
    """At a live pace events go out when their time has come, and a report with them that answers no tick."""
    emulator = live(make, outlet, 1000.0)
    emulator.handle("truth", "", truth_at(12))
    emulator.handle("modem_tx", "auv2", Transmit(0, 12 * NS, b"x"))
    emulator.on_deadline()
    assert outlet.of("modem_rx", "auv3") == [ModemEvent(0, 22 * NS, Received("auv2", b"x"))]
    (report,) = outlet.of("report")
    assert (report.through_tick, report.modem_events) == (-1, [[22 * NS]] * 3)
    assert [line.kind for line in report.log] == ["started", "delivered", "delivered"]
    assert emulator.wall_s_to_deadline() is None


def test_live_tells_of_what_is_on_the_air(make, outlet) -> None:
    """At a live pace a transmission is in the log as soon as it has started, and delivered ten seconds later."""
    emulator = live(make, outlet, 12.0)
    emulator.handle("modem_tx", "auv1", Transmit(0, 12 * NS, b"x"))
    assert outlet.of("modem_rx", "auv2") == []
    assert [line.kind for report in outlet.of("report") for line in report.log] == ["started"]
    assert 0.0 < emulator.wall_s_to_deadline() <= 10.0


@pytest.mark.parametrize(("pace", "speed"), [("live", 1.0), ("4.0", 4.0)])
def test_live_waits_for_what_is_not_due(make, outlet, pace: str, speed: float) -> None:
    """An event an hour of the mission ahead is waited for at the pace, and not handed out before."""
    emulator = live(make, outlet, 0.0, pace)
    assert emulator.wall_s_to_deadline() is None
    emulator.handle("modem_tx", "auv1", Transmit(0, 3590 * NS, b"x"))
    emulator.on_deadline()
    assert outlet.all == []
    assert 3500.0 < emulator.wall_s_to_deadline() * speed <= 3600.0


def test_live_starts_with_the_clock(make, outlet) -> None:
    """Before the mission starts nothing is due."""
    emulator = Emulator(make("clock.pace=live"), outlet)
    emulator.handle("modem_tx", "auv1", Transmit(0, 0, b"x"))
    emulator.on_deadline()
    assert (emulator.wall_s_to_deadline(), outlet.all) == (None, [])


def ledgers(scenario: Scenario, outlet, truth_at, lengths: Sequence[int]) -> list[LinkLedger]:
    """The ledgers of the run above, its steps handed over in windows, and of its end."""
    sent, steps = traffic(truth_at)
    arrivals = [("modem_tx", craft, request) for craft, request in sent]
    arrivals += [("advance", "", window) for window in windows(steps, lengths)]
    feed(scenario, outlet, [*arrivals, ("clock", "link", Clock("bye"))])
    return outlet.of("ledger")


@pytest.mark.parametrize("lengths", [[1] * 120, [7] * 17 + [1], [120]])
def test_ledgers_come_at_their_times(make, outlet, truth_at, lengths: list[int]) -> None:
    """Whatever the windows, ledgers are of every ``ledger_s`` and of the end, each of what is before its time."""
    published = ledgers(make("link.loss=0.3", "link.ledger_s=50"), outlet, truth_at, lengths)
    assert [ledger.t_ns // NS for ledger in published] == [50, 100, 120]
    log = [line for report in outlet.of("report") for line in report.log]
    for ledger in published:
        recount = Ledger(TEAM)
        for line in log:
            if line.t_ns < ledger.t_ns:
                recount.note(line)
        assert recount.snapshot(ledger.t_ns) == ledger
        assert faults(ledger, {}) == []
    assert published[0] != published[1] != published[2]
    assert [source.started for source in published[2].sources] == [4, 2, 2]


def test_the_last_ledger_comes_once(make, outlet, truth_at) -> None:
    """A run that ends at a multiple of ``ledger_s`` has one ledger of its end; one of no length has none."""
    assert [ledger.t_ns // NS for ledger in ledgers(make(), outlet, truth_at, [120])] == [60, 120]
    silent = type(outlet)()
    feed(make(), silent, [("clock", "link", Clock("bye"))])
    assert silent.all == []


def test_the_last_ledger_is_out_before_the_fault(make, outlet, truth_at) -> None:
    """When the simulator ends the run early, the ledger of what there was goes out before anything else."""
    emulator = feed(make(), outlet, [("advance", "", Advance([Step(truth_at(0), [0, 0, 0])]))])
    with pytest.raises(GrexError, match=r"^sim ended the run: why$"):
        emulator.handle("clock", "link", Clock("bye", reason="why", t_ns=5 * NS))
    assert [ledger.t_ns for ledger in outlet.of("ledger")] == [NS]


def test_ledgers_are_not_oftener_than_ticks(make, outlet, truth_at) -> None:
    """However short ``ledger_s`` is, there is one ledger a tick at most."""
    assert len(ledgers(make("link.ledger_s=1e-6"), outlet, truth_at, [120])) == 120


def test_live_ledgers(make, outlet, truth_at) -> None:
    """At a live pace ledgers are of the same times as far as the mission is, even in silence, and of its end."""
    emulator = live(make, outlet, 130.0)
    emulator.handle("truth", "", truth_at(12))
    assert outlet.of("ledger") == []
    emulator.handle("modem_tx", "auv2", Transmit(0, 12 * NS, b"x"))
    emulator.handle("truth", "", truth_at(61))
    emulator.on_deadline()
    assert [ledger.t_ns // NS for ledger in outlet.of("ledger")] == [60]
    assert outlet.of("ledger")[0].sources[1].started == 1
    emulator.handle("modem_tx", "auv1", Transmit(0, 131 * NS, b"y"))
    emulator.handle("clock", "link", Clock("bye", t_ns=63 * NS))
    last = outlet.of("ledger")[-1]
    assert (last.t_ns // NS, last.sources[0].started) == (63, 0)


def test_nothing_can_wait(make, outlet) -> None:
    """The link leaves nothing for idle time."""
    assert Emulator(make(), outlet).in_idle_time() is False


def test_foreign_topic(make, outlet) -> None:
    """A topic that is not the link's business is ignored."""
    assert not feed(make(), outlet, [("state", "auv1", None)]).done


@pytest.mark.parametrize("pace", ["lockstep", "live"])
def test_stranger(make, outlet, pace: str) -> None:
    """A transmission of a craft that is not in the scenario is dropped, not the end of the link."""
    feed(make(f"clock.pace={pace}"), outlet, [("modem_tx", "auv9", Transmit(0, 0, b"x"))])


def test_live_water_is_a_moment_behind(make, outlet, truth_at, monkeypatch) -> None:
    """A request that comes a moment after its slot has opened begins at the opening, not when it comes."""
    monkeypatch.setattr("grex_link.emulator._BEHIND_S", 5.0)
    emulator = Emulator(make("clock.pace=live", "link.profile=s2c_im"), outlet)
    emulator.handle("clock", "link", Clock("start", clock.unix_ns() - 14 * NS))
    emulator.handle("truth", "", truth_at(12))
    emulator.handle("modem_tx", "auv2", Transmit(0, 12 * NS, b"x"))
    assert outlet.of("modem_rx", "auv3") == []
    assert emulator.wall_s_to_deadline() > 2.0
    emulator.handle("clock", "link", Clock("bye", t_ns=20 * NS))
    (event,) = outlet.of("modem_rx", "auv3")
    assert event.event.source == "auv2"
    assert 12.16 < event.t_ns / NS < 12.4
