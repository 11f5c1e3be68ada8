"""Processes launched by hand, in any order, as on several machines."""

import json
import subprocess
import sys
import time

import pytest
from launching import SCENARIO, grex

from grex_sim.launch import free_port

AGENTS = ("auv1", "auv2", "auv3")


def commands(*overrides: str) -> dict[str, list[str]]:
    options = [part for value in overrides for part in ("--set", value)]
    module = [sys.executable, "-m"]
    return {
        "sim": grex("sim", str(SCENARIO), *options, "--json"),
        "link": grex("link", str(SCENARIO), *options),
        "auv1": [*module, "grex_agent", str(SCENARIO), *options, "--craft", "auv1"],
        "auv2": grex("agent", str(SCENARIO), *options, "--craft", "auv2"),
        "auv3": grex("agent", str(SCENARIO), *options, "--craft", "auv3"),
    }


def start(command: list[str]) -> subprocess.Popen:
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def end(processes: dict[str, subprocess.Popen]) -> dict[str, tuple[int, str, str]]:
    results = {}
    try:
        for who, process in processes.items():
            out, err = process.communicate(timeout=60)
            results[who] = process.returncode, out, err
    finally:
        kill(processes)
    return results


def kill(processes: dict[str, subprocess.Popen]) -> None:
    for process in processes.values():
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    "order", [["sim", "link", *AGENTS], ["auv3", "link", "auv1", "sim", "auv2"]], ids=["first", "amid"]
)
def test_started_in_any_order(order):
    """The participants find each other whoever is first, and all end well and silently."""
    overrides = [f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]', "duration_s=60"]
    to_start = commands(*overrides)
    processes = {}
    for who in order:
        processes[who] = start(to_start[who])
        time.sleep(0.4)
    results = end(processes)
    assert {who: (status, err) for who, (status, _, err) in results.items()} == dict.fromkeys(order, (0, ""))
    summary = json.loads(results["sim"][1].splitlines()[-1])["summary"]
    assert summary["ticks"] == 60


def test_another_scenario_is_refused():
    """An agent that runs other parameters than the simulator is named, before the first tick."""
    endpoint = f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]'
    to_start = commands(endpoint)
    processes = {who: start(to_start[who]) for who in ("sim", "link", "auv1", "auv3")}
    processes["auv2"] = start(commands(endpoint, "team.gain_mps=0.5")["auv2"])
    # The others may not have found the simulator before it left; they are not waited for.
    status, _, err = end({"sim": processes.pop("sim")})["sim"]
    kill(processes)
    assert status == 1
    assert err == "grex: agent auv2 runs another scenario; start all with the same file and overrides\n"


def test_missing_participants_are_named():
    """A simulator that waits in vain says for whom."""
    endpoint = f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]'
    to_start = commands(endpoint, "clock.start_timeout_s=4")
    results = end({who: start(to_start[who]) for who in ("sim", "link", "auv1")})
    assert results["sim"][0] == 1
    assert results["sim"][2] == "grex: not everybody is on the bus after 4 s; missing: agent auv2, agent auv3\n"
    # Those who were there are told why it is over.
    for who in ("link", "auv1"):
        assert results[who][0] == 1
        assert results[who][2].startswith("grex: sim ended the run: not everybody is on the bus")
