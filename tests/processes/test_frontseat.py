"""Real processes: agents steer simulated autopilots over UDP and a serial line, and when things go wrong."""

import json
import re
import signal
import subprocess
import time
from contextlib import ExitStack

import psutil
import pytest
from frontseat_runs import HEAD, OneBoat, autopilot, fixes, free_port
from launching import grex, running

#: Minutes of wall time: `pytest -m slow tests/processes`.
pytestmark = pytest.mark.slow

TEAM = """auv1 = [0, 0, 0]
auv2 = [0, 20, 3]
auv3 = [0, 40, 0]
[craft.auv1]
frontseat = {{ type = "mavlink", url = "udpin:127.0.0.1:{port}", arm = true }}
[craft.auv2]
frontseat = {{ type = "mavlink", url = "serial:{device}:115200", arm = true }}
[craft.auv3]
"""


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """A run of a boat over UDP, a sub over a serial line, and a simulated craft."""
    folder = tmp_path_factory.mktemp("mixed")
    port, device = free_port(), folder / "sub"
    scenario, out = folder / "mixed.toml", folder / "run"
    scenario.write_text(HEAD.format(duration_s=60, pace=4.0) + TEAM.format(port=port, device=device))
    soon = ("--ready", "4", "--speedup", "4")
    with ExitStack() as stack:
        stack.enter_context(autopilot(f"udpout:127.0.0.1:{port}", folder / "boat.log", *soon))
        sub = ("--family", "sub", "--sysid", "7", *soon)
        stack.enter_context(autopilot(f"pty:{device}", folder / "sub.log", *sub, start=(0.0, 20.0)))
        while not device.exists():
            time.sleep(0.05)
        launcher = stack.enter_context(running("run", str(scenario), "--json", "--out", str(out)))
        printed, err = launcher.communicate(timeout=100)
        time.sleep(0.5)
    assert (launcher.returncode, err) == (0, "")
    return folder, json.loads(printed)


def test_a_mixed_team_flies(mixed):
    """A boat on UDP, a sub on a serial line and a simulated craft fly one mission, and hear each other in one sea."""
    _, summary = mixed
    assert summary["complete"]
    assert summary["ticks"] == 60
    assert summary["delivered"] > 0


@pytest.mark.parametrize("craft", ["auv1", "auv2"])
def test_fixes_are_those_of_the_ticks(mixed, craft: str):
    """A craft on MAVLink has a valid fix for nearly every tick, stamped with that tick's time."""
    folder, _ = mixed
    found = fixes(folder / "run", craft)
    assert len(found) >= 55
    assert all(fix.t_ns == fix.tick * 10**9 for fix in found)
    assert [fix.tick for fix in found] == sorted({fix.tick for fix in found})
    assert sum(fix.valid for fix in found) >= 0.9 * len(found)


@pytest.mark.parametrize(("craft", "east_m", "speed_mps"), [("auv1", 0.0, 1.0), ("auv2", 20.0, 1.0)])
def test_it_keeps_its_track(mixed, craft: str, east_m: float, speed_mps: float):
    """Under way a craft on MAVLink keeps to its track within 3 m, in the mission's frame, and nears its speed."""
    folder, _ = mixed
    found = [fix for fix in fixes(folder / "run", craft) if fix.valid and fix.tick >= 20]
    assert all(abs(fix.east_m - east_m) < 3.0 for fix in found)
    made_good = (found[-1].north_m - found[0].north_m) / (found[-1].tick - found[0].tick)
    assert made_good == pytest.approx(speed_mps, abs=0.25)


def test_a_sub_goes_to_its_depth(mixed):
    """A sub is steered to the depth of its track."""
    folder, _ = mixed
    assert fixes(folder / "run", "auv2")[-1].down_m == pytest.approx(3.0, abs=0.5)


@pytest.mark.parametrize(("who", "log", "mode"), [("auv1", "boat", "HOLD"), ("auv2", "sub", "POSHOLD")])
def test_it_hands_back(mixed, who: str, log: str, mode: str):
    """At the end each autopilot is in a mode that holds, and both sides say so."""
    folder, _ = mixed
    said = (folder / "run" / f"frontseat-{who}.log").read_text()
    assert f"the craft is with its autopilot, in {mode}, armed" in said
    assert re.search(rf"GUIDED -> {mode} by 255/191", (folder / f"{log}.log").read_text())


