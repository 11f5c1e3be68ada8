"""The adapter on the bus, with a line and a bus of the test's own: fixes at the ticks, set-points, farewell."""

import pytest
from mavlink_bench import DATUM, MavlinkBench, setpoint

from grex_agent.frontseat import node as node_module
from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.node import Frontseat, prepare
from grex_link.errors import FaultError, GrexError
from grex_link.messages import Clock, Fix, Presence
from grex_link.scenario import loads
from grex_link.units import NS

TEXT = """
datum = { latitude_deg = 54.37, longitude_deg = 10.16 }
clock = { pace = "live", tick_s = 0.5 }
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
[craft.auv1]
clock = { offset_s = 0.25 }
frontseat = { type = "mavlink", url = "udpin:127.0.0.1:14550", arm = true }
"""
EPOCH = 1_800_000_000 * NS


class World:
    """A wall clock, an autopilot on the line, and a bus, all of the test's own."""

    def __init__(self, monkeypatch) -> None:
        self.bench = MavlinkBench(arm=True)
        self.put_messages: list[tuple[str, str, object]] = []
        self.target = None
        self.hears: list = []
        self.unsigned, self.trouble = 0, ""
        for name in ("grex_agent.frontseat.node.clock.monotonic_s", "grex_link.clock.monotonic_s"):
            monkeypatch.setattr(name, lambda: self.bench.now)
        monkeypatch.setattr("grex_link.clock.time.time_ns", lambda: EPOCH + round((self.bench.now - 110.0) * NS))
        monkeypatch.setattr(node_module.clock, "sleep_s", self.pass_time)
        scenario = loads(TEXT)
        self.core = FrontseatCore(scenario.mavlink_craft["auv1"], DATUM)
        self.bench.core = self.core
        self.node = Frontseat(scenario, "auv1", self, self, self.core)

    # The line: the bench's autopilot hears and answers through the core itself.
    def receive(self) -> list:
        return []

    def send(self, message) -> None:
        self.bench.take([message])

    # The bus.
    def take(self, timeout_s: float) -> None:
        self.bench.now += timeout_s

    def put(self, topic: str, craft: str, message) -> None:
        self.put_messages.append((topic, craft, message))

    def pass_time(self, seconds: float) -> None:
        """Let time pass, with everything that the autopilot says and the node does."""
        self.bench.run(seconds)
        if not self.node.done:
            self.node.on_deadline()

    def go(self, seconds: float, step: float = 0.05) -> "World":
        for _ in range(round(seconds / step)):
            self.pass_time(step)
        return self

    @property
    def fixes(self) -> list[Fix]:
        return [message for topic, craft, message in self.put_messages if (topic, craft) == ("fix", "auv1")]


@pytest.fixture
def world(monkeypatch) -> World:
    return World(monkeypatch)


