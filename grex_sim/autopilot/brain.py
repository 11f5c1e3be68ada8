"""Everything one start of an autopilot knows; telemetry reads it, commands change it."""

import math
from collections.abc import Mapping

import msgspec

from grex_link import draws
from grex_link.errors import ConfigError
from grex_link.messages import Pose
from grex_sim.autopilot.boot import Boot
from grex_sim.autopilot.control import Control
from grex_sim.autopilot.craft import Craft
from grex_sim.autopilot.estimator import Estimator
from grex_sim.autopilot.failsafe import GcsFailsafe
from grex_sim.autopilot.family import Family
from grex_sim.autopilot.faults import Fault, Faults, parameter_rows
from grex_sim.autopilot.message import Message, Outbox, Result, Severity
from grex_sim.autopilot.modes import Modes
from grex_sim.autopilot.parameters import RENAMED_47, Parameters
from grex_sim.autopilot.place import Place
from grex_sim.autopilot.streams import Streams
from grex_sim.autopilot.timesync import StampSync

_PIECE = 50


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """What a user chooses of one autopilot."""

    family: Family
    system: int = 1
    place: Place
    heading_rad: float = 0.0
    ready_s: float | None = None
    links: int = 1
    faults: tuple[Fault, ...] = ()
    seed: int = 1
    noise_m: float = 0.03
    speed_error: float = 0.0
    """It makes (1 + this) times the speed it is told to."""
    current_ned_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wind_ned_mps: tuple[float, float] = (0.1, 0.05)
    epoch_unix_s: float = 0.0
    """Date of time zero."""
    firmware: str = ""
    """``4.7``: with ArduPilot's new names of parameters."""
    speedup: float = 1.0
    parameters: dict[str, float] = {}
    """Values that are stored already when it is first started."""


class Body:
    """What outlives a reboot: the craft, its parameters, its faults, and what is on its way.

    Parameters
    ----------
    settings : Settings
        What the user chose.

    Raises
    ------
    ConfigError
        If a parameter in the settings does not exist.
    """

    def __init__(self, settings: Settings) -> None:
        family = settings.family
        self.settings = settings
        self.who = f"{family.name}{settings.system}"
        renamed = RENAMED_47 if settings.firmware == "4.7" else None
        rows = family.parameters + parameter_rows()
        self.parameters = Parameters(rows, bytewise=family.bytewise, renamed=renamed)
        for name, value in (
            ("SYSID_THISMAV", settings.system),
            ("MAV_SYSID", settings.system),
            ("MAV_SYS_ID", settings.system),
            ("SIM_SPEEDUP", settings.speedup),
        ):
            self.parameters.set(name, value)
        for name, value in settings.parameters.items():
            if not self.parameters.set(name, value):
                raise ConfigError("--param", f"{family.name} has no parameter {name}")
        mean, *wobble = family.wobble
        tuned = msgspec.structs.replace(family, wobble=((1.0 + settings.speed_error) * mean, *wobble))
        self.craft = Craft(self.who, tuned, settings.heading_rad, settings.current_ned_mps, settings.wind_ned_mps)
        self.faults = Faults(settings.faults, settings.seed)
        self.outbox = Outbox()
        self.acks = 0
        self.texts = 0


class Brain:
    """One start.

    Parameters
    ----------
    body : Body
        What was there before and will be after.
    at_s : float
        When it got power.
    """

    def __init__(self, body: Body, at_s: float) -> None:
        settings = body.settings
        self.body, self.settings, self.family = body, settings, settings.family
        self.parameters, self.craft, self.outbox = body.parameters, body.craft, body.outbox
        self.place = settings.place
        self.boot = Boot(self.family.boot, at_s, settings.ready_s)
        self.modes = Modes(self.family, self.boot)
        external = any(int(self.parameters.get(name)) == value for name, value in self.family.external_fix)
        self.listens_to_vision = bool(self.parameters.get("VISO_TYPE"))
        self.estimator = Estimator(
            self.boot, self.family.loss, body.who, settings.seed, settings.noise_m, external=external
        )
        self.control = Control(self.family, self.craft.truth)
        self.gcs = GcsFailsafe(self.family.gcs, self.parameters)
        start_s = self.boot.when(self.family.boot.heartbeat_s)
        defaults = {"HEARTBEAT": 1.0} | self.family.streams
        if self.family.timesync_asks_hz:
            defaults["TIMESYNC"] = self.family.timesync_asks_hz
        self.streams = [Streams(defaults, self.family.rate_max_hz, start_s) for _ in range(settings.links)]
        self.stamps = [StampSync() for _ in range(settings.links)]
        self.home: tuple[float, float, float] | None = None
        self.critical = False
        self.reboot_at_s = math.inf

    @property
    def pose(self) -> Pose:
        """Where the craft believes to be, NED about the start; its attitude is true."""
        truth, belief = self.craft.truth, self.estimator.belief
        return msgspec.structs.replace(truth, north_m=belief.north_m, east_m=belief.east_m, down_m=belief.down_m)

    def say(self, name: str, fields: Mapping[str, object], link: int | None, at_s: float) -> None:
        """Say something at a time."""
        self.outbox.put(at_s, Message(name, dict(fields)), link)

    def text(self, text: str, now_s: float, severity: Severity = Severity.WARNING) -> None:
        """Say a STATUSTEXT to everybody, in pieces if it is long."""
        pieces = [text[start : start + _PIECE] for start in range(0, len(text), _PIECE)]
        self.body.texts += len(pieces) > 1
        number = self.body.texts % 65535 if len(pieces) > 1 else 0
        for chunk, piece in enumerate(pieces):
            self.say("STATUSTEXT", {"severity": severity, "text": piece, "id": number, "chunk_seq": chunk}, None, now_s)

    def ack(self, command: int, result: Result, asked: Message, link: int, now_s: float, after_s: float = 0.0) -> None:
        """Answer a command as late as the family does, with the asker's ids in it."""
        self.body.acks += 1
        least, most = self.family.ack_s
        delay = least + (most - least) * draws.uniform(self.settings.seed, "ack", self.body.who, self.body.acks)
        delay += after_s + self.body.faults.value("late", now_s)
        fields = {
            "command": command,
            "result": result,
            "target_system": asked.system,
            "target_component": asked.component,
        }
        self.say("COMMAND_ACK", fields, link, now_s + delay)
