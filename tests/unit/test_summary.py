"""The result of a run: totals that add up, and what it says to a person and to a program."""

import msgspec
import numpy as np
import pytest
from missions import SCENARIOS

from grex_agent.mission import plan_mission
from grex_link.ledger import EDGES_S, Ledger
from grex_link.messages import LinkEvent, PortLedger, Pose, Truth
from grex_link.scenario import load
from grex_link.units import NS
from grex_sim.logbook import Logbook
from grex_sim.summary import Summary, as_json, as_text, summarise, write_files

TEAM = ("auv1", "auv2", "auv3")
PORT = PortLedger(0, 1, {}, 0, 0, 0, 1, {}, 1, 1, 0, 0, 0, 0)


def line(t_s, kind, seq=0, to="", *, source="auv1", reason="", purpose="data", lasting_s=1.0):
    """Write one line of the medium's log."""
    return LinkEvent(round(t_s * NS), kind, source, seq, to, 15, reason, purpose, "", round(lasting_s * NS))


HEARD = (
    line(0, "started"),
    line(10, "delivered", to="auv2", lasting_s=10),
    line(10, "lost", to="auv3", reason="lost_noise"),
)


def judge(*events, ledger_s=30.0, ports=(), fault="", overrides=()) -> Summary:
    """Summarise a run of thirty ticks in which these things happened in the water."""
    scenario = load(SCENARIOS / "paper-d.toml", overrides)
    book = Logbook()
    for tick in range(31):
        poses = [Pose(craft, 1.0 * tick, 25.0 * place, 0, 0, 0, 0, 1.0) for place, craft in enumerate(TEAM)]
        book.truth(Truth(tick, tick * NS, poses))
    book.link_events(events)
    if ledger_s is not None:
        ledger = Ledger(TEAM)
        for event in events:
            if event.t_ns < ledger_s * NS:
                ledger.note(event)
        book.message("ledger", "", ledger.snapshot(round(ledger_s * NS)))
    for craft, port in ports:
        book.message("port", craft, port)
    summary, _ = summarise(
        scenario, plan_mission(scenario), book, mission_s=30.0, startup_s=1.0, wall_s=2.0, fault=fault
    )
    return summary


def page(summary) -> list[str]:
    """Lines of the summary for a person."""
    return as_text(summary).splitlines()


def warnings(summary) -> list[str]:
    """Those that warn."""
    return [text for text in page(summary) if text.startswith("WARNING")]


def test_what_is_still_on_its_way() -> None:
    """Receptions to come are those of every mate, less what was delivered, overheard or lost there."""
    assert judge(line(0, "started")).in_flight == 2
    assert judge(*HEARD).in_flight == 0
    overheard = line(10, "overheard", to="auv3")
    summary = judge(*HEARD[:2], overheard)
    assert (summary.delivered, summary.lost, summary.refused, summary.in_flight) == (1, 0, 0, 0)


def test_what_goes_by_land_goes_to_one() -> None:
    """A message over cable or radio is one message for the one craft it goes to."""
    sent = line(0, "started", to="auv2", purpose="land")
    arrived = line(1, "delivered", to="auv2", purpose="land")
    assert judge(sent).in_flight == 1
    assert judge(sent, arrived).in_flight == 0
    summary = judge(sent, arrived, *HEARD[:2])
    assert (summary.messages_sent, summary.delivered, summary.in_flight) == (2, 2, 1)


def test_ledgers_by_name() -> None:
    """Sources and ports are found by the craft's name, links by both, and the bins of the histograms beside them."""
    summary = judge(*HEARD, ports=[("auv2", PORT), ("auv1", PORT)])
    assert (summary.ledger_s, summary.histogram_edges_s) == (30.0, list(EDGES_S))
    assert (list(summary.sources), list(summary.ports)) == ([*TEAM], ["auv1", "auv2"])
    assert summary.sources["auv1"].started == 1
    assert summary.paths["auv1>auv3"].lost == {"lost_noise": 1}
    assert len(summary.paths) == 6


def test_the_newest_ledger_counts() -> None:
    """Of several ledgers of the water or of a port the last one is kept."""
    summary = judge(ports=[("auv1", PORT), ("auv1", msgspec.structs.replace(PORT, t_ns=9))])
    assert summary.ports["auv1"].t_ns == 9


def test_a_program_reads_what_was_written(tmp_path) -> None:
    """From the JSON comes the same object again, and the file holds the same."""
    summary = judge(*HEARD, ports=[("auv1", PORT)])
    assert msgspec.json.decode(as_json(summary), type=Summary) == summary
    scenario = load(SCENARIOS / "paper-d.toml")
    result = summarise_result(scenario)
    write_files(tmp_path, scenario, result[0], summary, result[1])
    assert msgspec.json.decode((tmp_path / "summary.json").read_bytes(), type=Summary) == summary
    assert summary.out == str(tmp_path)


