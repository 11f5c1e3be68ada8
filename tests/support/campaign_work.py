"""Work for executors, importable by their processes: what it does is said by the job."""

import os
import signal
import time
from pathlib import Path

import msgspec


class Task(msgspec.Struct, frozen=True):
    """A job that is no mission."""

    key: str
    deed: str = "double"
    value: int = 0
    folder: str = ""


def work(task):
    """Double a value, fail, or die; leave a trace of every beginning."""
    if task.folder:
        with (Path(task.folder) / task.key).open("a", encoding="utf-8") as trace:
            trace.write("begun\n")
    if task.deed == "fail":
        raise ValueError(f"no {task.value}")
    if task.deed == "die" or (task.deed == "die once" and begun(task) < 2):
        os.kill(os.getpid(), signal.SIGKILL)
    if task.deed == "sleep":
        time.sleep(task.value)
    return {"value": 2 * task.value}


def begun(task):
    """How often a task has been begun."""
    return len((Path(task.folder) / task.key).read_text(encoding="utf-8").splitlines())
