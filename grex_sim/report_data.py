"""What a report is made of: everything of a run that its pictures and tables need, from the recording alone."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from grex_agent.mission import TeamPlan, plan_mission
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import AgentState, Setpoint, Truth
from grex_link.recording import Recording
from grex_sim.belief_errors import BeliefErrors, belief_errors
from grex_sim.link_stats import RunStats, link_stats
from grex_sim.score import Score, Series, score
from grex_sim.summary import SUMMARY_FILE, Summary

_TOPICS = ("truth", "state", "setpoint")


@dataclass(slots=True)
class RunData:
    """One run.

    Attributes
    ----------
    label : str
        Tells it from the others.
    scenario, plan
        What was asked for, and planned.
    t_s : ndarray, shape (l,)
        Mission time of the ticks that are judged.
    positions : ndarray, shape (l, craft, 2)
        True north and east, metres.
    score : Score
        fd(k) and its parts.
    states : dict of str to list of AgentState
        By craft.
    beliefs : dict
        For each craft, what it believed of each mate against the truth.
    stats : RunStats
        The ledger of the link, latency and age.
    summary : Summary or None
        What the run said of itself, wall times included; None if it was killed before.
    remark : str
        That the recording was cut off.
    """

    label: str
    scenario: Scenario
    plan: TeamPlan
    t_s: Series
    positions: Series
    score: Score
    states: dict[str, list[AgentState]]
    beliefs: dict[str, dict[str, BeliefErrors]]
    stats: RunStats
    summary: Summary | None
    remark: str


@dataclass(slots=True)
class _Heap:
    """Messages as they come from the recording."""

    truths: dict[int, Truth] = field(default_factory=dict)
    states: dict[str, list[AgentState]] = field(default_factory=dict)
    setpoints: dict[str, list[Setpoint]] = field(default_factory=dict)

    def take(self, craft: str, message: Any) -> None:
        if isinstance(message, Truth):
            self.truths[message.tick] = message
        elif isinstance(message, AgentState):
            self.states.setdefault(craft, []).append(message)
        else:
            self.setpoints.setdefault(craft, []).append(message)


def read_run(run: Path, label: str) -> RunData:
    """Read a run's recording, whole or cut off.

    Raises
    ------
    ConfigError
        If there is no recording of a run with at least one tick.
    """
    recording = Recording(run)
    heap = _Heap()
    for entry in recording.entries(_TOPICS):
        heap.take(entry.craft, entry.message)
    truths = [heap.truths[tick] for tick in sorted(heap.truths)]
    if len(truths) < 2:
        raise ConfigError(str(run), "broke off before its first tick: there is nothing to report")
    scenario = recording.scenario
    plan = plan_mission(scenario)
    positions = np.array([[(pose.north_m, pose.east_m) for pose in truth.poses] for truth in truths])
    return RunData(
        label=label,
        scenario=scenario,
        plan=plan,
        t_s=np.array([truth.t_ns for truth in truths[1:]]) / 1e9,
        positions=positions[1:],
        score=score(positions, plan, scenario.score),
        states=heap.states,
        beliefs={craft: belief_errors(heap.states.get(craft, []), heap.truths) for craft in scenario.craft},
        stats=link_stats(run),
        summary=_summary(recording.path.with_name(SUMMARY_FILE)),
        remark=recording.remark,
    )


def _summary(path: Path) -> Summary | None:
    try:
        return msgspec.json.decode(path.read_bytes(), type=Summary)
    except (OSError, msgspec.DecodeError):
        return None


def labels(runs: Sequence[Path]) -> list[str]:
    """Name runs by their folders, and number those that would have the same name."""
    names = [run.resolve().name if run.is_dir() else run.resolve().parent.name or run.stem for run in runs]
    return [f"{name} ({place + 1})" if names.count(name) > 1 else name for place, name in enumerate(names)]
