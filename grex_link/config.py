"""The scenario: one TOML file, one frozen Struct, units in the field docs, bounds in the types.

Only what a field can say by itself is checked here; what needs the geometry of the mission is checked where that is
computed. Every fault is a `ConfigError` of one line that names the path.
"""

from typing import Annotated, Literal

from msgspec import Meta, field

from grex_link.config_base import Config, Finite, ImportPath, Name, NonNegative, Positive, Probability
from grex_link.coordination_config import PeriodicTalk, ReferenceConfig, TalkConfig
from grex_link.link_config import LinkConfig
from grex_link.ranging_config import BaseConfig, InertialConfig, RangingConfig
from grex_link.tasks import EventConfig, StandbyConfig, TaskingConfig, TaskList


class ClockConfig(Config, frozen=True):
    """How mission time passes."""

    tick_s: Annotated[float, Meta(ge=0.01, le=10.0)] = 1.0
    """Length of a step of the whole team, seconds."""
    pace: Literal["lockstep", "live"] | Annotated[float, Meta(gt=0.0, le=1000.0)] = "lockstep"
    """``lockstep``: as fast as possible, nothing lost; ``live``: wall clock; a number: so many times the wall clock."""
    start_timeout_s: Positive = 60.0
    """Wall seconds everybody has to appear on the bus."""
    barrier_timeout_s: Positive = 20.0
    """Lockstep: wall seconds a participant may be silent before it is named as hung."""
    chaos_delay_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    """Every process sleeps a random time up to this before each message: shows that order does not matter."""

    @property
    def lockstep(self) -> bool:
        """Whether the steps of the team, not the wall clock, carry mission time."""
        return self.pace == "lockstep"

    @property
    def factor(self) -> float:
        """Mission seconds per wall second at the live paces."""
        return 1.0 if isinstance(self.pace, str) else self.pace


class BusConfig(Config, frozen=True):
    """Where the participants meet."""

    endpoints: Annotated[
        tuple[Annotated[str, Meta(pattern=r"^(tcp|unixsock-stream)/.+\Z")], ...], Meta(max_length=4)
    ] = ()
    """Zenoh endpoints the simulator listens on and all others connect to.
    Empty: ``grex run`` takes a free local port; by hand it is ``tcp/127.0.0.1:7447``."""


class KalmanConfig(Config, frozen=True):
    """The paper's planar model of a mate (eqs. 6–11)."""

    velocity_transfer_per_s: Positive = 1.0
    """K_v, 1/s."""
    position_process_sigma_m: NonNegative = 0.02
    """Process noise of each position per second of model time, metres."""
    velocity_process_sigma_mps: NonNegative = 0.05
    """Process noise of each velocity per second of model time, m/s."""
    fix_sigma_m: Positive = 0.1
    """Noise of a mate's reported position, metres."""
    memory_s: Annotated[float, Meta(ge=10.0, le=3600.0)] = 300.0
    """How old a message may be and still be worked in, seconds."""


class SpeedModelConfig(Config, frozen=True):
    """How the mates are taken to keep their speed, for the estimators beside the paper's."""

    lag_s: NonNegative = 2.0
    """Time constant of a mate's surge, seconds."""
    acceleration_max_mps2: Positive = 0.2
    error_relative: Positive = 0.03
    """Standard deviation of a mate's speed error, as a share of the speed it orders."""
    error_time_s: Positive = 2400.0
    """Time constant with which that error changes, seconds."""
    noise_mps: NonNegative = 0.003
    """Process noise of a mate's speed over a second: what the model does not know of its orders, m/s."""
    told_sigma_mps: Positive = 0.03
    """Noise of the speed that a mate tells, m/s: it is that of a moment, and rounded."""
    surprise: Positive = 4.0
    """A told speed this many standard deviations off means that the error has changed at once."""


class OwnFilterConfig(Config, frozen=True):
    """The navigation filter of the own state; the surge loop is that of `speed_model`."""

    fix_sigma_min_m: Positive = 0.05
    """A fix is trusted no more than this, metres, whatever it claims."""
    speed_sigma_mps: Positive | None = None
    """Noise of the speed through the water that comes with a fix, m/s; left out: it is not used."""
    place_noise_m: NonNegative = 0.02
    """Process noise of each coordinate over a second, metres."""
    current_sigma_mps: Positive = 0.2
    """How far the current may be from the known one, m/s."""
    current_noise_mps: NonNegative = 0.0001
    """Process noise of the current over a second, m/s."""