def test_fixes_of_the_ticks(world):
    """From the start there is one fix a tick, numbered and stamped with the tick's time by the craft's clock."""
    world.go(9.7)
    assert world.fixes == []
    world.node.handle("clock", "", Clock("start", EPOCH))
    assert [fix.tick for fix in world.fixes] == [0]
    world.bench.agent = setpoint()
    world.go(3.4)
    assert [fix.tick for fix in world.fixes] == [0, 1, 2, 3, 4, 5, 6]
    assert [fix.t_ns for fix in world.fixes] == [k * NS // 2 + NS // 4 for k in range(7)]
    assert all(fix.valid for fix in world.fixes)


def test_ticks_that_were_missed(world):
    """After a stall only the tick of now is told: what is over is over."""
    world.go(9.9)
    world.node.handle("clock", "", Clock("start", EPOCH))
    world.bench.agent = setpoint()
    world.bench.run(3.0)
    world.node.on_deadline()
    assert [fix.tick for fix in world.fixes] == [0, 5]


def test_a_position_that_is_not_valid(world):
    """A fix that is not valid says why."""
    world.bench.flags = 0xA7
    world.go(9.9)
    world.node.handle("clock", "", Clock("start", EPOCH))
    assert (world.fixes[0].valid, world.fixes[0].reason) == (False, "its estimator has no position (flags 0x0a7)")
    assert "no valid position" in world.node.waits_for


def test_the_end(world):
    """On bye the craft is handed back before the node is done; no fix comes after it."""
    world.go(9.9)
    world.node.handle("clock", "", Clock("start", EPOCH))
    world.node.handle("setpoint", "auv1", setpoint())
    world.go(1.0)
    assert world.bench.mode == 15
    told = len(world.fixes)
    world.node.handle("clock", "", Clock("bye"))
    assert world.node.done
    assert world.bench.mode == 4
    assert len(world.fixes) == told


def test_the_end_before_its_time(world):
    """When the bench breaks off the craft is handed back first, and then the reason is passed on."""
    world.go(9.9)
    with pytest.raises(GrexError, match=r"^sim ended the run: agent auv9 died$"):
        world.node.handle("clock", "", Clock("bye", reason="agent auv9 died"))
    assert world.bench.mode == 4


def test_a_bench_that_vanishes(world):
    """A simulator that vanishes is a fault with the mission time; the process then hands the craft back."""
    world.go(12.0)
    world.node.handle("clock", "", Clock("start", EPOCH))
    with pytest.raises(FaultError, match=r"^sim left the bus without saying goodbye at mission time 2\.0 s$"):
        world.node.handle("presence", "sim", Presence("sim", alive=False, scenario="x"))
    world.node.hand_back()
    assert world.bench.mode == 4


def test_an_autopilot_that_does_not_hold(world, monkeypatch):
    """An autopilot that does not say that it holds is not waited for longer than two seconds, and that is said."""
    world.go(9.9)
    world.bench.deaf = True
    said: list[str] = []
    monkeypatch.setattr("grex_agent.frontseat.node.log.warn", said.append)
    since = world.bench.now
    world.node.hand_back()
    assert 2.0 < world.bench.now - since < 3.0
    assert said[-1].endswith("it was last in GUIDED, armed: look after it")


NOBODY = "no heartbeat of an autopilot on udpin:127.0.0.1:14550; look whether it is on and sends to this address"


@pytest.mark.parametrize("trouble", ["", "connection refused: nothing listens there"])
def test_nobody_answers(world, monkeypatch, trouble: str):
    """While nobody answers the log says where, at once and every 10 s; the end names the address and what to do."""
    said: list[tuple[float, str]] = []
    since = world.bench.now
    monkeypatch.setattr(node_module.log, "info", lambda words: said.append((world.bench.now - since, words)))
    world.trouble = trouble
    with pytest.raises(GrexError) as caught:
        prepare(world, world.node, 25.0)
    reason = f"no autopilot on udpin:127.0.0.1:14550: {trouble}" if trouble else NOBODY
    assert str(caught.value) == f"the autopilot is not ready after 25 s: {reason}; or raise start_timeout_s"
    assert [at_s for at_s, _ in said] == pytest.approx([0.0, 10.0, 20.0], abs=0.1)
    where = "waiting for an autopilot on udpin:127.0.0.1:14550"
    assert {words for _, words in said} == {f"{where}: {trouble}" if trouble else where}


def test_whoever_answers_is_not_called(world, monkeypatch):
    """Once an autopilot has been heard, the log says nothing of waiting for one."""
    world.bench.flags = 0xA7
    world.go(1.0)
    said: list[str] = []
    monkeypatch.setattr(node_module.log, "info", said.append)
    with pytest.raises(GrexError, match="the autopilot is silent"):
        prepare(world, world.node, 25.0)
    assert not [words for words in said if words.startswith("waiting")]


def test_a_wrong_datum(world):
    """Far from the datum no mission starts; the line says what to set, and not to wait for longer."""
    world.bench.lat = -35.36
    world.take = world.pass_time
    with pytest.raises(
        GrexError,
        match=r"^the autopilot is not ready after 9 s: no valid position: .* \[datum\] to where the mission is$",
    ):
        prepare(world, world.node, 9.0)
    assert not world.bench.armed
