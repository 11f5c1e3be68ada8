"""Writes a recording as tables, CSV or Parquet: one file a topic, a row a message.

Columns are the fields of the messages with their units. What is a list of things, such as the beliefs about the mates,
is a table of its own, a row a thing; what has an inner message, such as a modem event, has its fields behind a ``_``;
what is left of lists and tables is JSON.
"""

import base64
import csv
import types
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Protocol, TextIO, Union, get_args, get_origin

import msgspec

from grex_link.errors import ConfigError, GrexError
from grex_link.recording import Recording
from grex_link.topics import TOPICS
from grex_sim.parquet import TableFile, need_parquet

#: Rows that are written in one go.
_GROUP = 20_000

Row = dict[str, Any]


class _Sink(Protocol):
    """A table file."""

    def write(self, rows: list[Row]) -> None: ...

    def close(self) -> None: ...


def export(recording: Recording, out: Path, form: str) -> dict[str, int]:
    """Write every topic of a recording as a table.

    Parameters
    ----------
    recording : Recording
        The run.
    out : Path
        Folder of the files; made if it is not there.
    form : str
        ``csv`` or ``parquet``.

    Returns
    -------
    dict of str to int
        For each file, how many rows it has.

    Raises
    ------
    ConfigError
        If Parquet cannot be written here, or there is no such folder.
    GrexError
        If the disk is full.
    """
    if form == "parquet":
        need_parquet()
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError("--out", f"cannot make the folder {out}: {error.strerror}") from None
    tables: dict[str, _Table] = {}
    with ExitStack() as stack:
        for entry in recording.entries():
            shape = _SHAPES[entry.topic]
            for name, row in shape.rows(entry.craft, entry.message):
                if name not in tables:
                    tables[name] = _Table(out / f"{name}.{form}", shape.columns[name])
                    stack.callback(tables[name].close)
                tables[name].add(row)
    return {each.path.name: each.count for each in tables.values()}


class _Table:
    """One file, and the rows that wait to be written."""

    def __init__(self, path: Path, columns: Mapping[str, Any]) -> None:
        self.path = path
        self.count = 0
        self._waiting: list[Row] = []
        try:
            self._sink: _Sink = TableFile(path, columns) if path.suffix == ".parquet" else _CsvFile(path, columns)
        except OSError as error:
            raise ConfigError("--out", f"cannot write {path}: {error.strerror}") from None

    def add(self, row: Row) -> None:
        self.count += 1
        self._waiting.append(row)
        if len(self._waiting) >= _GROUP:
            self._flush()

    def close(self) -> None:
        try:
            self._flush()
        finally:
            self._sink.close()

    def _flush(self) -> None:
        rows, self._waiting = self._waiting, []
        if rows:
            self._sink.write(rows)


class _CsvFile:
    """A CSV file: nothing where there is none, ``nan`` where there is no number, payloads in base64."""

    def __init__(self, path: Path, columns: Mapping[str, Any]) -> None:
        self._path = path
        self._columns = list(columns)
        self._file: TextIO = path.open("w", encoding="utf-8", newline="")
        self._writer = csv.writer(self._file)
        self._writer.writerow(self._columns)

    def write(self, rows: list[Row]) -> None:
        try:
            self._writer.writerows([_cell(row[name]) for name in self._columns] for row in rows)
        except OSError as error:
            raise GrexError(f"cannot write {self._path}: {error.strerror}") from None

    def close(self) -> None:
        try:
            self._file.close()
        except OSError as error:
            raise GrexError(f"cannot write {self._path}: {error.strerror}") from None


def _cell(value: Any) -> Any:
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    return str(value).lower() if isinstance(value, bool) else value


class _Shape:
    """How the messages of a topic become rows: of a table of its own, and of one for each list of things in them.

    Attributes
    ----------
    columns : dict
        For each table its columns, with their types.
    """

    def __init__(self, topic: str) -> None:
        kind = TOPICS[topic].recorded
        self._per_craft = TOPICS[topic].per_craft
        self._topic = topic
        structs = _structs(kind)
        self._lists = {
            field.encode_name for struct in structs for field in msgspec.structs.fields(struct) if _things(field.type)
        }
        head: Row = {"craft": str} if self._per_craft else {}
        main = {**head, **({"type": str} if len(structs) > 1 else {})}
        for struct in structs:
            main |= _flat_columns(struct, self._lists)
        times: Row = {name: main[name] for name in ("tick", "t_ns") if name in main}
        self._times = list(times)
        self.columns: dict[str, Row] = {topic: main}
        for struct in structs:
            for field in msgspec.structs.fields(struct):
                if (thing := _things(field.type)) is not None:
                    inner = _flat_columns(thing, ())
                    prefix = {
                        ("mate" if name == "craft" and "craft" in head else name): each for name, each in inner.items()
                    }
                    self.columns[f"{topic}_{field.encode_name}"] = {**head, **times, **prefix}

    def rows(self, craft: str, message: Any) -> Iterator[tuple[str, Row]]:
        """Yield the table and the row for a message, and for each thing of its lists."""
        head = {"craft": craft} if self._per_craft else {}
        row = {**dict.fromkeys(self.columns[self._topic]), **head}
        tag = type(message).__struct_config__.tag
        row |= {"type": tag} if "type" in row and tag is not None else {}
        row |= _flat(message, self._lists)
        if len(row) > len(head) + len(self._times) or not self._lists:
            yield self._topic, row
        times: Row = {name: row[name] for name in self._times}
        for name in self._lists:
            for thing in getattr(message, name, ()):
                inner = _flat(thing, ())
                if head and "craft" in inner:
                    inner["mate"] = inner.pop("craft")
                yield f"{self._topic}_{name}", {**head, **times, **inner}


def _structs(kind: Any) -> list[Any]:
    """Return the Structs a type allows."""
    parts = get_args(kind) if get_origin(kind) in {Union, types.UnionType} else (kind,)
    return [part for part in parts if isinstance(part, type) and issubclass(part, msgspec.Struct)]


def _things(kind: Any) -> Any:
    """Return the Struct of which a type is a list; None if it is none."""
    if get_origin(kind) is not list:
        return None
    structs = _structs(get_args(kind)[0])
    return structs[0] if structs else None


def _flat_columns(struct: Any, without: Any) -> Row:
    columns: Row = {}
    for field in msgspec.structs.fields(struct):
        inner = _structs(field.type)
        if field.encode_name in without:
            continue
        if not inner:
            columns[field.encode_name] = str if get_origin(field.type) in {list, dict} else field.type
            continue
        columns[f"{field.encode_name}_type"] = str
        for each in inner:
            columns |= {f"{field.encode_name}_{name}": kind for name, kind in _flat_columns(each, ()).items()}
    return columns


def _flat(message: Any, without: Any) -> Row:
    row: Row = {}
    for name in message.__struct_fields__:
        if name in without:
            continue
        value = getattr(message, name)
        if isinstance(value, msgspec.Struct):
            row[f"{name}_type"] = value.__struct_config__.tag
            row |= {f"{name}_{inner}": each for inner, each in _flat(value, ()).items()}
        elif isinstance(value, list | dict):
            row[name] = msgspec.json.encode(value).decode()
        else:
            row[name] = value
    return row


_SHAPES = {name: _Shape(name) for name, topic in TOPICS.items() if topic.recorded is not None}