def test_px4(tmp_path):
    """PX4 is taken into OFFBOARD and armed, keeps its track and speed, and is handed back to AUTO.LOITER."""
    boat = OneBoat(tmp_path, 60.0)
    with boat.autopilot("--family", "px4"):
        status, _, err = boat.fly()
    assert (status, err) == (0, "")
    assert boat.words[-1] == "the craft is with its autopilot, in AUTO.LOITER, armed"
    found = [fix for fix in boat.fixes() if fix.valid and fix.tick >= 25]
    assert all(abs(fix.east_m) < 3.0 for fix in found)
    assert (found[-1].north_m - found[0].north_m) / (found[-1].tick - found[0].tick) == pytest.approx(1.0, abs=0.25)


def test_a_person_arms(tmp_path):
    """Without arm = true the mission starts, the adapter waits for a person, and touches nothing."""
    boat = OneBoat(tmp_path, 20.0, more="")
    with boat.autopilot():
        status, _, err = boat.fly()
    assert (status, err) == (0, "")
    assert "ready: waiting for a person to set GUIDED and to arm" in boat.words
    assert "by 255/191" not in boat.log.read_text()


def test_signing(tmp_path):
    """With one key on both sides all goes well; with different keys nobody is heard."""
    key, other = tmp_path / "key", tmp_path / "other"
    key.write_text("1f" * 32)
    other.write_text("2e" * 32)
    boat = OneBoat(tmp_path, 10.0, more=f'arm = true\nsigning_key_file = "{key}"')
    with boat.autopilot("--signing-key-file", str(key)):
        assert boat.fly()[0] == 0
    with boat.autopilot("--signing-key-file", str(other)):
        status, _, err = boat.fly("--set", "clock.start_timeout_s=8")
    assert status == 1
    assert "no heartbeat of an autopilot" in err


