"""The scenario's ``[link]``: the water between the craft, who may speak when, and what goes wrong."""

from typing import Annotated, Literal

from msgspec import Meta

from grex_link.config_base import Config, Finite, Name, NonNegative, Positive, Probability

SoundSpeed = Annotated[float, Meta(ge=1000.0, le=2000.0)]


class SlotConfig(Config, frozen=True):
    """One slot of the TDMA cycle."""

    craft: Name
    start_s: NonNegative
    length_s: Positive


class Tdma(Config, frozen=True, tag="tdma"):
    """Every craft speaks in slots of its own, in a cycle that is counted from mission time zero."""

    slots: tuple[SlotConfig, ...] = ()
    """The slots; empty: one for each craft in turn, as long as its messages and the guard need."""
    cycle_s: Positive | None = None
    """Length of the cycle; the end of the last slot if left out."""
    guard_s: NonNegative | None = None
    """Silence after the messages of a slot; left out: what geometry, clocks and modem need."""
    range_max_m: Positive | None = None
    """Longest distance the guard is for; left out: that of the planned mission, half as much again, and 50 m."""
    clock_error_s: NonNegative = 0.01
    """How far a craft's clock may be off, for the guard."""
    jitter_s: NonNegative = 0.01
    """How late a modem may begin, for the guard."""
    messages_per_slot: Annotated[int, Meta(ge=1, le=100)] = 1


class SlottedAloha(Config, frozen=True, tag="slotted_aloha"):
    """In every slot every craft speaks with some probability."""

    probability: Annotated[float, Meta(gt=0.0, le=1.0)]
    slot_s: Positive | None = None
    """Left out: as long as a message and the guard of a TDMA slot."""


class PureAloha(Config, frozen=True, tag="aloha"):
    """Every craft speaks at random times, on average so often a second (Poisson)."""

    rate_per_s: Positive


class WenzNoise(Config, frozen=True, tag="wenz", tag_field="model"):
    """Ambient noise of the sea after Wenz and Coates."""

    wind_mps: Annotated[float, Meta(ge=0.0, le=60.0)] = 5.0
    shipping: Probability = 0.5


class FixedNoise(Config, frozen=True, tag="fixed", tag_field="model"):
    """Ambient noise of one spectrum level."""

    psd_db: Annotated[float, Meta(ge=-100.0, le=200.0)]
    """dB re 1 µPa²/Hz."""


class WaterConfig(Config, frozen=True):
    """What sound meets on its way."""

    sound_speed: SoundSpeed | Literal["mackenzie"] = 1500.0
    """The true speed of sound, m/s; or computed from temperature, salinity and depth."""
    layers: Annotated[
        tuple[tuple[Finite, Annotated[float, Meta(ge=1000.0, le=2000.0)]], ...], Meta(max_length=100)
    ] = ()
    """Or a profile: (depth m, speed m/s) from above to below, linear between; overrides ``sound_speed``."""
    nominal_sound_speed_mps: SoundSpeed = 1500.0
    """What modems and agents reckon with, because they do not know the true one."""
    temperature_c: Annotated[float, Meta(ge=-4.0, le=45.0)] = 10.0
    salinity_ppt: Annotated[float, Meta(ge=0.0, le=45.0)] = 35.0
    ph: Annotated[float, Meta(ge=5.0, le=9.0)] = 8.0
    absorption: Literal["ainslie_mccolm", "thorp"] = "ainslie_mccolm"
    spreading: Annotated[float, Meta(ge=1.0, le=2.0)] = 1.5
    """Exponent k of the transmission loss k·10·log10 r: 1.5 practical, 2 spherical."""
    noise: WenzNoise | FixedNoise = WenzNoise()


class BurstConfig(Config, frozen=True):
    """Gilbert–Elliott losses in time, for each directed link: a good and a bad state that take turns."""

    loss: Probability
    """Mean share of packets lost."""
    mean_length_s: Positive
    """Mean length of a bad time."""
    step_s: Positive = 1.0
    """Step of the chain."""
    loss_good: Probability = 0.0
    loss_bad: Probability = 1.0


class ShadowingConfig(Config, frozen=True):
    """Slow change of the level on every path, the same both ways (first-order autoregressive)."""

    sigma_db: NonNegative
    correlation_s: Positive = 120.0


class JammerConfig(Config, frozen=True):
    """A source of noise in the band for some time."""

    position_ned_m: tuple[Finite, Finite, Finite]
    source_level_db: Annotated[float, Meta(ge=0.0, le=250.0)]
    """dB re 1 µPa at 1 m, within the band."""
    start_s: NonNegative = 0.0
    end_s: Positive = 1e9


class OutageConfig(Config, frozen=True):
    """A time in which one craft's modem is off; it comes back as after a reboot."""

    craft: Name
    start_s: NonNegative
    end_s: Positive


class LandConfig(Config, frozen=True):
    """A link between two craft that is not under water: as often as it is given, each tells the other its state."""

    between: tuple[Name, Name]
    kind: Literal["cable", "radio"] = "radio"
    length_m: Positive | None = None
    """Of a cable: the two craft keep within it. Left out: long enough."""
    every_s: Positive = 1.0
    latency_s: NonNegative = 0.05
    rate_bps: Positive = 1e6
    loss: Probability = 0.0


class RangingErrors(Config, frozen=True):
    """What is wrong with measured ranges besides the modem's own noise."""

    outlier_probability: Probability = 0.0
    outlier_m: NonNegative = 50.0
    """Longest extra path of an outlier; it is drawn evenly up to this."""


class LinkConfig(Config, frozen=True):
    """The water between the craft, and who may speak when."""

    profile: Annotated[str, Meta(pattern=r"^[^\r\n]+\Z", max_length=200)] = "grex2008"
    """Name of a modem profile, or path of your own ``file.toml``."""
    loss: Probability = 0.0
    """Probability that a datagram is lost on the way to one receiver, besides all else."""
    seed: Annotated[int, Meta(ge=0)] | None = None
    """Seed of the link's draws; the scenario's seed if left out."""
    message: Literal["auto", "full", "short", "tiny"] = "auto"
    """Form of the team state on the air; ``auto``: the fullest that the modem carries."""
    mac: Tdma | SlottedAloha | PureAloha = Tdma()
    water: WaterConfig = WaterConfig()
    burst: BurstConfig | None = None
    shadowing: ShadowingConfig | None = None
    jammers: Annotated[tuple[JammerConfig, ...], Meta(max_length=20)] = ()
    outages: Annotated[tuple[OutageConfig, ...], Meta(max_length=100)] = ()
    land: Annotated[tuple[LandConfig, ...], Meta(max_length=100)] = ()
    ranging: RangingErrors = RangingErrors()
    ledger_s: Positive = 60.0
    """How often counters go out on the bus; they always do at the end."""
