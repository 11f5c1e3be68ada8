"""The bus inside one process: messages go to those whom the table names, in the order in which they were put."""

from typing import Any

import pytest

from grex_link.emulator import Emulator
from grex_link.memory_bus import MemoryBus
from grex_link.messages import Advance, Clock, Presence, Setpoint, Step, Transmit
from grex_link.scenario import fingerprint
from grex_link.topics import TOPICS

SETPOINT = Setpoint(12, 12 * 10**9, "steer", 0.5, 1.0, 3.0)


class Participant:
    """Keeps what it gets; is done after a number of messages, and at its deadlines does what it is told."""

    def __init__(self, enough: int = 1000, deadlines: int = 0) -> None:
        self.got: list[tuple[str, str, Any]] = []
        self.enough = enough
        self.deadlines = deadlines

    @property
    def done(self) -> bool:
        return len(self.got) >= self.enough

    def handle(self, topic: str, craft: str, message: Any) -> None:
        self.got.append((topic, craft, message))

    def wall_s_to_deadline(self) -> float | None:
        return 0.0 if self.deadlines else None

    def on_deadline(self) -> None:
        self.deadlines -= 1
        self.got.append(("deadline", "", None))

    def in_idle_time(self) -> bool:
        return False


@pytest.fixture
def bus() -> MemoryBus:
    return MemoryBus()


@pytest.fixture
def everybody(bus, make) -> dict[str, Participant]:
    nodes = {who: Participant() for who in ("sim", "link", "auv1", "auv2", "auv3")}
    for who, node in nodes.items():
        bus.join(node, make(), "agent" if who.startswith("auv") else who, who)
    return nodes


#: Who gets a message of each topic that is put for auv2 (or for nobody in particular).
READERS = {
    "fix": {"auv2", "sim"},
    "nav": set(),
    "setpoint": {"sim"},
    "modem_tx": {"link", "sim"},
    "modem_rx": {"auv2", "sim"},
    "state": {"sim"},
    "port": {"sim"},
    "task": {"auv2"},
    "task_news": {"sim"},
    "oracle": {"auv2"},
    "clock": {"auv2"},
    "truth": {"link"},
    "advance": {"link"},
    "report": {"sim"},
    "ledger": {"sim"},
    "status": set(),
    "link_event": set(),
}


@pytest.mark.parametrize("topic", TOPICS)
def test_delivery(bus, everybody, topic: str) -> None:
    """A message reaches exactly those whom the table names, and no other craft."""
    craft = "auv2" if TOPICS[topic].per_craft else ""
    bus.put(topic, craft, SETPOINT)
    bus.run()
    assert {who for who, node in everybody.items() if node.got == [(topic, craft, SETPOINT)]} == READERS[topic]
    assert all(len(node.got) <= 1 for node in everybody.values())


def test_clock_of_the_link(bus, everybody) -> None:
    """The link has a clock of its own, as if it were a craft."""
    bus.put("clock", "link", Clock("bye"))
    bus.run()
    assert [who for who, node in everybody.items() if node.got] == ["link"]


def test_order(bus, everybody) -> None:
    """Messages arrive in the order in which they were put, whoever put them."""
    for number in range(6):
        bus.put("modem_tx", f"auv{1 + number % 3}", Transmit(number, 0, b""))
    bus.run()
    assert [message.seq for _, _, message in everybody["sim"].got] == list(range(6))


def test_presence(bus, everybody, make) -> None:
    """The simulator sees everybody appear, everybody sees the simulator, all with the scenario's fingerprint."""
    bus.announce()
    bus.run()
    of_all = [Presence(who, alive=True, scenario=fingerprint(make())) for who in everybody]
    assert [message for topic, _, message in everybody["sim"].got if topic == "presence"] == of_all
    for who in ("link", "auv1", "auv2", "auv3"):
        assert everybody[who].got == [("presence", "sim", of_all[0])]


def test_ends_when_nothing_can_happen(bus, everybody) -> None:
    """A run in which nobody has anything to say or to wait for ends, though nobody is done."""
    bus.run()
    assert not any(node.got for node in everybody.values())


def test_deadlines(bus, make) -> None:
    """When no message is left, whoever's deadline is first acts; who is done has no deadline any more."""
    patient, busy, finished = Participant(), Participant(deadlines=3), Participant(enough=0, deadlines=3)
    for who, node in (("auv1", patient), ("auv2", busy), ("auv3", finished)):
        bus.join(node, make(), "agent", who)
    bus.put("fix", "auv2", SETPOINT)
    bus.run()
    assert [topic for topic, *_ in busy.got] == ["fix", "deadline", "deadline", "deadline"]
    assert (patient.got, finished.got) == ([], [])


def test_ends_when_all_are_done(bus, make) -> None:
    """When everybody is done the run is over, though somebody still has a deadline."""
    node = Participant(enough=2, deadlines=100)
    bus.join(node, make(), "agent", "auv1")
    bus.run()
    assert node.deadlines == 98


def test_messages_in_answer(bus, make, truth_at) -> None:
    """What a node puts while it handles a message is delivered in the same run."""
    scenario = make()
    hub, agent = Participant(), Participant()
    bus.join(hub, scenario, "sim", "sim")
    bus.join(agent, scenario, "agent", "auv2")
    bus.join(Emulator(scenario, bus), scenario, "link", "link")
    bus.put("advance", "", Advance([Step(truth_at(12), [1, 0, 0])]))
    bus.put("modem_tx", "auv1", Transmit(0, 12 * 10**9, b"x"))
    bus.run()
    assert [topic for topic, *_ in agent.got] == ["modem_rx"]
    assert [topic for topic, *_ in hub.got] == ["modem_tx", "modem_rx", "modem_rx", "modem_rx", "report"]
