"""Real processes on 127.0.0.1: a run is started the way a user starts it, and watched from outside."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

SCENARIO = Path(__file__).parents[2] / "deploy" / "scenarios" / "paper-d.toml"
#: Long enough to be interrupted: over ten minutes of wall time even for a very fast machine.
ENDLESS = ("--set", "duration_s=1e7")


def grex(*arguments: str) -> list[str]:
    """Command line of the console."""
    return [sys.executable, "-m", "grex_sim", *arguments]


def participants(launcher: int) -> dict[str, psutil.Process]:
    """Return the processes of a run by what they are: sim, link, and the craft's names."""
    found = {}
    for child in psutil.Process(launcher).children(recursive=True):
        words = child.cmdline()
        if "grex_agent" in words:
            found[words[words.index("--craft") + 1]] = child
        elif "grex_link" in words:
            found["link"] = child
        elif "grex_sim" in words:
            found["sim"] = child
    return found


@contextmanager
def running(*arguments: str) -> Iterator[subprocess.Popen]:
    """Start the console, and kill it and all its children at the end."""
    process = subprocess.Popen(grex(*arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        for child in psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []:
            child.kill()
        process.kill()
        process.communicate()


def wait_for_recording(folder: Path, size: int = 200_000) -> None:
    """Wait until a run is under way: its recording has grown."""
    deadline = time.monotonic() + 30.0
    recording = folder / "run.mcap"
    while not (recording.exists() and recording.stat().st_size > size):
        assert time.monotonic() < deadline, "the run did not get under way"
        time.sleep(0.05)