class TeamConfig(Config, frozen=True):
    """The team as a whole and how it coordinates."""

    name: Name = "grex"
    """Second part of every key on the bus."""
    estimator: ImportPath = "second_level"
    """The ends of the scale: ``none``, ``ideal``. Baselines: ``hold_last``, ``dead_reckoning``. The paper's:
    ``first_level``, ``second_level``. With a speed error: ``biased_planar``, ``biased_planar_first``, ``along_track``
    (the best), ``along_track_first``. Or ``your_package.module:YourEstimator``."""
    controller: ImportPath = "theta_p"
    """``theta_p`` (eq. 2); with ``own_filter`` also ``theta_p_unbiased``, which removes the own speed error, and
    ``shared_reference``; or ``your_package.module:YourController``."""
    gain_mps: NonNegative = 0.8
    """K of eq. (2): m/s per unit of Θ."""
    speed_min_mps: NonNegative = 0.3
    """Lowest speed the controller may order (depth control needs some)."""
    speed_max_mps: Positive = 3.0
    """Highest speed the controller may order."""
    fix_timeout_s: Positive = 5.0
    """A fix older than this is stale: the craft holds until there is a new one."""
    separation_min_m: Positive | None = None
    """Whoever would come nearer than this to a mate ahead, metres, slows down as far as it has to, and never below
    ``speed_min_mps``. Left out: no guard."""
    bias_max_relative: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.15
    """The own speed error that is removed, as a share of the speed ordered, is at most this."""
    reference: ReferenceConfig = ReferenceConfig()
    talk: TalkConfig = PeriodicTalk()
    kalman: KalmanConfig = KalmanConfig()
    speed_model: SpeedModelConfig = SpeedModelConfig()
    own_filter: OwnFilterConfig | None = None
    """Filter the own fixes; control and messages then have the filtered position. Left out: fixes are taken as is."""
    ranging: RangingConfig = RangingConfig()


class GuidanceConfig(Config, frozen=True):
    """Track keeping (P) and keeping of a place (P)."""

    cross_track_gain_rad_per_m: NonNegative = 0.05
    correction_max_rad: Annotated[float, Meta(ge=0.0, le=1.5)] = 0.8
    curvature_feedforward: NonNegative = 1.0
    """Share of the heading loop's lag that is led on arcs."""
    heading_lag_s: NonNegative = 2.0
    """Time constant of the heading loop that the feed-forward assumes, seconds."""
    distance_gain_per_s: NonNegative = 0.1
    """Speed towards a place per metre of distance, 1/s."""
    arrival_radius_m: Positive = 2.0
    """Within this distance a place is kept by stopping."""


class Lawnmower(Config, frozen=True, tag="lawnmower"):
    """The coordinated lawnmower: parallel legs joined by half circles, turned as a rigid body."""

    formation_m: dict[Name, tuple[Finite, Finite, Finite]]
    """For each craft its place in the formation: ahead, starboard, below the reference point, metres."""
    legs: Annotated[int, Meta(ge=1, le=200)] = 8
    leg_length_m: Positive = 400.0
    turn_radius_m: Positive = 65.0
    """Radius of the reference point's half circles."""
    speed_mps: Positive = 1.0
    """Planned speed over ground of the reference point."""
    heading_deg: Annotated[float, Meta(ge=-360.0, le=360.0)] = 0.0
    """Direction of the first leg, clockwise from north."""
    start_ned_m: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    """Where the reference point begins."""
    first_turn: Literal["starboard", "port"] = "starboard"
    at_end: Literal["continue", "hold"] = "continue"
    """After the last track: go straight on, or stay at its end."""


class LineConfig(Config, frozen=True, tag="line"):
    """A straight track from where the last one ended."""

    to_ned_m: tuple[Finite, Finite, Finite]
    speed_mps: Positive


class ArcConfig(Config, frozen=True, tag="arc"):
    """A track on a circle about a centre, from where the last one ended."""

    centre_ne_m: tuple[Finite, Finite]
    turn_deg: Annotated[float, Meta(ge=-350.0, le=350.0)]
    """Positive to starboard."""
    speed_mps: Positive


class TrackList(Config, frozen=True):
    """One craft's explicit tracks."""

    start_ned_m: tuple[Finite, Finite, Finite]
    tracks: Annotated[tuple[LineConfig | ArcConfig, ...], Meta(min_length=1, max_length=255)]


class Tracks(Config, frozen=True, tag="tracks"):
    """Explicit tracks; every craft has the same number, and a track takes all of them equally long."""

    craft: dict[Name, TrackList]
    at_end: Literal["continue", "hold"] = "continue"


class SeaConfig(Config, frozen=True):
    """What the water does to the craft."""

    current_ned_mps: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    """The true current."""
    known_current_ned_mps: tuple[Finite, Finite, Finite] | None = None
    """The current the craft compensate; the true one if left out."""


class Loop(Config, frozen=True):
    """A first-order lag with limits on value and rate (paper, Fig. 5); units are those of the state."""

    lag_s: NonNegative
    min: Finite
    max: Finite
    rate_max: Positive
    """Largest change a second."""


