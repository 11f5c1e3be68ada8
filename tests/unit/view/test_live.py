"""A run as it is heard: here a simulator's end of the bus and a listener in one process, on a free port."""

import time

import msgspec
import pytest
from missions import SCENARIOS

from grex_link.bus import Listener, ZenohBus
from grex_link.errors import BusError, ConfigError
from grex_link.messages import (
    Advance,
    AgentState,
    AgentStates,
    Clock,
    Fix,
    LinkEvent,
    LinkReport,
    Pose,
    RunStatus,
    Step,
    Truth,
)
from grex_link.scenario import load
from grex_sim.launch import free_port
from grex_sim.view.live import Live

TEAM = ["auv1", "auv2", "auv3"]


@pytest.fixture
def scenario():
    return load(SCENARIOS / "paper-d.toml", [f'bus.endpoints=["tcp/127.0.0.1:{free_port()}"]', "clock.pace=live"])


def truth(tick):
    return Truth(tick, tick * 10**9, [Pose(name, float(tick), 25.0, 0.0, 0.0, 0.0, 0.0, 1.0) for name in TEAM])


def until(live, met):
    """Listen until something is so, by the clock of the test; the frame in which it is."""
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        live.listen(time.monotonic())
        frame = live.frame(time.monotonic())
        if met(frame):
            return frame
        time.sleep(0.02)
    pytest.fail(f"it never came about; the last frame is {frame}")


def begin(bus, live, scenario):
    """Let the run begin, and the listener hear of it."""
    live.connect()
    status = RunStatus(0, msgspec.json.encode(scenario).decode(), [*TEAM, "link"], 3, 4)

    def known(frame):
        bus.put("status", "", status)
        return frame["run"] > 0

    until(live, known)
    assert not live.bad_payloads


def state_of(frame, who):
    return next(row["state"] for row in frame["health"] if row["who"] == who)


def test_a_live_run_is_heard(scenario) -> None:
    """Truth, own fixes, states and messages of the water come into the frame; counters of the simulator, too."""
    live = Live(scenario.bus.endpoints)
    with ZenohBus(scenario, "sim", "sim") as bus:
        begin(bus, live, scenario)
        mates = AgentState(7, 7 * 10**9, 0, 0.1, 0.5, 1.0, 1.0, 0.0, [], [], 0)

        def all_heard(frame):
            bus.put("truth", "", truth(7))
            bus.put("fix", "auv1", Fix(7, 7 * 10**9, 7.5, 25.0, 0.0, 0.0, 1.0, 0.1))
            bus.put("state", "auv2", AgentStates([mates]))
            bus.put("report", "", LinkReport(-1, [], [LinkEvent(6 * 10**9, "started", "auv3", 0, lasting_ns=10**10)]))
            craft = frame["craft"]
            return "own" in craft["auv1"] and "xte" in craft["auv2"] and frame["sounds"] and frame["t"] == 7.0

        frame = until(live, all_heard)
        assert frame["phase"] == "running"
        assert frame["craft"]["auv1"]["own"][0] == 7.5
        assert frame["sounds"][0]["source"] == "auv3"
        assert state_of(frame, "sim") == "alive"
        assert state_of(frame, "auv1") == "missing"
        sim = next(row for row in frame["health"] if row["who"] == "sim")
        assert sim["notes"] == {"late ticks": 3, "late setpoints": 4}
        live.close()


def test_in_lockstep_the_bundles_are_enough(scenario) -> None:
    """In lockstep the true poses come with what the hub hands to the link, and nobody listens to fixes."""
    lockstep = load(SCENARIOS / "paper-d.toml", [f'bus.endpoints=["{scenario.bus.endpoints[0]}"]'])
    live = Live(lockstep.bus.endpoints)
    with ZenohBus(lockstep, "sim", "sim") as bus:
        begin(bus, live, lockstep)

        def heard(frame):
            bus.put("fix", "auv1", Fix(9, 9 * 10**9, 9.5, 25.0, 0.0, 0.0, 1.0, 0.1))
            bus.put("advance", "", Advance([Step(truth(8), [0, 0, 0]), Step(truth(9), [0, 0, 0])]))
            return frame["t"] == 9.0

        frame = until(live, heard)
        assert "own" not in frame["craft"]["auv1"]
        live.close()


