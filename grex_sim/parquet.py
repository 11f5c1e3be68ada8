"""Writes Parquet: the only user of pyarrow, which the extra ``campaign`` installs."""

import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Union, get_args, get_origin

from grex_link.errors import ConfigError, GrexError


def need_parquet() -> None:
    """Say so if Parquet cannot be written here, before there is anything to lose.

    Raises
    ------
    ConfigError
        If pyarrow is not installed.
    """
    try:
        import pyarrow as pa
    except ModuleNotFoundError:
        raise ConfigError("pyarrow", "is not installed, and Parquet needs it: pip install 'grex[campaign]'") from None
    del pa


def column_type(values: Sequence[Any]) -> Any:
    """Find the one type that holds all values; text holds whatever is not of one kind."""
    kinds = {type(value) for value in values}
    if len(kinds) == 1:
        return kinds.pop()
    return float if kinds == {int, float} else str


class TableFile:
    """A Parquet file that is written piece by piece; use as a context manager.

    Parameters
    ----------
    path : Path
        The file.
    columns : dict of str to type
        Python types; None is allowed in every column, text takes whatever has another type.
    """

    def __init__(self, path: Path, columns: Mapping[str, Any]) -> None:
        import pyarrow as pa
        from pyarrow import parquet

        self._columns = columns
        self._pa = pa
        self._path = path
        self._schema = pa.schema([(name, _arrow_type(kind)) for name, kind in columns.items()])
        self._file = path.open("wb")
        self._writer = parquet.ParquetWriter(self._file, self._schema)

    def write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write some rows, as a group of their own.

        Raises
        ------
        GrexError
            If the disk is full, or cannot be written for another reason.
        """
        texts = {field.name for field in self._schema if self._pa.types.is_string(field.type)}
        arrays = [
            self._pa.array([_text(row[name]) if name in texts else row[name] for row in rows], field.type)
            for name, field in zip(self._columns, self._schema, strict=True)
        ]
        try:
            self._writer.write_table(self._pa.table(arrays, schema=self._schema))
        except OSError as error:
            raise _cannot_write(self._path, error) from None

    def close(self) -> None:
        """Write the footer, without which the file does not open."""
        try:
            try:
                self._writer.close()
            finally:
                self._file.close()
        except OSError as error:
            raise _cannot_write(self._path, error) from None


def write_table(path: Path, columns: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a whole table; see `TableFile`."""
    file = TableFile(path, columns)
    try:
        file.write(rows)
    finally:
        file.close()


def _cannot_write(path: Path, error: OSError) -> GrexError:
    return GrexError(f"cannot write {path}: {error.strerror or error}")


def _text(value: Any) -> str | None:
    return value if value is None or isinstance(value, str) else str(value)


def _arrow_type(kind: Any) -> Any:
    import pyarrow as pa

    if get_origin(kind) in {Union, types.UnionType}:
        (kind,) = [part for part in get_args(kind) if part is not type(None)]
    known = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), bytes: pa.binary()}
    return known.get(kind, pa.string())
