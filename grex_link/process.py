"""What every GREX process does first and last: signals, one-line errors, exit statuses."""

import ctypes
import gc
import os
import signal
import sys
from collections.abc import Callable
from typing import Any, NoReturn

from grex_link.errors import GrexError

#: Set by the launcher for its children to its own process id: they end when it does.
LAUNCHER_VARIABLE = "GREX_LAUNCHER_PID"
INTERRUPTED = 130
_PR_SET_PDEATHSIG = 1


def run_process(work: Callable[[], None]) -> NoReturn:
    """Do a process's work and exit with its status; every foreseen failure is one line on standard error."""
    signal.signal(signal.SIGTERM, _interrupt)
    collect_rarely()
    die_with_launcher()
    try:
        work()
    except GrexError as error:
        say(f"grex: {error}")
        sys.exit(error.exit_status)
    except KeyboardInterrupt:
        say("grex: interrupted")
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output is gone; there is nobody to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    sys.exit(0)


def collect_rarely() -> None:
    """Let Python look for cyclic garbage less often: there is next to none, and looking costs a third of the speed."""
    gc.set_threshold(50_000, 20, 20)


def say(line: str) -> None:
    """Print one line on standard error."""
    print(line, file=sys.stderr, flush=True)  # noqa: T201 - this is the console


def _interrupt(number: int, frame: Any) -> NoReturn:
    del number, frame
    raise KeyboardInterrupt


def die_with_launcher() -> None:
    """Ask the kernel for SIGTERM when the launcher dies, even by SIGKILL (Linux; elsewhere nothing)."""
    launcher = os.environ.get(LAUNCHER_VARIABLE)
    if launcher:
        die_with(int(launcher))


def die_with(parent: int) -> None:
    """Let this process be ended when its parent dies; end it now if that has happened (Linux; elsewhere nothing)."""
    if not sys.platform.startswith("linux"):
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        sys.exit("grex: the launcher is gone")
