"""What came of a campaign: a row a run, a Parquet file of them, and the estimates of each cell."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from grex_sim.campaign.definition import Cell, job_key
from grex_sim.campaign.engine import Outcome
from grex_sim.campaign.flight import Figures
from grex_sim.intervals import Estimate, mean_of
from grex_sim.parquet import column_type, write_table

RESULTS_FILE = "runs.parquet"
#: What is compared: column, heading.
COMPARED = (("fd", "FD"), ("age_mean_s", "mean age s"), ("received", "received"))

Row = dict[str, Any]


class CellResult(msgspec.Struct, frozen=True):
    """One cell: how many of its runs came to an end, and the estimates of what is compared."""

    values: dict[str, Any]
    runs: int
    failed: int
    estimates: dict[str, Estimate]


def rows(cells: Sequence[Cell], seeds: int, outcomes: Mapping[str, Outcome]) -> list[Row]:
    """Return a row for each run that has ended, cell by cell."""
    return [
        _row(number, cell, cell.scenario.seed + seed, outcomes[key])
        for number, cell in enumerate(cells)
        for seed in range(seeds)
        if (key := job_key(number, seed)) in outcomes
    ]


def _row(number: int, cell: Cell, seed: int, outcome: Outcome) -> Row:
    empty = dict.fromkeys(Figures.__struct_fields__)
    flown = {**empty, **(outcome.figures or {}), "seed": seed}
    return {"cell": number, **cell.values, **flown, "failed": outcome.figures is None, "fault": outcome.fault}


def write_rows(path: Path, found: Sequence[Row], cells: Sequence[Cell]) -> None:
    """Write all rows as one Parquet file; what stood there before is replaced at once or not at all."""
    types: dict[str, Any] = {"cell": int}
    for name in cells[0].values:
        types[name] = column_type([cell.values[name] for cell in cells])
    types |= {field.name: field.type for field in msgspec.structs.fields(Figures)}
    types |= {"failed": bool, "fault": str}
    partial = path.with_suffix(".partial")
    try:
        write_table(partial, types, found)
        os.replace(partial, path)  # noqa: PTH105 - it replaces
    finally:
        partial.unlink(missing_ok=True)


def cell_results(cells: Sequence[Cell], found: Sequence[Row]) -> list[CellResult]:
    """Judge every cell."""
    by_cell: dict[int, list[Row]] = {}
    for row in found:
        by_cell.setdefault(row["cell"], []).append(row)
    return [_judge(cell, by_cell.get(number, [])) for number, cell in enumerate(cells)]


def _judge(cell: Cell, found: Sequence[Row]) -> CellResult:
    flown = [row for row in found if not row["failed"]]
    columns = {
        "fd": [row["fd"] for row in flown],
        "age_mean_s": [row["age_mean_s"] for row in flown],
        "received": [_received(row) for row in flown],
    }
    estimates = {name: mean_of([value for value in values if value is not None]) for name, values in columns.items()}
    return CellResult(cell.values, len(flown), len(found) - len(flown), estimates)


def _received(row: Row) -> float | None:
    """Share of the receptions that arrived."""
    outcomes = row["delivered"] + row["lost"]
    return row["delivered"] / outcomes if outcomes else None