def test_a_run_that_breaks_off_names_who_it_was(scenario) -> None:
    """The goodbye of the simulator says who is at fault: that one is lost, and the reason is shown."""
    live = Live(scenario.bus.endpoints)
    with ZenohBus(scenario, "sim", "sim") as bus:
        with ZenohBus(scenario, "agent", "auv2"):
            begin(bus, live, scenario)
            until(live, lambda frame: state_of(frame, "auv2") == "alive")
            reason = "agent auv2 left the bus (killed, stopped or cut off) at mission time 9.0 s"
            bus.put("clock", "auv1", Clock("bye", reason=reason, t_ns=9 * 10**9))
            frame = until(live, lambda frame: frame["phase"] == "over")
        assert frame["reason"] == reason
        assert state_of(until(live, lambda _: True), "auv2") == "lost"
        live.close()


def test_another_run_begins_afresh(scenario) -> None:
    """When the simulator is gone it says so; when another one comes to the same place, it is another run."""
    live = Live(scenario.bus.endpoints)
    with ZenohBus(scenario, "sim", "sim") as bus:
        begin(bus, live, scenario)
    frame = until(live, lambda frame: frame["phase"] == "lost")
    assert state_of(frame, "sim") == "lost"
    with ZenohBus(scenario, "sim", "sim") as bus:
        status = RunStatus(0, msgspec.json.encode(scenario).decode(), [*TEAM, "link"], 0, 0)

        def known(frame):
            bus.put("status", "", status)
            return frame["run"] == 2

        frame = until(live, known)
        assert frame["phase"] == "running"
        live.close()


def test_what_does_not_decode_is_counted(scenario) -> None:
    """Rubbish on a key, and a scenario of another version, are counted and said; nothing ends."""
    live = Live(scenario.bus.endpoints)
    with ZenohBus(scenario, "sim", "sim") as bus:
        live.connect()

        def other_version(frame):
            bus.put("status", "", RunStatus(0, '{"mission":{"type":"spiral"}}', [], 0, 0))
            return "another version of GREX" in frame["reason"]

        until(live, other_version)
        begin_again = RunStatus(0, msgspec.json.encode(scenario).decode(), [*TEAM, "link"], 0, 0)

        def rubbish(frame):
            bus.put("status", "", begin_again)
            bus.put("state", "auv1", Clock("bye"))
            return frame["bad"] > 0

        until(live, rubbish)
        live.close()


def test_nobody_there() -> None:
    """Where nobody answers, one line says where it was looked; a key that is none is named."""
    where = f"tcp/127.0.0.1:{free_port()}"
    with pytest.raises(BusError, match=f"nobody answers at {where}"):
        Live((where,)).connect()
    assert not Live((where,)).listen(0.0)


def test_a_key_expression_that_is_none(scenario) -> None:
    """What is no key expression is named, with what is wrong with it."""
    with (
        ZenohBus(scenario, "sim", "sim"),
        Listener(scenario.bus.endpoints) as listener,
        pytest.raises(ConfigError, match="is no key expression"),
    ):
        listener.hear("grex//fix")


def test_a_slow_listener_has_bounded_room(scenario, monkeypatch) -> None:
    """What comes faster than it is taken is dropped and counted; nothing piles up without end."""
    monkeypatch.setattr("grex_link.bus._HEARD_MAX", 10)
    with ZenohBus(scenario, "sim", "sim") as bus, Listener(scenario.bus.endpoints) as listener:
        listener.hear("grex/grex/truth")
        deadline = time.monotonic() + 20.0
        sent = taken = 0
        while not listener.dropped:
            assert time.monotonic() < deadline
            bus.put("truth", "", truth(1))
            sent += 1
        while listener.take(0.2) is not None:
            taken += 1
        assert 10 <= taken <= sent - listener.dropped
