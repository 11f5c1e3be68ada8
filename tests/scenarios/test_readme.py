"""What README says can be done, and comes out, does."""

import re
from pathlib import Path

import pytest
from missions import fly

from grex_link.replay import replay

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
