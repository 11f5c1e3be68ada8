"""`grex study team` as a person runs it: what it prints, what it notices, and how it ends."""

import json
import os
import signal
import subprocess
import time

import psutil
import pytest
from launching import grex, running

from grex_link.errors import GrexError
from grex_sim.study.figures import Flight, deviation, ratio
from grex_sim.study.table import Row
from grex_sim.study.team import run_study
from grex_sim.study.workers import run_jobs

SHORT = ("duration_s=60", "team.estimator=along_track")


def test_a_study_agrees_with_processes():
    """Runs in memory over all cores end with the digest of runs as processes, and give a mean and an interval."""
    still, lossy = Flight("paper-d", SHORT), Flight("paper-d", (*SHORT, "link.loss=0.5", "duration_s=200"))
    rows = [Row("one", "", ratio(still, still)), Row("two", "", deviation(lossy))]
    study = run_study(3, rows=rows)
    assert study.mismatches == []
    one, two = study.results
    assert (one.value, one.interval, one.seeds) == (1.0, 0.0, 3)
    assert two.value == pytest.approx(sum(lossy.run(seed).fd for seed in (1, 2, 3)) / 3.0, abs=1e-12)
    assert two.interval > 0.0


def test_what_is_not_random_runs_twice():
    """A mission in which nothing is drawn is not flown for every seed, and its results are those of every seed."""
    told = []
    still = Flight("paper-d", SHORT)
    results = run_jobs([still], 50, lambda done, total: told.append((done, total)))
    assert len(results[still]) == 50
    assert told[-1] == (2, 2)
    assert results[still][49].digest == still.run(50).digest


def test_another_digest_is_noticed(tmp_path, monkeypatch):
    """A row that is not the same in memory and as processes is named with both digests."""
    (tmp_path / "restless.py").write_text(
        "import sys\n"
        "from grex_agent.team.reckoning import DeadReckoning, HoldLast\n"
        "Restless = DeadReckoning if sys.argv[0].endswith('grex_agent/__main__.py') else HoldLast\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    restless = Flight("paper-d", ("duration_s=90", "team.estimator=restless:Restless"))
    (mismatch,) = run_study(2, rows=[Row("odd", "", deviation(restless))]).mismatches
    assert mismatch.startswith(f"odd: digest {restless.run(1).digest} in memory, but ")


def consistency_of(seeds):
    """Run a study of one quick row over some seeds."""
    command = grex("study", "team", "--seeds", str(seeds), "--only", "nees_dead_reckoning_loss0", "--json")
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)


def test_json_and_nothing_else():
    """With --json one object comes on standard output, and nothing on standard error when that is no terminal."""
    done = consistency_of(3)
    assert (done.returncode, done.stderr) == (0, "")
    (row,) = json.loads(done.stdout)["rows"]
    assert sorted(row) == ["interval", "row", "seeds", "value"]
    assert (row["row"], row["seeds"]) == ("nees_dead_reckoning_loss0", 3)


def test_a_missed_target_ends_with_status_1():
    """Ten samples of a row that fall out of its band are printed as ever; one line says so, and the status is 1."""
    done = consistency_of(2)
    (row,) = json.loads(done.stdout)["rows"]
    assert row["value"] < 0.32
    assert done.returncode == 1
    assert done.stderr == f"grex: MISSED: nees_dead_reckoning_loss0 is {row['value']:.4f}, must be 0.32-2.05\n"


def test_an_unknown_row_is_one_line():
    """A row that is not there is one line that names those there are, and status 2."""
    done = subprocess.run(
        grex("study", "team", "--only", "nothing"), capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 2
    assert done.stderr.startswith("grex: --only: unknown row 'nothing'; there are best_fd_loss0, ")
    assert done.stderr.count("\n") == 1


def test_ctrl_c_ends_it_cleanly(gone):
    """Ctrl-C, which goes to every process of the terminal, ends a study at once with one line and leaves nobody."""
    with running("study", "team", "--seeds", "1000") as process:
        deadline = time.monotonic() + 60.0
        while len(children := psutil.Process(process.pid).children(recursive=True)) < 2:
            assert time.monotonic() < deadline, "the study did not get under way"
            time.sleep(0.05)
        time.sleep(1.0)
        for each in (psutil.Process(process.pid), *children):
            each.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (130, "grex: interrupted\n")
    assert gone(children)


def test_a_job_that_fails_is_named(tmp_path, monkeypatch):
    """A run that breaks ends the study with one line that says which job at which seed, and why."""
    (tmp_path / "broken.py").write_text(
        "class Broken:\n    def __init__(self, context):\n        raise ValueError('oh')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(GrexError, match=r"broken:Broken.*, seed [12]: .*oh"):
        run_jobs([Flight("paper-d", ("duration_s=60", "team.estimator=broken:Broken"))], 2, lambda *_: None)
