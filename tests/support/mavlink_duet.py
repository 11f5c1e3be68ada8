"""Adapter and simulated autopilot, each with its own bytes, on literal time: no socket, no clock."""

from autopilots import START

from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.dialect import Codec
from grex_agent.frontseat.inspection import Inspection
from grex_agent.frontseat.outputs import Note
from grex_link.config import DatumConfig, MavlinkFrontseat
from grex_link.messages import Fix, Setpoint
from grex_link.units import NS
from grex_sim.autopilot.brain import Settings
from grex_sim.autopilot.codec import Codec as AutopilotCodec
from grex_sim.autopilot.core import Autopilot
from grex_sim.autopilot.family import load_family
from grex_sim.autopilot.message import Message

STEP_S = 0.02
#: Of the adapter's clock at zero.
DATE_S = 1_800_000_000
DATUM = DatumConfig(START.latitude_deg, START.longitude_deg)


class Duet:
    """One adapter, one autopilot, and the bytes between them; `inspect` looks at it as a probe does."""

    def __init__(
        self, family: str, *, inspect: bool = False, adapter: dict | None = None, datum: DatumConfig = DATUM, **settings
    ) -> None:
        chosen = {"ready_s": 1.0, "noise_m": 0.05, "place": START} | settings
        self.pilot = Autopilot(Settings(family=load_family(family), **chosen))
        config = MavlinkFrontseat(url="udpin:127.0.0.1:1", **(adapter or {}))
        self.own = config.own_system
        self.core = FrontseatCore(config, datum, 1.0, DATE_S * NS)
        self.ours, self.theirs = Codec(config.own_system, config.own_component), AutopilotCodec(1)
        self.inspection: Inspection | None = None
        self._inspects = inspect
        self.now = 0.0
        self.words: list[str] = []
        self.sent: list[str] = []

    def run(self, seconds: float) -> "Duet":
        """Let time pass."""
        until = self.now + seconds
        while self.now < until - 1e-9:
            self.now += STEP_S
            for out in self.pilot.step(self.now):
                self._hear(self.theirs.pack(out.message) if isinstance(out.message, Message) else out.message)
            if self._inspects and self.inspection is None and self.core.peer is not None:
                self.inspection = Inspection(self.core.peer, self.own)
            self._take(self.core.on_time(self.now_ns))
            self._take([] if self.inspection is None else self.inspection.due(self.now))
        return self

    def navigate(self, fix: Fix) -> None:
        """Tell the adapter where the craft is."""
        self._take(self.core.on_navigation(fix, self.now_ns))

    def steer(self, order: Setpoint) -> None:
        """Give the adapter a set-point of the agent."""
        self._take(self.core.on_setpoint(order, self.now_ns))

    @property
    def now_ns(self) -> int:
        return round((1000.0 + self.now) * NS)

    @property
    def advice(self) -> list[str]:
        return self.inspection.advice()

    @property
    def missing(self) -> list[str]:
        return self.inspection.missing(1000.0 + self.now)

    def _hear(self, data: bytes) -> None:
        for message in self.ours.decode(data):
            self._take(self.core.on_message(message, self.now_ns))
            if self.inspection is not None:
                self.inspection.on_message(message)

    def _take(self, out) -> None:
        for item in out:
            if isinstance(item, Note):
                self.words.append(item.text)
                continue
            self.sent.append(item.get_type())
            for message in self.theirs.read(self.ours.encode(item)):
                self.pilot.heard(message, 0, self.now)