class SpeedWander(Config, frozen=True):
    """A speed error that wanders about zero: an Ornstein–Uhlenbeck process, stationary from the start on."""

    sigma_relative: Annotated[float, Meta(ge=0.0, le=0.5)]
    """Standard deviation, as a share of the speed ordered."""
    time_s: Positive = 60.0
    """Time constant, seconds."""


class SpeedLimit(Config, frozen=True):
    """A time in which a craft cannot go faster."""

    start_s: NonNegative
    end_s: NonNegative
    max_mps: NonNegative
    """Greatest surge, m/s."""


class VehicleConfig(Config, frozen=True):
    """A simulated craft: four loops, a depth controller and what is wrong with its thrusters."""

    roll: Loop = Loop(lag_s=1.0, min=-0.5, max=0.5, rate_max=0.5)
    pitch: Loop = Loop(lag_s=1.5, min=-0.5, max=0.5, rate_max=0.2)
    heading: Loop = Loop(lag_s=2.0, min=-1e9, max=1e9, rate_max=0.35)
    """Its value limits are meaningless and ignored; the heading wraps."""
    surge: Loop = Loop(lag_s=2.0, min=0.3, max=3.0, rate_max=0.2)
    depth_gain_rad_per_m: NonNegative = 0.05
    """Pitch ordered per metre of depth error."""
    speed_error_relative: Annotated[float, Meta(ge=-0.9, le=2.0)] = 0.0
    """The surge actuator gives (1 + this) times what is ordered."""
    speed_error_mps: Finite = 0.0
    """And this much more."""
    speed_wander: SpeedWander | None = None
    """An error besides, which wanders."""
    speed_limits: Annotated[tuple[SpeedLimit, ...], Meta(max_length=100)] = ()
    """Times in which the craft cannot go as fast as it should."""


class NavigationConfig(Config, frozen=True):
    """Error of a craft's own navigation: offset, white noise, and an error that grows (paper, Fig. 4)."""

    offset_ned_m: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    white_m: NonNegative = 0.0
    """Standard deviation of white noise on north and east each, metres."""
    drift_ned_mps: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)


class SimFrontseat(Config, frozen=True, tag="sim"):
    """The craft is a simulated one."""


class MavlinkFrontseat(Config, frozen=True, tag="mavlink"):
    """The craft is steered by an autopilot that speaks MAVLink; only at the paces of the wall clock."""

    url: Annotated[str, Meta(min_length=1, max_length=200)]
    """``udpin:host:port``, ``udpout:host:port``, ``tcp:host:port`` or ``serial:/dev/tty…:baud``."""
    system: Annotated[int, Meta(ge=1, le=255)] | None = None
    """System id of the autopilot; left out: the first that is heard."""
    family: Literal["auto", "rover", "sub", "px4"] = "auto"
    """How it wants its set-points; ``auto``: by its heartbeat."""
    own_system: Annotated[int, Meta(ge=1, le=255)] = 255
    own_component: Annotated[int, Meta(ge=1, le=255)] = 191
    arm: bool = False
    """Whether the adapter may change the mode and arm; otherwise a person does."""
    setpoint_rate_hz: Annotated[float, Meta(ge=1.0, le=20.0)] = 5.0
    setpoint_age_max_s: Positive = 2.0
    """An agent silent for longer is stale: the craft is handed back to its autopilot, holding."""
    feed: Literal["none", "gps_input", "vision"] = "none"
    """Whether the agent's navigation is fed into the autopilot, for a craft without GPS."""
    signing_key_file: str | None = None
    """File with the 32 bytes, in hexadecimal, of a MAVLink 2 signing key."""


class DatumConfig(Config, frozen=True):
    """Where on earth the mission frame has its origin (WGS 84)."""

    latitude_deg: Annotated[float, Meta(ge=-85.0, le=85.0)]
    longitude_deg: Annotated[float, Meta(ge=-180.0, le=180.0)]


class EmulatedModem(Config, frozen=True, tag="emulated"):
    """The modem is the emulator."""


class SerialModem(Config, frozen=True, tag="serial"):
    """A real modem on a serial port; only at the paces of the wall clock."""

    port: Annotated[str, Meta(min_length=1)]
    """Device, for instance ``/dev/ttyUSB0``."""
    driver: Literal["micromodem"] = "micromodem"
    """``micromodem``: the NMEA interface of the WHOI Micro-Modem."""
    baud: Annotated[int, Meta(ge=300, le=4_000_000)] = 19200
    address: Annotated[int, Meta(ge=0, le=255)] | None = None
    """Its address on the air; left out: the craft's place in the team."""


