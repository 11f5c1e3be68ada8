"""The bus inside one process: a queue, and who reads what."""

from collections import deque
from collections.abc import Sequence

from grex_link import clock
from grex_link.bus import Envelope
from grex_link.config import Scenario
from grex_link.messages import Message, Presence
from grex_link.node import Node
from grex_link.scenario import fingerprint
from grex_link.topics import Role, subscriptions


class MemoryBus:
    """All participants in one process: a queue of messages and a table of readers."""

    def __init__(self) -> None:
        self._queue: deque[tuple[Node, Envelope]] = deque()
        self._readers: dict[tuple[str, str], list[Node]] = {}
        self._present: list[tuple[Node, str, str, Role]] = []

    def join(self, node: Node, scenario: Scenario, role: Role, who: str) -> None:
        """Add a participant; the simulator sees everyone appear, everyone sees the simulator."""
        for topic, craft in subscriptions(role, who):
            for name in scenario.craft if craft == "*" else [craft]:
                self._readers.setdefault((topic, name), []).append(node)
        self._present.append((node, who, fingerprint(scenario), role))

    def announce(self) -> None:
        """Let everybody appear, once all have joined."""
        for reader, _, _, role in self._present:
            for _, who, scenario, _ in self._present:
                if role == "sim" or who == "sim":
                    self._queue.append((reader, ("presence", who, Presence(who, alive=True, scenario=scenario))))

    def put(self, topic: str, craft: str, message: Message) -> None:
        """Write a message to a topic."""
        for node in self._readers.get((topic, craft), ()):
            self._queue.append((node, (topic, craft, message)))

    def run(self) -> None:
        """Hand out messages until every participant is done, or nothing can happen any more."""
        nodes = [node for node, *_ in self._present]
        pending = self._queue
        while True:
            while pending:
                node, (topic, craft, message) = pending.popleft()
                node.handle(topic, craft, message)
            if all(node.done for node in nodes) or not _wait_for_deadline(nodes):
                return


def _wait_for_deadline(nodes: Sequence[Node]) -> bool:
    """Sleep until the first deadline of any node and let it act; False if there is none."""
    waits = [(wait, node) for node in nodes if not node.done and (wait := node.wall_s_to_deadline()) is not None]
    if not waits:
        return False
    wait, node = min(waits, key=lambda entry: entry[0])
    clock.sleep_s(wait)
    node.on_deadline()
    return True
