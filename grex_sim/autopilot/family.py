"""What a family of autopilots is: a table. Times are autopilot seconds as measured on real ones at pace 1."""

from typing import Annotated, Literal

import msgspec

from grex_link.config import VehicleConfig

Kind = Literal["manual", "stop", "point", "guided", "depth", "surface", "home"]


class Mode(msgspec.Struct, frozen=True):
    """One mode."""

    name: str
    number: int
    """``custom_mode`` of the heartbeat."""
    kind: Kind
    """``manual``: a pilot steers. ``stop``: no thrust. ``point``: keeps its place. ``guided``: obeys set-points.
    ``depth``: keeps its depth. ``surface``: comes up. ``home``: goes home and stays."""
    needs_position: bool = False


class BootTimes(msgspec.Struct, frozen=True):
    """Seconds from power-on; all of them shrink with ``--ready``."""

    console_lines: int
    """Lines of console text on the link before the first heartbeat."""
    heartbeat_s: float
    settled_s: float
    """Until then a mode that is accepted is taken back."""
    position_s: float
    """GLOBAL_POSITION_INT holds something else than what stands in ``before``."""
    before: Literal["zero", "home"]
    clock_s: float
    """SYSTEM_TIME has a date."""
    arm_s: float
    """Modes that need no position can be armed."""
    ready_s: float
    """The estimator has a position and an origin."""


class LossTimes(msgspec.Struct, frozen=True):
    """What happens when satellites are lost, seconds after."""

    fix_s: float
    """GPS_RAW_INT.fix_type falls."""
    aiding_s: float
    """The estimator's flags fall and LOCAL_POSITION_NED stops; until then it reckons on."""
    lie: Literal["runs_on", "frozen"]
    """What GLOBAL_POSITION_INT goes on telling."""
    lie_s: float
    """How long it runs on."""
    text: str
    failsafe_s: float | None
    failsafe_mode: str = ""
    failsafe_text: str = ""
    return_s: float = 10.0
    """From the return of satellites to good flags (not measured)."""


class SetpointRules(msgspec.Struct, frozen=True):
    """Which set-points are obeyed, and what happens when they stop."""

    velocity_mask: int
    """These bits must all be 0 for a velocity to be taken."""
    acceleration_ignored: bool
    """Whether acceleration must be masked out."""
    frames: tuple[int, ...]
    fatal_frames: tuple[int, ...] = ()
    """Frames that make it leave the guided mode."""
    yaw: Literal["heading", "look", "ignored"] = "heading"
    """``heading``: the craft goes there, velocity is only speed. ``look``: it looks there and goes sideways."""
    attitude: Literal["speed", "depth", "stop"] = "speed"
    timeout_s: float = 3.0
    on_timeout: Literal["text", "silence", "leave"] = "text"
    heading_timeout_s: float = 5.0
    """Headings in a depth-holding mode."""
    positions_streamed: bool = False


class GcsRules(msgspec.Struct, frozen=True):
    """What happens when the heartbeats of the ground station stop."""

    enable: str
    """Parameter that enables it."""
    actions: tuple[tuple[int, str], ...]
    """Its values that do something, with a mode's name or ``disarm``."""
    timeout: str | None
    """Parameter with the seconds; None: 5."""
    extra_s: float
    lost_text: str
    back_text: str


class Family(msgspec.Struct, frozen=True, kw_only=True):
    """One family of autopilots and the craft it steers."""

    name: str
    vehicle_type: int
    autopilot: int
    version: tuple[int, int, int]
    modes: tuple[Mode, ...]
    first_mode: str
    boot_mode: str
    """Mode while it boots."""
    guided: str
    hold: str
    """What a pilot is thought to want when he takes over; also LOITER_UNLIM."""
    point: str
    boot: BootTimes
    loss: LossTimes
    setpoints: SetpointRules
    gcs: GcsRules | None
    parameters: tuple[tuple[str, str, float], ...]
    """Name, type (``i8 i16 i32 f32``), default."""
    bytewise: bool = False
    """Integer parameters travel as their bytes, not as their value."""
    streams: dict[str, float]
    """Messages sent without being asked, Hz."""
    rate_max_hz: float | None
    unknown_interval: int
    """MAV_RESULT for the interval of a message nobody knows."""
    ack_s: tuple[float, float]
    timesync_s: float
    timesync_asks_hz: float = 0.0
    reject_event: bool = False
    """Arming is refused by an EVENT without a text, and TEMPORARILY_REJECTED."""
    own_mode_encoding: bool = False
    """DO_SET_MODE takes main and sub mode."""
    reposition_long: bool = False
    change_speed: Literal["after_position", "accepted"] = "accepted"
    origin_moves: bool = False
    """Whether SET_GPS_GLOBAL_ORIGIN is obeyed again."""
    dives: bool = False
    gps_parameter: str
    """Set to other than `gps_good`, satellites are lost."""
    gps_good: int
    external_fix: tuple[tuple[str, int], ...] = ()
    """Parameters and values that make it take positions from messages instead of satellites, from boot."""
    external_messages: tuple[str, ...] = ()
    clock_ppm: float
    """How much its clock is fast."""
    vehicle: VehicleConfig
    speed_parameters: tuple[str, ...] = ()
    """Parameters that limit the speed, m/s."""
    speed_full_mps: float
    """What thrust 1 stands for."""
    wobble: tuple[float, float, float] = (1.0, 0.0, 1.0)
    """Speed got per speed asked: mean, amplitude, period in seconds."""

    def mode(self, number: int) -> Mode | None:
        """Find a mode by its ``custom_mode``."""
        return next((mode for mode in self.modes if mode.number == number), None)

    def named(self, name: str) -> Mode | None:
        """Find a mode by its name, in any case."""
        return next((mode for mode in self.modes if mode.name == name.upper()), None)

    def known(self, name: str) -> Mode:
        """Take a mode that the table is known to have."""
        found = self.named(name)
        if found is None:
            raise KeyError(name)
        return found


FamilyName = Annotated[Literal["rover", "sub", "px4"], msgspec.Meta(description="Which autopilot")]


def load_family(name: FamilyName) -> Family:
    """Take a family's table."""
    from importlib import import_module

    family: Family = import_module(f"grex_sim.autopilot.{name}").FAMILY
    return family