class CraftClockConfig(Config, frozen=True):
    """Error of a craft's clock: local time = true time + offset + drift · (time since it was set)."""

    offset_s: Annotated[float, Meta(ge=-3600.0, le=3600.0)] = 0.0
    drift_ppm: Annotated[float, Meta(ge=-1000.0, le=1000.0)] = 0.0
    gps_at_surface: bool = False
    """Whether GPS sets it, without error, whenever the craft is at the surface."""
    surface_depth_m: NonNegative = 0.5
    """Above this depth it is at the surface."""


class SelfNoiseConfig(Config, frozen=True):
    """Noise of the craft itself at its own modem, within the band: level + slope · speed."""

    level_db: Annotated[float, Meta(ge=0.0, le=200.0)]
    """dB re 1 µPa."""
    slope_db_per_mps: NonNegative = 0.0


class CraftConfig(Config, frozen=True):
    """One craft of the team."""

    frontseat: SimFrontseat | MavlinkFrontseat = SimFrontseat()
    modem: EmulatedModem | SerialModem = EmulatedModem()
    clock: CraftClockConfig = CraftClockConfig()
    self_noise: SelfNoiseConfig | None = None
    vehicle: VehicleConfig = VehicleConfig()
    navigation: NavigationConfig = NavigationConfig()
    inertial: InertialConfig | None = None
    """The craft's navigation is inertial, and its own filter models that; left out: it is absolute."""
    base: BaseConfig | None = None
    """It is no craft but a modem at a fixed place."""
    tasks: TaskList = ()
    """What it does from the start on, one after another; then what it is for."""


class RecordingConfig(Config, frozen=True):
    """What is recorded of a run."""

    on_full_disk: Literal["stop", "go_on"] = "stop"
    """``stop``: the run breaks off, saying so; ``go_on``: it goes on unrecorded, saying so. What was written opens."""


class ScoreConfig(Config, frozen=True):
    """Weights of the formation deviation (eq. 5)."""

    distance: Probability = 1.0
    angle: Probability = 1.0
    xte: Probability = 1.0


class Scenario(Config, frozen=True, kw_only=True):
    """Everything a run depends on."""

    title: str = ""
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 1
    duration_s: Positive | None = None
    """Length of the run; the mission's planned duration if left out."""
    clock: ClockConfig = ClockConfig()
    bus: BusConfig = BusConfig()
    team: TeamConfig = TeamConfig()
    guidance: GuidanceConfig = GuidanceConfig()
    datum: DatumConfig | None = None
    """Needed for craft on MAVLink."""
    mission: Lawnmower | Tracks
    link: LinkConfig = LinkConfig()
    sea: SeaConfig = SeaConfig()
    score: ScoreConfig = ScoreConfig()
    recording: RecordingConfig = RecordingConfig()
    standby: dict[Name, StandbyConfig] = field(default_factory=dict)
    """Craft without a part in the mission; see `grex_link.tasks`."""
    events: Annotated[tuple[EventConfig, ...], Meta(max_length=100)] = ()
    tasking: TaskingConfig = TaskingConfig()
    craft: Annotated[dict[Name, CraftConfig], Meta(min_length=1, max_length=200)]
    """The team, in the order of the formation polygon: lines between neighbours do not cross (paper, Fig. 3)."""

    @property
    def formation(self) -> list[str]:
        """Craft that have a part in the mission, in the order of the team: no bases, and nobody who stands by."""
        return [craft for craft, config in self.craft.items() if config.base is None and craft not in self.standby]

    @property
    def bases(self) -> dict[str, BaseConfig]:
        """Modems at fixed places."""
        return {craft: config.base for craft, config in self.craft.items() if config.base is not None}

    @property
    def speakers(self) -> list[str]:
        """Who speaks under water by itself: a base only where it asks for ranges, in the order of the team."""
        asking = self.team.ranging.mode == "two_way"
        return [craft for craft, config in self.craft.items() if config.base is None or asking]

    @property
    def link_seed(self) -> int:
        """Seed of the link's draws."""
        return self.seed if self.link.seed is None else self.link.seed

    @property
    def serial_craft(self) -> list[str]:
        """Craft whose modem is a real one on a serial port: their sound is not in the emulated water."""
        return [craft for craft, config in self.craft.items() if isinstance(config.modem, SerialModem)]

    @property
    def operators_craft(self) -> str:
        """Craft on which the operator is: as given, else the first with radio, else with cable, else the first."""
        if self.tasking.operator is not None:
            return self.tasking.operator
        for kind in ("radio", "cable"):
            tied = {craft for land in self.link.land if land.kind == kind for craft in land.between}
            if found := [craft for craft in self.craft if craft in tied]:
                return found[0]
        return next(iter(self.craft))

    @property
    def mavlink_craft(self) -> dict[str, MavlinkFrontseat]:
        """Craft that are steered by an autopilot: the sea does not move them."""
        frontseats = {craft: config.frontseat for craft, config in self.craft.items()}
        return {craft: each for craft, each in frontseats.items() if isinstance(each, MavlinkFrontseat)}