FAULTS = {
    "silence": ("silence@36:10", ["silent for 3 s", "is heard again"], True),
    "reboot": ("reboot@36", ["the autopilot has booted", "a person has to set GUIDED|disarmed"], False),
    "pilot": ("pilot@36=MANUAL", ["has set MANUAL: no set-points are sent"], False),
    "gps": ("gps@36:15", ["no valid position: "], True),
    "loss": ("loss@0:1000=0.3", ["GUIDED and armed: the agent steers"], True),
    "garbage": ("garbage@10:30", ["GUIDED and armed: the agent steers"], True),
    "jump": ("jump@36=1000", [], True),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault(tmp_path, fault: str):
    """What goes wrong at an autopilot is said in a clear line, the run goes on, and the fixes tell the truth."""
    argument, lines, recovers = FAULTS[fault]
    boat = OneBoat(tmp_path, 70.0)
    with boat.autopilot("--fault", argument):
        status, _, err = boat.fly()
    assert (status, err) == (0, ""), boat.words
    for line in lines:
        assert any(re.search(line, words) for words in boat.words), (line, boat.words)
    found = boat.fixes()
    assert found[5].valid
    if recovers:
        assert found[-1].valid, (found[-1].reason, boat.words)
    if fault in {"silence", "gps"}:
        assert any(not fix.valid and fix.reason for fix in found)
    if fault == "pilot":
        assert "GUIDED by 255/191" not in boat.log.read_text().partition("MANUAL by the pilot")[2]


def test_arming_denied(tmp_path):
    """An autopilot that does not arm ends the run before the mission starts, with its own reason in the line."""
    boat = OneBoat(tmp_path, 30.0)
    with boat.autopilot("--fault", "refuse@0:1000"):
        status, _, err = boat.fly("--set", "clock.start_timeout_s=15")
    assert status == 1
    assert re.match(r"grex: frontseat auv1 ended with status 1 \(the autopilot is not ready after 15 s: .+\)", err), err


def test_nobody_answers(tmp_path):
    """Without an autopilot the run ends before the mission starts, and says what was missing."""
    boat = OneBoat(tmp_path, 30.0)
    status, _, err = boat.fly("--set", "clock.start_timeout_s=6")
    assert status == 1
    assert "no heartbeat of an autopilot" in err
    assert err.count("\n") == 1


def test_an_agent_that_is_killed(tmp_path):
    """When the agent is killed the craft holds, and the run ends and names the agent."""
    boat = OneBoat(tmp_path, 1000.0)
    with boat.autopilot():
        with boat.grex() as launcher:
            boat.wait_for_words("the agent steers")
            time.sleep(3.0)
            (agent,) = [c for c in psutil.Process(launcher.pid).children(recursive=True) if "grex_agent" in c.cmdline()]
            agent.send_signal(signal.SIGKILL)
            _, err = launcher.communicate(timeout=30)
        assert re.match(r"grex: agent auv1 was killed by SIGKILL", err)
        assert boat.words[-1] == "the craft is with its autopilot, in HOLD, armed"


def test_an_agent_that_hangs(tmp_path):
    """When the agent hangs the craft is handed back within setpoint_age_max_s; when it goes on, so does the craft."""
    boat = OneBoat(tmp_path, 120.0)
    with boat.autopilot():
        with boat.grex() as launcher:
            boat.wait_for_words("the agent steers")
            time.sleep(3.0)
            (agent,) = [c for c in psutil.Process(launcher.pid).children(recursive=True) if "grex_agent" in c.cmdline()]
            agent.suspend()
            boat.wait_for_words("the agent is silent")
            boat.wait_for_words("in HOLD, armed")
            agent.resume()
            boat.wait_for_words("the agent speaks again")
            launcher.send_signal(signal.SIGINT)
            launcher.communicate(timeout=30)
        assert boat.words[-1] == "the craft is with its autopilot, in HOLD, armed"


def test_an_adapter_that_is_killed(tmp_path):
    """A killed adapter ends the run by name, the boat stops by its own timeout, and the next run takes it again."""
    boat = OneBoat(tmp_path, 1000.0)
    with boat.autopilot():
        with boat.grex() as launcher:
            boat.wait_for_words("the agent steers")
            time.sleep(4.0)
            children = psutil.Process(launcher.pid).children(recursive=True)
            (adapter,) = [child for child in children if "grex_agent.frontseat" in child.cmdline()]
            adapter.send_signal(signal.SIGKILL)
            _, err = launcher.communicate(timeout=30)
        assert re.match(r"grex: frontseat auv1 was killed by SIGKILL", err)
        status, _, err = boat.fly("--set", "duration_s=10")
        assert (status, err) == (0, "")
    assert "target not received last 3secs, stopping" in boat.log.read_text()


def test_two_autopilots_with_one_id(tmp_path):
    """Two autopilots with one system id on a link are refused in words before the mission starts."""
    boat = OneBoat(tmp_path, 30.0)
    # Started together with the same draws they would say the same bytes, which nobody could tell from an echo.
    other = boat.autopilot("--seed", "2", "--ready", "6", log="other.log")
    with boat.autopilot(), other:
        status, _, err = boat.fly()
    assert status == 1
    assert "two autopilots have system id 1" in err


def test_ctrl_c(tmp_path):
    """Ctrl-C hands the craft back before everything ends."""
    boat = OneBoat(tmp_path, 1000.0)
    with boat.autopilot():
        with boat.grex() as launcher:
            boat.wait_for_words("the agent steers")
            time.sleep(2.0)
            launcher.send_signal(signal.SIGINT)
            launcher.communicate(timeout=30)
        assert launcher.returncode == 130
        assert boat.words[-1] == "the craft is with its autopilot, in HOLD, armed"


# -- grex frontseat --probe -------------------------------------------------------------------------------------------


def probe(url: str) -> subprocess.CompletedProcess:
    return subprocess.run(grex("frontseat", "--probe", url), capture_output=True, text=True, timeout=40, check=False)


def test_probe_nobody():
    """A probe of an address where nobody is says so in one line within some ten seconds, and exits 1."""
    since = time.monotonic()
    found = probe(f"udpin:127.0.0.1:{free_port()}")
    assert time.monotonic() - since < 20.0
    assert (found.returncode, found.stdout) == (1, "")
    assert re.fullmatch(r"grex: udpin:127\.0\.0\.1:\d+: nobody answers; .*\n", found.stderr)


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
def test_probe(tmp_path, family: str):
    """A probe tells autopilot, version, modes, position and rates, and exits 0 when nothing is missing."""
    port = free_port()
    with autopilot(f"udpout:127.0.0.1:{port}", tmp_path / "log", "--family", family, "--ready", "2"):
        found = probe(f"udpin:127.0.0.1:{port}")
    assert (found.returncode, found.stderr) == (0, ""), found.stdout
    assert re.search(r"Position +valid", found.stdout)
    assert re.search(r"Version +\d+\.\d+\.\d+", found.stdout)
    assert re.search(r"GLOBAL_POSITION_INT \d", found.stdout)
    assert re.search(r"Missing +nothing", found.stdout)


def test_probe_says_what_is_missing(tmp_path):
    """An autopilot that does not know where it is: the probe exits 1, and names that."""
    port = free_port()
    with autopilot(f"udpout:127.0.0.1:{port}", tmp_path / "log", "--ready", "60"):
        found = probe(f"udpin:127.0.0.1:{port}")
    assert found.returncode == 1
    assert "missing for GREX" in found.stderr
    assert "a valid position" in found.stderr


def test_probe_of_no_address():
    """An address that is none is an error of the command line."""
    found = probe("14550")
    assert found.returncode == 2
    assert found.stderr.startswith("grex: --probe: '14550' is no address of an autopilot; write udpin:HOST:PORT")
