"""A study's table: statistics, targets, and what is printed."""

import json
import tomllib

import msgspec
import pytest

from grex_agent.mission import plan_mission, range_max_m
from grex_link.errors import ConfigError, GrexError
from grex_link.mac import plan_mac
from grex_link.profile import load_profile
from grex_link.units import NS
from grex_sim.intervals import student_t
from grex_sim.study.all_rows import ROWS
from grex_sim.study.figures import SCENARIOS, Flight, cost, cost_share, deviation, mean_and_interval, ratio
from grex_sim.study.rows import CONDITIONS
from grex_sim.study.rows_beyond import best
from grex_sim.study.rows_talk import on_s2c_im
from grex_sim.study.table import AtMost, InBand, Result, Row, as_json, as_text, chi_square_band
from grex_sim.study.team import Study, choose, run_study

FLIGHT = Flight("paper-d", ("duration_s=50",))
RESULTS = [
    Result(Row("good", "a mission", deviation(FLIGHT), AtMost(0.5)), 0.25, 0.01, 20),
    Result(Row("bad", "another one", deviation(FLIGHT), AtMost(0.2)), 0.25, 0.02, 20),
    Result(Row("beside", "one without a target", deviation(FLIGHT)), 12.5, 0.0, 20),
]


class Flown:
    """What a figure takes from a summary."""

    def __init__(self, fd, messages_sent, bytes_sent=0, team_sound_j=None):
        self.fd, self.messages_sent = fd, messages_sent
        self.bytes_sent, self.team_sound_j = bytes_sent, team_sound_j


def test_json_is_what_programs_are_promised():
    """The JSON has exactly the rows, with name, mean, interval and seeds."""
    assert json.loads(as_json(RESULTS)) == {
        "rows": [
            {"row": "good", "value": 0.25, "interval": 0.01, "seeds": 20},
            {"row": "bad", "value": 0.25, "interval": 0.02, "seeds": 20},
            {"row": "beside", "value": 12.5, "interval": 0.0, "seeds": 20},
        ]
    }


def test_a_missed_target_is_said():
    """The table says of each row with a target whether it is met, and of others nothing."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in as_text(RESULTS).splitlines()]
    assert lines[0] == ["row", "condition", "value", "target", "met"]
    assert lines[2:] == [
        ["good", "a mission", "0.2500 ± 0.0100", "<= 0.5", "yes"],
        ["bad", "another one", "0.2500 ± 0.0200", "<= 0.2", "NO"],
        ["beside", "one without a target", "12.5000 ± 0.0000", "", ""],
    ]


@pytest.mark.parametrize(
    ("results", "said"),
    [
        (RESULTS[::2], None),
        (RESULTS, "^MISSED: bad is 0.2500, must be <= 0.2$"),
        (
            [*RESULTS, Result(Row("worse", "", RESULTS[0].row.figure, InBand(1)), 2.5, 0.0, 20)],
            "; worse is 2.5000, must",
        ),
    ],
    ids=["all met", "one missed", "two missed"],
)
def test_a_study_that_misses_a_target_fails(results, said):
    """A study ends with one line that names every row that misses its target, and without one if none does."""
    study = Study(results, [])
    if said is None:
        study.judge()
    else:
        with pytest.raises(GrexError, match=said) as failure:
            study.judge()
        assert failure.value.exit_status == 1
        assert "good" not in str(failure.value)


def test_another_digest_fails_too():
    """Digests that differ are said as well as targets that are missed, in the same line."""
    with pytest.raises(GrexError, match=r"NOT THE SAME RESULT .*: good: digest 1, 2\. MISSED: bad is"):
        Study(RESULTS, ["good: digest 1, 2"]).judge()
    with pytest.raises(GrexError, match=r"digest 1, 2$"):
        Study(RESULTS[:1], ["good: digest 1, 2"]).judge()


@pytest.mark.parametrize(("freedom", "quantile"), [(1, 12.706), (2, 4.303), (5, 2.571), (19, 2.093), (100, 1.984)])
def test_students_t(freedom, quantile):
    """The quantile is that of the printed tables of Student's t."""
    assert student_t(freedom) == pytest.approx(quantile, abs=5e-4)


def test_mean_and_interval():
    """The interval is Student's: 4.303 standard errors of three values; nothing where every seed gives the same."""
    assert mean_and_interval([1.0, 2.0, 3.0]) == pytest.approx((2.0, 4.3027 / 3.0**0.5), rel=1e-4)
    assert mean_and_interval([0.3, 0.3, 0.3]) == pytest.approx((0.3, 0.0))


