"""What ``grex link stats`` finds in a recording: the ledger of the water, and how latency and age are distributed.

Counts, means and histograms are the ledger's. Percentiles are exact, from every delivery in the recording.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from grex_link.config import Scenario
from grex_link.energy import sound_energy_j
from grex_link.errors import ConfigError
from grex_link.ledger import EDGES_S, Ledger, faults
from grex_link.messages import LinkEvent, LinkLedger, PathLedger, PortLedger, SourceLedger, Truth
from grex_link.profile import ModemProfile, load_profile
from grex_link.recording import Entry, Recording
from grex_link.units import NS


class Spread(msgspec.Struct, frozen=True):
    """How a time is distributed, seconds; None where there is none."""

    mean_s: float | None
    p50_s: float | None
    p90_s: float | None


class LinkStats(msgspec.Struct, frozen=True):
    """One directed link."""

    counts: PathLedger
    latency: Spread
    """Of the deliveries."""
    age: Spread
    """Of information, over the time since the first delivery."""


class NodeStats(msgspec.Struct, frozen=True):
    """One craft."""

    water: SourceLedger
    airtime_share: float
    """Of the mission."""
    sound_j: float | None
    """Acoustic energy of what it has sent under water; None if the modem's source level is not known."""
    port: PortLedger | None


class RunStats(msgspec.Struct, frozen=True):
    """What ``grex link stats --json`` prints."""

    run: str
    mission_s: float
    recomputed: bool
    """Whether the run was cut off before its last ledger, so that this one was drawn up from the log."""
    histogram_edges_s: list[float]
    """Edges of the bins of ``latency_counts`` and ``age_seconds``; the first begins at 0, the last is open."""
    latency: Spread
    """Of all links together."""
    age: Spread
    links: dict[str, LinkStats]
    nodes: dict[str, NodeStats]
    faults: list[str]
    """What does not add up."""


def link_stats(run: Path) -> RunStats:
    """Read the books of a run's link from its recording, whether or not it came to its end.

    Parameters
    ----------
    run : Path
        The run's folder, or its recording.

    Raises
    ------
    ConfigError
        If there is no recording of a run.
    """
    books = _Books(run)
    published, end_ns = books.ledger, books.end_ns
    final = published is not None and published.t_ns >= end_ns
    end_ns = published.t_ns if published is not None and final else end_ns
    log = [event for event in books.log if event.t_ns < end_ns]
    ledger = _ledger(books.team, log, end_ns)
    found = faults(ledger, books.ports, None)
    if final and published != ledger:
        found.append("the ledger that was published is not that of the log in the recording")
    saws = _Saws(log, end_ns)
    return RunStats(
        run=str(run),
        mission_s=end_ns / NS,
        recomputed=not final,
        histogram_edges_s=list(EDGES_S),
        latency=_spread_of_values(saws.latencies(ledger.paths)),
        age=_spread_of_teeth(saws.teeth(ledger.paths)),
        links={f"{path.source}>{path.destination}": _link(path, saws) for path in ledger.paths},
        nodes={source.craft: _node(source, end_ns, books) for source in ledger.sources},
        faults=found,
    )


class _Books:
    """What a recording holds of the link."""

    def __init__(self, run: Path) -> None:
        self.team: list[str] = []
        self.log: list[LinkEvent] = []
        self.ledger: LinkLedger | None = None
        self.ports: dict[str, PortLedger] = {}
        self.end_ns = 0
        recording = Recording(run)
        self.profile = _profile(recording.scenario)
        for entry in recording.entries({"truth", "link_event", "ledger", "port"}):
            self._take(entry)
        if not self.team:
            raise ConfigError(str(run), "holds no run: nothing was recorded before it broke off")

    def _take(self, entry: Entry) -> None:
        match entry.message:
            case Truth(poses=poses):
                self.team = self.team or [pose.craft for pose in poses]
                self.end_ns = max(self.end_ns, entry.t_ns)
            case LinkEvent() as event:
                self.log.append(event)
                self.end_ns = max(self.end_ns, entry.t_ns + 1)
            case LinkLedger() as ledger:
                self.ledger = ledger
            case PortLedger() as port:
                self.ports[entry.craft] = port


