"""A simulated autopilot on the bench: literal times, no sockets."""

import math

from grex_sim.autopilot.brain import Settings
from grex_sim.autopilot.core import Autopilot
from grex_sim.autopilot.family import load_family
from grex_sim.autopilot.message import Frame, Message
from grex_sim.autopilot.place import Place

START = Place(54.37, 10.16)
MODES = {
    "rover": {"MANUAL": 0, "HOLD": 4, "LOITER": 5, "GUIDED": 15},
    "sub": {"STABILIZE": 0, "ALT_HOLD": 2, "GUIDED": 4, "SURFACE": 9, "POSHOLD": 16, "MANUAL": 19},
    "px4": {"MANUAL": 0x010000, "POSCTL": 0x030000, "GUIDED": 0x060000, "LOITER": 0x03040000},
}
VELOCITY = 0x0DC7
ARM, SET_MODE, SET_INTERVAL, REQUEST, REBOOT = 400, 176, 511, 512, 246


class Bench:
    """One autopilot, what it said and when."""

    def __init__(self, family: str = "rover", ready_s: float | None = 2.0, **settings) -> None:
        self.family = family
        chosen = {"noise_m": 0.0, "place": START} | settings
        self.pilot = Autopilot(Settings(family=load_family(family), ready_s=ready_s, **chosen))
        self.now = 0.0
        self.heard: list[tuple[float, int | None, Message | bytes]] = []

    def run(self, until: float, every: float = 0.1, repeat=None) -> "Bench":
        """Go on to a time; `repeat` is done at every step."""
        while self.now < until - 1e-9:
            self.now = min(self.now + every, until)
            self.heard += [(self.now, out.link, out.message) for out in self.pilot.step(self.now)]
            if repeat is not None:
                repeat()
        return self

    def send(self, name: str, system: int = 255, component: int = 191, link: int = 0, **fields) -> None:
        self.pilot.heard(Message(name, fields, system, component), link, self.now)

    def heartbeat(self, system: int = 255) -> None:
        self.send("HEARTBEAT", system=system, type=6)

    def command(self, number: int, *params: float, name: str = "COMMAND_LONG", wait: float = 0.1, **more) -> int | None:
        """Send a command, wait for its ACK and return its result; None if none came."""
        fields = {f"param{n + 1}": value for n, value in enumerate([*params, *[0.0] * (7 - len(params))])}
        ids = {key: more.pop(key) for key in ("system", "component", "link") if key in more}
        fields |= {"command": number, "target_system": 1, "target_component": 1}
        self.send(name, **ids, **(fields | more))
        since = self.now
        self.run(self.now + wait, every=0.02)
        acks = [m for m in self.said("COMMAND_ACK", since) if m["command"] == number]
        return acks[-1]["result"] if acks else None

    def mode(self, name: str) -> int | None:
        number = MODES[self.family][name]
        if self.family == "px4":
            return self.command(SET_MODE, 1, number >> 16 & 0xFF, number >> 24)
        return self.command(SET_MODE, 1, number)

    def guided(self) -> "Bench":
        """Ready, in its guided mode and armed."""
        self.run(3.0)
        if self.family == "px4":
            self.velocity(0.0, 0.0)
        assert self.mode("GUIDED") == 0
        if self.family == "px4":
            self.velocity(0.0, 0.0)
        assert self.command(ARM, 1) == 0
        return self

    def velocity(self, north: float, east: float, down: float = 0.0, mask: int = VELOCITY, **more) -> None:
        fields = {"coordinate_frame": Frame.LOCAL_NED, "target_system": 1, "x": 0.0, "y": 0.0, "z": 0.0}
        fields |= {"yaw": 0.0, "yaw_rate": 0.0, "type_mask": mask, "vx": north, "vy": east, "vz": down}
        self.send("SET_POSITION_TARGET_LOCAL_NED", **(fields | more))

    def drive(self, seconds: float, north: float, east: float, down: float = 0.0, **more) -> "Bench":
        """Repeat a velocity at 5 Hz."""
        return self.run(self.now + seconds, 0.2, lambda: self.velocity(north, east, down, **more))

    # -- what was said ------------------------------------------------------------------------------------------

    def said(self, name: str, since: float = 0.0) -> list[Message]:
        return [m for t, _, m in self.heard if t > since and isinstance(m, Message) and m.name == name]

    def last(self, name: str) -> Message:
        return self.said(name)[-1]

    def texts(self, since: float = 0.0) -> list[str]:
        return [m["text"] for m in self.said("STATUSTEXT", since)]

    @property
    def shown(self) -> int:
        """Mode in the last heartbeat."""
        return self.last("HEARTBEAT")["custom_mode"]

    @property
    def armed(self) -> bool:
        return bool(self.last("HEARTBEAT")["base_mode"] & 128)

    @property
    def truth(self):
        return self.pilot.brain.craft.truth

    @property
    def speed(self) -> float:
        return self.pilot.brain.craft.speed_mps

    @property
    def heading_deg(self) -> float:
        return math.degrees(self.truth.heading_rad)

    def set_parameter(self, name: str, value: float) -> Message | None:
        since = self.now
        self.send("PARAM_SET", target_system=1, param_id=name, param_value=value, param_type=9)
        self.run(self.now + 0.04, 0.02)
        said = self.said("PARAM_VALUE", since)
        return said[-1] if said else None
