"""``grex link stats``: from a recording, whole or cut off, to the ledger and its pages."""

import json
import sys

import msgspec
import pytest
from missions import fly
from recordings import METADATA, recorded_messages

from grex_link.errors import ConfigError
from grex_link.ledger import Ledger, faults
from grex_link.messages import LinkEvent, PathLedger, PortLedger, Pose, Truth
from grex_link.recorder import Recorder
from grex_link.topics import TOPICS, Topic
from grex_link.units import NS
from grex_sim import cli
from grex_sim.link_stats import Spread, link_stats
from grex_sim.link_stats_text import as_text

TEAM = ("auv1", "auv2", "auv3")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Half an hour of case d with losses: (folder, summary)."""
    folder = tmp_path_factory.mktemp("run")
    return folder, fly("paper-d", "duration_s=1800", "link.loss=0.3", "link.ledger_s=70", out=folder)


def truth(t_s, team=TEAM):
    """Truth at a time."""
    return Truth(t_s, t_s * NS, [Pose(craft, 0, 0, 0, 0, 0, 0, 0) for craft in team])


def record(folder, *messages):
    """Record messages as the simulator does: (topic, craft, message)."""
    recorder = Recorder(folder / "run.mcap", METADATA)
    for topic, craft, message in messages:
        recorder.write(topic, craft, message.t_ns, message)
    recorder.close()
    return folder


def event(t_s, kind, seq=0, to="", *, source="auv1", reason="", purpose="data", lasting_s=0.0):
    """Write one line of the medium's log."""
    line = LinkEvent(round(t_s * NS), kind, source, seq, to, 15, reason, purpose, "", round(lasting_s * NS))
    return "link_event", "", line


#: Started at 0 and 10; delivered after 1, 2 and 3 s; one lost; one on its way.
EVENTS = (
    event(0.0, "started", lasting_s=0.5),
    event(1.0, "delivered", 0, "auv2", lasting_s=1.0),
    event(2.0, "delivered", 0, "auv3", lasting_s=2.0),
    event(10.0, "started", 1, lasting_s=0.5),
    event(13.0, "delivered", 1, "auv2", lasting_s=3.0),
    event(13.0, "lost", 1, "auv3", reason="lost_collision"),
    event(20.0, "started", 0, source="auv2", lasting_s=0.5),
)


def words(line):
    """Split a line at its blanks."""
    return line.split()


def small(tmp_path, *more):
    """Record the events above and thirty seconds of truth."""
    return record(tmp_path, ("truth", "", truth(0)), *EVENTS, ("truth", "", truth(30)), *more)


