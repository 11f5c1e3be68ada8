"""The result of a run: one object of figures, and the files beside it."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from grex_agent.closest import closest_approach
from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_link.energy import sound_energy_j
from grex_link.errors import RecordingError
from grex_link.ledger import EDGES_S, faults
from grex_link.link_config import Tdma
from grex_link.messages import PathLedger, PortLedger, SourceLedger
from grex_link.profile import load_profile
from grex_link.tasks import type_of
from grex_link.units import NS
from grex_sim.cables import Cable
from grex_sim.logbook import Logbook
from grex_sim.navigation_errors import PlaceErrors
from grex_sim.score import Score, score

SUMMARY_FILE = "summary.json"
SERIES_FILE = "series.csv"
#: How many reasons of losses are named to a person.
_MAIN_REASONS = 3
#: In a larger team they are not named one by one.
_SENDERS_NAMED = 6
#: Errors of a position below this are not told to a person.
_WORTH_TELLING_M = 0.01


class ClosestApproach(msgspec.Struct, frozen=True):
    """How near two craft came to each other, in truth."""

    craft: tuple[str, str]
    distance_m: float
    t_s: float
    """Mission time."""


class TaskLine(msgspec.Struct):
    """One thing that somebody said of a task."""

    t_s: float
    """Mission time by the clock of who said it."""
    said_by: str
    order: str
    """Name of the order or the event; for what came by sound, sender and number."""
    craft: str
    """Who is to do it."""
    task: str
    status: str
    detail: str


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
    closest: ClosestApproach | None
    """Closest approach of any two craft; None of one craft alone."""
    unhealthy_steps: dict[str, dict[str, int]]
    """For each craft, in how many steps its agent reported which word of health."""
    navigation: dict[str, PlaceErrors]
    """For each craft, how far off it was where it took itself to be; ``base>craft``: where a base took it to be."""
    ledger_s: float | None
    """Mission time of the newest ledger of the water; None if there is none."""
    ledger_faults: list[str]
    """What does not add up in the ledgers."""
    histogram_edges_s: list[float]
    """Edges of the bins of ``latency_counts`` and ``age_seconds`` in ``paths``; the first bin begins at 0, the last is
    open."""
    sources: dict[str, SourceLedger]
    """For each craft, what it has sent."""
    paths: dict[str, PathLedger]
    """For each directed link, ``auv1>auv2``, what became of it there."""
    sound_j: dict[str, float]
    """For each craft, the acoustic energy of what it has sent under water; empty if the modem has no source level."""
    team_sound_j: float | None
    """That of all craft together; None if the modem has no source level."""
    ports: dict[str, PortLedger]
    """For each craft, the books of its modem port."""
    cables: list[Cable]
    tasks: list[TaskLine]
    """What became of tasks, in the order in which it was said."""
    digest: str
    recording_fault: str = ""
    """Why nothing more was recorded from some time on; empty if all was."""
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
    members = [place for place, craft in enumerate(scenario.craft) if craft in plan.craft]
    result = score(positions[:, members] if len(positions) else positions, plan, scenario.score)
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
        in_flight=logbook.in_flight(len(scenario.craft)),
        late_ticks=logbook.late_ticks,
        late_setpoints=logbook.late_setpoints,
        bad_frames=logbook.bad_frames,
        adrift_steps=logbook.adrift_steps,
        closest=_closest(scenario, logbook),
        unhealthy_steps=logbook.unhealthy_steps,
        navigation=logbook.places.errors(positions, list(scenario.craft)),
        **_ledgers(scenario, logbook, complete=not fault),
        cables=logbook.cables,
        tasks=[
            TaskLine(news.t_ns / NS, who, news.order, news.craft, type_of(news.task), news.status, news.detail)
            for who, news in logbook.task_news
        ],
        digest=logbook.digest,
        recording_fault=logbook.recording_fault,
    )
    return summary, result


def _closest(scenario: Scenario, logbook: Logbook) -> ClosestApproach | None:
    approach = closest_approach(logbook.positions_ned)
    if approach is None:
        return None
    names = list(scenario.craft)
    pair = names[approach.first], names[approach.second]
    return ClosestApproach(pair, approach.distance_m, approach.moment * scenario.clock.tick_s)


def _ledgers(scenario: Scenario, logbook: Logbook, *, complete: bool) -> dict[str, Any]:
    """Return the fields of a summary that come from the ledgers."""
    ledger = logbook.ledger
    mac = scenario.link.mac
    # What is handed over at the very end may not have begun: the messages of a slot, and one over land.
    in_hand = (mac.messages_per_slot if isinstance(mac, Tdma) else 1) + bool(scenario.link.land)
    # The books of a broken run are of several times. At a live pace a message may leave an agent before the end of the
    # mission and come to its modem after it; and of modems on a serial line, which are live, the link knows nothing.
    comparable = complete and scenario.clock.lockstep
    profile = load_profile(scenario.link.profile)
    sources = ledger.sources if ledger else []
    sound = {source.craft: sound_energy_j(profile, source.airtime_s) for source in sources}
    sound_j = {craft: joules for craft, joules in sound.items() if joules is not None}
    return {
        "ledger_s": ledger and ledger.t_ns / NS,
        "ledger_faults": [] if ledger is None else faults(ledger, logbook.ports, in_hand if comparable else None),
        "histogram_edges_s": list(EDGES_S),
        "sources": {source.craft: source for source in sources},
        "sound_j": sound_j,
        "team_sound_j": sum(sound_j.values()) if sound_j else None,
        "paths": {f"{path.source}>{path.destination}": path for path in ledger.paths} if ledger else {},
        "ports": {craft: logbook.ports[craft] for craft in scenario.craft if craft in logbook.ports},
    }


def write_files(out: Path, scenario: Scenario, logbook: Logbook, summary: Summary, result: Score) -> None:
    """Write summary and per-step series into a run's folder.

    Raises
    ------
    RecordingError
        If the disk is full.
    """
    summary.out = str(out)
    encoded = msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n"
    writers: dict[str, Callable[[Path], object]] = {
        SUMMARY_FILE: lambda path: path.write_bytes(encoded),
        SERIES_FILE: lambda path: _write_series(path, scenario, logbook, result),
    }
    for name, write in writers.items():
        try:
            write(out / name)
        except OSError as error:
            with suppress(OSError):
                (out / name).unlink()  # a part of it would be taken for the whole
            raise RecordingError(f"cannot write {out / name}: {error.strerror}") from None


def _write_series(path: Path, scenario: Scenario, logbook: Logbook, result: Score) -> None:
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
    np.savetxt(path, columns, fmt="%.9g", delimiter=",", header=",".join(names), comments="")


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
            f"{summary.messages_sent} messages sent ({summary.bytes_sent} bytes, {_energy(summary)}), "
            f"{summary.delivered} received, "
            f"{summary.lost} lost, {summary.refused} refused, {summary.in_flight} on their way at the end"
        ),
        *_about_senders(summary),
        *_about_navigation(summary.navigation),
        *_about_links(summary.paths),
        *_about_closest(summary.closest),
        *_about_tasks(summary.tasks),
        *_about_cables(summary.cables),
        f"digest {summary.digest}",
    ]
    lines += _warnings(summary)
    if summary.out:
        lines.append(f"files in {summary.out}")
    return "\n".join(lines)


def _energy(summary: Summary) -> str:
    """Say what all messages under water took; nobody knows where the modem's source level is not known."""
    return "energy unknown" if summary.team_sound_j is None else f"{summary.team_sound_j:.3g} J of sound"


