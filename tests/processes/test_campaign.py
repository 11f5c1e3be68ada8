"""Campaigns as a user starts, kills and resumes them, with real processes."""

import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import ExitStack

import msgspec
import pyarrow.parquet as pq
import pytest
from missions import SCENARIOS

from grex_sim.launch import free_port

PAPER = str(SCENARIOS / "paper-d.toml")
SHORT = ("--set", "duration_s=120", "--vary", "link.loss=0,0.5", "--vary", "team.estimator=none,first_level")


def command(folder, *options):
    return [
        sys.executable,
        "-m",
        "grex_sim",
        "campaign",
        PAPER,
        *SHORT,
        "--workers",
        "2",
        "--out",
        str(folder),
        *options,
    ]


def journal_lines(folder):
    file = folder / "journal.jsonl"
    return file.read_bytes().count(b"\n") - 1 if file.exists() else 0


def wait_for(folder, lines, process):
    deadline = time.monotonic() + 60.0
    while journal_lines(folder) < lines and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)


def table_of(folder):
    rows = pq.read_table(folder / "runs.parquet").to_pylist()
    return [{name: value for name, value in row.items() if name != "wall_s"} for row in rows]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A campaign of four cells and six seeds that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    ended = subprocess.run(command(folder, "--seeds", "6"), capture_output=True, text=True, check=True, timeout=120)
    return folder, ended.stdout


def test_a_campaign_leaves_a_row_a_run_a_table_and_a_picture(whole):
    """Four cells times six seeds are 24 rows, each with its values and seed; the table has a line a cell."""
    folder, out = whole
    rows = table_of(folder)
    combinations = Counter((row["link.loss"], row["team.estimator"]) for row in rows)
    assert combinations == {(loss, name): 6 for loss in (0.0, 0.5) for name in ("none", "first_level")}
    assert {row["seed"] for row in rows} == set(range(1, 7))
    assert not any(row["failed"] for row in rows)
    assert (folder / "campaign.png").stat().st_size > 20_000
    assert "24 missions of 120 s" in out
    table = [line.split() for line in out.splitlines()[2:6]]
    assert [line[:4] for line in table] == [
        [loss, name, "6", "0"] for loss in ("0", "0.5") for name in ("none", "first_level")
    ]


def test_a_run_of_a_campaign_is_that_of_grex_run(whole):
    """The digest in a row is that of the same scenario and seed flown by `grex run`."""
    folder, _ = whole
    row = next(row for row in table_of(folder) if row["cell"] == 3 and row["seed"] == 4)
    options = ["--set", "duration_s=120", "--set", "link.loss=0.5", "--set", "team.estimator=first_level"]
    ended = subprocess.run(
        [sys.executable, "-m", "grex_sim", "run", PAPER, *options, "--seed", "4", "--in-process", "--json",
         "--out", folder / "one"],
        capture_output=True, check=True, timeout=60,
    )  # fmt: skip
    assert msgspec.json.decode(ended.stdout)["digest"] == row["digest"]


@pytest.mark.parametrize(("number", "status"), [(signal.SIGKILL, -9), (signal.SIGINT, 130)])
def test_a_campaign_that_was_stopped_goes_on_where_it_was(tmp_path, whole, number, status):
    """Killed or interrupted, the same command flies the rest; the results are those of one that was not."""
    folder = tmp_path / "stopped"
    with subprocess.Popen(command(folder, "--seeds", "6"), stderr=subprocess.PIPE, text=True) as process:
        wait_for(folder, 5, process)
        process.send_signal(number)
        said = process.stderr.read()
    assert process.returncode == status
    kept = journal_lines(folder)
    assert 5 <= kept < 24
    if status == 130:
        assert said == (
            f"grex: interrupted: {kept} of 24 runs are kept in {folder}; the same command goes on from there\n"
        )
    again = subprocess.run(command(folder, "--seeds", "6"), capture_output=True, text=True, check=True, timeout=120)
    assert f"{24 - kept} missions of 120 s" in again.stdout
    assert table_of(folder) == table_of(whole[0])
    assert journal_lines(folder) == 24


def test_another_definition_in_the_same_folder_is_refused(whole):
    """Other seeds in the folder of a campaign are one line, and nothing of it changes."""
    folder, _ = whole
    before = (folder / "journal.jsonl").read_bytes()
    ended = subprocess.run(command(folder, "--seeds", "7"), capture_output=True, text=True, check=False, timeout=60)
    assert ended.returncode == 2
    assert ended.stderr == (f"grex: {folder}: holds another campaign (6 seeds instead of 7); take another --out\n")
    assert (folder / "journal.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--vary", "link.los=1"], "$.link.los: unknown key"),
        (["--vary", "title"], "--vary: 'title' does not have the form"),
        (["--seeds", "0"], "--seeds: must be 1 or more"),
        (["--set", "clock.pace=live"], "$.clock.pace: a campaign flies in lockstep only"),
        pytest.param(
            ["--scheduler", "tcp://127.0.0.1:1"],
            "--scheduler: no Dask scheduler answers at tcp://127.0.0.1:1",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_cannot_work_is_one_line(tmp_path, options, words):
    """A fault of the command line is found before anything is flown."""
    ended = subprocess.run(command(tmp_path / "c", *options), capture_output=True, text=True, check=False, timeout=60)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert ended.stderr.startswith(f"grex: {words}")
    assert journal_lines(tmp_path / "c") <= 0


@pytest.mark.slow
def test_a_cluster_of_which_a_worker_is_killed_loses_no_run(tmp_path, whole):
    """A real scheduler with two workers, one killed midway: every run ends once, with the figures of a local one."""
    address = f"tcp://127.0.0.1:{free_port()}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    dask = [sys.executable, "-m", "distributed.cli."]
    with ExitStack() as stack:

        def start(program, *options):
            process = stack.enter_context(subprocess.Popen([*dask[:2], dask[2] + program, *options], **quiet))
            stack.callback(process.kill)
            return process

        start("dask_scheduler", "--host", address, "--no-dashboard", "--no-jupyter")
        workers = [
            start("dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", str(n))
            for n in range(2)
        ]
        folder = tmp_path / "cluster"
        with subprocess.Popen(
            [*command(folder, "--seeds", "6"), "--scheduler", address], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True,
        ) as process:  # fmt: skip
            wait_for(folder, 6, process)
            workers[0].kill()
            out, err = process.communicate(timeout=90)
    assert (process.returncode, err) == (0, "")
    assert 6 <= journal_lines(folder) == 24
    assert "24 missions of 120 s" in out
    assert table_of(folder) == table_of(whole[0])
