"""The paces that run with the wall clock, as processes."""

import json
import subprocess

import pytest
from launching import SCENARIO, grex


@pytest.fixture(scope="module")
def scaled(tmp_path_factory) -> dict:
    """Case d for 150 s of mission at 25 times the wall clock."""
    folder = str(tmp_path_factory.mktemp("scaled"))
    command = grex("run", str(SCENARIO), "--pace", "25", "--set", "duration_s=150", "--json", "--out", folder)
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout)


def test_mission_time_runs_with_the_wall_clock(scaled):
    """At pace 25 a mission of 150 s takes 6 s of wall time, and no less."""
    assert scaled["pace"] == 25.0
    assert 6.0 <= scaled["wall_s"] < 9.0


def test_messages_pass_at_a_scaled_pace(scaled):
    """Every slot is used and every datagram that has had its time is received."""
    assert scaled["messages_sent"] == 15
    assert scaled["delivered"] >= 26
    assert scaled["bad_frames"] == {}


def test_the_same_agent_keeps_the_formation(scaled):
    """The live team keeps the formation as the lockstep team does, and keeps up with the clock at least at times."""
    assert scaled["fd"] < 1.0
    assert scaled["late_ticks"] < scaled["ticks"]
