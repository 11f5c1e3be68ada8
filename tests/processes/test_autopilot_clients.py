"""The simulated autopilot in a process of its own, and the clients users have: pymavlink, MAVSDK, MAVProxy."""

import math
import os
import signal
import socket
import subprocess
import sys
import tty
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from launching import grex
from mavlink_client import PATIENCE_S, Client, address, autopilot
from pymavlink.dialects.v20 import ardupilotmega as dialect

#: Minutes of wall time: `pytest -m slow tests/processes`.
pytestmark = pytest.mark.slow

ATTITUDE, LOCAL, GLOBAL = 30, 32, 33
HOLD, GUIDED = 4, 15
QUICK = ("--ready", "2", "--speedup", "5", "--wind", "0,0")


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def arm_in_guided(client: Client, mode: int = GUIDED) -> None:
    client.wait("LOCAL_POSITION_NED")
    assert client.command(176, 1, mode) == 0
    client.shows(mode)
    assert client.command(400, 1) == 0
    client.shows(mode, armed=True)


@contextmanager
def station(*arguments: str):
    """A ground station that has heard an autopilot."""
    with Client("udpin:127.0.0.1:0") as client, autopilot("--url", f"udpout:127.0.0.1:{client.port}", *arguments):
        client.wait("HEARTBEAT")
        yield client


@pytest.fixture(scope="module")
def boat():
    """One Rover on UDP for all tests that leave it able to go on."""
    with station(*QUICK) as client:
        client.interval(LOCAL, 10.0)
        yield client


@pytest.mark.parametrize("url", ["udpin:127.0.0.1:0", "tcpin:127.0.0.1:0", "pty:"])
def test_every_kind_of_link(url):
    """Over UDP, TCP and a serial pty: heartbeat, an interval as asked for, a position, a mode."""
    with autopilot("--url", url, *QUICK) as process:
        where = address(process)
        with Client(where.replace("udpin", "udpout").replace("tcpin", "tcp")) as client:
            beat = client.wait("HEARTBEAT", repeat=lambda: client.link.mav.heartbeat_send(18, 8, 0, 0, 0))
            assert (beat.type, beat.autopilot) == (11, 3)
            assert client.interval(ATTITUDE, 20.0) == 0
            got = client.seconds("ATTITUDE", 4.0)
            assert len(got) / 4.0 == pytest.approx(20.0, rel=0.25)
            place = client.wait("GLOBAL_POSITION_INT", lambda m: m.lat != 0)
            assert place.lat == pytest.approx(543_700_000, abs=2000)
            assert client.command(176, 1, HOLD) == 0
            client.shows(HOLD)


