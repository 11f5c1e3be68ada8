"""Benches for the contract of every frontseat: the simulated craft, and the adapter with a simulated autopilot.

An agent of one order a tick is on the other side. The adapter runs in this process, its autopilot in one of its own, at
a pace of many mission seconds a wall second.
"""

import time
from contextlib import ExitStack
from pathlib import Path

from frontseat_runs import autopilot, free_port

from grex_agent.frontseat.address import parse_url
from grex_agent.frontseat.connection import Connection
from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.dialect import Codec
from grex_agent.frontseat.node import Frontseat
from grex_agent.mission import plan_mission
from grex_link import clock
from grex_link.messages import Clock, Fix, Message, Setpoint
from grex_link.scenario import loads
from grex_sim.sea import Sea

NS = 1_000_000_000
PACE = 10.0
#: A fix is asked for once a second; an agent that is silent for longer is stale.
SCENARIO = """
datum = {{ latitude_deg = 54.37, longitude_deg = 10.16 }}
[clock]
pace = {pace}
[mission]
type = "lawnmower"
legs = 1
[mission.formation_m]
auv1 = [0, 0, 0]
[craft.auv1.frontseat]
{frontseat}
"""


class Outlet:
    """Keeps the fixes."""

    def __init__(self) -> None:
        self.fixes: list[Fix] = []

    def put(self, topic: str, craft: str, message: Message) -> None:
        """See `grex_link.node.Outlet`."""
        assert (topic, craft) == ("fix", "auv1")
        self.fixes.append(message)


class SimBench:
    """The simulated craft, which the bench moves."""

    dives = True
    loses_navigation = False
    stale_s = 5.0
    """It stops so long after the agent's last word (`team.fix_timeout_s`)."""

    def __init__(self, folder: Path, fault: str = "") -> None:
        del folder, fault
        scenario = loads(SCENARIO.format(pace='"lockstep"', frontseat='type = "sim"'))
        self._sea = Sea(scenario, plan_mission(scenario))
        self.fixes: list[Fix] = self._sea.fixes([0])
        self._last: Setpoint | None = None

    def run(self, seconds: int, **order) -> None:
        """Let mission time pass; the agent repeats an order at every tick, or is silent."""
        for _ in range(seconds):
            tick = self.fixes[-1].tick
            if order:
                self._last = Setpoint(tick, tick * NS, **order)
            fresh = self._last is not None and tick - self._last.tick < self.stale_s
            self._sea.advance({"auv1": self._last} if fresh else {})
            self.fixes += self._sea.fixes([0])

    def close(self) -> None:
        """Nothing is left behind."""


class AdapterBench:
    """The adapter, and a simulated autopilot at the other end of a line."""

    family = "rover"
    options: tuple[str, ...] = ()
    """More of the autopilot's."""
    more = ""
    """More of the frontseat's, in the scenario."""
    loses_navigation = True
    stale_s = 3.0
    """The autopilot's own timeout; the adapter's is shorter."""

    def __init__(self, folder: Path, fault: str = "") -> None:
        self._stack = ExitStack()
        ours, theirs = self._ends(folder)
        options = ["--family", self.family, "--speedup", f"{PACE:g}", "--ready", "10", *self.options]
        options += ["--fault", fault] if fault else []
        self._stack.enter_context(autopilot(theirs, folder / "autopilot.log", *options))
        deadline = time.monotonic() + 20.0
        while ours.startswith("serial:") and not (folder / "line").exists():
            assert time.monotonic() < deadline, "the autopilot has made no pty"
            time.sleep(0.02)
        frontseat = f'type = "mavlink"\nurl = "{ours}"\narm = true\n{self.more}'
        scenario = loads(SCENARIO.format(pace=PACE, frontseat=frontseat))
        config = scenario.mavlink_craft["auv1"]
        now = clock.unix_ns()
        self.core = FrontseatCore(config, scenario.datum, PACE, now - round(clock.monotonic_s() * NS))
        connection = Connection(parse_url(config.url, "url"), Codec(255, 191, None, now))
        connection.open("url")
        self._stack.callback(connection.close)
        self._outlet = Outlet()
        self._node = Frontseat(scenario, "auv1", self._outlet, connection, self.core)
        self._stack.callback(self._node.hand_back)
        self.fixes = self._outlet.fixes
        self._start()

    def _ends(self, folder: Path) -> tuple[str, str]:
        del folder
        port = free_port()
        return f"udpin:127.0.0.1:{port}", f"udpout:127.0.0.1:{port}"

    @property
    def dives(self) -> bool:
        """Whether it follows a depth."""
        return self.family == "sub"

    def _start(self) -> None:
        deadline = time.monotonic() + 40.0
        while self._node.waits_for:
            assert time.monotonic() < deadline, self._node.waits_for
            self._turn()
        self._node.handle("clock", "auv1", Clock("start", clock.unix_ns()))

    def run(self, seconds: int, **order) -> None:
        """Let mission time pass; the agent answers every fix with an order, or is silent."""
        last = self.fixes[-1].tick
        give_up = time.monotonic() + 20.0 + 3.0 * seconds / PACE
        answered = last - 1
        while (tick := self.fixes[-1].tick) < last + seconds:
            if order and tick > answered:
                answered = tick
                self._node.handle("setpoint", "auv1", Setpoint(tick, tick * NS, **order))
            self._turn()
            assert time.monotonic() < give_up, "no fixes come"

    def _turn(self) -> None:
        time.sleep(0.003)
        self._node.on_deadline()

    def close(self) -> None:
        """Hand back, and end the autopilot."""
        self._stack.close()


class SerialBench(AdapterBench):
    """The same over a serial line."""

    family = "sub"

    def _ends(self, folder: Path) -> tuple[str, str]:
        device = folder / "line"
        return f"serial:{device}:115200", f"pty:{device}"
