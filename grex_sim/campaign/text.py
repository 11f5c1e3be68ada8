"""What a campaign prints: a table of its cells, and how fast it was."""

from collections.abc import Sequence

from grex_sim.campaign.results import COMPARED, CellResult, Row
from grex_sim.layout import table


def as_table(results: Sequence[CellResult]) -> list[str]:
    """Lay out a line for each cell: its values, its runs, and means with their 95 % intervals."""
    paths = list(results[0].values)
    headings = [*paths, "runs", "failed", *(heading for _, heading in COMPARED)]
    lines = [
        [
            *(str(result.values[path]) for path in paths),
            str(result.runs),
            str(result.failed),
            *(str(result.estimates[name]) for name, _ in COMPARED),
        ]
        for result in results
    ]
    return ["mean of the runs ± half of its 95 % interval", *table(headings, lines, len(paths))]


def rate(found: Sequence[Row], flown: int, wall_s: float, workers: str) -> str:
    """Say how fast the campaign was, and how fast a single run was in it."""
    done = [row for row in found if not row["failed"]]
    mission_s = sum(row["duration_s"] for row in done)
    factor = mission_s / max(sum(row["wall_s"] for row in done), 1e-9)
    mean_s = mission_s / max(len(done), 1)
    return (
        f"{flown} missions of {mean_s:.0f} s in {wall_s:.1f} s on {workers}: {60.0 * flown / max(wall_s, 1e-9):.0f} "
        f"missions a minute; one by itself at {factor:.0f} x real time"
    )


def failures(found: Sequence[Row]) -> list[str]:
    """Name the first few runs that failed, and count the others."""
    failed = [row for row in found if row["failed"]]
    lines = [f"WARNING: cell {row['cell']}, seed {row['seed']} failed: {row['fault']}" for row in failed[:_NAMED]]
    return lines + ([f"WARNING: and {len(failed) - _NAMED} more failed"] if len(failed) > _NAMED else [])


_NAMED = 5
