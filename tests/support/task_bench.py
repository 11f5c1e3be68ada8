"""Tasks on the bench: a craft that moves as its tasks steer it, and two posts with a line between them that loses."""

import math
from collections.abc import Callable

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import plan_mission
from grex_agent.tasks.post import TaskPost
from grex_agent.tasks.runner import TaskRunner
from grex_link.config import Scenario
from grex_link.messages import Fix, Received, TxEvent
from grex_link.scenario import decode

NS = 1_000_000_000


def habitat(**tables) -> Scenario:
    """A pair tied by cable, a craft that stands by, and one that cannot dive."""
    document = {
        "mission": {
            "type": "lawnmower",
            "legs": 2,
            "leg_length_m": 200.0,
            "formation_m": {"top": [0.0, 0.0, 0.0], "low": [0.0, 0.0, 10.0]},
        },
        "standby": {"aid": {"at_ned_m": [0.0, 50.0, 5.0]}, "ship": {"at_ned_m": [0.0, -50.0, 0.0], "on_call": False}},
        "link": {"land": [{"between": ["top", "low"], "kind": "cable", "length_m": 15.0}]},
        "craft": {
            "top": {},
            "low": {},
            "aid": {},
            "ship": {"vehicle": {"pitch": {"lag_s": 1.0, "min": 0.0, "max": 0.0, "rate_max": 0.2}}},
        },
    }
    return decode(document | tables)


class Swimmer:
    """A craft that goes where its runner steers it, at once, in steps of a second."""

    def __init__(self, scenario: Scenario, craft: str, at=None) -> None:
        plan = plan_mission(scenario)
        self.plan = plan.everybody[craft]
        self.processor = ManoeuvreProcessor(self.plan)
        self.runner = TaskRunner(scenario, craft, plan, self.processor)
        self.north, self.east, self.down = at or (*self.plan.start[:2], self.plan.start_depth_m)
        self.heading = 0.0
        self.now_s = 0
        self.formation = 0.0
        self.path: list[tuple[float, float, float]] = []

    def fix(self) -> Fix:
        return Fix(self.now_s, self.now_s * NS, self.north, self.east, self.down, self.heading, 1.0, 0.1)

    def step(self, *, lost: bool = False):
        """One second; returns what the runner said."""
        steering = self.runner.step(self.now_s * NS, self.fix(), self.formation, lost=lost)
        self.now_s += 1
        if steering is not None and not lost:
            self.heading = steering.course_rad
            self.north += steering.speed_mps * math.cos(steering.course_rad)
            self.east += steering.speed_mps * math.sin(steering.course_rad)
            if steering.speed_mps:
                self.down += max(-0.4, min(0.4, steering.depth_m - self.down))
        self.path.append((self.north, self.east, self.down))
        return steering

    def run(self, until: Callable[[], bool], most_s: int = 2000) -> int:
        """Step until something is so; returns how many seconds that took."""
        begin = self.now_s
        while not until():
            assert self.now_s - begin < most_s, "it never came to that"
            self.step()
        return self.now_s - begin

    def said(self) -> list[str]:
        """What has become of tasks so far."""
        return [happening.status for happening in self.runner.happenings]

    def has(self, status: str) -> Callable[[], bool]:
        return lambda: status in self.said()


class Line:
    """Two posts, a and b: what one sends leaves a second later, and comes another second later if it is not lost."""

    def __init__(self, lost: Callable[[str, int], bool], tries: int = 8, answer_s: int = 5) -> None:
        self.posts = {who: TaskPost(who, ["a", "b"], tries, answer_s * NS) for who in "ab"}
        self._lost = lost
        self._due: list[tuple[int, str, object]] = []
        self.sent = {"a": 0, "b": 0}
        self.arrived: list = []
        self.words: list[str] = []
        self.now_s = 0

    def step(self, on_arrival: Callable[[str], str] = lambda name: "started") -> None:
        now_ns = self.now_s * NS
        due, self._due = self._due, []
        for at_s, who, event in due:
            post = self.posts[who]
            if at_s > self.now_s:
                self._due.append((at_s, who, event))
            elif isinstance(event, TxEvent):
                post.on_status(event, now_ns)
            elif (arrival := post.on_received(event)) is not None:
                self.arrived.append(arrival)
                status = on_arrival(arrival.name)
                post.answer(arrival.name, status, now_ns, "depth" if status == "refused" else "")
        for who in "ab":
            self.posts[who].step(now_ns, lambda payload, to, who=who: self._send(who, to, payload))
        self.words += [word.status for word in self.posts["a"].words]
        self.posts["a"].words.clear()
        self.now_s += 1

    def run(self, seconds: int) -> None:
        for _ in range(seconds):
            self.step()

    def _send(self, who: str, to: str, payload: bytes) -> int:
        ticket = self.sent[who]
        self.sent[who] += 1
        self._due.append((self.now_s + 1, who, TxEvent(ticket, "SENT")))
        if not self._lost(who, ticket):
            self._due.append((self.now_s + 2, to, Received(who, payload)))
        return ticket
