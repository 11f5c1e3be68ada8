"""The result of a run: one object of figures, and the files beside it."""

from pathlib import Path

import msgspec
import numpy as np

from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_sim.logbook import Logbook
from grex_sim.score import Score, score

SUMMARY_FILE = "summary.json"
SERIES_FILE = "series.csv"


class Summary(msgspec.Struct, kw_only=True):
    """What ``--json`` prints and ``summary.json`` holds; seconds, metres, radians."""

    title: str
    estimator: str
    pace: str | float
    seed: int
    complete: bool
    fault: str
    fd: float | None
    fd_distance: float | None
    fd_angle: float | None
    fd_xte: float | None
    duration_s: float
    """Mission time that was run."""
    startup_s: float
    """Wall time from the opening of the bus until everybody was on it."""
    wall_s: float
    """Wall time from the first tick to the last."""
    real_time_factor: float
    ticks: int
    ticks_per_s: float
    messages_sent: int
    bytes_sent: int
    delivered: int
    """Datagrams received, summed over the receivers."""
    lost: int
    refused: int
    in_flight: int
    """Receptions still to come when the run ended."""
    late_ticks: int
    late_setpoints: int
    bad_frames: dict[str, int]
    adrift_steps: dict[str, int]
    """For each craft, in how many steps the current was too strong for the course it was to make good."""
    unhealthy_steps: dict[str, dict[str, int]]
    """For each craft, in how many steps its agent reported which word of health."""
    digest: str
    out: str | None = None
    """Folder of the run's files."""


def summarise(
    scenario: Scenario,
    plan: TeamPlan,
    logbook: Logbook,
    *,
    mission_s: float,
    startup_s: float,
    wall_s: float,
    fault: str,
) -> tuple[Summary, Score]:
    """Judge a run that is over, whether or not it came to its end."""
    positions = logbook.positions
    result = score(positions, plan, scenario.score)
    ticks = max(len(positions) - 1, 0)
    judged = ticks > 0
    distance, angle, xte = result.parts if judged else (None, None, None)
    summary = Summary(
        title=scenario.title,
        estimator=scenario.team.estimator,
        pace=scenario.clock.pace,
        seed=scenario.seed,
        complete=not fault,
        fault=fault,
        fd=result.fd if judged else None,
        fd_distance=distance,
        fd_angle=angle,
        fd_xte=xte,
        duration_s=mission_s,
        startup_s=startup_s,
        wall_s=wall_s,
        real_time_factor=mission_s / wall_s if wall_s else 0.0,
        ticks=ticks,
        ticks_per_s=ticks / wall_s if wall_s else 0.0,
        messages_sent=logbook.messages_sent,
        bytes_sent=logbook.bytes_sent,
        delivered=logbook.delivered,
        lost=logbook.lost,
        refused=logbook.refused,
        in_flight=logbook.messages_sent * (len(scenario.craft) - 1) - logbook.delivered - logbook.lost,
        late_ticks=logbook.late_ticks,
        late_setpoints=logbook.late_setpoints,
        bad_frames=logbook.bad_frames,
        adrift_steps=logbook.adrift_steps,
        unhealthy_steps=logbook.unhealthy_steps,
        digest=logbook.digest,
    )
    return summary, result


def write_files(out: Path, scenario: Scenario, logbook: Logbook, summary: Summary, result: Score) -> None:
    """Write summary and per-step series into a run's folder."""
    summary.out = str(out)
    (out / SUMMARY_FILE).write_bytes(msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n")
    positions = logbook.positions[1:]
    if not len(positions):
        return
    t_s = np.arange(1, len(positions) + 1) * scenario.clock.tick_s
    names = ["t_s", "fd", "fd_distance", "fd_angle", "fd_xte"]
    names += [f"{craft}_{axis}_m" for craft in scenario.craft for axis in ("north", "east")]
    columns = np.column_stack(
        [
            t_s,
            result.fd_series,
            result.distance,
            result.angle,
            result.xte,
            positions.reshape(len(positions), -1),
        ]
    )
    np.savetxt(out / SERIES_FILE, columns, fmt="%.9g", delimiter=",", header=",".join(names), comments="")


def as_json(summary: Summary) -> str:
    """Return the summary as one JSON object on one line."""
    return msgspec.json.encode(summary).decode()


def as_text(summary: Summary) -> str:
    """Return the summary as a few lines for a person."""
    lines = [summary.title] if summary.title else []
    if summary.fd is not None:
        lines.append(
            f"formation deviation FD {summary.fd:.4f}"
            f"  (distance {summary.fd_distance:.4f}, angle {summary.fd_angle:.4f}, cross-track {summary.fd_xte:.4f})"
        )
    lines += [
        (
            f"{summary.duration_s:.0f} s of mission in {summary.wall_s:.1f} s: "
            f"{summary.real_time_factor:.0f} x real time, {summary.ticks_per_s:.0f} ticks/s ({summary.pace})"
        ),
        (
            f"{summary.messages_sent} messages sent ({summary.bytes_sent} bytes), {summary.delivered} received, "
            f"{summary.lost} lost, {summary.refused} refused, {summary.in_flight} on their way at the end"
        ),
        f"digest {summary.digest}",
    ]
    lines += _warnings(summary)
    if summary.out:
        lines.append(f"files in {summary.out}")
    return "\n".join(lines)


def _warnings(summary: Summary) -> list[str]:
    lines = []
    if summary.late_ticks or summary.late_setpoints:
        lines.append(
            f"WARNING: the pace was not held: {summary.late_ticks} of {summary.ticks} ticks and "
            f"{summary.late_setpoints} setpoints came late; take a lower pace, or lockstep"
        )
    lines += [
        f"WARNING: {craft} reported {word} in {steps} steps"
        for craft, words in summary.unhealthy_steps.items()
        for word, steps in words.items()
    ]
    lines += [
        f"WARNING: {craft} could not hold its course against the current in {steps} steps"
        for craft, steps in summary.adrift_steps.items()
    ]
    lines += [f"WARNING: {craft} received {n} bad frames" for craft, n in summary.bad_frames.items()]
    return lines
