"""Lays out text for a terminal: names with their texts, and tables."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence

WIDTH = 110
INDENT = 15


def entry(name: str, text: str) -> list[str]:
    """Lay out a name and its text, wrapped under itself."""
    start = f"{name:<{INDENT}}"
    return textwrap.wrap(text, WIDTH, initial_indent=start, subsequent_indent=" " * INDENT, break_long_words=False)


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], left: int) -> Iterator[str]:
    """Lay out a table; the first columns are set to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    for row in (headings, *rows):
        yield "  " + "  ".join(_cells(row, widths, left)).rstrip()


def _cells(row: Iterable[str], widths: Iterable[int], left: int) -> Iterator[str]:
    for place, (cell, width) in enumerate(zip(row, widths, strict=True)):
        yield cell.ljust(width) if place < left else cell.rjust(width)