def summarise_result(scenario):
    """Return logbook and score of a run of no length."""
    book = Logbook()
    poses = [Pose(craft, 0.0, 25.0 * place, 0, 0, 0, 0, 1.0) for place, craft in enumerate(TEAM)]
    book.truth(Truth(0, 0, poses))
    _, result = summarise(scenario, plan_mission(scenario), book, mission_s=0.0, startup_s=0, wall_s=0, fault="x")
    assert np.shape(result.fd_series) == (0,)
    return book, result


@pytest.mark.parametrize(
    ("profile", "team_j", "told"),
    [
        ("s2c_im", 10**1.32 * 3.0, "2 messages sent (30 bytes, 62.7 J of sound), 0 received"),
        ("grex2008", None, "2 messages sent (30 bytes, energy unknown), 0 received"),
    ],
)
def test_messages_bytes_and_energy(profile, team_j, told) -> None:
    """Messages, bytes and the energy of the sound are told; of a modem without a source level that it is unknown."""
    sent = [line(1, "started"), line(4, "started", source="auv2", lasting_s=2.0)]
    summary = judge(*sent, overrides=[f"link.profile={profile}"])
    assert summary.team_sound_j == (team_j and pytest.approx(team_j))
    assert (summary.sound_j == {}) == (team_j is None)
    assert any(text.startswith(told) for text in page(summary))


def test_age_and_losses_in_two_lines() -> None:
    """A person reads mean age and worst pair in one line, the share of losses and their reasons in another."""
    other = [line(1, "started", source="auv2"), line(6, "delivered", to="auv1", source="auv2", lasting_s=5),
             line(6, "lost", to="auv3", source="auv2", reason="missed_busy")]  # fmt: skip
    told = page(judge(*HEARD, *other))
    # 10 to 30 s in twenty seconds; 5 to 29 s in twenty-four.
    assert "age of information 18.5 s on average, 20.0 s on auv1>auv2; 4 of 6 links carried nothing" in told
    assert "50.0 % of 4 receptions lost: lost_noise 25.0 %, missed_busy 25.0 %" in told
    assert told.index("digest " + judge(*HEARD, *other).digest) > 0


def test_only_the_main_reasons_are_told() -> None:
    """Three reasons are named, the greatest first, and the number of others."""
    reasons = ["missed_snr"] * 4 + ["lost_noise"] * 3 + ["lost_burst"] * 2 + ["missed_off", "missed_busy"]
    events = [line(0, "started", seq) for seq in range(11)]
    events += [line(9, "lost", seq, "auv2", reason=reason) for seq, reason in enumerate(reasons)]
    (told,) = [text for text in page(judge(*events)) if "lost:" in text]
    named = "missed_snr 36.4 %, lost_noise 27.3 %, lost_burst 18.2 % and 2 other reasons"
    assert told == "100.0 % of 11 receptions lost: " + named


@pytest.mark.parametrize("ledger_s", [None, 30.0])
def test_nothing_to_tell(ledger_s) -> None:
    """Without a ledger, or without a message, there is no line on age and losses, and no warning."""
    summary = judge(ledger_s=ledger_s)
    assert not any("age of information" in text or "lost:" in text for text in page(summary))
    assert (summary.ledger_faults, warnings(summary)) == ([], [])
    assert (summary.ledger_s is None, summary.paths == {}) == (ledger_s is None,) * 2


def test_what_does_not_add_up_is_a_warning() -> None:
    """A transmission with two outcomes at one craft is a fault in the object and a warning in the text."""
    summary = judge(*HEARD, HEARD[2])
    (fault,) = summary.ledger_faults
    assert fault.startswith("auv1>auv3: sent 1, but 0 delivered, 0 overheard, 2 lost")
    assert warnings(summary) == [f"WARNING: the ledger does not add up: {fault}"]


def test_ports_are_compared_when_the_run_is_whole() -> None:
    """A port that has started more than its modem has begun is a fault in lockstep runs that came to their end."""
    ports = [("auv1", msgspec.structs.replace(PORT, requested=9, started=9))]
    assert judge(*HEARD, ports=ports).ledger_faults == ["auv1: its port has started 9, its modem has begun 1"]
    assert judge(*HEARD, ports=ports, fault="sim died").ledger_faults == []
    assert judge(*HEARD, ports=ports, overrides=["clock.pace=live"]).ledger_faults == []
    several = ["link.mac={type='tdma',messages_per_slot=8}", "link.profile=s2c_im"]
    assert judge(*HEARD, ports=ports, overrides=several).ledger_faults == []


def test_a_port_that_contradicts_itself() -> None:
    """The books of a port must balance even when the run broke off."""
    ports = [("auv1", msgspec.structs.replace(PORT, requested=2))]
    (fault,) = judge(*HEARD, ports=ports, fault="sim died").ledger_faults
    assert fault.startswith("auv1: requested 2, but ")