def test_a_serial_port_that_somebody_else_made():
    """`serial:/dev/pts/N:57600` takes its place at the end of a line that is there already."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    parser = dialect.MAVLink(None)
    parser.robust_parsing = True
    names = set()
    try:
        with autopilot("--url", f"serial:{os.ttyname(theirs)}:57600", *QUICK):
            while not {"HEARTBEAT", "ATTITUDE"} <= names:
                names |= {message.get_type() for message in parser.parse_buffer(os.read(ours, 4096)) or []}
    finally:
        os.close(ours)
        os.close(theirs)
    assert "GLOBAL_POSITION_INT" in names


def test_arming_is_denied_and_then_accepted():
    """In GUIDED arming fails, with reasons as texts, until the position is there; then the heartbeat says armed."""
    with station("--ready", "12", "--speedup", "4") as client:
        client.shows(0)
        assert client.command(176, 1, GUIDED) == 0
        assert client.command(400, 1) == 4
        assert any(text.startswith("Arm:") for text in client.texts)
        client.wait("EKF_STATUS_REPORT", lambda m: m.flags == 0x33F)
        assert client.command(400, 1) == 0
        client.shows(GUIDED, armed=True)


def test_a_guided_drive(boat):
    """It holds the speed and the heading that are asked for, stops with a text when set-points stop, stays GUIDED."""
    arm_in_guided(boat)

    def east():
        boat.velocity(0.0, 2.0)

    boat.seconds("LOCAL_POSITION_NED", 9.0, repeat=east)
    run = boat.seconds("LOCAL_POSITION_NED", 5.0, repeat=east)
    assert all(math.hypot(m.vx, m.vy - 2.0) < 0.2 for m in run)
    way = math.dist((run[0].x, run[0].y), (run[-1].x, run[-1].y))
    assert way / (run[-1].time_boot_ms - run[0].time_boot_ms) * 1000.0 == pytest.approx(2.0, abs=0.1)
    assert boat.wait("GLOBAL_POSITION_INT", repeat=east).hdg == pytest.approx(9000, abs=200)
    boat.wait("STATUSTEXT", lambda m: "stopping" in m.text)
    boat.wait("LOCAL_POSITION_NED", lambda m: math.hypot(m.vx, m.vy) < 0.1)
    boat.shows(GUIDED, armed=True)
    assert boat.command(400, 0) == 0
    boat.shows(GUIDED, armed=False)


def test_duplicates_and_garbage(boat):
    """A command sent twice has two ACKs, and bytes that are none stop nobody."""
    boat.link.mav.command_long_send(1, 1, 176, 0, 1, HOLD, 0, 0, 0, 0, 0)
    boat.link.mav.command_long_send(1, 1, 176, 0, 1, HOLD, 0, 0, 0, 0, 0)
    assert [boat.wait("COMMAND_ACK").command for _ in range(2)] == [176, 176]
    for size in (1, 7, 300, 1400):
        boat.link.write(os.urandom(size))
    boat.link.write(b"\xfd" * 280)
    assert boat.command(176, 1, 0) == 0
    boat.shows(0)


def test_it_says_what_it_cannot_do(boat):
    """An unknown parameter gets silence, an unknown command UNSUPPORTED, a rate that is too high DENIED."""
    boat.link.mav.param_request_read_send(1, 1, b"NONSENSE", -1)
    boat.link.mav.param_request_read_send(1, 1, b"WP_SPEED", -1)
    assert boat.wait("PARAM_VALUE").param_id == "WP_SPEED"
    assert boat.command(213, 1) == 3
    assert boat.interval(ATTITUDE, 50.0) == 2


def test_a_reboot_resets_intervals(boat):
    """After a reboot its time begins anew, on the same link, and what was asked for does not come any more."""
    boat.wait("LOCAL_POSITION_NED")
    assert boat.command(246, 1) == 0
    boat.wait("GLOBAL_POSITION_INT", lambda m: m.time_boot_ms < 3000)
    boat.wait("EKF_STATUS_REPORT", lambda m: m.flags == 0x33F)
    kinds = [boat.link.recv_match(blocking=True, timeout=PATIENCE_S).get_type() for _ in range(100)]
    assert "LOCAL_POSITION_NED" not in kinds
    boat.interval(LOCAL, 10.0)


def test_two_ground_stations():
    """Two stations see the same craft; each has its own intervals, and what one orders the other sees."""
    with Client("udpin:127.0.0.1:0") as one, Client("udpin:127.0.0.1:0", system=254) as two:
        urls = [part for c in (one, two) for part in ("--url", f"udpout:127.0.0.1:{c.port}")]
        with autopilot(*urls, *QUICK):
            one.wait("HEARTBEAT")
            two.wait("HEARTBEAT")
            assert two.interval(LOCAL, 20.0) == 0
            two.wait("LOCAL_POSITION_NED")
            assert one.command(176, 1, HOLD) == 0
            two.shows(HOLD)
            kinds = [one.link.recv_match(blocking=True, timeout=PATIENCE_S).get_type() for _ in range(100)]
    assert "LOCAL_POSITION_NED" not in kinds


def test_silence_and_a_pilot_to_order(boat):
    """A parameter silences it for 10 s of its own time; another is a pilot who takes over."""
    boat.link.mav.param_set_send(1, 1, b"GREX_SILENCE", 10.0, 9)
    before = boat.wait("GLOBAL_POSITION_INT").time_boot_ms
    boat.wait("GLOBAL_POSITION_INT", lambda m: m.time_boot_ms > before + 8000)
    boat.link.mav.param_set_send(1, 1, b"GREX_PILOT", float(HOLD), 9)
    boat.shows(HOLD)


def test_a_sub_dives():
    """A Sub in GUIDED goes down at the rate asked for and keeps its depth when told to stop."""
    with station("--family", "sub", *QUICK) as client:
        client.interval(LOCAL, 10.0)
        arm_in_guided(client, 4)
        client.wait("LOCAL_POSITION_NED", lambda m: m.z > 2.0, repeat=lambda: client.velocity(0.4, 0.0, 0.5))
        run = client.seconds("LOCAL_POSITION_NED", 4.0, repeat=lambda: client.velocity(0.4, 0.0))
    assert run[-1].vz == pytest.approx(0.0, abs=0.05)
    assert run[-1].vx == pytest.approx(0.32, abs=0.05)


def test_px4_leaves_and_returns():
    """A PX4 without set-points leaves OFFBOARD, and comes back by itself with them."""
    with station("--family", "px4", "--ready", "1", "--speedup", "2") as client:

        def north():
            client.velocity(1.0, 0.0)

        client.wait("LOCAL_POSITION_NED", repeat=north)
        assert client.command(176, 1, 6) == 0
        north()
        assert client.command(400, 1) == 0
        client.shows(0x060000, armed=True, repeat=north)
        client.shows(0x030000, armed=True)
        client.shows(0x060000, armed=True, repeat=north)


def test_three_boats_at_once():
    """Three boats with ids of their own, on one port of a ground station, each go where they are told."""
    courses = {1: (1.0, 0.0), 2: (0.0, 1.0), 3: (-1.0, 0.0)}
    with Client("udpin:127.0.0.1:0") as client, ExitStack() as stack:
        for system in courses:
            url = f"udpout:127.0.0.1:{client.port}"
            stack.enter_context(autopilot("--url", url, "--sysid", str(system), *QUICK))
        for system in courses:
            client.wait("EKF_STATUS_REPORT", lambda m, s=system: m.get_srcSystem() == s and m.flags == 0x33F)
            assert client.command(176, 1, GUIDED, target=system) == 0
            assert client.command(400, 1, target=system) == 0

        def drive():
            for system, (north, east) in courses.items():
                client.velocity(north, east, target=system)

        for system, (north, east) in courses.items():
            client.wait(
                "GLOBAL_POSITION_INT",
                lambda m, s=system, n=north, e=east: (
                    m.get_srcSystem() == s and math.dist((m.vx, m.vy), (n * 100.0, e * 100.0)) < 20.0
                ),
                repeat=drive,
            )


def test_a_killed_and_restarted_one_comes_from_a_new_port():
    """Killed and started again, it is another sender for the ground station, and obeys as before."""
    with Client("udpin:127.0.0.1:0") as client:
        url = f"udpout:127.0.0.1:{client.port}"
        with autopilot("--url", url, *QUICK) as process:
            client.wait("HEARTBEAT")
            process.kill()
        with autopilot("--url", url, *QUICK):
            client.wait("GLOBAL_POSITION_INT", lambda m: m.time_boot_ms < 2000)
            assert len(client.link.clients) == 2
            assert client.command(176, 1, HOLD) == 0


def test_who_is_not_there_is_waited_for():
    """With nobody at the other end it runs on, and Ctrl-C ends it with status 130."""
    with autopilot(
        "--url", f"udpout:127.0.0.1:{free_port()}", "--url", f"tcp:127.0.0.1:{free_port()}", *QUICK
    ) as process:
        while "is using GPS" not in process.stdout.readline():
            pass
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE_S) == 130


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--url", "nowhere"), "--url: 'nowhere' is no link; write udpout:HOST:PORT"),
        (("--fault", "storm@3"), "--fault: 'storm@3' is none; write KIND@AT"),
        (("--param", "NONSENSE=1"), "--param: rover has no parameter NONSENSE"),
        (("--start", "54"), "--start: write LAT,LON[,HEADING]"),
    ],
)
def test_a_command_line_that_cannot_work(arguments, says):
    """It ends with status 2 and one line that says what to write."""
    done = subprocess.run(
        grex("autopilot", *arguments), capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 2
    assert says in done.stderr
    assert done.stderr.count("\n") == 1


MAVSDK = """
import sys, time
from mavsdk.mavsdk import Configuration, Mavsdk
from mavsdk.component_type import ComponentType
from mavsdk.plugins.action.action import Action
from mavsdk.plugins.telemetry.telemetry import Telemetry

sdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
sdk.add_any_connection(sys.argv[1])
system = sdk.first_autopilot(30.0)
telemetry, action = Telemetry(system), Action(system)
deadline = time.monotonic() + 30.0
while not telemetry.health().is_global_position_ok and time.monotonic() < deadline:
    time.sleep(0.05)
while abs(telemetry.position().latitude_deg - 54.37) > 0.001 and time.monotonic() < deadline:
    time.sleep(0.05)
held = action.hold()
armed = action.arm()
while not telemetry.armed() and time.monotonic() < deadline:
    time.sleep(0.05)
print("RESULT", system.get_system_id(), round(telemetry.position().latitude_deg, 3), int(held), int(armed),
      telemetry.armed(), flush=True)
sdk.destroy()
"""


@pytest.mark.parametrize("family", ["rover", "px4"])
def test_mavsdk(family):
    """The real MAVSDK connects, reads the position, holds and arms; our log shows the mode it asked for."""
    port = free_port()
    with autopilot("--family", family, "--url", f"udpout:127.0.0.1:{port}", "--ready", "1") as process:
        command = [sys.executable, "-c", MAVSDK, f"udpin://127.0.0.1:{port}"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
        process.terminate()
        log = process.stdout.read()
    result = next((line for line in done.stdout.splitlines() if "RESULT" in line), done.stdout + done.stderr)
    assert result.split("RESULT")[1].split() == ["1", "54.37", "1", "1", "True"]
    if family == "rover":
        assert "MANUAL -> HOLD by 245/190" in log


SAID_AND_DONE = (("Mode MANUAL", "mode HOLD"), ("Mode HOLD", "status GLOBAL_POSITION_INT"), ("lat :", ""))


def test_mavproxy(tmp_path):
    """The real MAVProxy connects, changes the mode, and shows the position."""
    port = free_port()
    program = Path(sys.executable).parent / "mavproxy.py"
    command = [
        str(program),
        f"--master=udpin:127.0.0.1:{port}",
        "--default-modules=mode",
        f"--state-basedir={tmp_path}",
    ]
    with autopilot("--url", f"udpout:127.0.0.1:{port}", "--ready", "1") as process:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        with subprocess.Popen(command, **pipes, text=True, cwd=tmp_path) as proxy:
            said = ""
            try:
                for until, then in SAID_AND_DONE:
                    while until not in said:
                        line = proxy.stdout.readline()
                        assert line, said
                        said += line
                    proxy.stdin.write(then + "\n")
                    proxy.stdin.flush()
            finally:
                proxy.kill()
        process.terminate()
        assert "MANUAL -> HOLD by 255/230" in process.stdout.read()
    assert "Got COMMAND_ACK: DO_SET_MODE: ACCEPTED" in said
