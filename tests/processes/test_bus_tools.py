"""grex topics, echo and hz on the bus of a real run; and a viewer that changes nothing."""

import json
import signal
import subprocess
import time

import pytest
import zenoh
from launching import SCENARIO, grex, running

from grex_sim.launch import free_port


@pytest.fixture(scope="module")
def endpoint(tmp_path_factory):
    """A live run that is under way."""
    where = f"tcp/127.0.0.1:{free_port()}"
    options = ("--pace", "live", "--set", "clock.tick_s=0.1", "--set", f'bus.endpoints=["{where}"]')
    with running("run", str(SCENARIO), *options, "--out", str(tmp_path_factory.mktemp("live"))):
        deadline = time.monotonic() + 30.0
        while (
            subprocess.run(
                grex("topics", "--connect", where, "--seconds", "0.5", "--json"), capture_output=True, check=False
            ).stdout.count(b"/setpoint")
            < 3
        ):
            assert time.monotonic() < deadline
        yield where


def test_topics_says_what_there_is(endpoint):
    """Every participant, and every key with its type, writer and rate."""
    out = subprocess.run(grex("topics", "--connect", endpoint, "--json"), capture_output=True, check=True).stdout
    listed = json.loads(out)
    assert listed["participants"] == {"grex": ["auv1", "auv2", "auv3", "link", "sim"]}
    rows = {row["key"]: row for row in listed["topics"]}
    setpoint = rows["grex/grex/auv1/setpoint"]
    assert (setpoint["type"], setpoint["writer"]) == ("Setpoint", "agent")
    assert setpoint["hz"] == pytest.approx(10.0, rel=0.3)
    text = subprocess.run(grex("topics", "--connect", endpoint), capture_output=True, check=True, text=True).stdout
    assert "grex/grex/auv1/setpoint" in text


def ended(process):
    """Ctrl-C, and what a command says afterwards."""
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=5)
    return process.returncode, out, err


def test_echo_prints_lines_of_json(endpoint):
    """Messages of a key expression, decoded, a line each; Ctrl-C ends it cleanly."""
    with running("echo", "grex/*/*/fix", "--connect", endpoint) as process:
        lines = [json.loads(process.stdout.readline()) for _ in range(9)]
        status, _, err = ended(process)
    assert (status, err) == (0, "")
    assert {line["key"] for line in lines} == {f"grex/grex/auv{number}/fix" for number in (1, 2, 3)}
    assert all(line["message"]["valid"] for line in lines)


def test_echo_counts_what_does_not_decode(endpoint):
    """What a stranger puts there is said once, counted, and the rest goes on."""
    config = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with (
        running("echo", "grex/grex/*/nav", "--connect", endpoint) as process,
        zenoh.open(zenoh.Config.from_json5(json.dumps(config))) as session,
    ):
        time.sleep(2.0)
        for _ in range(3):
            session.put("grex/grex/auv1/nav", b"\xc1 no message")
        time.sleep(0.5)
        status, out, err = ended(process)
    assert (status, out) == (0, "")
    assert "grex/grex/auv1/nav: a message of 12 bytes does not decode" in err
    assert err.endswith("grex: grex/grex/auv1/nav: 3 messages did not decode\n")


def test_hz_measures_rates(endpoint):
    """Mean, shortest, longest and deviation for each key; Ctrl-C ends it cleanly with the last table."""
    with running("hz", "grex/grex/*/setpoint", "--connect", endpoint) as process:
        time.sleep(3.0)
        status, out, err = ended(process)
    assert (status, err) == (0, "")
    rows = [row.split() for row in out.splitlines() if row.strip().startswith("grex/")][-3:]
    assert [row[0] for row in rows] == [f"grex/grex/auv{number}/setpoint" for number in (1, 2, 3)]
    for _, _, hz, least, most, _ in rows:
        assert float(hz) == pytest.approx(10.0, rel=0.3)
        assert float(least) <= 1.0 / float(hz) <= float(most)


@pytest.mark.parametrize("command", [("topics",), ("echo", "grex/**"), ("hz", "grex/**")])
def test_nobody_there(command):
    """Where nobody answers, one line says so within seconds, with exit status 1."""
    where = f"tcp/127.0.0.1:{free_port()}"
    result = subprocess.run(grex(*command, "--connect", where), capture_output=True, text=True, timeout=20, check=False)
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr == f"grex: nobody answers at {where}; is a run on the bus there?\n"


def test_a_bad_key_is_named(endpoint):
    """What is no key expression is named, with exit status 2."""
    command = grex("echo", "grex//fix", "--connect", endpoint)
    result = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert result.returncode == 2
    assert result.stderr.startswith("grex: KEY: 'grex//fix' is no key expression")
    assert result.stderr.count("\n") == 1
