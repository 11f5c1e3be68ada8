"""`grex replay`, `grex export` and `grex report` on runs that were flown, cut off, foreign, newer, or hold NaN."""

import csv
import json
import re
import subprocess
import sys

import msgspec
import numpy as np
import pyarrow.parquet as pq
import pytest
from missions import SCENARIOS, fly

from grex_link.errors import ConfigError
from grex_link.messages import Fix, ModemEvent, RangeResult
from grex_link.recorder import Recorder
from grex_link.recording import Recording, run_metadata
from grex_link.scenario import load
from grex_sim import cli
from grex_sim.belief_errors import belief_errors
from grex_sim.replay import Difference, first_difference, read_tape
from grex_sim.replay_text import compare, with_estimator
from grex_sim.report_data import labels
from grex_sim.report_page import write_report

TITLE = '<img src=x onerror=alert(1)> & "quoted" \'$x_$'
SHORT = ("duration_s=200", "link.loss=0.2", "mission.leg_length_m=60", f"title={json.dumps(TITLE)}")


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A short mission of three craft."""
    folder = tmp_path_factory.mktemp("flown")
    fly("paper-d", *SHORT, out=folder)
    return folder


@pytest.fixture(scope="module")
def cut(flown, tmp_path_factory):
    """The same recording, cut at half."""
    file = tmp_path_factory.mktemp("cut") / "run.mcap"
    data = (flown / "run.mcap").read_bytes()
    file.write_bytes(data[: len(data) // 2])
    return file


@pytest.fixture
def grex(monkeypatch, capsys):
    """Run the console in this process: (exit status, standard output, standard error)."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["grex", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return run


# -- what a recording may be ---------------------------------------------------------------------------------------


def test_a_whole_recording_is_known_to_be_whole(flown):
    """A recording that has its end says nothing about itself."""
    recording = Recording(flown)
    assert sum(entry.topic == "state" for entry in recording.entries()) == 600
    assert (recording.whole, recording.remark) == (True, "")


def test_a_file_cut_at_half_is_read_to_its_last_whole_chunk(cut):
    """What is left of it is read, and the remark says up to when."""
    recording = Recording(cut)
    ticks = [entry.message.tick for entry in recording.entries(["truth"])]
    assert recording.whole is False
    assert ticks == list(range(len(ticks)))
    assert 0 < len(ticks) < 201
    assert re.search(r"was cut off: read to its last whole chunk, mission time \d+\.\d s$", recording.remark)


def write(path, metadata, fixes=()):
    """Write a recording of fixes."""
    recorder = Recorder(path, metadata)
    for fix in fixes:
        recorder.write("fix", "auv1", fix.t_ns, fix)
    recorder.close()


METADATA = run_metadata(load(SCENARIOS / "paper-d.toml"))


@pytest.mark.parametrize(
    ("metadata", "words"),
    [
        ({}, "is an MCAP file, but no recording of a GREX run|another version of GREX"),
        ({**METADATA, "format": "2"}, r"was recorded by a newer GREX \(recording format 2; this one reads up to 1\)"),
        ({**METADATA, "format": "new"}, "was recorded by a newer GREX"),
        ({**METADATA, "scenario": '{"mission":{}}'}, "was recorded by another version of GREX: its scenario"),
    ],
)
def test_a_foreign_or_newer_recording_is_one_line(tmp_path, metadata, words):
    """Recordings that are not ours, or of a GREX to come, are told apart from those that are damaged."""
    write(tmp_path / "run.mcap", metadata)
    with pytest.raises(ConfigError, match=words):
        Recording(tmp_path)


