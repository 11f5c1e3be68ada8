"""Runs a scenario's simulator: in this process with everybody on a memory bus, or as one process among others."""

from collections.abc import Callable
from pathlib import Path

from grex_agent.core import AgentCore
from grex_agent.mission import TeamPlan, plan_mission
from grex_agent.separation import check_separation
from grex_agent.shell import Agent
from grex_link import clock
from grex_link.bus import ZenohBus, serve
from grex_link.config import Scenario
from grex_link.emulator import Emulator
from grex_link.errors import ConfigError, FaultError, RecordingError
from grex_link.memory_bus import MemoryBus
from grex_link.node import Outlet
from grex_link.recorder import Recorder
from grex_link.recording import RECORDING_FILE, run_metadata
from grex_sim.cables import CableWatch
from grex_sim.hub import Hub, Progress
from grex_sim.live import LiveHub
from grex_sim.lockstep import LockstepHub
from grex_sim.logbook import Logbook
from grex_sim.score import Score
from grex_sim.summary import Summary, summarise, write_files

#: Less than the launcher gives on Ctrl-C, so that the summary is written before.
_FAREWELL_S = 1.0


def check_scenario(scenario: Scenario) -> TeamPlan:
    """Work out everything a run needs beforehand, so that a fault is found before anything starts.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    plan = plan_mission(scenario)
    check_separation(scenario, plan)
    AgentCore(scenario, scenario.formation[0])
    return plan


def check_in_process(scenario: Scenario) -> TeamPlan:
    """Check as `check_scenario` does, and that nobody needs a process of its own."""
    plan = check_scenario(scenario)
    for craft in scenario.serial_craft:
        raise ConfigError(
            f"$.craft.{craft}.modem.type", "a serial modem needs its own process: run without --in-process"
        )
    for craft in scenario.mavlink_craft:
        raise ConfigError(
            f"$.craft.{craft}.frontseat.type", "a craft on MAVLink needs its own process: run without --in-process"
        )
    return plan


def simulate_in_process(scenario: Scenario, out: Path | None, progress: Progress) -> Summary:
    """Run everybody in this process, on the memory bus."""
    plan = check_in_process(scenario)
    bus = MemoryBus()

    def play(hub: Hub) -> None:
        bus.join(hub, scenario, "sim", "sim")
        bus.join(Emulator(scenario, bus), scenario, "link", "link")
        for craft in scenario.craft:
            bus.join(Agent(scenario, craft, bus), scenario, "agent", craft)
        bus.announce()
        bus.run()
        if not hub.done:
            raise FaultError("the run", "came to a standstill", hub.now_s)

    return _simulate(scenario, plan, bus, play, out, progress)


def simulate(scenario: Scenario, out: Path | None, progress: Progress) -> Summary:
    """Run the simulator as one process among others, on Zenoh; it is the hub of the bus."""
    plan = check_scenario(scenario)
    with ZenohBus(scenario, "sim", "sim") as bus:

        def play(hub: Hub) -> None:
            try:
                serve(bus, hub, scenario.clock)
            except BaseException as error:
                reason = str(error) or "interrupted"
                hub.say_goodbye(reason)
                _see_off(bus, hub, reason)
                raise
            _see_off(bus, hub, "")

        return _simulate(scenario, plan, bus, play, out, progress)


def _simulate(
    scenario: Scenario,
    plan: TeamPlan,
    outlet: Outlet,
    play: Callable[[Hub], None],
    out: Path | None,
    progress: Progress,
) -> Summary:
    """Let a hub play a scenario, and write down what came of it, even if it breaks off."""
    recorder = scene = None
    if out is not None:
        from grex_sim.foxglove_scene import FoxgloveScene  # protobuf takes a tenth of a second

        scene = FoxgloveScene(scenario, plan)
        out.mkdir(parents=True, exist_ok=True)
        recorder = Recorder(out / RECORDING_FILE, run_metadata(scenario))
    stop_when_full = scenario.recording.on_full_disk == "stop"
    logbook = Logbook(recorder, scene, CableWatch(scenario), stop_when_full=stop_when_full)
    build = LockstepHub if scenario.clock.lockstep else LiveHub
    hub = build(scenario, plan, outlet, logbook, progress)
    fault = "interrupted"
    try:
        play(hub)
        fault = ""
    except Exception as error:
        fault = str(error)
        raise
    finally:
        progress(hub.now_s)
        now = clock.monotonic_s()
        started_at = now if hub.started_at is None else hub.started_at
        unrecorded = _close(logbook)
        fault = fault or str(unrecorded or "")
        summary, result = summarise(
            scenario,
            plan,
            logbook,
            mission_s=hub.now_s,
            startup_s=started_at - hub.opened_at,
            wall_s=now - started_at,
            fault=fault,
        )
        if out is not None:
            _write(out, scenario, logbook, summary, result)
    if unrecorded is not None:
        raise unrecorded
    return summary


def _close(logbook: Logbook) -> RecordingError | None:
    """Close the recording, and hand back what hinders that: there is a summary to be written."""
    try:
        logbook.close()
    except RecordingError as error:
        return error
    return None


def _write(out: Path, scenario: Scenario, logbook: Logbook, summary: Summary, result: Score) -> None:
    """Write summary and series; where there is no room for them, the summary says it to whom it is shown."""
    try:
        write_files(out, scenario, logbook, summary, result)
    except RecordingError as error:
        summary.recording_fault = "; ".join(part for part in (summary.recording_fault, str(error)) if part)
        if summary.complete and scenario.recording.on_full_disk == "stop":
            raise


def _see_off(bus: ZenohBus, hub: Hub, reason: str) -> None:
    """Stay, as the router, until everybody has left or has had time to.

    Before the start some may only be coming: they are told, too, and not left to wait.
    """
    present = set(hub.present)
    deadline = clock.monotonic_s() + _FAREWELL_S
    while (present or not hub.started) and clock.monotonic_s() < deadline:
        envelope = bus.take(0.05)
        if envelope is None:
            continue
        topic, who, message = envelope
        if topic != "presence":
            hub.handle(*envelope)  # the last words of the agents
        elif message.alive:
            present.add(who)
            hub.say_goodbye(reason)
        else:
            present.discard(who)
