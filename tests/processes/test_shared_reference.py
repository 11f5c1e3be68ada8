"""The shared reference and talk by events, as processes."""

import json
import subprocess

from launching import SCENARIO, grex

OPTIONS = ("--set", "duration_s=300", "--set", "link.loss=0.3", "--json")
SLOW = ("--set", "craft.auv3.vehicle.speed_limits=[{start_s=50.0, end_s=150.0, max_mps=0.7}]")


def run(folder, *options):
    """Summary of a run."""
    file = SCENARIO.with_name("shared-reference.toml")
    command = grex("run", str(file), *OPTIONS, *SLOW, *options, "--out", str(folder))
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=100).stdout)


def test_same_digest_in_processes_as_in_one(tmp_path):
    """A slow craft, losses and events: as processes with random delays the run is bit for bit that of one process."""
    processes = run(tmp_path / "processes", "--set", "clock.chaos_delay_s=0.001")
    in_process = run(tmp_path / "one", "--in-process")
    assert processes["digest"] == in_process["digest"]
    assert processes["messages_sent"] == in_process["messages_sent"] > 3
    assert not processes["bad_frames"]
