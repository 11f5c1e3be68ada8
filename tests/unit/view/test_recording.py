"""A recording as frames for the page: whole, cut, foreign, newer, with holes in the data."""

import json

import msgspec
import pytest

from grex_link.errors import ConfigError
from grex_link.messages import Truth
from grex_link.recorder import Recorder, read_messages, read_scenario
from grex_sim.view.recording import Recording


def frames(recording):
    return [frame for piece in recording.pieces for frame in json.loads(piece)]


def test_every_tick_is_a_frame(recorded) -> None:
    """A short run has a frame for each tick, with the recorded poses and the deviation of the run's own series."""
    recording = Recording(recorded)
    shown = frames(recording)
    assert [frame["t"] for frame in shown] == recording.scene["times"] == [float(tick) for tick in range(301)]
    truths = [message for topic, _, message in read_messages(recorded / "run.mcap") if topic == "/truth"]
    for frame, truth in zip(shown, truths, strict=True):
        assert frame["craft"]["auv2"]["true"][0] == pytest.approx(truth["poses"][1]["north_m"], abs=1e-4)
    series = [float(row.split(",")[1]) for row in (recorded / "series.csv").read_text().split()[1:]]
    assert [frame["fd"][0] for frame in shown[1:]] == pytest.approx(series, abs=1e-6)
    assert recording.bad_payloads == 0


def test_every_message_appears_with_its_outcomes(recorded) -> None:
    """Every transmission that ended is on some frame, with each receiver's outcome and cause."""
    events = [message for topic, _, message in read_messages(recorded / "run.mcap") if topic == "/link/event"]
    wanted = {
        (e["source"], e["seq"], e["destination"]): e["reason"] for e in events if e["kind"] in {"lost", "delivered"}
    }
    seen = {}
    for frame in frames(Recording(recorded)):
        for sound in frame["sounds"]:
            source, seq, *_ = sound["id"].split("/")
            seen.update({(source, int(seq), who): end[2] for who, end in sound["ends"].items()})
    assert seen == wanted
    assert "lost_burst" not in seen.values()
    assert len({reason for reason in seen.values() if reason}) == 1


def test_a_long_run_is_thinned(recorded, monkeypatch) -> None:
    """A run of more ticks than there is room for has every so many of them, from the first on."""
    monkeypatch.setattr("grex_sim.view.recording._FRAMES_MAX", 50)
    recording = Recording(recorded)
    assert recording.scene["times"] == [float(tick) for tick in range(0, 301, 7)]


def test_a_file_cut_at_half_shows_what_is_left(recorded, tmp_path) -> None:
    """Of a file that was cut the frames up to the cut are there."""
    whole = (recorded / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(whole[: len(whole) // 2])
    count = Recording(tmp_path).scene["frames"]
    assert 30 < count < 301


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing", None, "cannot read the recording: No such file"),
        ("text", b"no recording at all, but longer than a magic number", "is no recording, or is damaged"),
        ("empty", b"", "is no recording"),
    ],
)
def test_what_is_no_recording_is_named(tmp_path, name, content, words) -> None:
    """A file that is none ends in one line that names it."""
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=words) as fault:
        Recording(path)
    assert str(path) in str(fault.value)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("metadata", "words"),
    [
        ({"made_by": "somebody else"}, "names no scenario"),
        ({"scenario": "{"}, "holds no scenario that this version of GREX knows"),
        ({"scenario": '{"mission":{"type":"spiral"}}'}, "is of another version of GREX"),
    ],
)
def test_another_recording_is_named(tmp_path, metadata, words) -> None:
    """A recording of something else, or of a newer GREX, ends in one line that says so."""
    Recorder(tmp_path / "run.mcap", metadata).close()
    with pytest.raises(ConfigError, match=words):
        Recording(tmp_path)


def test_null_stands_for_nan(recorded, tmp_path) -> None:
    """A NaN that was recorded, which JSON cannot say, is a gap; what does not decode at all is counted."""
    path = recorded / "run.mcap"
    recorder = Recorder(tmp_path / "run.mcap", {"scenario": read_scenario(path)})
    for _, t_ns, message in read_messages(path, lambda topic: topic == "/truth"):
        truth = msgspec.convert(message, Truth)
        if truth.tick == 5:
            truth = msgspec.structs.replace(truth, poses=[msgspec.structs.replace(truth.poses[0], east_m=float("nan"))])
        recorder.write("truth", "", t_ns, truth)
    recorder.close()
    recording = Recording(tmp_path)
    frame = frames(recording)[5]
    assert frame["craft"]["auv1"]["true"][1] is None
    assert recording.bad_payloads == 0
