"""A process ends with the status that its end has, one line for every foreseen failure, and with its launcher."""

import os
import re
import signal
import subprocess
import sys

import pytest

PRELUDE = """
import os, signal, sys
from grex_link.errors import BusError, ConfigError
from grex_link.process import run_process
def fail(error):
    raise error
run_process(lambda: {work})
"""


def start(work: str, **environment: str) -> subprocess.Popen:
    command = [sys.executable, "-c", PRELUDE.format(work=work)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=os.environ | environment)


@pytest.mark.parametrize(
    ("work", "status", "line"),
    [
        ("None", 0, ""),
        ("fail(ConfigError('$.link.loss', 'is 2'))", 2, "grex: $.link.loss: is 2\n"),
        ("fail(BusError('missing: auv2'))", 1, "grex: missing: auv2\n"),
        ("os.kill(os.getpid(), signal.SIGTERM)", 130, "grex: interrupted\n"),
        ("os.kill(os.getpid(), signal.SIGINT)", 130, "grex: interrupted\n"),
        ("sys.exit(5)", 5, ""),
    ],
)
def test_end(work: str, status: int, line: str) -> None:
    """Every foreseen end has its status, and one line on standard error or none."""
    process = start(work)
    assert process.communicate(timeout=30) == ("", line)
    assert process.returncode == status


def test_unforeseen_failure() -> None:
    """A fault in the program itself is shown whole, not hidden behind one line."""
    process = start("1 / 0")
    _, err = process.communicate(timeout=30)
    assert process.returncode == 1
    assert "Traceback" in err
    assert "ZeroDivisionError" in err


def test_reader_gone() -> None:
    """Who writes into a pipe that nobody reads any more ends quietly, as in ``grex ... | head``."""
    process = start("print('x' * 1_000_000, flush=True)")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(timeout=30) == 1
    process.stderr.close()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells children of their parent's end")
def test_launcher_gone_before_the_start() -> None:
    """A process whose launcher is no longer its parent ends at once and says why."""
    process = start("print('worked')", GREX_LAUNCHER_PID="1")
    assert process.communicate(timeout=30) == ("", "grex: the launcher is gone\n")
    assert process.returncode == 1


LAUNCHER = """
import os, subprocess, sys
environment = os.environ | {"GREX_LAUNCHER_PID": str(os.getpid())}
child = subprocess.Popen([sys.executable, "-c", sys.argv[1]], env=environment)
child.wait()
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells children of their parent's end")
def test_ends_with_its_launcher() -> None:
    """A process ends when its launcher is killed, even by SIGKILL."""
    child = PRELUDE.format(work="(print('ready', flush=True), signal.pause())")
    pipe = subprocess.PIPE
    launcher = subprocess.Popen([sys.executable, "-c", LAUNCHER, child], stdout=pipe, stderr=pipe, text=True)
    assert launcher.stdout.readline() == "ready\n"
    launcher.send_signal(signal.SIGKILL)
    # Both pipes end only when the child, which holds their other ends too, has ended.
    assert launcher.communicate(timeout=30) == ("", "grex: interrupted\n")


def link(*arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "grex_link", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_link_with_a_bad_scenario(tmp_path, text: str) -> None:
    """The link refuses a bad scenario with status 2 and the one line that names the fault."""
    file = tmp_path / "bad.toml"
    file.write_text(text)
    done = link(str(file), "--set", "link.loss=2.0")
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(r"grex: \$\.link\.loss: [^\n]+\n", done.stderr)


def test_link_help() -> None:
    """The link says what it is and what it wants."""
    done = link("--help")
    assert (done.returncode, done.stderr) == (0, "")
    assert "SCENARIO" in done.stdout
    assert "--set" in done.stdout
