"""A plain pymavlink client, as a user would write one, against `grex autopilot` in a process of its own."""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self

from launching import grex
from pymavlink import mavutil

PATIENCE_S = 30.0
VELOCITY = 0x0DC7


@contextmanager
def autopilot(*arguments: str) -> Iterator[subprocess.Popen]:
    """Start an autopilot, and stop it at the end; `lines` reads what it printed first."""
    command = grex("autopilot", *arguments)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.terminate()
        process.communicate(timeout=PATIENCE_S)


def address(process: subprocess.Popen) -> str:
    """Where an autopilot says it listens: the last words of its first line."""
    return process.stdout.readline().split(" at ")[1].split()[-1]


class Client:
    """A ground station."""

    def __init__(self, url: str, system: int = 255) -> None:
        os.environ["MAVLINK20"] = "1"
        self.texts: list[str] = []
        self.link = mavutil.mavlink_connection(
            url, baud=57600, source_system=system, source_component=191, dialect="ardupilotmega", robust_parsing=True
        )

    @property
    def port(self) -> int:
        return self.link.port.getsockname()[1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_) -> None:
        self.link.close()

    def wait(self, kind: str, condition=lambda _: True, seconds: float = PATIENCE_S, repeat=None):
        """The next message of a kind that meets a condition; something is repeated every 50 ms of wall time."""
        deadline = time.monotonic() + seconds
        again = 0.0
        while time.monotonic() < deadline:
            if repeat is not None and time.monotonic() >= again:
                again = time.monotonic() + 0.05
                repeat()
            message = self.link.recv_match(blocking=True, timeout=0.05)
            self.texts += [message.text] if message is not None and message.get_type() == "STATUSTEXT" else []
            if message is not None and message.get_type() == kind and condition(message):
                return message
        raise AssertionError(f"no such {kind} in {seconds} s")

    def shows(self, mode: int, *, armed: bool | None = None, repeat=None):
        """Wait for a heartbeat with a mode."""
        return self.wait(
            "HEARTBEAT",
            lambda m: m.custom_mode == mode and armed in {None, bool(m.base_mode & 128)},
            repeat=repeat,
        )

    def command(self, number: int, *params: float, target: int = 1) -> int:
        """Send a command once and return the result in its ACK."""
        filled = [*params, *[0.0] * (7 - len(params))]
        self.link.mav.command_long_send(target, 1, number, 0, *filled)
        return self.wait("COMMAND_ACK", lambda m: m.command == number).result

    def interval(self, number: int, hz: float) -> int:
        return self.command(511, number, 1e6 / hz)

    def velocity(self, north: float, east: float, down: float = 0.0, target: int = 1) -> None:
        self.link.mav.set_position_target_local_ned_send(
            0, target, 1, 1, VELOCITY, 0.0, 0.0, 0.0, north, east, down, 0.0, 0.0, 0.0, 0.0, 0.0
        )

    def seconds(self, kind: str, boot_s: float, repeat=None) -> list:
        """Messages of a kind during a stretch of the autopilot's own time."""
        first = self.wait(kind, repeat=repeat)
        got = [first]
        while got[-1].time_boot_ms - first.time_boot_ms < boot_s * 1000.0:
            got.append(self.wait(kind, repeat=repeat))
        return got
