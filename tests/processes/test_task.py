"""`grex task` on a live bus with real processes: one run of the habitat scenario at a fast pace, and many orders.

standby2's modem is off, so that it never echoes.
"""

import json
import re
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from launching import grex, running
from recordings import recorded_messages

from grex_link.task_wire import ORDER_BYTES
from grex_sim.launch import free_port

SCENARIO = str(Path(__file__).parents[2] / "deploy" / "scenarios" / "habitat.toml")


def endpoint() -> str:
    return f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]'


def under_way(process: subprocess.Popen, folder: Path) -> None:
    """Wait until the mission has started: positions are recorded."""
    deadline = time.monotonic() + 60.0
    while not (folder / "run.mcap").exists() or (folder / "run.mcap").stat().st_size < 20_000:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline, "the run did not get under way"
        time.sleep(0.05)


def order(where: str, *arguments: str) -> tuple[int, str, str]:
    """Give an order; returns (exit status, standard output, standard error)."""
    done = subprocess.run(
        grex("task", SCENARIO, "--set", where, *arguments), capture_output=True, text=True, timeout=100, check=False
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def live(tmp_path_factory) -> Iterator[tuple[str, Path]]:
    """A run at 40 times the wall clock: its endpoint, and its folder."""
    where, out = endpoint(), tmp_path_factory.mktemp("live")
    overrides = [
        where, "events=[]", "duration_s=8000", "tasking.tries=2", "mission.legs=30",
        "link.outages=[{craft='standby2',start_s=0.1,end_s=1e6}]",
    ]  # fmt: skip
    options = [part for value in overrides for part in ("--set", value)]
    with running("run", SCENARIO, "--pace", "40", "--out", str(out), *options) as process:
        under_way(process, out)
        yield where, out


def test_a_task_from_order_to_end(live):
    """The operator reads, with the mission times, how an order is queued, on air, echoed, started and done."""
    where, out = live
    status, said, err = order(where, "--craft", "standby1", "inspect", "--at", "10,60", "--for", "20")
    assert (status, err) == (0, "")
    lines = re.findall(r"^ *([\d.]+) s  (.*)$", said, re.MULTILINE)
    assert [words for _, words in lines] == [
        "queued on ship", "on air", "echoed by standby1", "started by standby1", "done by standby1",
    ]  # fmt: skip
    times = [float(t_s) for t_s, _ in lines]
    assert times == sorted(times)
    # 38 m there and 20 s of survey, but not twice as long.
    assert 20.0 < times[-1] - times[2] < 200.0
    deadline = time.monotonic() + 20.0
    statuses: list[str] = []
    while "done" not in statuses and time.monotonic() < deadline:
        time.sleep(0.3)
        statuses = [news.status for news in recorded_messages(out, "task_news", "standby1")]
    assert statuses[:2] == ["started", "done"]


def test_a_refused_task(live):
    """What the craft cannot do it refuses over the water, with a reason; one line, status 1."""
    status, said, err = order(live[0], "--craft", "standby1", "inspect", "--at", "10,60,5", "--radius", "1")
    assert (status, err) == (1, "grex: inspect of standby1 refused: radius\n")
    assert "echoed by standby1" in said


def test_a_craft_that_does_not_echo(live):
    """A craft that does not hear: after the tries that are set the sender gives up; one line, status 1."""
    status, said, err = order(live[0], "--craft", "standby2", "surface")
    assert (status, err) == (1, "grex: surface of standby2 failed: no echo in 2 tries\n")
    assert "on air" in said
    assert "echoed" not in said


def test_by_radio(live):
    """A craft with radio is reached by it and never by sound; one that is tied by cable does not leave."""
    where, out = live
    status, said, err = order(where, "--craft", "surface", "goto", "--at", "10,60,0")
    assert (status, err) == (1, "grex: goto of surface refused: cable\n")
    times = [float(t_s) for t_s in re.findall(r"^ *([\d.]+) s", said, re.MULTILINE)]
    ways: set[str] = set()
    deadline = time.monotonic() + 20.0
    while not ways and time.monotonic() < deadline:
        time.sleep(0.3)
        ways = {
            event.purpose
            for event in recorded_messages(out, "link_event")
            if (event.kind, event.source, event.size_bytes) == ("started", "ship", ORDER_BYTES)
            and times[0] <= event.t_ns / 1e9 <= times[-1]
        }
    assert ways == {"land"}


def test_the_operators_own_craft(live):
    """An order to the craft the operator is on needs no message; a task without end is seen through to its start."""
    status, said, err = order(live[0], "--craft", "ship", "hold")
    assert (status, err) == (0, "")
    assert [line.split("  ")[-1] for line in said.splitlines()] == ["queued on ship", "started by ship"]


def test_waiting_has_an_end(live):
    """An operator who does not want to wait is told what the last word was; status 1."""
    status, _, err = order(live[0], "--craft", "standby1", "hold", "--for", "4000", "--wait", "8")
    assert status == 1
    assert err == "grex: not done in 8 s; hold of standby1: the last word was 'started'\n"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ("--craft", "auv9", "hold"),
            "grex: --craft: unknown craft 'auv9'; there are surface, diver, standby1, standby2, ship\n",
        ),
        (
            ("--craft", "standby1", "inspect"),
            "grex: --at: is missing: inspect needs a place, north,east or north,east,depth\n",
        ),
        (
            ("--craft", "standby1", "inspect", "--at", "here"),
            "grex: --at: 'here' is not north,east or north,east,depth in metres\n",
        ),
        (
            ("--craft", "standby1", "inspect", "--at", "nan,0,0"),
            "grex: --at: 'nan,0,0' is not north,east or north,east,depth in metres\n",
        ),
        (("--craft", "standby1", "return", "--radius", "5"), "grex: --radius: return has no such thing\n"),
        (("--craft", "standby1", "goto", "--at", "9999,0,5"), "grex: goto: north 9999 does not fit into an order: "),
    ],
    ids=["craft", "missing", "at", "nan", "option", "far"],
)
def test_a_wrong_command_line(arguments, line):
    """What is wrong in the command is one line and status 2, before the bus is looked for."""
    status, said, err = order(endpoint(), *arguments)
    assert (status, said) == (2, "")
    assert err.startswith(line)
    assert err.count("\n") == 1