@pytest.mark.parametrize("damage", ["empty", "text", "flipped", "no file", "no folder"])
@pytest.mark.parametrize("command", ["report", "export", "replay"])
def test_what_is_no_recording_is_one_line(grex, tmp_path, flown, damage, command):
    """An empty file, a text, a flipped bit, and nothing at all: one line each, whatever is asked for."""
    file = tmp_path / "run.mcap"
    if damage == "flipped":
        data = bytearray((flown / "run.mcap").read_bytes())
        data[len(data) // 3] ^= 0x55
        file.write_bytes(data)
    elif damage in {"empty", "text"}:
        file.write_text("" if damage == "empty" else "time,north,east\n" * 100, encoding="utf-8")
    options = {"report": [], "export": ["--to", "csv", "--out", tmp_path / "o"], "replay": ["--craft", "auv1"]}
    run = tmp_path / "nowhere" if damage == "no folder" else tmp_path
    status, _, err = grex(command, run, *options[command])
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith(f"grex: {run}")


# -- replay --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("craft", ["auv1", "auv2", "auv3"])
def test_every_craft_of_a_run_replays(grex, flown, craft):
    """The console says how much was replayed, and that it is the same."""
    status, out, _ = grex("replay", flown, "--craft", craft)
    assert status == 0
    assert re.match(rf"{craft}: 200 steps, \d+ modem events and [67] requests replayed; every output is", out)


def test_a_run_that_was_cut_off_replays_as_far_as_it_goes(grex, cut):
    """A file cut at half is replayed to its last whole chunk, and says so."""
    status, out, _ = grex("replay", cut, "--craft", "auv2")
    remark, found = out.splitlines()
    assert status == 0
    assert "was cut off" in remark
    assert 0 < int(found.split()[1]) < 200


def test_the_first_difference_ends_with_status_1(tmp_path, flown, grex):
    """A recording in which one setpoint is another one is told, with step, field and both values."""
    recorder = Recorder(tmp_path / "run.mcap", run_metadata(Recording(flown).scenario))
    for entry in Recording(flown).entries():
        message = entry.message
        if (entry.topic, entry.craft) == ("setpoint", "auv1") and message.tick == 50:
            message = msgspec.structs.replace(message, speed_mps=message.speed_mps + 1e-6)
        recorder.write(entry.topic, entry.craft, entry.t_ns, message)
    recorder.close()
    status, out, err = grex("replay", tmp_path, "--craft", "auv1")
    assert (status, out) == (1, "")
    assert err.startswith("grex: auv1 replays otherwise from step 50 at 50.000 s: setpoint.speed_mps was recorded as ")


def test_another_estimator_is_judged_against_the_truth(grex, flown):
    """The table has a line for each mate and estimator; figures of the recorded one are those of the recording."""
    status, out, _ = grex("replay", flown, "--craft", "auv2", "--estimator", "dead_reckoning")
    assert status == 0
    tape = read_tape(Recording(flown), "auv2")
    rms = belief_errors(tape.states, tape.truths)["auv1"].rms_m
    lines = [line.split() for line in out.splitlines()]
    recorded = next(line for line in lines if line[:2] == ["auv1", "second_level"])
    replayed = next(line for line in lines if line[:2] == ["auv1", "dead_reckoning"])
    assert recorded[3] == f"{rms:.3f}"
    assert float(replayed[3]) != pytest.approx(rms, rel=1e-3)
    assert (flown / "replay-auv2.png").stat().st_size > 20_000


def test_the_recorded_estimator_believes_the_same_again(flown):
    """Naming the estimator that flew gives the recorded beliefs."""
    recording = Recording(flown)
    tape = read_tape(recording, "auv2")
    assert first_difference(tape, with_estimator(recording.scenario, "second_level"), "auv2") is None
    assert isinstance(first_difference(tape, with_estimator(recording.scenario, "hold_last"), "auv2"), Difference)


def test_who_was_not_there_is_named(flown):
    """An unknown craft, and an unknown estimator, are faults of the command line."""
    with pytest.raises(ConfigError, match=r"^--craft: 'auv9' was not there; there were auv1, auv2, auv3$"):
        compare(flown, "auv9")


def test_a_live_run_replays(tmp_path):
    """At a pace of the wall clock, too, a recording has what a replay needs: which events each step had."""
    fly("paper-d", "duration_s=100", "clock.pace=100", "clock.tick_s=0.5", "link.profile=s2c_im", out=tmp_path)
    assert "every output is the recorded one" in compare(tmp_path, "auv2")


# -- export --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_export_holds_every_message(grex, flown, tmp_path, form):
    """Both kinds of files have a row for each fix and each belief, with the values of the recording."""
    status, out, _ = grex("export", flown, "--to", form, "--out", tmp_path)
    assert status == 0
    read = read_csv if form == "csv" else lambda file: pq.read_table(file).to_pylist()
    fixes = list(Recording(flown).entries(["fix"]))
    rows = read(tmp_path / f"fix.{form}")
    assert len(rows) == len(fixes) == 600
    assert [(row["craft"], int(row["tick"]), float(row["north_m"])) for row in rows] == [
        (entry.craft, entry.message.tick, entry.message.north_m) for entry in fixes
    ]
    assert len(read(tmp_path / f"state_mates.{form}")) == 1200
    assert len(read(tmp_path / f"truth_poses.{form}")) == 603
    assert f"{600:8d} rows  fix.{form}" in out.splitlines()


def read_csv(file):
    """Read a CSV file as dicts."""
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def test_what_is_no_number_survives(tmp_path, grex):
    """NaN stays NaN in CSV and in Parquet, and what is missing stays missing."""
    fix = Fix(0, 0, float("nan"), 2.0, 3.0, 0.0, 1.0, 0.1)
    recorder = Recorder(tmp_path / "run.mcap", METADATA)
    recorder.write("fix", "auv1", 0, fix)
    recorder.write("modem_rx", "auv1", 0, ModemEvent(0, 5, RangeResult(3, "auv2", None)))
    recorder.close()
    for form in ("csv", "parquet"):
        assert grex("export", tmp_path, "--to", form)[0] == 0
    (row,) = pq.read_table(tmp_path / "parquet" / "fix.parquet").to_pylist()
    assert np.isnan(row["north_m"])
    assert row["east_m"] == 2.0
    (event,) = pq.read_table(tmp_path / "parquet" / "modem_rx.parquet").to_pylist()
    assert (event["event_type"], event["event_range_m"]) == ("range_result", None)
    assert read_csv(tmp_path / "csv" / "fix.csv")[0]["north_m"] == "nan"
    assert read_csv(tmp_path / "csv" / "modem_rx.csv")[0]["event_range_m"] == ""


def test_the_example_script_reads_a_run(flown):
    """deploy/examples/read_run.py runs as it is, and prints the FD of the run."""
    script = SCENARIOS.parent / "examples" / "read_run.py"
    ended = subprocess.run(
        [sys.executable, script, flown], capture_output=True, text=True, check=True, timeout=60, cwd=flown
    )
    fd = json.loads((flown / "summary.json").read_text(encoding="utf-8"))["fd"]
    assert f"FD {fd:.4f}" in ended.stdout


# -- report --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def page(flown, cut, tmp_path_factory):
    """The report of a run beside one that was cut off."""
    file = tmp_path_factory.mktemp("report") / "r.html"
    remarks = write_report([flown, cut], file)
    assert [("was cut off" in remark) for remark in remarks] == [True]
    return file.read_text(encoding="utf-8")


def test_a_report_has_everything_in_it(flown, page):
    """Two runs side by side are one page: pictures inside, no script, no address, figures and what was cut off."""
    assert page.count('src="data:image/png;base64,') == 2 + 2 * 3
    assert not re.search(r"<script|https?://|src=\"(?!data:)|href=\"(?!data:)|url\(", page)
    fd = json.loads((flown / "summary.json").read_text(encoding="utf-8"))["fd"]
    assert f"<td>FD</td><td>{fd:.4g} ±" in page
    assert "killed: there is no summary" in page


def test_text_of_a_scenario_is_text(page):
    """Whatever a title holds, it is shown and not obeyed."""
    assert "<img src=x" not in page
    assert "&lt;img src=x onerror=alert(1)&gt; &amp; &quot;quoted&quot;" in page


def test_a_report_of_beliefs_that_are_no_numbers_is_drawn(grex, tmp_path):
    """Steps in which the craft had no position are drawn as gaps, and spoil no mean."""
    fly("paper-d", "duration_s=60", out=tmp_path / "flown")
    recording = Recording(tmp_path / "flown")
    recorder = Recorder(tmp_path / "run.mcap", run_metadata(recording.scenario))
    for entry in recording.entries():
        message = entry.message
        if entry.topic == "state" and 20 <= message.tick < 30:
            mates = [msgspec.structs.replace(mate, north_m=float("nan")) for mate in message.mates]
            message = msgspec.structs.replace(message, mates=mates, xte_m=float("nan"))
        recorder.write(entry.topic, entry.craft, entry.t_ns, message)
    recorder.close()
    assert grex("report", tmp_path)[0] == 0
    assert "nan" not in re.sub(r"base64,[^\"]*", "", (tmp_path / "report.html").read_text(encoding="utf-8")).lower()


def test_runs_of_the_same_name_are_numbered(tmp_path):
    """Labels are the folders' names, numbered where they are the same."""
    for name in ("a/run", "b/run", "c/other"):
        (tmp_path / name).mkdir(parents=True)
    assert labels([tmp_path / "a/run", tmp_path / "b/run", tmp_path / "c/other"]) == ["run (1)", "run (2)", "other"]


def test_without_a_run_it_asks_for_one(grex):
    """`grex report` alone says what is missing."""
    status, _, err = grex("report")
    assert status == 2
    assert "RUN" in err


# -- a full disk ---------------------------------------------------------------------------------------------------


def run_with_room_for(file_bytes, folder, choice, *overrides):
    """Fly case d where no file can be longer than this."""
    program = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({file_bytes}, resource.RLIM_INFINITY))\n"
        "from grex_sim.cli import main; main()\n"
    )
    options = [part for value in (f"recording.on_full_disk={choice}", *overrides) for part in ("--set", value)]
    return subprocess.run(
        [sys.executable, "-c", program, "run", SCENARIOS / "paper-d.toml", "--in-process", "--out", "r", *options],
        capture_output=True, text=True, check=False, timeout=60, cwd=folder,
    )  # fmt: skip