def test_ledger_is_recorded(run):
    """A run's recording holds a ledger for every ``ledger_s`` of the mission and one of its end."""
    recorded = recorded_messages(run[0], "ledger")
    assert [ledger.t_ns // NS for ledger in recorded] == [*range(70, 1800, 70), 1800]


def test_recomputed_is_published(run):
    """From the events in the recording alone comes exactly each ledger that was published."""
    log = recorded_messages(run[0], "link_event")
    for published in recorded_messages(run[0], "ledger"):
        ledger = Ledger(TEAM)
        for line in log:
            if line.t_ns < published.t_ns:
                ledger.note(line)
        assert ledger.snapshot(published.t_ns) == published


def test_summary_holds_the_last_ledger(run):
    """In the summary are all sources and links of the last ledger, by name, and the totals are theirs."""
    folder, summary = run
    last = recorded_messages(folder, "ledger")[-1]
    assert summary.ledger_s == 1800.0
    assert list(summary.sources.values()) == last.sources
    assert list(summary.paths.values()) == last.paths
    assert list(summary.paths) == ["auv1>auv2", "auv1>auv3", "auv2>auv1", "auv2>auv3", "auv3>auv1", "auv3>auv2"]
    assert summary.messages_sent == sum(source.started for source in last.sources)
    assert summary.delivered == sum(path.delivered for path in last.paths)
    assert summary.lost == sum(sum(path.lost.values()) for path in last.paths) > 0
    assert summary.in_flight == sum(path.on_the_way for path in last.paths) > 0
    assert summary.ledger_faults == faults(last, summary.ports) == []
    written = json.loads((folder / "summary.json").read_text())
    assert written["paths"]["auv3>auv1"]["lost"] == summary.paths["auv3>auv1"].lost


def test_statistics_of_a_whole_run(run):
    """The statistics of a run that came to its end are its last ledger, with exact percentiles beside it."""
    folder, summary = run
    stats = link_stats(folder)
    assert (stats.recomputed, stats.mission_s, stats.faults) == (False, 1800.0, [])
    assert {name: link.counts for name, link in stats.links.items()} == summary.paths
    for link in stats.links.values():
        assert link.latency == Spread(10.0, 10.0, 10.0)
        assert link.age.mean_s == pytest.approx(link.counts.age_mean_s)
        assert 10.0 < link.age.p50_s < link.age.p90_s


def test_a_live_run_has_the_ledger_of_its_end(tmp_path):
    """At a live pace, too, the last ledger is of the mission's end, and exactly that of the recorded events."""
    overrides = ["clock.pace=400", "link.profile=s2c_im", "link.ledger_s=20", "link.land=[{between=['auv1','auv2']}]"]
    summary = fly("paper-d", "duration_s=110", *overrides, out=tmp_path)
    stats = link_stats(tmp_path)
    assert (stats.recomputed, stats.mission_s, stats.faults) == (False, 110.0, [])
    assert summary.messages_sent == sum(node.water.started + node.water.by_land for node in stats.nodes.values()) > 0
    assert summary.in_flight == sum(path.on_the_way for path in summary.paths.values())


def test_age_of_a_real_run(tmp_path):
    """In the paper's cycle, whole cycles with nothing lost, information is 25 s old on average: 10 to 40 s, evenly."""
    fly("paper-d", "duration_s=1810", out=tmp_path)
    first = link_stats(tmp_path).links["auv1>auv2"]
    assert first.counts.age_mean_s == pytest.approx(25.0)
    assert (first.age.p50_s, first.age.p90_s) == (pytest.approx(25.0), pytest.approx(37.0))


def test_a_run_that_was_cut_off(run, tmp_path):
    """Of a recording that ends anywhere, the ledger is drawn up from the events that are left, and adds up."""
    content = (run[0] / "run.mcap").read_bytes()
    for share in (0.5, 0.8):
        (tmp_path / "run.mcap").write_bytes(content[: int(len(content) * share)])
        stats = link_stats(tmp_path)
        assert stats.recomputed
        assert 0.0 < stats.mission_s < 1800.0
        assert stats.faults == []
        log = recorded_messages(tmp_path, "link_event")
        assert sum(link.counts.delivered for link in stats.links.values()) == sum(
            line.kind == "delivered" for line in log
        )


def test_an_older_ledger_is_not_taken_for_the_last(tmp_path):
    """What has happened since the newest ledger of a run that broke off is counted, too."""
    old = Ledger(TEAM).snapshot(0)
    stats = link_stats(small(tmp_path, ("ledger", "", old)))
    assert stats.recomputed
    assert stats.links["auv1>auv2"].counts.delivered == 2


def test_percentiles(tmp_path):
    """Latencies 1 and 3 s; age grows from 1 to 13 and from 3 to 20 s: its percentiles are exact, not those of bins."""
    link = link_stats(small(tmp_path)).links["auv1>auv2"]
    assert link.latency == Spread(2.0, pytest.approx(2.0), pytest.approx(2.8))
    # Of 29 s: 2 s in 1–3, then two teeth 3–13 at double rate, then one to 20. Half: 3 + 12.5/2; nine tenths: 13 + 4.1.
    assert link.age.p50_s == pytest.approx(9.25)
    assert link.age.p90_s == pytest.approx(17.1)
    assert link.age.mean_s == pytest.approx((12 * 7.0 + 17 * 11.5) / 29)


def test_silent_links_have_no_figures(tmp_path):
    """Where nothing was delivered there is no latency and no age, in JSON null."""
    stats = link_stats(small(tmp_path))
    nothing = Spread(None, None, None)
    assert (stats.links["auv2>auv3"].latency, stats.links["auv2>auv3"].age) == (nothing, nothing)
    assert json.loads(msgspec.json.encode(stats))["links"]["auv2>auv3"]["age"]["p50_s"] is None


def test_overall_figures_are_of_all_links(tmp_path):
    """Together, all links have the latencies of all deliveries and the ages of all their time."""
    stats = link_stats(small(tmp_path))
    assert stats.latency.mean_s == 2.0
    # auv1>auv3 ages from 2 to 30 s in 28 s.
    assert stats.age.mean_s == pytest.approx((12 * 7.0 + 17 * 11.5 + 28 * 16.0) / 57)


def test_a_ledger_that_is_not_of_the_log(tmp_path):
    """A last ledger that the recorded events do not bear out is told of, and so is what does not add up."""
    wrong = Ledger(TEAM).snapshot(30 * NS)
    assert link_stats(small(tmp_path, ("ledger", "", wrong))).faults == [
        "the ledger that was published is not that of the log in the recording"
    ]
    twice = record(tmp_path, ("truth", "", truth(30)), *EVENTS[:2], EVENTS[1])
    (fault,) = link_stats(twice).faults
    assert fault.startswith("auv1>auv2: sent 1, but 2 delivered")
    assert f"WARNING: the ledger does not add up: {fault}" in as_text(link_stats(twice))


def test_the_text_of_a_small_run(tmp_path):
    """Every figure of a small run stands in its page: the table of links, craft, losses and both histograms."""
    page = as_text(link_stats(small(tmp_path))).splitlines()
    assert page[0].endswith(": 30 s of mission, cut off; drawn up from the log; times in seconds")
    rows = [line.split() for line in page]
    assert words("auv1>auv2 2 2 100.0 % 0 0 0.0 % 0 2.000 2.000 2.800 9.638 9.250 17.1") in rows
    assert words("auv1>auv3 2 1 50.0 % 0 1 50.0 % 0 2.000 2.000 2.000 16.0 16.0 27.2") in rows
    assert words("auv2>auv1 1 0 - 0 0 - 1 - - - - - -") in rows
    assert ["all", "6", "3", "75.0", "%"] in [row[:5] for row in rows]
    assert words("auv1 2 1.000 3.3 % 30 0 0 -") in rows
    assert "auv1>auv3: lost_collision 1 (50.0 %)" in page
    assert "auv2>auv3: nothing came to an end" in page
    assert "auv1>auv2: nothing lost" in page
    place = page.index("auv1>auv2: nothing lost")
    assert page[place + 1].split() == words("latency deliveries age of information, time")
    assert page[place + 2].split() == ["0.8", "-", "1.6", "s", "█" * 20, "1", "█", "0.600", "s"]
    assert page[place + 3].split()[:4] == ["1.6", "-", "3.2", "s"]


def test_the_bars_are_as_long_as_the_bins_are_full(tmp_path):
    """The fullest bin has the whole bar, half as full is half the bar, and what is nearly nothing is seen."""
    lines = []
    sizes = {0.15: 40, 0.3: 20, 0.6: 1}
    for latency_s, count in sizes.items():
        for _ in range(count):
            lines += [event(1.0, "delivered", len(lines), "auv2", lasting_s=latency_s, purpose="ping")]
    page = as_text(link_stats(record(tmp_path, ("truth", "", truth(30, TEAM[:2])), *lines))).splitlines()
    bars = [line.split()[-2:] for line in page if "█" in line]
    assert bars == [["█" * 20, "40"], ["█" * 10, "20"], ["█", "1"]]


def test_ports_and_rare_things_are_told(tmp_path, monkeypatch):
    """Books of the ports have a table; refusals, answers, land links and fragments have a line where they occur."""
    port = PortLedger(30 * NS, 9, {"size": 1}, 2, 1, 1, 4, {"busy": 1}, 8, 5, 3, 6, 7, 2)
    more = [
        event(21.0, "refused", 4, reason="busy"),
        event(22.0, "started", 5, "auv2", purpose="land"),
        event(23.0, "started", 0, purpose="answer"),
        ("truth", "", truth(30)),
    ]
    assert "port of" not in as_text(link_stats(small(tmp_path)))
    row = Topic("port", "{craft}/port", PortLedger, ("agent",), ("sim",), "event", recorded=PortLedger)
    monkeypatch.setitem(TOPICS, "port", row)
    older = msgspec.structs.replace(port, t_ns=0, requested=0)
    stats = link_stats(record(tmp_path, *EVENTS, *more, ("port", "auv1", older), ("port", "auv1", port)))
    assert {craft: node.port for craft, node in stats.nodes.items()} == {"auv1": port, "auv2": None, "auv3": None}
    page = as_text(stats)
    assert words("auv1 9 1 2 1 1 4 8 5 3") in [line.split() for line in page.splitlines()]
    told = (
        "busy refused by the modem 1, answer sent 1, by land 1 in 1 requests, size refused by the port 1, "
        "busy failed 1, reassembled 6, abandoned 7, bad frames 2"
    )
    assert " ".join(page.split()).count(f"auv1: {told}") == 1


def test_the_page_fits(run):
    """The page of a team of three is no wider than 110 columns and ends no line in blanks."""
    page = as_text(link_stats(run[0])).splitlines()
    assert max(map(len, page)) <= 110
    assert all(line == line.rstrip() for line in page)


def test_one_craft_alone(tmp_path):
    """A craft without a team has no links, and a page all the same."""
    stats = link_stats(record(tmp_path, ("truth", "", truth(30, TEAM[:1])), event(0.0, "started", lasting_s=3.0)))
    assert stats.links == {}
    assert stats.nodes["auv1"].airtime_share == 0.1
    assert "10.0 %" in as_text(stats)


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda folder: folder / "none", "is no run: there is no such folder"),
        (lambda folder: folder, "is no run: there is no run.mcap in it"),
        (lambda folder: folder / "text.txt", "is no recording, or is damaged"),
        (record, "holds no run: nothing was recorded before it broke off"),
    ],
)
def test_what_is_no_run(tmp_path, make, problem):
    """Of whatever is no run, one line says what is the matter with it."""
    (tmp_path / "text.txt").write_text("this is no recording of anything\n" * 9)
    path = make(tmp_path)
    with pytest.raises(ConfigError) as caught:
        link_stats(path)
    assert str(caught.value) == f"{path}: {problem}"


