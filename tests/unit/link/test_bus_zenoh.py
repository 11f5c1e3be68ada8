"""The bus between processes: here its two ends in one process, on a free port of this machine."""

import socket
from collections.abc import Callable

import msgspec
import pytest
import zenoh

from grex_link.bus import ZenohBus, serve
from grex_link.config import ClockConfig, Scenario
from grex_link.errors import BusError, GrexError
from grex_link.messages import Clock, Fix, ModemEvent, Presence, Received, Setpoint
from grex_link.scenario import fingerprint

FIX = Fix(12, 12 * 10**9, 1.0, 2.0, 3.0, 0.5, 1.0, 0.1)
SETPOINT = Setpoint(12, 12 * 10**9, "steer", 0.5, 1.0, 3.0)
SOON_S = 20.0


@pytest.fixture
def scenario(make) -> Scenario:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return make(f"bus.endpoints=['tcp/127.0.0.1:{port}']", f"team.name=t{port}")


def take(bus: ZenohBus, wanted: str) -> tuple:
    """Take messages until one of a topic comes."""
    while True:
        envelope = bus.take(SOON_S)
        assert envelope is not None, f"no {wanted}"
        if envelope[0] == wanted:
            return envelope


def see(bus: ZenohBus, who: str, *, alive: bool) -> Presence:
    """Take messages until somebody has come or gone."""
    while True:
        presence = take(bus, "presence")[2]
        if (presence.who, presence.alive) == (who, alive):
            return presence


def put_raw(scenario: Scenario) -> Callable[[str, bytes], None]:
    """Return a function with which a stranger puts bytes on keys of the team, through a connection of its own."""
    config = {"mode": "client", "connect": {"endpoints": list(scenario.bus.endpoints)}}
    config["scouting"] = {"multicast": {"enabled": False}, "gossip": {"enabled": False}}

    def put(below: str, payload: bytes) -> None:
        with zenoh.open(zenoh.Config.from_json5(msgspec.json.encode(config).decode())) as session:
            session.put(f"grex/{scenario.team.name}/{below}", payload)

    return put


def test_presence(scenario: Scenario) -> None:
    """Both sides see each other come, with the fingerprint of the scenario, and go."""
    with ZenohBus(scenario, "sim", "sim") as sim:
        with ZenohBus(scenario, "agent", "auv1") as agent:
            assert see(sim, "auv1", alive=True).scenario == fingerprint(scenario)
            assert see(agent, "sim", alive=True).scenario == fingerprint(scenario)
        see(sim, "auv1", alive=False)


def test_messages_both_ways(scenario: Scenario) -> None:
    """After the other has been seen no message is missed, and each comes with its topic and craft."""
    with ZenohBus(scenario, "sim", "sim") as sim, ZenohBus(scenario, "agent", "auv1") as agent:
        see(sim, "auv1", alive=True)
        sim.put("fix", "auv2", FIX)
        sim.put("fix", "auv1", FIX)
        assert take(agent, "fix") == ("fix", "auv1", FIX)
        agent.put("setpoint", "auv1", SETPOINT)
        assert take(sim, "setpoint") == ("setpoint", "auv1", SETPOINT)


def test_agents_hear_nobody_else(scenario: Scenario) -> None:
    """What is meant for one craft does not reach another, though both hang on one router."""
    event = ModemEvent(0, 12, Received("auv3", b"x"))
    with (
        ZenohBus(scenario, "sim", "sim") as sim,
        ZenohBus(scenario, "link", "link") as link,
        ZenohBus(scenario, "agent", "auv1") as one,
        ZenohBus(scenario, "agent", "auv2") as two,
    ):
        for who in ("link", "auv1", "auv2"):
            see(sim, who, alive=True)
        sim.put("clock", "link", Clock("start"))
        assert take(link, "clock") == ("clock", "link", Clock("start"))
        link.put("modem_rx", "auv1", event)
        sim.put("fix", "auv1", FIX)
        heard = {one.take(SOON_S)[0] for _ in range(3)}
        assert heard == {"presence", "modem_rx", "fix"}
        sim.put("clock", "auv2", Clock("bye"))
        assert {two.take(SOON_S)[0] for _ in range(2)} == {"presence", "clock"}
        assert two.take(0.0) is None


BROKEN = [b"", b"\xc1", b"no message", msgspec.msgpack.encode({"tick": "twelve"}), msgspec.msgpack.encode(FIX)[:-3]]


def test_broken_payloads(scenario: Scenario, fresh_log, capsys) -> None:
    """Payloads that do not decode are counted, logged once for their key and dropped; good ones still come."""
    with ZenohBus(scenario, "sim", "sim") as sim:
        key = f"grex/{scenario.team.name}/auv2/setpoint"
        put = put_raw(scenario)
        for payload in BROKEN:
            put("auv2/setpoint", payload)
        put("auv2/setpoint", msgspec.msgpack.encode(SETPOINT))
        envelopes = []
        while not envelopes or envelopes[-1] is None or envelopes[-1][0] != "setpoint":
            envelopes.append(sim.take(SOON_S))
        assert envelopes[-1] == ("setpoint", "auv2", SETPOINT)
        assert sim.bad_payloads == {key: len(BROKEN)}
        assert capsys.readouterr().err.count(key) == 1


