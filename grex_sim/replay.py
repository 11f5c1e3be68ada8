"""Replays a recorded craft: what came in is given to an agent's core again, in the order of its steps.

A step is known by its state: its time by the craft's clock, and how many modem events had come by then. The fix is that
of the same tick and time; a step without one was overdue. Nothing here reads a clock; lockstep or live is the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import msgspec

from grex_agent.core import AgentCore
from grex_agent.team.interface import needs_oracle
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import AgentState, Fix, Message, ModemEvent, Setpoint, Truth
from grex_link.recording import Recording

TOLERANCE = 1e-9
TOPICS = ("fix", "modem_rx", "modem_tx", "setpoint", "state", "truth")


@dataclass(slots=True)
class Tape:
    """What one craft saw and did, as recorded.

    Attributes
    ----------
    fixes, setpoints : dict
        By (tick, time by the craft's clock in ns).
    events : list of ModemEvent
        In the order of their numbers.
    requests : list
        What the modem was asked for, in order.
    states : list of AgentState
        One a step.
    truths : dict of int to Truth
        By tick.
    """

    fixes: dict[tuple[int, int], Fix] = field(default_factory=dict)
    events: list[ModemEvent] = field(default_factory=list)
    requests: list[Message] = field(default_factory=list)
    setpoints: dict[tuple[int, int], Setpoint] = field(default_factory=dict)
    states: list[AgentState] = field(default_factory=list)
    truths: dict[int, Truth] = field(default_factory=dict)

    def take(self, topic: str, message: Any) -> None:
        """Put a message where it belongs."""
        if topic == "fix":
            self.fixes[message.tick, message.t_ns] = message
        elif topic == "setpoint":
            self.setpoints[message.tick, message.t_ns] = message
        elif topic == "truth":
            self.truths[message.tick] = message
        elif topic == "modem_rx":
            self.events.append(message)
        elif topic == "modem_tx":
            self.requests.append(message)
        else:
            self.states.append(message)


class Difference(msgspec.Struct, frozen=True):
    """The first thing in which a replay is not what was recorded."""

    tick: int
    t_s: float
    """Mission time by the craft's clock."""
    where: str
    """Such as ``setpoint.speed_mps``."""
    recorded: Any
    replayed: Any

    def __str__(self) -> str:
        return (
            f"step {self.tick} at {self.t_s:.3f} s: {self.where} was recorded as {self.recorded!r} "
            f"and replayed as {self.replayed!r}"
        )


@dataclass(slots=True)
class Step:
    """One replayed step."""

    recorded: AgentState
    state: AgentState
    setpoint: Setpoint
    requests: list[Message]


def read_tape(recording: Recording, craft: str) -> Tape:
    """Read what a craft saw and did.

    Raises
    ------
    ConfigError
        If there is no such craft in the run, or it made no step.
    """
    if craft not in recording.scenario.craft:
        raise ConfigError("--craft", f"{craft!r} was not there; there were {', '.join(recording.scenario.craft)}")
    tape = Tape()
    for entry in recording.entries(TOPICS):
        if entry.craft in {craft, ""}:
            tape.take(entry.topic, entry.message)
    tape.events.sort(key=lambda event: event.seq)
    if not tape.states:
        raise ConfigError(str(recording.path), f"holds no step of {craft}")
    return tape


def replay(tape: Tape, scenario: Scenario, craft: str) -> Iterator[Step]:
    """Let a new core live through a tape.

    Parameters
    ----------
    tape : Tape
        What came in.
    scenario : Scenario
        The recorded one, or one that differs in what is aboard.
    craft : str
        Whose core.

    Raises
    ------
    ConfigError
        If such a core cannot be built, or the recording lacks an input.
    """
    core = AgentCore(scenario, craft)
    sees_truth = needs_oracle(scenario)
    given = 0
    for recorded in tape.states:
        fix = tape.fixes.get((recorded.tick, recorded.t_ns))
        wanted = max(recorded.modem_events, 0 if fix is None else fix.modem_events)
        if wanted > len(tape.events):
            raise ConfigError("RUN", f"modem event {len(tape.events)} of {craft} is missing from the recording")
        for event in tape.events[given:wanted]:
            core.on_modem(event)
        given = max(given, wanted)
        if sees_truth and recorded.tick in tape.truths:
            core.on_truth(tape.truths[recorded.tick])
        if fix is not None:
            core.on_fix(fix)
        yield _step(core, recorded)


def _step(core: AgentCore, recorded: AgentState) -> Step:
    outputs: dict[str, list[Any]] = {"setpoint": [], "state": [], "modem_tx": [], "port": []}
    for topic, message in core.step(recorded.tick, recorded.t_ns):
        outputs[topic].append(message)
    (setpoint,), (state,) = outputs["setpoint"], outputs["state"]
    return Step(recorded, state, setpoint, outputs["modem_tx"])


def first_difference(tape: Tape, scenario: Scenario, craft: str) -> Difference | None:
    """Replay a tape, and find the first output that is not the recorded one within `TOLERANCE`; None if all are."""
    asked = 0
    for step in replay(tape, scenario, craft):
        before = step.recorded
        # How many events there had been is an input; older recordings do not have it.
        pairs: list[tuple[str, Any, Any]] = [
            (
                "state",
                msgspec.structs.replace(before, modem_events=0),
                msgspec.structs.replace(step.state, modem_events=0),
            )
        ]
        if (setpoint := tape.setpoints.get((before.tick, before.t_ns))) is not None:
            pairs.append(("setpoint", setpoint, step.setpoint))
        for request in step.requests:
            recorded = tape.requests[asked] if asked < len(tape.requests) else None
            pairs.append(("modem_tx", recorded, request))
            asked += 1
        for name, recorded, replayed in pairs:
            if found := _compare(name, msgspec.to_builtins(recorded), msgspec.to_builtins(replayed)):
                return Difference(before.tick, before.t_ns / 1e9, *found)
    return None


def _compare(name: str, one: Any, other: Any) -> tuple[str, Any, Any] | None:
    """Find where two values differ: (where, one, other)."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return next((found for key in one if (found := _compare(f"{name}.{key}", one[key], other[key]))), None)
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = enumerate(zip(one, other, strict=True))
        return next((found for n, pair in pairs if (found := _compare(f"{name}[{n}]", *pair))), None)
    return None if _same(one, other) else (name, one, other)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        both_nan = one != one and other != other  # noqa: PLR0124
        return both_nan or abs(one - other) <= TOLERANCE * max(1.0, abs(one))
    return bool(one == other)
