"""The adapter's core between literal messages: an autopilot that does what a test tells it, and no socket."""

import math

from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.dialect import mavlink
from grex_agent.frontseat.families import KNOWN
from grex_agent.frontseat.outputs import Note
from grex_link.config import DatumConfig, MavlinkFrontseat
from grex_link.messages import Setpoint
from grex_link.units import NS

DATUM = DatumConfig(54.37, 10.16)
TYPES = {"rover": (3, 11), "sub": (3, 12), "px4": (12, 10)}
GOOD_FLAGS = 0x33F
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS = range(6)
ARM, SET_MODE, SET_INTERVAL, REQUEST = 400, 176, 511, 512


def of(message, system: int = 1, component: int = 1, number: int = 0):
    """Give a message its sender and its number."""
    mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
    mav.seq = number % 256
    message.pack(mav)
    return message


def setpoint(speed_mps: float = 1.0, course_rad: float = 0.0, mode: str = "steer", depth_m: float = 0.0) -> Setpoint:
    return Setpoint(0, 0, mode, course_rad, speed_mps, depth_m)


class MavlinkBench:
    """A core, an autopilot of few words, and everything that was said.

    Tests change its attributes: what it streams (`says`), how it answers (`answers`, by command), `mode`, `armed`.
    """

    def __init__(self, family: str = "rover", *, pace: float = 1.0, **config) -> None:
        self.family = KNOWN[family]
        self.config = MavlinkFrontseat(url="udpin:127.0.0.1:1", **config)
        self.core = FrontseatCore(self.config, DATUM, pace)
        self.kind = TYPES[family]
        self.now = 100.0
        self.boot = self.now - 50.0
        self.speedup = pace
        self.mode, self.armed, self.status = 0, False, 4
        self.flags, self.fix_type = GOOD_FLAGS, 3
        self.lat, self.lon, self.velocity, self.heading, self.depth = 54.37, 10.16, (0.0, 0.0), 0.0, 0.0
        self.says = {"heartbeat", "global", "local", "attitude", "estimator", "gps"}
        self.answers = dict.fromkeys((ARM, SET_MODE, SET_INTERVAL, REQUEST), ACCEPTED)
        self.refused_modes: set[int] = set()
        self.deaf = False
        self.agent: Setpoint | None = None
        self.sent: list[tuple[float, object]] = []
        self.notes: list[Note] = []
        self._due: dict[str, float] = {}
        self._number = 0

    # -- time -----------------------------------------------------------------------------------------------------

    @property
    def boot_ms(self) -> int:
        return round((self.now - self.boot) * self.speedup * 1000)

    def run(self, seconds: float, every: float = 0.05) -> "MavlinkBench":
        """Let time pass."""
        until = self.now + seconds
        while self.now < until - 1e-9:
            self.now += every
            for message in self._stream():
                self.hear(message)
            if self.agent is not None and self._is_due("agent", 0.5 / self.speedup):
                self.take(self.core.on_setpoint(self.agent, self.now_ns))
            self.take(self.core.on_time(self.now_ns))
        return self

    @property
    def now_ns(self) -> int:
        return round(self.now * NS)

    def start(self, agent: Setpoint | None = None) -> "MavlinkBench":
        """Begin the mission."""
        self.agent = agent
        self.take(self.core.on_start(self.now_ns))
        return self

    def steering(self, agent: Setpoint | None = None) -> "MavlinkBench":
        """Go on until the agent steers; `arm` is to be true."""
        self.run(4.0)
        assert self.phase == "steering", self.words
        return self.start(agent or setpoint())

    # -- what is said ---------------------------------------------------------------------------------------------

    def hear(self, message, system: int = 1, component: int = 1) -> None:
        self._number += 1
        self.take(self.core.on_message(of(message, system, component, self._number), self.now_ns))

    def text(self, words: str, severity: int = 6, number: int = 0, chunk: int = 0) -> None:
        self.hear(mavlink.MAVLink_statustext_message(severity, words.encode(), number, chunk))

    def heartbeat(self, system: int = 1, component: int = 1, kind: tuple[int, int] | None = None) -> None:
        autopilot, type_ = kind or self.kind
        base = 1 | (128 if self.armed else 0)
        message = mavlink.MAVLink_heartbeat_message(type_, autopilot, base, self.mode, self.status, 3)
        self.hear(message, system, component)

    def take(self, out) -> None:
        for item in out:
            if isinstance(item, Note):
                self.notes.append(item)
                continue
            self.sent.append((self.now, item))
            if item.get_type() == "COMMAND_LONG" and not self.deaf:
                self._obey(item)

    def _obey(self, command) -> None:
        result = self.answers.get(command.command)
        if result is None:
            return
        if command.command == SET_MODE and round(command.param2) in self.refused_modes:
            result = FAILED
        if result == ACCEPTED and command.command == SET_MODE:
            self.mode = round(command.param2) << 16 | round(command.param3) << 24
            self.mode = self.mode if self.kind[0] == 12 else round(command.param2)
        if result == ACCEPTED and command.command == ARM:
            self.armed = True
        self.hear(mavlink.MAVLink_command_ack_message(command.command, result, 0, 0, 255, 191))

    def _is_due(self, what: str, every: float) -> bool:
        if self.now + 1e-9 < self._due.get(what, -1e9):
            return False
        self._due[what] = self.now + every
        return True

    def _stream(self):
        if "heartbeat" in self.says and self._is_due("heartbeat", 1.0 / self.speedup):
            self.heartbeat()
        if self._is_due("fast", 0.2 / self.speedup):
            yield from self._position()
        if self._is_due("slow", 0.5 / self.speedup):
            if "estimator" in self.says:
                yield self._estimator()
            if "gps" in self.says:
                yield mavlink.MAVLink_gps_raw_int_message(
                    0, self.fix_type, round(self.lat * 1e7), round(self.lon * 1e7), 0, 100, 100, 0, 0, 10, 0, 500
                )

    def _position(self):
        ms = self.boot_ms
        north, east = self.velocity
        if "global" in self.says:
            yield mavlink.MAVLink_global_position_int_message(
                ms, round(self.lat * 1e7), round(self.lon * 1e7), 0, 0, round(north * 100), round(east * 100), 0,
                round(math.degrees(self.heading) * 100) % 36000,
            )  # fmt: skip
        if "local" in self.says:
            yield mavlink.MAVLink_local_position_ned_message(ms, 500.0, 500.0, self.depth, north, east, 0.0)
        if "attitude" in self.says:
            yield mavlink.MAVLink_attitude_message(ms, 0.0, 0.0, self.heading, 0.0, 0.0, 0.0)

    def _estimator(self):
        if self.kind[0] == 12:
            return mavlink.MAVLink_estimator_status_message(0, self.flags, 0, 0, 0, 0, 0, 0, 0.7, 1.0)
        return mavlink.MAVLink_ekf_status_report_message(self.flags, 0, 0, 0, 0, 0)

    # -- what there is --------------------------------------------------------------------------------------------

    @property
    def estimate(self):
        return self.core.estimate(self.now_ns, self.now_ns)

    @property
    def phase(self) -> str:
        return self.core.peer.control.phase

    @property
    def words(self) -> list[str]:
        return [note.text for note in self.notes]

    @property
    def warnings(self) -> list[str]:
        return [note.text for note in self.notes if note.level == "warn"]

    def said(self, kind: str, since: float = 0.0) -> list:
        """Return the messages of a kind that the core has sent since a time."""
        return [message for at, message in self.sent if message.get_type() == kind and at > since]

    def setpoints(self, seconds: float) -> list:
        """Go on, and return the set-points of that time."""
        since = self.now
        self.run(seconds)
        return self.said("SET_POSITION_TARGET_LOCAL_NED", since)

    def commands(self, number: int, since: float = 0.0) -> list:
        return [message for message in self.said("COMMAND_LONG", since) if message.command == number]
