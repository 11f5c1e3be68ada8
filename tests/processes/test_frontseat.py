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
from mavlink_client import Client

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


@pytest.fixture
def keys(tmp_path):
    """Two signing keys."""
    (tmp_path / "key").write_text("1f" * 32)
    (tmp_path / "other").write_text("2e" * 32)
    return str(tmp_path / "key"), str(tmp_path / "other")


def test_signing(tmp_path, keys):
    """With one key on both sides all goes well, from connecting to handing back."""
    boat = OneBoat(tmp_path, 10.0, more=f'arm = true\nsigning_key_file = "{keys[0]}"')
    with boat.autopilot("--signing-key-file", keys[0]):
        assert boat.fly()[0] == 0
    assert boat.words[-1] == "the craft is with its autopilot, in HOLD, armed"


@pytest.mark.parametrize(("ours", "theirs"), [(0, 1), (0, None), (None, 0)])
def test_signing_that_does_not_match(tmp_path, keys, ours, theirs):
    """A wrong key, or a key on one side only, ends the run before the mission, with one line that speaks of the key."""
    key = "" if ours is None else f'\nsigning_key_file = "{keys[ours]}"'
    boat = OneBoat(tmp_path, 10.0, more=f"arm = true{key}")
    with boat.autopilot(*([] if theirs is None else ["--signing-key-file", keys[theirs]])):
        status, _, err = boat.fly("--set", "clock.start_timeout_s=12")
    assert status == 1
    assert err.count("\n") == 1
    assert re.match(r"grex: frontseat auv1 ended with status 1 \(the autopilot is not ready after 12 s: ", err)
    assert "signed" in err.partition("signing_key_file")[0]
    assert "signing_key_file" in err


HELD = "the craft is with its autopilot, in HOLD, armed"
#: Fault as a parameter of the simulated autopilot, lines that are said, and how the run ends.
FAULTS = {
    "silence of 10 s": ("GREX_SILENCE", 10.0, ["silent for 3 s", "is heard again"], HELD),
    "reboot": (
        "GREX_REBOOT",
        1.0,
        ["the autopilot has booted: its message rates are asked for again"],
        "the craft is with its autopilot, in MANUAL, disarmed",
    ),
    "mode taken by a pilot": (
        "GREX_PILOT",
        0.0,
        ["has set MANUAL: no set-points are sent; set GUIDED and arm"],
        "the craft is with its autopilot, in MANUAL, armed",
    ),
    # A rover that has lost its position holds by itself, and nobody takes it out of that but a person.
    "no satellites": ("GREX_GPS", 1.0, ["no valid position: ", "has set HOLD: no set-points are sent"], HELD),
    "loss of 30 %": ("GREX_LOSS", 0.3, [], HELD),
    "garbage": ("GREX_GARBAGE", 10.0, [], HELD),
    "time jump": ("GREX_JUMP", 1000.0, [r"the autopilot's date has jumped by \+1000 s"], HELD),
}
#: The agent goes on steering through these.
STEERS_ON = {"silence of 10 s", "loss of 30 %", "garbage", "time jump"}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault(tmp_path, fault: str):
    """What goes wrong under way is said in a clear line, and the run ends in the state that is stated for it."""
    name, value, lines, end = FAULTS[fault]
    boat, port = OneBoat(tmp_path, 90.0), free_port()
    with ExitStack() as stack:
        stack.enter_context(boat.autopilot("--url", f"udpin:127.0.0.1:{port}"))
        station = stack.enter_context(Client(f"udpout:127.0.0.1:{port}", system=250))
        launcher = stack.enter_context(boat.grex())
        station.under_way()
        station.set(name, value)
        for line in lines:
            boat.wait_for_words(line)
        if fault == "no satellites":
            station.set(name, 0.0)
        _, err = launcher.communicate(timeout=120)
    assert (launcher.returncode, err) == (0, "")
    assert boat.words[-1] == end, boat.words
    found = boat.fixes()
    valid = [fix for fix in found if fix.valid]
    assert valid[-1].tick > found[-1].tick - 10, (found[-1].reason, boat.words)
    if fault in {"silence of 10 s", "no satellites", "reboot"}:
        assert any(not fix.valid and fix.reason for fix in found)
    if fault in STEERS_ON:
        assert all(abs(fix.east_m) < 3.0 for fix in valid if fix.tick >= 20)
        assert valid[-1].north_m - valid[-10].north_m > 4.0
    else:
        # The craft is not ours any more: whoever has it, has it.
        after = boat.log.read_text().partition(" by a pilot" if "pilot" in fault else "fault: ")[2]
        assert "GUIDED by 255/191" not in after


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
    """When the agent is killed the craft holds within the autopilot's timeout plus 1 s; the run ends and names it."""
    boat = OneBoat(tmp_path, 1000.0, pace=1.0)
    with boat.autopilot():
        with boat.grex() as launcher:
            boat.wait_for_words("the agent steers")
            # What it has printed has happened: its clock, from then on, is at least so far.
            then_s, since = boat.autopilot_time("-> GUIDED by 255/191"), time.monotonic()
            time.sleep(3.0)
            (agent,) = [c for c in psutil.Process(launcher.pid).children(recursive=True) if "grex_agent" in c.cmdline()]
            killed_s = then_s + time.monotonic() - since
            agent.send_signal(signal.SIGKILL)
            _, err = launcher.communicate(timeout=30)
        assert re.match(r"grex: agent auv1 was killed by SIGKILL", err)
        assert boat.words[-1] == HELD
    assert boat.autopilot_time("GUIDED -> HOLD by 255/191") - killed_s < 3.1 + 1.0


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


