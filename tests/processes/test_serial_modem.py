"""Real processes on real ptys: a team whose modems are Micro-Modems, with firmware in our water at the other end."""

import json
import re
import signal
import time

import psutil
from launching import running as launched
from launching import wait_for_recording
from micromodem_firmware import Line, Water, running
from recordings import recorded_messages

from grex_link.messages import ModemStatus, Received, TxEvent
from grex_link.scenario import loads

PLACES = {"auv1": (0.0, 0.0, 5.0), "auv2": (0.0, 100.0, 5.0)}
SCENARIO = """
duration_s = {duration_s}
[clock]
pace = {pace}
[link]
profile = "umodem_psk1"
[link.mac]
type = "tdma"
range_max_m = 200.0
[mission]
type = "lawnmower"
leg_length_m = 1000.0
turn_radius_m = 200.0
[mission.formation_m]
auv1 = [0, 0, 5]
auv2 = [0, 100, 5]
[craft.auv1]
modem = {{ type = "serial", port = "{auv1}" }}
[craft.auv2]
modem = {{ type = "serial", port = "{auv2}" }}
"""


class Team:
    """Two modems in the water, and the scenario of craft that use them."""

    def __init__(self, folder, duration_s: float, pace: str = '"live"') -> None:
        text = SCENARIO.format(duration_s=duration_s, pace=pace, auv1="a", auv2="b")
        self.water = Water(loads(text), PLACES)
        self.lines = {craft: Line(modem) for craft, modem in self.water.modems.items()}
        devices = {craft: line.device for craft, line in self.lines.items()}
        self.scenario = folder / "serial.toml"
        self.scenario.write_text(SCENARIO.format(duration_s=duration_s, pace=pace, **devices))
        self.out = folder / "run"

    def run(self):
        return launched("run", str(self.scenario), "--json", "--out", str(self.out))

    def recorded(self, craft: str, kind: type) -> list:
        events = [message.event for message in recorded_messages(self.out, "modem_rx", craft)]
        return [event for event in events if isinstance(event, kind)]


def test_a_team_on_serial_modems(tmp_path):
    """`grex run --pace live` flies two craft on real ports: they hear each other, and everybody ends well."""
    team = Team(tmp_path, 20.0)
    with running(team.water, team.lines, 1.0), team.run() as launcher:
        out, err = launcher.communicate(timeout=90)
    assert err == ""
    assert json.loads(out)["pace"] == "live"
    for craft, mate in (("auv1", "auv2"), ("auv2", "auv1")):
        heard = team.recorded(craft, Received)
        assert heard
        assert {event.source for event in heard} == {mate}
        sent = [event.status for event in team.recorded(craft, TxEvent)]
        assert sent
        assert set(sent) == {"SENT"}
    assert (team.out / "modem-auv1.log").read_text() == ""


def test_a_device_that_vanishes(tmp_path):
    """An unplugged modem is a status for the agent and one line in the log; the run goes on to its end."""
    team = Team(tmp_path, 15.0)
    with running(team.water, team.lines, 1.0) as unplug, team.run() as launcher:
        wait_for_recording(team.out, 5_000)
        unplug("auv1")
        out, err = launcher.communicate(timeout=90)
    assert (launcher.returncode, err) == (0, "")
    assert json.loads(out)["ticks"] == 15
    states = [(event.state, event.detail) for event in team.recorded("auv1", ModemStatus)]
    assert [state for state, _ in states] == ["ready", "error"]
    assert states[1][1].startswith("the port is gone")
    log = (team.out / "modem-auv1.log").read_text().splitlines()
    assert len(log) == 1
    assert "port is gone" in log[0]
    failed = [event.reason for event in team.recorded("auv1", TxEvent) if event.status == "FAILED"]
    assert set(failed) <= {"error", "off"}


def test_a_device_that_is_not_there(tmp_path):
    """A port that cannot be opened is one line with its path and exit status 2, before the mission starts."""
    team = Team(tmp_path, 30.0)
    team.lines["auv2"].unplug()
    del team.lines["auv2"]
    with running(team.water, team.lines, 1.0), team.run() as launcher:
        _, err = launcher.communicate(timeout=60)
    assert launcher.returncode == 2
    assert re.fullmatch(r"grex: \$\.craft\.auv2\.modem\.port: cannot open /dev/pts/\d+: .*\n", err)


def test_a_killed_driver_is_named(tmp_path, gone):
    """The driver of a modem belongs to the run: when it dies, the run ends and names it."""
    team = Team(tmp_path, 600.0)
    with running(team.water, team.lines, 1.0), team.run() as launcher:
        wait_for_recording(team.out, 5_000)
        children = psutil.Process(launcher.pid).children(recursive=True)
        (driver,) = [c for c in children if "grex_agent.modem" in c.cmdline() and "auv2" in c.cmdline()]
        driver.send_signal(signal.SIGKILL)
        killed_at = time.monotonic()
        _, err = launcher.communicate(timeout=20)
        assert time.monotonic() - killed_at < 10.0
    assert launcher.returncode == 1
    assert re.fullmatch(r"grex: modem auv2 was killed by SIGKILL \(status -9\) at mission time \d+\.0 s\n", err)
    assert gone(children)