@pytest.mark.parametrize(
    "payload",
    [msgspec.msgpack.encode(SETPOINT).replace(b"steer", b"st\xff\xffr"), b"\x81\xa1x" + b"\x91" * 100_000 + b"\xc0"],
    ids=["not UTF-8", "nested"],
)
def test_nasty_payloads(scenario: Scenario, fresh_log, payload: bytes) -> None:
    """Neither a text that is not UTF-8 nor one nested without end does more than a broken payload."""
    with ZenohBus(scenario, "sim", "sim") as sim:
        put_raw(scenario)("auv2/setpoint", payload)
        while not sim.bad_payloads:
            envelope = sim.take(SOON_S)
            assert envelope is None or envelope[0] == "presence"


def test_no_message(scenario: Scenario) -> None:
    """Who waits for no time at all gets nothing, at once."""
    with ZenohBus(scenario, "sim", "sim") as sim:
        see(sim, "sim", alive=True)
        assert sim.take(0.0) is None


def test_port_in_use(scenario: Scenario) -> None:
    """A second simulator on the same port ends with one line that names the endpoints of the scenario."""
    with ZenohBus(scenario, "sim", "sim"), pytest.raises(GrexError, match=r"^\$\.bus\.endpoints: [^\n]*$") as caught:
        ZenohBus(scenario, "sim", "sim")
    assert scenario.bus.endpoints[0] in str(caught.value)


def test_nobody_answers(scenario: Scenario) -> None:
    """Who finds no simulator within the start timeout ends with one line that names the endpoint."""
    short = msgspec.structs.replace(scenario, clock=msgspec.structs.replace(scenario.clock, start_timeout_s=0.01))
    with pytest.raises(GrexError, match=r"^\$\.bus\.endpoints: nobody answers [^\n]*$") as caught:
        ZenohBus(short, "agent", "auv1")
    assert scenario.bus.endpoints[0] in str(caught.value)


class Twice:
    """A node that counts what it is asked to do, and is done after its second fix."""

    def __init__(self, idle_work: int) -> None:
        self.done = self.started = False
        self.asked: list[str] = []
        self.idle_work = idle_work

    def handle(self, topic: str, craft: str, message: object) -> None:
        self.asked.append(topic)
        self.done = self.asked.count("fix") == 2

    def wall_s_to_deadline(self) -> float | None:
        return 0.0 if self.asked.count("deadline") < 3 else SOON_S

    def on_deadline(self) -> None:
        self.asked.append("deadline")

    def in_idle_time(self) -> bool:
        if self.asked.count("idle") == self.idle_work:
            return False
        self.asked.append("idle")
        return True


class Idle(Twice):
    """A node that has three things to do in idle time, and is done at its deadline."""

    def __init__(self) -> None:
        super().__init__(idle_work=3)

    def on_deadline(self) -> None:
        super().on_deadline()
        self.done = True


def test_serve(scenario: Scenario) -> None:
    """A node is served messages and deadlines until it is done, and then nothing more."""
    with ZenohBus(scenario, "sim", "sim") as sim, ZenohBus(scenario, "agent", "auv1") as agent:
        see(sim, "auv1", alive=True)
        for _ in range(3):
            sim.put("fix", "auv1", FIX)
        node = Twice(idle_work=0)
        serve(agent, node, ClockConfig(chaos_delay_s=0.001))
        assert node.asked.count("fix") == 2
        assert node.asked[-1] == "fix"


def test_idle_time(scenario: Scenario) -> None:
    """While no message waits a node does what could wait, all of it before its deadline."""
    with ZenohBus(scenario, "sim", "sim") as sim, ZenohBus(scenario, "agent", "auv1") as agent:
        see(sim, "auv1", alive=True)
        see(agent, "sim", alive=True)
        assert agent.idle
        node = Idle()
        serve(agent, node, ClockConfig())
        assert node.asked == ["idle"] * 3 + ["deadline"]


class Waiting(Twice):
    """A node that has nothing to do before the mission starts."""

    def wall_s_to_deadline(self) -> float | None:
        return None


def test_nobody_waits_for_the_start_for_ever(scenario: Scenario) -> None:
    """A participant that hears nothing of the start gives up after twice the start timeout, and says so."""
    with (
        ZenohBus(scenario, "sim", "sim"),
        ZenohBus(scenario, "agent", "auv1") as agent,
        pytest.raises(BusError, match=r"has not started for 0\.2 s"),
    ):
        serve(agent, Waiting(idle_work=0), ClockConfig(start_timeout_s=0.1))
