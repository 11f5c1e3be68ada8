"""Launches a run as processes, watches them, and leaves none behind.

They are the simulator, the link, and for each craft an agent; also a frontseat for each craft on MAVLink, and a driver
for each modem on a serial port.
"""

import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import msgspec

from grex_link.config import Scenario
from grex_link.errors import ConfigError, FaultError, GrexError
from grex_link.process import LAUNCHER_VARIABLE
from grex_sim.hub import Progress
from grex_sim.summary import Summary

_GRACE_S = 1.5
#: A frontseat hands its craft back, and waits for the autopilot to say so.
_HAND_BACK_S = 3.0
_CAUSE_S = 2.0


class Launch:
    """The processes of one run.

    Use as a context manager: whatever happens inside, no process is left when it ends.

    Parameters
    ----------
    scenario : Scenario
        The run, checked.
    arguments : sequence of str
        Scenario file and overrides, as every process takes them.
    out : Path
        The run's folder; what each process says on standard error goes into ``<who>.log`` there.
    """

    def __init__(self, scenario: Scenario, arguments: Sequence[str], out: Path) -> None:
        self._out = out
        self._time_s: float | None = None
        # It speaks at every tick, or names those it waits for after one of these times.
        clock = scenario.clock
        self._silence_s = _CAUSE_S + max(clock.start_timeout_s, clock.barrier_timeout_s, clock.tick_s / clock.factor)
        self._grace_s = _HAND_BACK_S if scenario.mavlink_craft else _GRACE_S
        self._started: dict[str, subprocess.Popen[str]] = {}
        if not scenario.bus.endpoints:
            arguments = [*arguments, "--set", f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]']
        self._commands = {
            "sim": ["grex_sim", "sim", *arguments, "--out", str(out), "--json"],
            "link": ["grex_link", *arguments],
            **{f"agent {craft}": ["grex_agent", *arguments, "--craft", craft] for craft in scenario.craft},
            **{
                f"frontseat {craft}": ["grex_agent.frontseat", *arguments, "--craft", craft]
                for craft in scenario.mavlink_craft
            },
            **{f"modem {craft}": ["grex_agent.modem", *arguments, "--craft", craft] for craft in scenario.serial_craft},
        }

    def __enter__(self) -> Self:
        try:
            for who, command in self._commands.items():
                self._start(who, command)
        except OSError as error:
            self._end_all()
            raise GrexError(f"cannot start the processes of the run: {error}") from error
        return self

    def __exit__(self, *_: object) -> None:
        self._end_all()

    def wait(self, progress: Progress) -> Summary:
        """Wait for the run to end.

        Raises
        ------
        GrexError
            Names the participant that stopped the run, how it ended, and the mission time.
        """
        summary = None
        sim = self._started["sim"]
        heard_at = time.monotonic()
        with selectors.DefaultSelector() as selector:
            assert sim.stdout is not None  # noqa: S101 - it was started with a pipe
            selector.register(sim.stdout, selectors.EVENT_READ)
            while sim.poll() is None or selector.get_map():
                for _ in selector.select(timeout=0.1):
                    heard_at = time.monotonic()
                    line = sim.stdout.readline()
                    if not line:
                        selector.unregister(sim.stdout)
                    else:
                        summary = self._on_line(json.loads(line), progress) or summary
                if summary is None and sim.poll() is None:
                    self._check_participants()
                    if time.monotonic() - heard_at > self._silence_s:
                        raise FaultError("sim", f"has said nothing for {self._silence_s:g} s", self._time_s)
        if summary is None or sim.wait() != 0:
            raise self._fault()
        return summary

    def _on_line(self, line: dict[str, Any], progress: Progress) -> Summary | None:
        if "time_s" in line:
            self._time_s = line["time_s"]
            progress(line["time_s"])
            return None
        return msgspec.convert(line["summary"], Summary)

    def _start(self, who: str, command: Sequence[str]) -> None:
        with (self._out / f"{who.replace(' ', '-')}.log").open("w") as log:
            self._started[who] = subprocess.Popen(  # noqa: S603 - our own modules
                [sys.executable, "-m", *command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE if who == "sim" else log,
                stderr=log,
                text=True,
                process_group=0,  # Ctrl-C is for the launcher alone; it ends the others in order
                env={**os.environ, LAUNCHER_VARIABLE: str(os.getpid()), "OPENBLAS_NUM_THREADS": "1"},
            )

    def _check_participants(self) -> None:
        """Before the first tick the simulator cannot know that somebody has died: it has never been there."""
        if self._time_s is None and self._dead():
            raise self._fault()

    def _dead(self) -> dict[str, int]:
        return {
            who: status
            for who, process in self._started.items()
            if (status := process.poll()) is not None and status != 0 and who != "sim"
        }

    def _fault(self) -> GrexError:
        """Say who stopped the run and how it ended; a dead participant before the simulator that missed it."""
        deadline = time.monotonic() + _CAUSE_S
        sim = self._started["sim"]
        words = self._last_words("sim")
        if " left the bus" in words:
            while not self._dead() and time.monotonic() < deadline:
                time.sleep(0.02)
        # Killed comes before failed: the others fail because of it.
        for who, status in sorted(self._dead().items(), key=lambda entry: entry[1] > 0):
            if status < 0 or not self._last_words(who).startswith("sim "):
                return self._explained(who, status)
        ended = sim.poll()
        if ended is None or ended >= 0:
            return _as_error(words or f"the simulator ended with status {ended} and no result", ended)
        return self._explained("sim", ended)

    def _explained(self, who: str, status: int) -> GrexError:
        if status < 0:
            return FaultError(who, f"was killed by {signal.Signals(-status).name} (status {status})", self._time_s)
        words = self._last_words(who)
        if status == ConfigError.exit_status:
            return _as_error(words, status)
        return FaultError(who, f"ended with status {status} ({words or self._silence()})", self._time_s)

    def _silence(self) -> str:
        """Say why somebody has not said anything, if that can be seen."""
        full = os.statvfs(self._out).f_bavail == 0
        return f"no word why: the disk of {self._out} is full" if full else "no word why"

    def _last_words(self, who: str) -> str:
        lines = (self._out / f"{who.replace(' ', '-')}.log").read_text(errors="replace").strip().splitlines()
        # Ours, rather than what a library has said after it.
        own = [line for line in lines if line.startswith("grex: ")]
        return (own or lines or [""])[-1].removeprefix("grex: ")

    def _end_all(self) -> None:
        alive = [process for process in self._started.values() if process.poll() is None]
        for process in alive:
            process.terminate()
        deadline = time.monotonic() + self._grace_s
        for process in alive:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if (sim := self._started.get("sim")) and sim.stdout:
            sim.stdout.close()


def free_port() -> int:
    """Find a TCP port on the loopback interface that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _as_error(words: str, status: int | None) -> GrexError:
    error = GrexError(words)
    error.exit_status = status or 1
    return error
