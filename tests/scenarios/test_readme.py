"""What README says can be done, and comes out, does."""

import re
from pathlib import Path

import pytest
from missions import fly

from grex_link.replay import replay
from grex_sim.study.rows import CONDITIONS, S0, p_law
from grex_sim.study.rows_beyond import best
from grex_sim.study.rows_talk import S2C_IM, on_s2c_im

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def plug_in(tmp_path, monkeypatch):
    """The module that README shows, where Python finds it."""
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (tmp_path / "my_team.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.parametrize("overrides", [1, 2], ids=["estimator", "both"])
def test_the_plug_in_gives_what_is_printed(plug_in, overrides):
    """The example estimator, and the example controller with it, run as they stand and give the FD printed there."""
    names = ("team.estimator=my_team:DeadReckoning", "team.controller=my_team:WaitForTheLast")[:overrides]
    title = ("own", "both")[overrides - 1]
    printed = re.search(rf"^{title}\nformation deviation FD ([\d.]+)", README, re.MULTILINE)[1]
    assert f"{fly('paper-d', *names).fd:.4f}" == printed


@pytest.mark.parametrize("case", "abcd")
def test_table_1_is_what_is_printed(case):
    """The FD of every case in README's table is what its scenario gives."""
    printed = re.search(rf"^\| {case} \|[^|]*\| ([\d.]+) \|", README, re.MULTILINE)[1]
    assert f"{fly(f'paper-{case}').fd:.4f}" == printed


@pytest.mark.parametrize("modem", ["umodem_psk6", "janus", "grex2008"])
def test_the_table_of_modems_is_what_is_printed(modem):
    """FD and mean age of a modem in README's table, without bursts and with, are what the paper's mission gives."""
    row = re.search(rf"^\| {modem} \|(.*)\|$", README, re.MULTILINE)[1].split("|")
    bursts = "link.burst={loss=0.5,mean_length_s=60}"
    assert bursts in README
    for column, overrides in ((2, ()), (4, (bursts,))):
        summary = fly("paper-d", f"link.profile={modem}", *overrides)
        ages = [path.age_mean_s for path in summary.paths.values()]
        assert f"{summary.fd:.4f}" == row[column].strip()
        assert f"{sum(ages) / len(ages):.1f}" == row[column + 1].strip()


def test_the_medium_alone_gives_what_is_printed(tmp_path):
    """The example of grex medium has the outcomes that README counts."""
    folder = Path(__file__).parents[2] / "deploy" / "medium"
    counts = replay(folder / "schedule.csv", folder / "link.toml", tmp_path / "outcomes.csv")
    assert ", ".join(f"{count} {outcome}" for outcome, count in counts.items()) + "; written to" in README


def table(heading):
    """Read the table of README whose first heading is this: cells by the first cell of their row."""
    (rows,) = re.findall(rf"^\| {re.escape(heading)} \|.*\n\|[-|]+\n((?:\|.*\n)+)", README, re.MULTILINE)
    split = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows.splitlines()]
    return {first: rest for first, *rest in split}


def assert_printed(value, printed):
    """Hold a value against a cell, to as many decimals as that has, whatever stands after the number."""
    number = printed.strip("*").split(" ")[0]
    decimals = len(number.partition(".")[2])
    assert f"{value:.{decimals}f}" == number


METHODS = {
    **{name: f"`{name}`" for name in ("none", "hold_last", "dead_reckoning", "biased_planar", "along_track", "ideal")},
    "first_level": "`first_level` (paper's c)",
    "second_level": "`second_level` (paper's d)",
    "best": "best law",
}
#: In the other conditions something is drawn at random, and a mean over 20 seeds takes minutes.
STILL = ("s0", "s2", "s3", "s5")
#: One of them at every run of the tests.
QUICK = ("hold_last", "s3")


@pytest.mark.parametrize(
    ("method", "condition"),
    [
        pytest.param(method, condition, marks=() if (method, condition) == QUICK else pytest.mark.slow)
        for method in METHODS
        for condition in STILL
    ],
)
def test_the_table_of_conditions_is_what_is_printed(method, condition):
    """FD in a condition where nothing is random, under the paper's law or the best one, is what README says."""
    flight = best(condition) if method == "best" else p_law(CONDITIONS[condition][0], method)
    assert_printed(flight.run(1).fd, table("FD")[METHODS[method]][list(CONDITIONS).index(condition)])


TALK = {
    "periodic": "`periodic`",
    "event": "`event`, `heartbeat_slots = 15`",
    "event_quiet": "`event`, `heartbeat_slots = 288`",
    "best": "best law, `heartbeat_slots = 9`",
    "best_quiet": "best law, `heartbeat_slots = 198`",
}


@pytest.mark.slow
@pytest.mark.parametrize("talk", TALK)
def test_the_table_of_talk_is_what_is_printed(talk):
    """Messages, bytes, energy and FD of a kind of talk on a modem whose source level is known are what README says."""
    flown, ideal = on_s2c_im(talk).run(1), p_law(S0, "ideal", more=S2C_IM).run(1)
    messages, size, joules, ratio, _ = table("talk on `s2c_im`")[TALK[talk]]
    assert (str(flown.messages_sent), str(flown.bytes_sent)) == (messages, size)
    assert_printed(flown.team_sound_j, joules)
    assert_printed(flown.fd / ideal.fd, ratio)


RANGES = {
    "`team.ranging.mode=off`": ("team.ranging.mode=off",),
    "two-way (as it is)": (),
    "two-way, `link.loss=0.5`": ("link.loss=0.5",),
    "two-way, a tenth of the ranges up to 50 m too long": ("link.ranging={outlier_probability=0.1,outlier_m=50.0}",),
    "one-way on `umodem_psk1`": ("link.profile=umodem_psk1", "team.ranging.mode=one_way"),
}


@pytest.mark.slow
@pytest.mark.parametrize("ranging", RANGES)
def test_the_table_of_ranges_is_what_is_printed(ranging):
    """Errors of two craft that drift for two hours are what README says, without ranges and with them."""
    errors = fly("ins-drift", *RANGES[ranging]).navigation
    found = [figure for craft in ("auv1", "auv2") for figure in (errors[craft].rms_m, errors[craft].max_m)]
    for value, printed in zip(found, table("`deploy/scenarios/ins-drift.toml`")[ranging], strict=True):
        assert_printed(value, printed)


def test_the_base_is_as_good_as_is_printed():
    """The base knows the place of the craft that it watches as well as README says."""
    printed = re.search(r"`deploy/scenarios/base.toml` that is ([\d.]+) m r\.m\.s\.", README)[1]
    assert_printed(fly("base").navigation["base>auv2"].rms_m, printed)
