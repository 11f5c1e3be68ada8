"""A recording opens in the field's viewers, and what was flushed survives whatever happens to its end."""

from pathlib import Path
from typing import get_args

import msgspec
import pytest
from mcap.reader import make_reader
from recordings import METADATA, recorded_messages

from grex_link.errors import ConfigError
from grex_link.messages import AgentState, Fix, ModemEvent, Received, Truth
from grex_link.recorder import Recorder
from grex_link.recording import Entry, Recording
from grex_link.topics import TOPICS


def fix(tick: int) -> Fix:
    return Fix(tick, tick * 10**9, 1.0 / 3.0, -2.0, 3.0, 0.5, 1.0, 0.1)


def record(path: Path, chunks: list[int]) -> list[int]:
    """Record some fixes in each chunk; the length of the file after each."""
    recorder = Recorder(path, METADATA)
    tick, lengths = 0, []
    for count in chunks:
        for _ in range(count):
            recorder.write("fix", f"auv{1 + tick % 3}", tick * 10**9, fix(tick))
            tick += 1
        recorder.flush()
        lengths.append(path.stat().st_size)
    recorder.close()
    return lengths


def test_messages_come_back(tmp_path) -> None:
    """What was written is read back in its order, with topic, time and every value."""
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, METADATA)
    recorder.write("fix", "auv1", 12, fix(12))
    recorder.write("modem_rx", "auv2", 22, ModemEvent(0, 22, Received("auv1", b"\x00\xff")))
    recorder.write("truth", "", 11, Truth(11, 11, []))
    recorder.close()
    assert list(Recording(path).entries()) == [
        Entry("fix", "auv1", 12, fix(12)),
        Entry("modem_rx", "auv2", 22, ModemEvent(0, 22, Received("auv1", b"\x00\xff"))),
        Entry("truth", "", 11, Truth(11, 11, [])),
    ]


def test_a_clock_behind_the_mission(tmp_path) -> None:
    """What a clock behind the start of the mission has stamped is recorded at its start, and says its own time."""
    recorder = Recorder(tmp_path / "run.mcap", METADATA)
    recorder.write("fix", "auv1", -2 * 10**9, fix(-2))
    recorder.close()
    assert list(Recording(tmp_path).entries()) == [Entry("fix", "auv1", 0, fix(-2))]


def test_the_fields_viewers_open_it(tmp_path) -> None:
    """A finished recording has an index, JSON schemas, its metadata and times, as any MCAP reader sees them."""
    record(tmp_path / "run.mcap", [3, 4])
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary.statistics.message_count == 7
        assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 6 * 10**9)
        assert {channel.topic for channel in summary.channels.values()} == {"/auv1/fix", "/auv2/fix", "/auv3/fix"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"json"}
        (schema,) = summary.schemas.values()
        assert (schema.name, schema.encoding) == ("Fix", "jsonschema")
        assert msgspec.json.decode(schema.data) == msgspec.json.schema(Fix)
        assert [(record.name, record.metadata) for record in reader.iter_metadata()] == [("grex", METADATA)]
        one = [msgspec.json.decode(message.data) for _, _, message in reader.iter_messages(topics=["/auv2/fix"])]
        assert [message["tick"] for message in one] == [1, 4]


@pytest.mark.parametrize("row", [row for row in TOPICS.values() if row.recorded], ids=lambda row: row.name)
def test_every_recorded_topic(tmp_path, row) -> None:
    """Every topic that the table says is recorded can be, under its key and with the schema of its Struct."""
    recorder = Recorder(tmp_path / "run.mcap", {})
    recorder.write(row.name, "auv1", 12, fix(12))
    recorder.close()
    with (tmp_path / "run.mcap").open("rb") as file:
        ((schema, channel, _),) = make_reader(file).iter_messages()
    assert channel.topic == "/" + row.key.replace("{craft}", "auv1")
    assert schema.name == " or ".join(kind.__name__ for kind in get_args(row.recorded) or (row.recorded,))


def test_state_is_recorded_one_by_one() -> None:
    """Agents' states, sent in bundles, are recorded as single states."""
    assert TOPICS["state"].recorded is AgentState


def test_flushed_is_on_disk(tmp_path) -> None:
    """After a flush, what was written so far is read from a file that is still being written."""
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, METADATA)
    for tick in range(5):
        recorder.write("fix", "auv1", tick, fix(tick))
    recorder.flush()
    assert [fix.tick for fix in recorded_messages(path, "fix")] == [0, 1, 2, 3, 4]
    recorder.write("fix", "auv1", 5, fix(5))
    recorder.close()
    assert len(recorded_messages(path, "fix")) == 6


def test_flush_of_nothing(tmp_path) -> None:
    """A flush when there is nothing new changes nothing."""
    path = tmp_path / "run.mcap"
    assert len(set(record(path, [3, 0, 0]))) == 1
    assert len(recorded_messages(path, "fix")) == 3


def test_empty_recording(tmp_path) -> None:
    """A run that broke off before its first message leaves a recording that opens."""
    record(tmp_path / "run.mcap", [])
    assert recorded_messages(tmp_path, "fix") == []


def cut(path: Path, length: int) -> list:
    short = path.with_name("cut.mcap")
    short.write_bytes(path.read_bytes()[:length])
    return recorded_messages(short, "fix")


def test_cut_in_a_chunk(tmp_path) -> None:
    """Of a file that ends in the middle of a chunk, every whole chunk before it is read."""
    path = tmp_path / "run.mcap"
    first, second, _ = record(path, [5, 6, 7])
    whole = recorded_messages(path, "fix")
    assert len(whole) == 18
    assert cut(path, (first + second) // 2) == whole[:5]


def test_cut_anywhere(tmp_path) -> None:
    """Wherever a recording is cut off, all messages of its whole chunks are read; before that it is told in a line."""
    path = tmp_path / "run.mcap"
    said, *ends = record(path, [0, 5, 6, 7])
    whole = recorded_messages(path, "fix")
    counts = [0, 5, 11, 18]
    for length in range(0, said, 101):
        with pytest.raises(ConfigError, match=r"is empty|no recording"):
            cut(path, length)
    for length in range(said, path.stat().st_size, 11):
        got = cut(path, length)
        assert got == whole[: len(got)]
        assert len(got) >= counts[sum(end <= length for end in ends)]


def test_cut_in_the_index(tmp_path) -> None:
    """A recording whose index is not whole still has all its messages."""
    path = tmp_path / "run.mcap"
    record(path, [5, 6, 7])
    assert len(cut(path, path.stat().st_size - 5)) == 18


def test_a_flipped_bit_anywhere(tmp_path) -> None:
    """Wherever a bit is flipped, what is read is what was written, or one line tells of it."""
    path = tmp_path / "run.mcap"
    record(path, [5, 6, 7])
    whole, data = recorded_messages(path, "fix"), path.read_bytes()
    lines = []
    for place in range(0, len(data), 17):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x80]) + data[place + 1 :])
        try:
            got = recorded_messages(path, "fix")
        except ConfigError as error:
            lines.append(str(error))
        else:
            assert all(fix in whole for fix in got)
    assert lines
    assert not any("\n" in line for line in lines)
