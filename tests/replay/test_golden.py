"""Golden recordings are replayed: an agent of today does what that of then did, given the same.

`pytest tests/replay --refresh-golden` flies them anew; look at what has changed, and say so in CHANGELOG.md.
"""

from pathlib import Path

import msgspec
import pytest
from missions import SCENARIOS

from grex_link.recorder import Recorder
from grex_link.recording import Recording, run_metadata
from grex_link.scenario import load
from grex_sim.replay import TOPICS, first_difference, read_tape
from grex_sim.run import simulate_in_process

FOLDER = Path(__file__).parent / "golden"
SHORT = ("mission.leg_length_m=15", "mission.legs=2", "duration_s=40", "link.profile=s2c_im", "link.loss=0.2")
#: For each recording: the scenario it is flown with, and whose inputs are kept.
GOLDEN = {
    "second_level": (("team.estimator=second_level",), "auv2"),
    "along_track": (("team.estimator=along_track",), "auv3"),
    "ideal": (("team.estimator=ideal",), "auv1"),
    "own_filter": (
        ("team.estimator=along_track_first", "team.own_filter={}", "sea.current_ned_mps=[0.1,0.05,0.0]"),
        "auv2",
    ),
}


def refresh(name, folder):
    """Fly a golden run, and keep what one craft needs of it."""
    overrides, craft = GOLDEN[name]
    simulate_in_process(load(SCENARIOS / "paper-d.toml", [*SHORT, *overrides]), folder, lambda _: None)
    flown = Recording(folder)
    recorder = Recorder(FOLDER / f"{name}.mcap", run_metadata(flown.scenario))
    topics = TOPICS if name == "ideal" else [topic for topic in TOPICS if topic != "truth"]
    for entry in flown.entries(topics):
        if entry.craft in {craft, ""}:
            recorder.write(entry.topic, entry.craft, entry.t_ns, entry.message)
    recorder.close()


@pytest.fixture(params=GOLDEN)
def golden(request, tmp_path):
    """A golden recording: (recording, craft)."""
    if request.config.getoption("--refresh-golden"):
        refresh(request.param, tmp_path)
    return Recording(FOLDER / f"{request.param}.mcap"), GOLDEN[request.param][1]


def test_an_agent_of_today_does_what_was_recorded(golden):
    """Setpoints, states and transmissions are those of the golden recording within 1e-9, step by step."""
    recording, craft = golden
    tape = read_tape(recording, craft)
    assert len(tape.states) == 40
    assert len(tape.events) >= 10
    assert first_difference(tape, recording.scenario, craft) is None


def test_a_changed_agent_is_found_out(golden):
    """An agent with another gain differs, and the first difference names step, field and both values."""
    recording, craft = golden
    tape = read_tape(recording, craft)
    team = msgspec.structs.replace(recording.scenario.team, gain_mps=0.81)
    found = first_difference(tape, msgspec.structs.replace(recording.scenario, team=team), craft)
    assert found is not None
    assert "ordered_mps" in str(found) or "mates" in str(found)


def test_golden_recordings_are_small():
    """All golden recordings together stay below 160 kB."""
    assert 0 < sum(file.stat().st_size for file in FOLDER.glob("*.mcap")) < 160_000
