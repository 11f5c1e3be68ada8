"""Records a run as MCAP, with schemas, so that the field's viewers open it. The writing end of mcap."""

from contextlib import suppress
from pathlib import Path
from typing import Any, get_args

import msgspec
from mcap.writer import CompressionType, Writer

from grex_link.errors import RecordingError
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
        try:
            self._writer.add_message(channel, t_ns, self._encode(message), t_ns)
        except OSError as error:
            raise self._fault(error) from None

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
        channel = self._channels.get((topic, schema))
        if channel is None:
            number = self._schemas.get(schema)
            if number is None:
                number = self._schemas[schema] = self._writer.register_schema(schema, "protobuf", descriptors)
            channel = self._channels[topic, schema] = self._writer.register_channel(topic, "protobuf", number)
        try:
            self._writer.add_message(channel, t_ns, data, t_ns)
        except OSError as error:
            raise self._fault(error) from None

    def flush(self) -> None:
        """Put everything on disk that has been written."""
        try:
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError as error:
            raise self._fault(error) from None

    def close(self) -> None:
        """Write the index and close the file."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()
        except OSError as error:
            self.abandon()
            raise self._fault(error) from None

    def abandon(self) -> None:
        """Close the file as it is, without an index: it opens to its last whole chunk."""
        with suppress(OSError):
            self._file.close()

    def _fault(self, error: OSError) -> RecordingError:
        """Say in one line that the disk is full, or cannot be written for another reason."""
        return RecordingError(f"cannot go on recording {self._path}: {error.strerror}; what was written opens")

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
