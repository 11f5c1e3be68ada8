"""Reads the recording of a run back as the messages that were written, whole or cut off. The reading end of mcap."""

import struct
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import mcap.records as mr
import msgspec
from mcap.exceptions import EndOfFile, McapError
from mcap.stream_reader import CRCValidationError, StreamReader

from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import Message
from grex_link.not_a_number import with_nan
from grex_link.topics import TOPICS, Topic

RECORDING_FILE = "run.mcap"
#: Counts up whenever an older GREX could not read what a newer one records.
FORMAT = 1
METADATA = "grex"
#: What mcap raises at damage; RuntimeError is lz4's, the last three come of texts and lengths that are none.
_DAMAGE = (McapError, CRCValidationError, RuntimeError, UnicodeDecodeError, MemoryError, OverflowError)


def run_metadata(scenario: Scenario) -> dict[str, str]:
    """Return what a recording says of its run as a whole."""
    return {"format": str(FORMAT), "scenario": msgspec.json.encode(scenario).decode()}


class Entry(NamedTuple):
    """One recorded message."""

    topic: str
    """Its row of `TOPICS`."""
    craft: str
    """Empty for a topic that there is once."""
    t_ns: int
    """Mission time."""
    message: Message


class Recording:
    """A run's recording.

    Parameters
    ----------
    run : Path
        The run's folder, or the file itself.

    Attributes
    ----------
    path : Path
        The file.
    scenario : Scenario
        What was run.
    whole : bool or None
        Whether the file has its end; None as long as it has not been read through.
    end_ns : int
        Mission time of the newest message read so far.

    Raises
    ------
    ConfigError
        If there is no such run, or its file is none of GREX's, or of a newer version.
    """

    def __init__(self, run: Path) -> None:
        self.path = recording_file(run)
        self.whole: bool | None = None
        self.end_ns = 0
        self.scenario = _scenario(self.path, self._metadata())

    def entries(self, topics: Collection[str] | None = None) -> Iterator[Entry]:
        """Read the messages of some topics, or of all, in the order of writing, up to the last whole chunk."""
        channels: dict[int, tuple[Topic, str, msgspec.json.Decoder[Any]]] = {}
        for record in self._records():
            if isinstance(record, mr.Channel):
                found = _place(record.topic)
                if (
                    found is not None
                    and record.message_encoding == "json"
                    and (topics is None or found[0].name in topics)
                ):
                    channels[record.id] = *found, msgspec.json.Decoder(found[0].recorded)
            elif isinstance(record, mr.Message) and record.channel_id in channels:
                topic, craft, decoder = channels[record.channel_id]
                self.end_ns = max(self.end_ns, record.log_time)
                yield Entry(topic.name, craft, record.log_time, self._decode(topic, decoder, record.data))

    @property
    def remark(self) -> str:
        """One line about a file that was cut off, once it has been read; empty if it was not."""
        if self.whole is not False:
            return ""
        return f"{self.path} was cut off: read to its last whole chunk, mission time {self.end_ns / 1e9:.1f} s"

    def _decode(self, topic: Topic, decoder: msgspec.json.Decoder[Any], data: bytes) -> Message:
        try:
            message: Message = decoder.decode(data)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            try:  # what was no number has become null
                message = msgspec.convert(with_nan(msgspec.json.decode(data), topic.recorded), topic.recorded)
            except (msgspec.DecodeError, UnicodeDecodeError):
                raise ConfigError(
                    str(self.path), f"was recorded by another version of GREX: {topic.name}: {error}"
                ) from None
        return message

    def _metadata(self) -> dict[str, str]:
        """Find what the recording says of itself; it comes before everything else."""
        for record in self._records():
            if isinstance(record, mr.Metadata) and record.name == METADATA:
                return record.metadata
            if isinstance(record, mr.Channel | mr.Message | mr.DataEnd):
                break
        raise ConfigError(str(self.path), "is an MCAP file, but no recording of a GREX run")

    def _records(self) -> Iterator[Any]:
        self.whole = None
        try:
            with self.path.open("rb") as file:
                for record in StreamReader(file, validate_crcs=True, record_size_limit=2**30).records:
                    if isinstance(record, mr.Footer):
                        self.whole = True
                    yield record
        except (EndOfFile, struct.error):
            if not self.path.stat().st_size:
                raise ConfigError(str(self.path), "is empty: nothing was recorded") from None
            self.whole = bool(self.whole)
        except _DAMAGE:
            raise _damaged(self.path) from None
        except OSError as error:
            raise ConfigError(str(self.path), f"cannot be read: {error.strerror}") from None


def recording_file(run: Path) -> Path:
    """Find the recording of a run.

    Raises
    ------
    ConfigError
        If there is none.
    """
    if not run.exists():
        raise ConfigError(str(run), "is no run: there is no such folder")
    file = run / RECORDING_FILE if run.is_dir() else run
    if not file.is_file():
        raise ConfigError(str(run), f"is no run: there is no {RECORDING_FILE} in it")
    return file


def _scenario(path: Path, metadata: dict[str, str]) -> Scenario:
    form = metadata.get("format", "0")
    if not form.isdigit() or int(form) > FORMAT:
        raise ConfigError(
            str(path), f"was recorded by a newer GREX (recording format {form}; this one reads up to {FORMAT})"
        )
    try:
        return msgspec.json.decode(metadata.get("scenario", ""), type=Scenario)
    except msgspec.DecodeError as error:
        raise ConfigError(str(path), f"was recorded by another version of GREX: its scenario: {error}") from None


def _place(name: str) -> tuple[Topic, str] | None:
    """Find the row of the table, and the craft, that an MCAP topic stands for."""
    below = name.removeprefix("/")
    craft, _, rest = below.partition("/")
    for topic in TOPICS.values():
        if topic.recorded is not None and topic.key in {below, "{craft}/" + rest}:
            return topic, craft if topic.per_craft else ""
    return None


def _damaged(path: Path) -> ConfigError:
    return ConfigError(str(path), "is no recording, or is damaged")
