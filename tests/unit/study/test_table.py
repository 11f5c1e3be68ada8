"""A study's table: statistics, targets, and what is printed."""

import json
import tomllib

import msgspec
import pytest

from grex_link.errors import ConfigError
from grex_sim.study.figures import SCENARIOS, Flight, deviation, mean_and_interval, message_share, ratio
from grex_sim.study.rows import CONDITIONS
from grex_sim.study.rows_beyond import ROWS, best
from grex_sim.study.table import AtMost, InBand, Result, Row, as_json, as_text, chi_square_band
from grex_sim.study.team import choose, run_study

FLIGHT = Flight("paper-d", ("duration_s=50",))
RESULTS = [
    Result(Row("good", "a mission", deviation(FLIGHT), AtMost(0.5)), 0.25, 0.01, 20),
    Result(Row("bad", "another one", deviation(FLIGHT), AtMost(0.2)), 0.25, 0.02, 20),
    Result(Row("beside", "one without a target", deviation(FLIGHT)), 12.5, 0.0, 20),
]


class Flown:
    """What a figure takes from a summary."""

    def __init__(self, fd, messages_sent):
        self.fd, self.messages_sent = fd, messages_sent


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


def test_mean_and_interval():
    """The interval is 1.96 standard errors, and nothing where every seed gives the same."""
    assert mean_and_interval([1.0, 2.0, 3.0]) == pytest.approx((2.0, 1.96 / 3.0**0.5))
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
    """A ratio is FD over FD, and a share messages over messages, of the same seed."""
    one, other = Flown(0.6, 50), Flown(0.4, 200)
    assert ratio(FLIGHT, FLIGHT).value(one, other) == pytest.approx(1.5)
    assert message_share(FLIGHT, FLIGHT).value(one, other) == pytest.approx(0.25)
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
