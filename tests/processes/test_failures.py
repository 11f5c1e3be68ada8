"""What goes wrong is named, ends in time, and leaves nothing behind."""

import re
import signal
import socket
import subprocess
import time

import psutil
import pytest
from launching import ENDLESS, SCENARIO, grex, participants, running, wait_for_recording
from recordings import recorded_messages

from grex_sim.launch import free_port


@pytest.fixture
def endless(tmp_path):
    """A run under way that would go on for long: (launcher, its participants, its folder)."""
    with running(
        "run", str(SCENARIO), *ENDLESS, "--set", "clock.barrier_timeout_s=4", "--out", str(tmp_path)
    ) as process:
        wait_for_recording(tmp_path)
        yield process, participants(process.pid), tmp_path


def test_a_killed_agent_is_named(endless, gone):
    """An agent that dies is named with its status and the mission time within 5 s; nothing is left running."""
    launcher, processes, folder = endless
    processes["auv2"].send_signal(signal.SIGKILL)
    killed_at = time.monotonic()
    _, err = launcher.communicate(timeout=10)
    assert time.monotonic() - killed_at < 5.0
    assert launcher.returncode == 1
    assert re.fullmatch(r"grex: agent auv2 was killed by SIGKILL \(status -9\) at mission time \d+\.0 s\n", err)
    assert gone(processes.values())
    # The recording opens and holds everything up to the last tick.
    last_s = float(re.search(r"time (\d+)", err)[1])
    assert max(truth.t_ns for truth in recorded_messages(folder, "truth")) == last_s * 1e9
    assert max(state.t_ns for state in recorded_messages(folder, "state", "auv1")) >= (last_s - 1) * 1e9


def test_a_killed_simulator_is_named_and_its_recording_opens(endless, gone):
    """Even when the recording process itself is killed, the file holds everything but the last second."""
    launcher, processes, folder = endless
    time.sleep(1.5)
    processes["sim"].send_signal(signal.SIGKILL)
    _, err = launcher.communicate(timeout=10)
    assert launcher.returncode == 1
    assert re.fullmatch(r"grex: sim was killed by SIGKILL \(status -9\) at mission time \d+\.0 s\n", err)
    assert gone(processes.values())
    told_s = float(re.search(r"time (\d+)", err)[1])
    recorded_s = max(truth.t_ns for truth in recorded_messages(folder, "truth")) / 1e9
    # The simulator told the time at most 0.2 s, and wrote at most 0.5 s of wall time before; the rate is of this run.
    assert recorded_s > 0.4 * told_s


def test_a_hung_agent_is_named(endless, gone):
    """An agent that is alive but silent is named too."""
    launcher, processes, _ = endless
    processes["auv3"].suspend()
    _, err = launcher.communicate(timeout=20)
    assert launcher.returncode == 1
    assert err.startswith("grex: agent auv3 ")
    assert err.count("\n") == 1
    assert gone(processes.values())


def test_ctrl_c_ends_all(endless, gone):
    """Ctrl-C ends everybody within 3 s and says so; the recording is complete as far as it got."""
    launcher, processes, folder = endless
    launcher.send_signal(signal.SIGINT)
    _, err = launcher.communicate(timeout=3)
    assert launcher.returncode == 130
    assert err == "grex: interrupted\n"
    assert gone(processes.values())
    assert '"fault": "interrupted"' in (folder / "summary.json").read_text()


def test_nobody_survives_the_launcher(endless, gone):
    """When the launcher itself is killed, its processes end, too."""
    launcher, processes, _ = endless
    launcher.kill()
    launcher.wait()
    assert gone(processes.values())


def one_line(*arguments: str) -> tuple[int, str]:
    result = subprocess.run(grex(*arguments), capture_output=True, text=True, timeout=60, check=False)
    assert result.stdout == ""
    return result.returncode, result.stderr


def test_a_port_in_use_is_named(tmp_path):
    """Two runs cannot share a port: the second says which, with exit status 2."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        endpoint = f"tcp/127.0.0.1:{server.getsockname()[1]}"
        override = ("--set", f'bus.endpoints=["{endpoint}"]')
        for command in (("sim", str(SCENARIO), *override), ("run", str(SCENARIO), *override, "--out", str(tmp_path))):
            status, err = one_line(*command)
            assert status == 2
            assert err.startswith(f"grex: $.bus.endpoints: cannot listen on {endpoint}")
            assert err.count("\n") == 1


def test_an_endpoint_where_nobody_answers_is_named():
    """An agent that finds no simulator says where it looked, with exit status 2."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = ("--set", f'bus.endpoints=["{endpoint}"]', "--set", "clock.start_timeout_s=1")
    status, err = one_line("agent", str(SCENARIO), "--craft", "auv1", *options)
    assert status == 2
    assert err == f"grex: $.bus.endpoints: nobody answers at {endpoint}; start the simulator, or correct the endpoint\n"


def test_a_bad_value_is_named_before_anything_starts(tmp_path):
    """A fault in the scenario is one line with its path and exit status 2; no process is started for it."""
    before = {process.pid for process in psutil.process_iter()}
    status, err = one_line("run", str(SCENARIO), "--set", "link.loss=1.5", "--out", str(tmp_path / "out"))
    assert (status, err) == (2, "grex: $.link.loss: expected `float` <= 1.0\n")
    assert not (tmp_path / "out").exists()
    assert {p.pid for p in psutil.process_iter() if p.pid not in before and "grex" in p.name()} == set()


def test_an_agent_that_cannot_start_is_explained(tmp_path):
    """A plug-in that only the agents' processes cannot load is named with the agent, not as a hang."""
    status, err = one_line(
        "run", str(SCENARIO), "--set", "team.estimator=no_such_package:Estimator", "--out", str(tmp_path)
    )
    assert status == 2
    assert err.startswith("grex: $.team.estimator: cannot import 'no_such_package': ModuleNotFoundError: ")
    assert err.count("\n") == 1
