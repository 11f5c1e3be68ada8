"""A study's table: rows as data, what they came to, and how that is printed."""

import json
import math
from collections.abc import Sequence
from typing import NamedTuple

from grex_sim.study.figures import Figure


class AtMost(NamedTuple):
    """A target: the mean is to be no greater."""

    limit: float

    def met(self, value: float, seeds: int) -> bool:
        """Whether a mean over so many seeds meets it."""
        del seeds
        return value <= self.limit

    def text(self, seeds: int) -> str:
        """Say what is to be reached."""
        del seeds
        return f"<= {self.limit:g}"


class InBand(NamedTuple):
    """A target: the mean of squared errors of so many runs a seed is in the 95 % band of χ²."""

    runs: int

    def met(self, value: float, seeds: int) -> bool:
        """Whether a mean over so many seeds meets it."""
        least, most = chi_square_band(self.runs * seeds)
        return least <= value <= most

    def text(self, seeds: int) -> str:
        """Say what is to be reached."""
        least, most = chi_square_band(self.runs * seeds)
        return f"{least:.2f}-{most:.2f}"


class Row(NamedTuple):
    """One row of a study.

    Attributes
    ----------
    name : str
        In the JSON, and for ``--only``.
    about : str
        For people.
    figure : Figure
        What is measured.
    target : AtMost or InBand or None
        What is to be reached.
    """

    name: str
    about: str
    figure: Figure
    target: AtMost | InBand | None = None


class Result(NamedTuple):
    """What a row came to: mean over the seeds, and half the width of its 95 % interval."""

    row: Row
    value: float
    interval: float
    seeds: int

    @property
    def met(self) -> bool:
        """Whether it is as it must be; a row without a target is."""
        return self.row.target is None or self.row.target.met(self.value, self.seeds)

    def missed(self) -> str:
        """Say what it came to, and what it was to reach."""
        target = self.row.target
        return f"{self.row.name} is {self.value:.4f}" + (f", must be {target.text(self.seeds)}" if target else "")


def chi_square_band(freedom: int) -> tuple[float, float]:
    """Band of χ²/n that holds 95 % for n degrees of freedom (Wilson and Hilferty's approximation)."""
    ninth = 2.0 / (9.0 * freedom)
    least, most = ((1.0 - ninth + z * math.sqrt(ninth)) ** 3 for z in (-1.95996, 1.95996))
    return least, most


def as_json(results: Sequence[Result]) -> str:
    """Print for programs."""
    rows = [
        {"row": each.row.name, "value": each.value, "interval": each.interval, "seeds": each.seeds} for each in results
    ]
    return json.dumps({"rows": rows})


def as_text(results: Sequence[Result]) -> str:
    """Print for people, as a table that Markdown reads as well."""
    head = ("row", "condition", "value", "target", "met")
    body = [head, *map(_cells, results)]
    widths = [max(len(cells[column]) for cells in body) for column in range(len(head))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)) + " |"
             for cells in body]  # fmt: skip
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines)


def _cells(result: Result) -> tuple[str, ...]:
    row, target = result.row, result.row.target
    said = ("", "") if target is None else (target.text(result.seeds), "yes" if result.met else "NO")
    return (row.name, row.about, f"{result.value:.4f} ± {result.interval:.4f}", *said)