def test_a_recording_of_another_version(tmp_path):
    """A recording whose messages are others than ours is named with the message that is."""

    class Other(PathLedger, frozen=True):
        t_ns: int = 5

    odd = Other("auv1", "auv2", 0, 0, {}, 0, [], 0.0, [], 0.0, 0)
    with pytest.raises(ConfigError, match=r"was recorded by another version of GREX: ledger: "):
        link_stats(record(tmp_path, ("truth", "", truth(0)), ("ledger", "", odd)))


@pytest.fixture
def grex(monkeypatch, capsys):
    """Run the console in this process: (exit status, standard output, standard error)."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["grex", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return call


def test_the_command(grex, run, tmp_path):
    """``grex link stats RUN`` prints the page, with --json the object, for a folder and for the recording itself."""
    page = as_text(link_stats(run[0]))
    assert grex("link", "stats", str(run[0])) == (0, page + "\n", "")
    status, out, _ = grex("link", "stats", str(run[0] / "run.mcap"), "--json")
    assert status == 0
    assert json.loads(out)["links"]["auv1>auv2"]["counts"]["sent"] == run[1].paths["auv1>auv2"].sent
    assert grex("link", "stats", str(tmp_path)) == (2, "", f"grex: {tmp_path}: is no run: there is no run.mcap in it\n")


def test_the_emulator_has_its_command_still(grex, tmp_path):
    """``grex link SCENARIO`` runs the emulator, even for a scenario named stats; each has a help of its own."""
    assert grex("link", str(tmp_path / "stats"))[2].endswith(
        "cannot read the scenario file: No such file or directory\n"
    )
    status, out, _ = grex("link", "--help")
    assert (status, "SCENARIO" in out, "--set" in out) == (0, True, True)
    status, out, _ = grex("link", "stats", "--help")
    assert (status, "RUN" in out, "--json" in out) == (0, True, True)
    assert "link stats" in grex("--help")[1]
