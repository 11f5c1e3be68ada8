"""Records a run as MCAP, with schemas, so that the field's viewers open it. The only user of mcap."""

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple, get_args

import mcap.records
import msgspec
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from grex_link.errors import ConfigError, RecordingError
from grex_link.messages import Message
from grex_link.topics import TOPICS

_CHUNK_BYTES = 256 * 1024


class Recorder:
    """An MCAP file being written.

    It is append-only: the file of a run that was killed opens and holds everything up to the last `flush`.

    Parameters
    ----------
    path : Path
        The file to write.
    metadata : dict of str to str
        What belongs to the run as a whole: the scenario, the seed, versions.

    Raises
    ------
    RecordingError
        If the file cannot be written; so do all methods, with a full disk.
    """

    def __init__(self, path: Path, metadata: dict[str, str]) -> None:
        self._path = path
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise RecordingError(f"cannot record {path}: {error.strerror}") from None
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.LZ4)
        self._writer.start(profile="", library="grex")
        self._writer.add_metadata("grex", metadata)
        self._encode = msgspec.json.Encoder().encode
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}

    def write(self, topic: str, craft: str, t_ns: int, message: Message) -> None:
        """Record a message at a mission time; what a craft's slow clock puts before the mission counts as its start."""
        t_ns = max(t_ns, 0)  # MCAP has no time before zero
        channel = self._channels.get((topic, craft))
        if channel is None:
            channel = self._channels[topic, craft] = self._register(topic, craft)
        with self._room():
            self._writer.add_message(channel, t_ns, self._encode(message), t_ns)

    def write_encoded(self, topic: str, schema: str, descriptors: bytes, t_ns: int, data: bytes) -> None:
        """Record a protobuf message at a mission time.

        Parameters
        ----------
        topic : str
            With its slash.
        schema : str
            Full name of its type.
        descriptors : bytes
            FileDescriptorSet that holds the type.
        t_ns : int
            Mission time, nanoseconds.
        data : bytes
            The message.
        """
        with self._room():
            self._write_encoded(topic, schema, descriptors, t_ns, data)

    def _write_encoded(self, topic: str, schema: str, descriptors: bytes, t_ns: int, data: bytes) -> None:
        channel = self._channels.get((topic, schema))
        if channel is None:
            number = self._schemas.get(schema)
            if number is None:
                number = self._schemas[schema] = self._writer.register_schema(schema, "protobuf", descriptors)
            channel = self._channels[topic, schema] = self._writer.register_channel(topic, "protobuf", number)
        self._writer.add_message(channel, t_ns, data, t_ns)

    def flush(self) -> None:
        """Put everything on disk that has been written."""
        with self._room():
            self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Write the index and close the file."""
        with self._room():
            try:
                self._writer.finish()  # type: ignore[no-untyped-call]
            finally:
                self._file.close()

    def abandon(self) -> None:
        """Close the file as it is, without an index: it opens to its last whole chunk."""
        with suppress(OSError):
            self._file.close()

    @contextmanager
    def _room(self) -> Iterator[None]:
        """Say in one line that the disk is full, or cannot be written for another reason."""
        try:
            yield
        except OSError as error:
            raise RecordingError(
                f"cannot go on recording {self._path}: {error.strerror}; what was written opens"
            ) from None

    def _register(self, topic: str, craft: str) -> int:
        row = TOPICS[topic]
        schema = self._schemas.get(topic)
        if schema is None:
            data = msgspec.json.encode(msgspec.json.schema(row.recorded))
            schema = self._schemas[topic] = self._writer.register_schema(_schema_name(row.recorded), "jsonschema", data)
        return self._writer.register_channel("/" + row.key.format(craft=craft), "json", schema)


def _schema_name(recorded: Any) -> str:
    """Name of a Struct, or of those a union allows."""
    return " or ".join(part.__name__ for part in get_args(recorded) or (recorded,))


class Recorded(NamedTuple):
    """One message of a recording, as it was written."""

    topic: str
    t_ns: int
    """Mission time."""
    data: bytes
    """JSON."""


def read_messages(path: Path, wanted: Callable[[str], bool] = lambda _: True) -> list[tuple[str, int, Any]]:
    """Read a recording, even one that was cut off.

    Parameters
    ----------
    path : Path
        The file.
    wanted : callable
        Says of a topic's key whether its messages are read; all are if left out.

    Returns
    -------
    list of (topic, mission time ns, decoded JSON)
        In the order of writing; what a cut destroyed at the end is left out.

    Raises
    ------
    ConfigError
        If the file is no recording.
    """
    return [(topic, t_ns, msgspec.json.decode(data)) for topic, t_ns, data in stream_messages(path, wanted)]


def stream_messages(path: Path, wanted: Callable[[str], bool] = lambda _: True) -> Iterator[Recorded]:
    """Read a recording message by message; see `read_messages`. What is not JSON is left out."""
    channels: dict[int, str] = {}
    with path.open("rb") as file, suppress(EndOfFile, struct.error), _named(path):
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                if record.message_encoding == "json" and wanted(record.topic):
                    channels[record.id] = record.topic
            elif isinstance(record, mcap.records.Message) and record.channel_id in channels:
                yield Recorded(channels[record.channel_id], record.log_time, record.data)


def read_scenario(path: Path) -> str:
    """Read from a recording which scenario was run, as JSON.

    Raises
    ------
    ConfigError
        If the file is no recording of a run.
    """
    try:
        with path.open("rb") as file, suppress(EndOfFile, struct.error), _named(path):
            for record in StreamReader(file).records:
                if isinstance(record, Metadata) and "scenario" in record.metadata:
                    return record.metadata["scenario"]
    except OSError as error:
        raise ConfigError(str(path), f"cannot read the recording: {error.strerror}") from None
    raise ConfigError(str(path), "is no recording of a GREX run: it names no scenario")


def read_metadata(path: Path) -> dict[str, str]:
    """Read what a recording says of the run as a whole, even if it was cut off; nothing if it says nothing.

    Raises
    ------
    ConfigError
        If the file is no recording.
    """
    with path.open("rb") as file, suppress(EndOfFile, struct.error), _named(path):
        for record in StreamReader(file).records:
            if isinstance(record, mcap.records.Metadata):
                return dict(record.metadata)
    return {}


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Say of what is no MCAP file that it is none; one that ends too early is one."""
    try:
        yield
    except EndOfFile:
        raise
    except McapError:
        raise ConfigError(str(path), "is no recording, or is damaged") from None