@pytest.mark.parametrize(
    ("freedom", "least", "most"), [(20, 0.4795, 1.7085), (100, 0.7422, 1.2956), (1000, 0.9143, 1.0895)]
)
def test_chi_square_band(freedom, least, most):
    """The band is that of the tables of χ²."""
    assert chi_square_band(freedom) == pytest.approx((least, most), abs=2e-3)
    assert InBand(freedom // 20).met(least + 0.01, 20)
    assert not InBand(freedom // 20).met(least - 0.01, 20)
    assert not InBand(freedom // 20).met(most + 0.01, 20)


def test_figures():
    """A ratio is FD over FD, and a share messages, bytes or joules over the same of the other, of the same seed."""
    one, other = Flown(0.6, 50, 300, 7.0), Flown(0.4, 200, 3000, 14.0)
    assert ratio(FLIGHT, FLIGHT).value(one, other) == pytest.approx(1.5)
    whats = "messages_sent", "bytes_sent", "team_sound_j"
    assert [cost_share(FLIGHT, FLIGHT, what).value(one, other) for what in whats] == [0.25, 0.1, 0.5]
    assert [cost(FLIGHT, what).value(one) for what in whats] == [50.0, 300.0, 7.0]
    assert deviation(FLIGHT).value(one) == 0.6


def test_every_row_can_be_measured():
    """Names are unique, and every scenario and estimator of the table is there and sound."""
    assert len({row.name for row in ROWS}) == len(ROWS)
    for job in {job for row in ROWS for job in row.figure.jobs}:
        job.check()


def test_conditions_are_what_they_say():
    """Every condition is the paper's mission and modem, and differs in the sea and the craft alone."""
    paper = tomllib.loads((SCENARIOS / "paper-d.toml").read_text())
    for condition, _ in CONDITIONS.values():
        made = tomllib.loads((SCENARIOS / f"{condition}.toml").read_text())
        assert (made["mission"], made["link"]) == (paper["mission"], paper["link"])
        assert Flight(condition).load(1).team.gain_mps == Flight("paper-d").load(1).team.gain_mps


def test_the_best_law_is_that_of_its_scenario():
    """What the study flies as the best law is deploy/scenarios/shared-reference.toml, but for the title."""
    there, here = Flight("shared-reference").load(1), best("s0").load(1)
    assert msgspec.structs.replace(here, title=there.title) == there


def test_rows_of_energy_have_an_energy():
    """Every row of energy flies missions whose modem has a source level."""
    rows = [row for row in ROWS if "energy" in row.name]
    assert {"event_energy_s2c_im", "event_energy_share_s2c_im", "best_energy_share_s2c_im"} <= {
        row.name for row in rows
    }
    profiles = {job.load(1).link.profile for row in rows for job in row.figure.jobs}
    assert all(load_profile(profile).source_level_db is not None for profile in profiles)


@pytest.mark.parametrize(("talk", "message_bytes"), [("event_quiet", 15), ("best_quiet", 9)])
def test_quiet_talk_is_as_long_silent_as_on_the_papers_modem(talk, message_bytes):
    """On the fast modem the longest silence in seconds is that of the paper's, to within a cycle of slots."""
    quiet, slots = (on_s2c_im(each).load(1) for each in (talk, talk.removesuffix("_quiet")))
    heartbeats = [each.team.talk.heartbeat_slots for each in (quiet, slots)]
    assert msgspec.structs.replace(quiet.team.talk, heartbeat_slots=heartbeats[1]) == slots.team.talk
    mac = plan_mac(quiet, range_max_m(plan_mission(quiet)), message_bytes)
    assert heartbeats[0] * mac.cycle_ns / NS == pytest.approx(30.0 * heartbeats[1], abs=mac.cycle_ns / NS)


#: Those that issue 5 names; programs ask for them.
PROMISED = """
    estimator_ratio_loss0 estimator_ratio_loss50 estimator_ratio_slow_loss0 best_fd_loss0 best_fd_loss50
    slow_mate_fd_loss0 slow_mate_fd_loss50 wander_fd_loss0 dgps_fd_loss0 current_fd_loss0 event_message_share
    ins_drift_rms_m
"""


def test_promised_rows_have_targets():
    """Every row that was promised by name is in the table, with what it is to reach."""
    targets = {row.name: row.target for row in ROWS}
    assert all(isinstance(targets[name], AtMost) for name in PROMISED.split())


def test_rows_are_chosen_by_name():
    """Rows come in the table's order; an unknown one is named with those there are."""
    names = [row.name for row in ROWS]
    assert [row.name for row in choose(ROWS, [names[3], names[1]])] == [names[1], names[3]]
    assert choose(ROWS, []) == list(ROWS)
    with pytest.raises(ConfigError, match=f"--only: unknown row 'nothing'; there are {names[0]}"):
        choose(ROWS, ["nothing"])


def test_one_seed_is_too_few():
    """There is no interval of one seed, and that is said before anything runs."""
    with pytest.raises(ConfigError, match="--seeds: 1 is too few"):
        run_study(1)


def test_a_fault_is_found_before_anything_runs():
    """A scenario that is not there, or an estimator that is not, is a fault of configuration."""
    with pytest.raises(ConfigError, match="deploy/scenarios"):
        Flight("nowhere").check()
    with pytest.raises(ConfigError, match=r"\$\.link\.loss"):
        Flight("paper-d", ("link.loss=2",)).check()
