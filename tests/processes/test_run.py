"""One run as processes, recorded; then many assertions on what it left."""

import json
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from launching import SCENARIO, grex, participants, running
from mcap.reader import make_reader

DURATION_S = 600


@dataclass
class Recorded:
    summary: dict
    folder: Path
    processes: dict = field(default_factory=dict)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Recorded:
    """Case d for ten minutes of mission, everybody delayed at random so that it can be watched."""
    folder = tmp_path_factory.mktemp("run")
    seen: dict = {}
    options = (
        "--set",
        f"duration_s={DURATION_S}",
        "--set",
        "clock.chaos_delay_s=0.001",
        "--json",
        "--out",
        str(folder),
    )
    with running("run", str(SCENARIO), *options) as process:
        while process.poll() is None:
            if len(seen) < 5:
                seen = {who: (child.pid, child.ppid()) for who, child in participants(process.pid).items()}
            time.sleep(0.02)
        out, err = process.communicate()
    assert process.returncode == 0, err
    assert err == ""
    return Recorded(json.loads(out), folder, seen)


@pytest.fixture(scope="module")
def in_process(tmp_path_factory) -> dict:
    folder = tmp_path_factory.mktemp("in-process")
    command = grex(
        "run", str(SCENARIO), "--in-process", "--set", f"duration_s={DURATION_S}", "--json", "--out", str(folder)
    )
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout)


def channels(folder: Path) -> dict[str, int]:
    with (folder / "run.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
        counts = summary.statistics.channel_message_counts
        return {channel.topic: counts[number] for number, channel in summary.channels.items()}


def test_five_processes_for_three_craft(run):
    """Three craft are five processes: an agent each, the link and the simulator."""
    assert set(run.processes) == {"auv1", "auv2", "auv3", "link", "sim"}
    assert len({pid for pid, _ in run.processes.values()}) == 5
    assert len({parent for _, parent in run.processes.values()}) == 1


def test_the_first_tick_comes_soon(run):
    """Everybody is on the bus, and the mission starts, within five seconds."""
    assert 0.0 < run.summary["startup_s"] < 5.0


def test_same_digest_with_random_delays_in_every_process(run, in_process):
    """Any scheduling of the processes gives the same truth, link log and setpoints as one process, bit by bit."""
    assert run.summary["digest"] == in_process["digest"]
    assert run.summary["fd"] == in_process["fd"]


def test_summary_has_the_promised_figures(run):
    """The JSON object holds every figure the README promises."""
    promised = [
        "fd",
        "fd_distance",
        "fd_angle",
        "fd_xte",
        "duration_s",
        "wall_s",
        "real_time_factor",
        "ticks_per_s",
        "messages_sent",
        "bytes_sent",
        "delivered",
        "lost",
        "digest",
    ]
    assert all(run.summary[name] is not None for name in promised)
    assert run.summary["complete"]
    assert run.summary["duration_s"] == DURATION_S
    assert run.summary == json.loads((run.folder / "summary.json").read_text())


def test_every_message_is_counted(run):
    """Sixty slots of ten seconds: sixty messages of 15 bytes, the last one still on the air at the end."""
    assert run.summary["messages_sent"] == 60
    assert run.summary["bytes_sent"] == 60 * 15
    assert run.summary["delivered"] == 59 * 2
    assert run.summary["in_flight"] == 2


def test_recording_holds_every_topic_at_every_tick(run):
    """The MCAP file has each craft's fix, setpoint and state for every tick, and the truth."""
    counts = channels(run.folder)
    for craft in ("auv1", "auv2", "auv3"):
        assert counts[f"/{craft}/fix"] == counts[f"/{craft}/setpoint"] == counts[f"/{craft}/state"] == DURATION_S
        assert counts[f"/{craft}/modem/tx"] == 20
    assert counts["/truth"] == DURATION_S + 1
    assert counts["/link/event"] == run.summary["messages_sent"] + run.summary["delivered"]


def test_recording_is_json_with_schemas(run):
    """Any viewer can read the recording: every channel is JSON with a JSON schema, or Foxglove's own in protobuf."""
    with (run.folder / "run.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema.name.startswith("foxglove."):
                assert schema.encoding == channel.message_encoding == "protobuf"
                continue
            assert schema.encoding == "jsonschema"
            assert channel.message_encoding == "json"
            assert json.loads(message.data)
            json.loads(schema.data)


def test_series_has_a_row_a_tick(run):
    """The per-step series holds fd(k) and its parts for every tick, and they add up."""
    rows = (run.folder / "series.csv").read_text().splitlines()
    assert len(rows) == DURATION_S + 1
    values = [[float(value) for value in row.split(",")] for row in rows[1:]]
    assert all(abs(row[1] - sum(row[2:5])) < 1e-6 for row in values)
    assert sum(row[1] for row in values) / DURATION_S == pytest.approx(run.summary["fd"], rel=1e-6)


def test_the_run_is_drawn(run):
    """A picture of the run is there, and is one."""
    assert (run.folder / "run.png").read_bytes().startswith(b"\x89PNG")