@pytest.mark.parametrize("second", [("--ready", "6"), ()], ids=["started later", "just alike"])
def test_two_autopilots_with_one_id(tmp_path, second):
    """Two autopilots with one system id on a link are refused in words before the mission starts."""
    boat = OneBoat(tmp_path, 30.0)
    with boat.autopilot(), boat.autopilot(*second, log="other.log"):
        status, _, err = boat.fly()
    assert status == 1
    assert "two autopilots have system id 1: give one of them another one" in err


def test_a_second_autopilot_that_comes_later(tmp_path):
    """One that turns up with the same id in mid-mission is named, and nobody is sent anything: the boat stops."""
    boat = OneBoat(tmp_path, 90.0)
    with boat.autopilot(), boat.grex() as launcher:
        boat.wait_for_words("the agent steers")
        with boat.autopilot(log="other.log"):
            boat.wait_for_words("two autopilots have system id 1: give one of them another one")
            launcher.communicate(timeout=90)
    found = boat.fixes()
    assert not found[-1].valid
    assert "two autopilots have system id 1" in found[-1].reason
    assert "target not received last 3secs, stopping" in boat.log.read_text()


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


def probe(url: str, *scenario: str) -> subprocess.CompletedProcess:
    command = grex("frontseat", *scenario, "--probe", url)
    return subprocess.run(command, capture_output=True, text=True, timeout=40, check=False)


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
    assert re.search(r"Place +54\.37\d{4}, 10\.16\d{4}$", found.stdout, re.MULTILINE)
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


def test_probe_with_a_scenario(tmp_path):
    """With a scenario the probe says how far the craft is from its datum, and that far away is too far."""
    boat = OneBoat(tmp_path, 10.0)
    with boat.autopilot():
        found = probe(f"udpin:127.0.0.1:{boat.port}", str(boat.scenario))
        assert re.search(r"Place +54\.37\d{4}, 10\.16\d{4}, \d+ m from the datum$", found.stdout, re.MULTILINE)
        assert found.returncode == 0
        boat.scenario.write_text(boat.scenario.read_text().replace("latitude_deg = 54.37", "latitude_deg = -35.36"))
        found = probe(f"udpin:127.0.0.1:{boat.port}", str(boat.scenario))
    assert found.returncode == 1
    assert "the autopilot is 9980 km from the datum; set [datum] to where the mission is" in found.stderr


WRONG = {
    "rover": ("SYSID_MYGCS=7", "FS_GCS_ENABLE=0", "FS_EKF_ACTION=0"),
    "sub": ("SYSID_MYGCS=7", "FS_GCS_ENABLE=2"),
    "px4": ("COM_OF_LOSS_T=30", "COM_OBL_RC_ACT=2", "NAV_DLL_ACT=2"),
}


@pytest.mark.parametrize("family", WRONG)
def test_probe_warns(tmp_path, family: str):
    """Failsafes that would not stop the craft, and ids that do not count, are a line each with what to set."""
    port = free_port()
    parameters = [word for text in WRONG[family] for word in ("--param", text)]
    with autopilot(f"udpout:127.0.0.1:{port}", tmp_path / "log", "--family", family, "--ready", "2", *parameters):
        found = probe(f"udpin:127.0.0.1:{port}")
    assert found.returncode == 0
    lines = re.findall(r"^  Warning +(\w+) is (\S+): .*set it to", found.stdout, re.MULTILINE)
    assert {f"{name}={value}" for name, value in lines} == set(WRONG[family])


def test_probe_of_no_address():
    """An address that is none is an error of the command line."""
    found = probe("14550")
    assert found.returncode == 2
    assert found.stderr.startswith("grex: --probe: '14550' is no address of an autopilot; write udpin:HOST:PORT")
