"""A recording as frames for the page: whole, cut, foreign, newer, with holes in the data."""

import json

import pytest
from msgspec.structs import replace
from recordings import METADATA, recorded_messages

from grex_link.errors import ConfigError
from grex_link.messages import LinkLedger
from grex_link.recorder import Recorder
from grex_link.recording import Recording, run_metadata
from grex_sim.view.recorded_page import RecordedPage


def frames(page):
    return [frame for piece in page.pieces for frame in json.loads(piece)]


def test_every_tick_is_a_frame(recorded) -> None:
    """A short run has a frame for each tick, with the recorded poses and the deviation of the run's own series."""
    page = RecordedPage(recorded)
    shown = frames(page)
    assert [frame["t"] for frame in shown] == page.scene["times"] == [float(tick) for tick in range(301)]
    for frame, truth in zip(shown, recorded_messages(recorded, "truth"), strict=True):
        assert frame["craft"]["auv2"]["true"][0] == pytest.approx(truth.poses[1].north_m, abs=1e-4)
    series = [float(row.split(",")[1]) for row in (recorded / "series.csv").read_text().split()[1:]]
    assert [frame["fd"][0] for frame in shown[1:]] == pytest.approx(series, abs=1e-6)


def test_every_message_appears_with_its_outcomes(recorded) -> None:
    """Every transmission that ended is on some frame, with each receiver's outcome and cause."""
    wanted = {
        (event.source, event.seq, event.destination): event.reason
        for event in recorded_messages(recorded, "link_event")
        if event.kind in {"lost", "delivered"}
    }
    seen = {}
    for frame in frames(RecordedPage(recorded)):
        for sound in frame["sounds"]:
            source, seq, *_ = sound["id"].split("/")
            seen.update({(source, int(seq), who): end[2] for who, end in sound["ends"].items()})
    assert seen == wanted
    assert "lost_burst" not in seen.values()
    assert len({reason for reason in seen.values() if reason}) == 1


def test_a_long_run_is_thinned(recorded, monkeypatch) -> None:
    """A run of more ticks than there is room for has every so many of them, from the first on."""
    monkeypatch.setattr("grex_sim.view.recorded_page._FRAMES_MAX", 50)
    assert RecordedPage(recorded).scene["times"] == [float(tick) for tick in range(0, 301, 7)]


def test_a_file_cut_at_half_shows_what_is_left(recorded, tmp_path) -> None:
    """Of a file that was cut the frames up to the cut are there."""
    whole = (recorded / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(whole[: len(whole) // 2])
    count = RecordedPage(tmp_path).scene["frames"]
    assert 30 < count < 301


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing", None, "is no run: there is no such folder"),
        ("text", b"no recording at all, but longer than a magic number", "is no recording, or is damaged"),
        ("empty", b"", "is empty: nothing was recorded"),
    ],
)
def test_what_is_no_recording_is_named(tmp_path, name, content, words) -> None:
    """A file that is none ends in one line that names it."""
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=words) as fault:
        RecordedPage(path)
    assert str(path) in str(fault.value)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("metadata", "words"),
    [
        ({"made_by": "somebody else"}, "is an MCAP file, but no recording of a GREX run|another version of GREX"),
        ({"scenario": "{"}, "was recorded by another version of GREX: its scenario"),
        ({"scenario": '{"mission":{"type":"spiral"}}'}, "was recorded by another version of GREX: its scenario"),
    ],
)
def test_another_recording_is_named(tmp_path, metadata, words) -> None:
    """A recording of something else, or of a newer GREX, ends in one line that says so."""
    Recorder(tmp_path / "run.mcap", metadata).close()
    with pytest.raises(ConfigError, match=words):
        RecordedPage(tmp_path)


def test_null_stands_for_nan(recorded, tmp_path) -> None:
    """A NaN that was recorded, which JSON cannot say, is a gap, at that tick only."""
    recorder = Recorder(tmp_path / "run.mcap", run_metadata(Recording(recorded).scenario))
    for truth in recorded_messages(recorded, "truth"):
        nowhere = replace(truth, poses=[replace(truth.poses[0], east_m=float("nan"))])
        recorder.write("truth", "", truth.t_ns, nowhere if truth.tick == 5 else truth)
    recorder.close()
    shown = frames(RecordedPage(tmp_path))
    assert shown[5]["craft"]["auv1"]["true"][1] is None
    assert shown[6]["craft"]["auv1"]["true"][1] is not None


def test_messages_of_another_version_are_one_line(tmp_path) -> None:
    """A recording whose messages are others than ours is named, with the message that is."""
    recorder = Recorder(tmp_path / "run.mcap", METADATA)
    recorder.write("truth", "", 0, LinkLedger(0, [], []))
    recorder.close()
    with pytest.raises(ConfigError, match="was recorded by another version of GREX: truth: "):
        RecordedPage(tmp_path)