def test_nobody_on_the_bus():
    """Without a run there is one line that says where nobody is; status 1, in seconds."""
    where = endpoint()
    status, said, err = order(where, "--craft", "standby1", "hold")
    assert (status, said) == (1, "")
    assert re.fullmatch(r"grex: nobody is on the bus at tcp/127\.0\.0\.1:\d+; start the run first, with the same "
                        r"bus\.endpoints\n", err)  # fmt: skip


def test_a_run_in_lockstep_takes_no_orders(tmp_path):
    """In lockstep an order would come at no certain step: it is refused, with what to do instead."""
    where = endpoint()
    with running("run", SCENARIO, "--out", str(tmp_path), "--set", where, "--set", "duration_s=1e6") as process:
        under_way(process, tmp_path)
        status, _, err = order(where, "--craft", "standby1", "hold")
    assert status == 1
    assert err.startswith("grex: hold of standby1 refused: this run is in lockstep;")


def test_lockstep_between_processes_is_lockstep_in_one(tmp_path):
    """The event, the order, its echo and the inspection come out the same, bit by bit, in one process and in seven."""
    arguments = ("--set", endpoint(), "--set", "duration_s=660", "--set", "link.loss=0.2", "--json")
    digests, tasks = [], []
    for how in ((), ("--in-process",)):
        done = subprocess.run(
            grex("run", SCENARIO, *arguments, *how, "--out", str(tmp_path / "out")),
            capture_output=True, text=True, timeout=100, check=True,
        )  # fmt: skip
        summary = json.loads(done.stdout)
        digests.append(summary["digest"])
        tasks.append({(line["said_by"], line["status"], line["t_s"]) for line in summary["tasks"]})
    assert digests[0] == digests[1]
    assert tasks[0] == tasks[1]
    assert {"on_air", "started"} <= {status for _, status, _ in tasks[0]}


def test_a_run_that_ends_meanwhile(tmp_path):
    """When the run goes away the operator is told so at once, and what the last word was."""
    where = endpoint()
    options = ("--set", where, "--set", "duration_s=1e5", "--set", "events=[]")
    with running("run", SCENARIO, "--pace", "20", "--out", str(tmp_path), *options) as process:
        under_way(process, tmp_path)
        waiting = subprocess.Popen(
            grex("task", SCENARIO, "--set", where, "--craft", "ship", "hold", "--for", "4000"),
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert waiting.stdout is not None
        assert "queued" in waiting.stdout.readline()
        for child in psutil.Process(process.pid).children():
            child.kill()
        _, err = waiting.communicate(timeout=30)
    assert waiting.returncode == 1
    assert err == "grex: the run is over; hold of ship: the last word was 'started'\n"