def _about_senders(summary: Summary) -> list[str]:
    """Say in a line what each craft has sent, and what that took, if the modem's source level is known."""
    parts = []
    for craft, source in summary.sources.items():
        energy = f", {summary.sound_j[craft]:.3g} J of sound" if craft in summary.sound_j else ""
        parts.append(f"{craft} {source.started} ({source.bytes_sent} bytes{energy})")
    return [f"sent by {'; '.join(parts)}"] if 1 < len(parts) <= _SENDERS_NAMED else []


def _about_navigation(navigation: Mapping[str, PlaceErrors]) -> list[str]:
    """Say who did not know where it, or the craft it watches, was."""
    wrong = [f"{who} {error.rms_m:.2f} m" for who, error in navigation.items() if error.rms_m >= _WORTH_TELLING_M]
    return [f"believed positions wrong by (r.m.s.): {', '.join(wrong)}"] if wrong else []


def _about_closest(closest: ClosestApproach | None) -> list[str]:
    if closest is None:
        return []
    one, other = closest.craft
    return [f"closest approach {closest.distance_m:.1f} m, {one} and {other} at {closest.t_s:.0f} s"]


def _about_links(paths: Mapping[str, PathLedger]) -> list[str]:
    """Say in two lines how good the links were."""
    lines = []
    ages = {name: path.age_mean_s for name, path in paths.items() if path.age_mean_s >= 0.0}
    if ages:
        worst = max(ages, key=ages.__getitem__)
        silent = f"; {len(paths) - len(ages)} of {len(paths)} links carried nothing" if len(ages) < len(paths) else ""
        mean_s = sum(ages.values()) / len(ages)
        lines.append(f"age of information {mean_s:.1f} s on average, {ages[worst]:.1f} s on {worst}{silent}")
    lost = sum((Counter(path.lost) for path in paths.values()), Counter())
    outcomes = lost.total() + sum(path.delivered + path.overheard for path in paths.values())
    if lost:
        main = ", ".join(f"{reason} {100 * n / outcomes:.1f} %" for reason, n in lost.most_common(_MAIN_REASONS))
        others = len(lost) - _MAIN_REASONS
        main += f" and {others} other reasons" if others > 0 else ""
        lines.append(f"{100 * lost.total() / outcomes:.1f} % of {outcomes} receptions lost: {main}")
    return lines


def _about_tasks(tasks: Sequence[TaskLine]) -> list[str]:
    """Say what became of every order: the last word of whoever gave it, and the first of who does it."""
    orders: dict[tuple[str, str], list[TaskLine]] = {}
    for line in tasks:
        orders.setdefault((line.said_by, line.order), []).append(line)
    told = []
    for (who, order), lines in orders.items():
        steps = [f"{line.status} at {line.t_s:.0f} s{f' ({line.detail})' if line.detail else ''}" for line in lines]
        first = lines[0]
        by = (
            f"{who} does {first.task}"
            if first.craft == who
            else f"{who} sends {first.craft or 'nobody'} to {first.task}"
        )
        told.append(f"task {order}: {by}: {', '.join(steps)}")
    return told


def _about_cables(cables: Sequence[Cable]) -> list[str]:
    return [
        f"cable {'–'.join(cable.between)}: {cable.longest_m:.1f} m apart at most, of {cable.length_m:g} m"
        for cable in cables
    ]


def _warnings(summary: Summary) -> list[str]:
    lines = [f"WARNING: {summary.recording_fault}"] if summary.recording_fault else []
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
    lines += [
        f"WARNING: {' and '.join(cable.between)} were farther apart than their cable in {cable.over_steps} steps"
        for cable in summary.cables
        if cable.over_steps
    ]
    lines += [f"WARNING: the ledger does not add up: {fault}" for fault in summary.ledger_faults]
    lines += [f"WARNING: {craft} received {n} bad frames" for craft, n in summary.bad_frames.items()]
    return lines