@pytest.mark.parametrize(("choice", "status"), [("stop", 1), ("go_on", 0)])
def test_a_full_disk_stops_a_run_or_its_recording(tmp_path, choice, status):
    """When nothing more can be written, one line says so, the run does as configured, and what was written opens."""
    ended = run_with_room_for(150_000, tmp_path, choice, "duration_s=1200")
    words = "cannot go on recording r/run.mcap: File too large; what was written opens"
    assert (ended.returncode, ended.stderr.count("\n")) == (status, 1)
    assert words in (ended.stderr if choice == "stop" else ended.stdout)
    recording = Recording(tmp_path / "r")
    assert sum(entry.topic == "truth" for entry in recording.entries()) > 20
    assert "was cut off" in recording.remark
    if choice == "go_on":
        assert "1200 s of mission" in ended.stdout


def test_a_summary_that_has_no_room_is_not_half_there(tmp_path):
    """A run that goes on says that there is neither recording nor summary, and leaves no part of one."""
    ended = run_with_room_for(500, tmp_path, "go_on", "duration_s=60")
    assert ended.returncode == 0
    assert "cannot go on recording r/run.mcap: File too large" in ended.stdout
    assert "; cannot write r/summary.json: File too large" in ended.stdout
    assert not (tmp_path / "r" / "summary.json").exists()