def _ledger(team: Sequence[str], log: Iterable[LinkEvent], t_ns: int) -> LinkLedger:
    """Draw up the ledger from the log."""
    ledger = Ledger(team)
    for event in log:
        ledger.note(event)
    return ledger.snapshot(t_ns)


class _Saws:
    """The single deliveries behind the ledger: latencies, and the teeth of the age of information."""

    def __init__(self, log: Iterable[LinkEvent], end_ns: int) -> None:
        self._latencies: dict[tuple[str, str], list[int]] = {}
        self._teeth: dict[tuple[str, str], list[tuple[int, int]]] = {}
        newest: dict[tuple[str, str], tuple[int, int]] = {}
        for event in log:
            if event.kind != "delivered":
                continue
            ends = event.source, event.destination
            self._latencies.setdefault(ends, []).append(event.lasting_ns)
            sent_ns = event.t_ns - event.lasting_ns
            if event.purpose not in {"data", "land"} or (ends in newest and sent_ns <= newest[ends][0]):
                continue
            self._end_tooth(ends, newest.get(ends), event.t_ns)
            newest[ends] = sent_ns, event.t_ns
        for ends, last in newest.items():
            self._end_tooth(ends, last, end_ns)

    def _end_tooth(self, ends: tuple[str, str], last: tuple[int, int] | None, t_ns: int) -> None:
        if last is not None:
            sent_ns, since_ns = last
            self._teeth.setdefault(ends, []).append((since_ns - sent_ns, t_ns - sent_ns))

    def latencies(self, paths: Iterable[PathLedger]) -> list[int]:
        """Latencies on some links, ns."""
        return [ns for path in paths for ns in self._latencies.get((path.source, path.destination), [])]

    def teeth(self, paths: Iterable[PathLedger]) -> list[tuple[int, int]]:
        """Ages between which information grew old on some links, ns."""
        return [tooth for path in paths for tooth in self._teeth.get((path.source, path.destination), [])]


def _link(path: PathLedger, saws: _Saws) -> LinkStats:
    return LinkStats(path, _spread_of_values(saws.latencies([path])), _spread_of_teeth(saws.teeth([path])))


def _node(water: SourceLedger, end_ns: int, books: _Books) -> NodeStats:
    profile = books.profile
    sound_j = None if profile is None else sound_energy_j(profile, water.airtime_s)
    return NodeStats(water, water.airtime_s * NS / max(end_ns, 1), sound_j, books.ports.get(water.craft))


def _profile(scenario: Scenario) -> ModemProfile | None:
    """Modem of the run, as its scenario names it; None if the modem's own file is gone."""
    try:
        return load_profile(scenario.link.profile)
    except ConfigError:
        return None


def _spread_of_values(values_ns: Sequence[int]) -> Spread:
    if not values_ns:
        return Spread(None, None, None)
    p50, p90 = np.quantile(np.array(values_ns) / NS, [0.5, 0.9])
    return Spread(sum(values_ns) / len(values_ns) / NS, float(p50), float(p90))


def _spread_of_teeth(teeth_ns: Sequence[tuple[int, int]]) -> Spread:
    """Spread over time of what grows evenly along each tooth: at an age x it spends as much as teeth lie across x."""
    teeth: NDArray[np.float64] = np.array(teeth_ns, dtype=float).reshape(-1, 2) / NS
    duration_s = float((teeth[:, 1] - teeth[:, 0]).sum())
    if not duration_s:
        return Spread(None, None, None)
    ages = teeth.ravel()
    order = np.argsort(ages, kind="stable")
    ages = ages[order]
    across = np.cumsum(np.tile([1, -1], len(teeth))[order])
    spent = np.concatenate([[0.0], np.cumsum(across[:-1] * np.diff(ages))])
    p50, p90 = np.interp([0.5 * duration_s, 0.9 * duration_s], spent, ages)
    return Spread(float((teeth[:, 1] ** 2 - teeth[:, 0] ** 2).sum()) / 2 / duration_s, float(p50), float(p90))
