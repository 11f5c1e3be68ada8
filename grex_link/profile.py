"""Modem profiles: data, one TOML file a modem. A user's own file needs no code: ``link.profile = "my_modem.toml"``."""

import tomllib
from collections.abc import Sequence
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from grex_link.errors import ConfigError
from grex_link.units import NS

Decibel = Annotated[float, Meta(ge=-300.0, le=300.0)]
Positive = Annotated[float, Meta(gt=0.0, le=1e9)]
NonNegative = Annotated[float, Meta(ge=0.0, le=1e9)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Points = Annotated[tuple[Annotated[float, Meta(ge=-1e9, le=1e9)], ...], Meta(min_length=1, max_length=100)]
Shares = Annotated[tuple[Share, ...], Meta(min_length=1, max_length=100)]


class Data(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of a profile's tables."""


class Threshold(Data, frozen=True, tag="threshold"):
    """A packet is whole if its lowest SINR is not below a threshold."""

    sinr_db: Decibel


class ErrorTable(Data, frozen=True, tag="table"):
    """Packet error rate over SINR, linear between the points, held beyond them."""

    sinr_db: Points
    per: Shares
    """Does not rise from point to point."""
    frame_bytes: Annotated[int, Meta(ge=1)] | None = None
    """The rate is that of one frame of this length, and a payload needs all its frames; left out: of a packet."""

    def __post_init__(self) -> None:
        """Check the points."""
        _check_table("sinr_db", self.sinr_db, "per", self.per)
        _check_order("per", [-share for share in self.per], "rise")


class BitErrors(Data, frozen=True, tag="bit_errors"):
    """Packet error rate 1 - (1 - BER)^(8 n) of a modulation without coding, at SINR plus a processing gain."""

    modulation: Literal["bpsk", "dpsk", "fsk"]
    """``bpsk``: BER = erfc(√s)/2; ``dpsk``: e^(-s)/2; ``fsk``, non-coherent: e^(-s/2)/2."""
    gain_db: Decibel = 0.0


class Protocol(Data, frozen=True, tag="protocol"):
    """UnetStack's protocol model: who is near enough hears, unless anybody within interference range speaks, too."""

    communication_m: Positive
    detection_m: Positive
    interference_m: Positive
    detection: Share = 1.0
    """Chance that a packet within detection range is detected."""
    communication: Share = 1.0
    """Chance that a detected packet within communication range is whole."""


class RangeTable(Data, frozen=True):
    """Share of packets that arrive over range, measured with all that the water did; 0 beyond the last point."""

    range_m: Points
    pdr: Shares

    def __post_init__(self) -> None:
        """Check the points."""
        _check_table("range_m", self.range_m, "pdr", self.pdr)


class InterferenceTable(Data, frozen=True):
    """Share of packets that survive over the ratio of signal to interference alone."""

    sir_db: Points
    pdr: Shares
    """Does not fall from point to point."""

    def __post_init__(self) -> None:
        """Check the points."""
        _check_table("sir_db", self.sir_db, "pdr", self.pdr)
        _check_order("pdr", self.pdr, "fall")


class Ranging(Data, frozen=True):
    """What a modem can measure of the distance to another."""

    two_way: bool = False
    one_way: bool = False
    """Needs clocks that agree; measured with every reception."""
    ambiguity_s: NonNegative = 0.0
    """One-way travel times are known modulo this; 0 for no ambiguity."""
    sigma_m: NonNegative = 0.1
    """Standard deviation of a range."""
    step_m: NonNegative = 0.0
    """Least significant bit of a range; 0 for none."""
    reply_s: NonNegative = 0.0
    """Time the other modem takes before it answers; both know it."""
    ping_bytes: Annotated[int, Meta(ge=0)] = 0
    """Length of a ping and of its answer, as far as the airtime goes."""
    ping_airtime_s: Annotated[float, Meta(gt=0.0, le=1e4)] | None = None
    """Airtime of a ping, its answer, or an acknowledgement; left out: that of a payload of that length."""


class ModemProfile(Data, frozen=True, kw_only=True):
    """What a modem can do. ``assumed`` names the numbers nobody has published.

    The paper's modem has no acoustics (``source_level_db`` is left out): its messages take their time, whatever the
    distance, and one craft speaks at a time.
    """

    title: str
    payload_max_bytes: Annotated[int, Meta(ge=1, le=65535)]
    payload_max_bits: Annotated[int, Meta(ge=1)] | None = None
    """Where it is no whole number of bytes."""
    frame_bytes: Annotated[int, Meta(ge=1)] | None = None
    """Payloads are padded to whole frames of this length."""
    airtime_fixed_s: Annotated[float, Meta(gt=0.0, le=1e4)]
    airtime_per_byte_s: Annotated[float, Meta(ge=0.0, le=1e3)]
    one_speaker_at_a_time: bool = False
    broadcast: bool = True
    acknowledges: bool = False
    """Whether it can ask the receiver of a unicast for an acknowledgement."""
    addresses_max: Annotated[int, Meta(ge=2)] | None = None
    """How many modems can have an address."""
    transmit_latency_s: NonNegative = 0.0
    """From the request until the sound begins."""
    decode_latency_s: NonNegative = 0.0
    """From the end of the sound until the payload is out."""
    turnaround_s: NonNegative = 0.0
    """After its own transmission it is deaf this much longer."""
    frequency_hz: Positive | None = None
    """Centre of the band."""
    bandwidth_hz: Positive | None = None
    source_level_db: Decibel | None = None
    """dB re 1 µPa at 1 m."""
    acquisition_sinr_db: Decibel | None = None
    """Above this a receiver locks; left out: where the error figures begin to be less than certain loss."""
    reception: Threshold | ErrorTable | BitErrors | Protocol | None = None
    range_pdr: RangeTable | None = None
    interference_pdr: InterferenceTable | None = None
    range_max_m: Positive | None = None
    """Beyond this nothing is heard, whatever the SINR."""
    noise_psd_db: Decibel | None = None
    """A noise spectrum level the profile is defined with; left out: the scenario's sea."""
    spreading: Annotated[float, Meta(ge=1.0, le=2.0)] | None = None
    """A spreading exponent the profile is defined with; left out: the scenario's."""
    rician_k: NonNegative | None = None
    """Ratio of the steady to the scattered power, packet by packet; left out: no fading."""
    ranging: Ranging = Ranging()
    sources: list[str]
    assumed: list[str]

    def __post_init__(self) -> None:
        """Check what one field says about another."""
        acoustic = (self.frequency_hz, self.bandwidth_hz, self.source_level_db, self.reception)
        if self.one_speaker_at_a_time:
            if any(value is not None for value in acoustic):
                raise ValueError("a modem of which one speaks at a time has no acoustics")
        elif any(value is None for value in acoustic):
            raise ValueError("frequency_hz, bandwidth_hz, source_level_db and reception are needed")
        for name in self.assumed:
            if not _has(self, name):
                raise ValueError(f"assumed names {name!r}, which is no field of this profile")

    @property
    def bits_max(self) -> int:
        """Bits of the longest payload."""
        return self.payload_max_bits or 8 * self.payload_max_bytes

    def airtime_ns(self, size_bytes: int) -> int:
        """Time on the air of a payload, nanoseconds."""
        frame = self.frame_bytes
        padded = size_bytes if frame is None else -(-max(size_bytes, 1) // frame) * frame
        return round((self.airtime_fixed_s + self.airtime_per_byte_s * padded) * NS)

    @property
    def ping_airtime_ns(self) -> int:
        """Time on the air of a ping, its answer, or an acknowledgement, nanoseconds."""
        ping_s = self.ranging.ping_airtime_s
        return self.airtime_ns(self.ranging.ping_bytes) if ping_s is None else round(ping_s * NS)

    @property
    def lock_sinr_db(self) -> float:
        """SINR above which a receiver locks."""
        if self.acquisition_sinr_db is not None:
            return self.acquisition_sinr_db
        reception = self.reception
        if isinstance(reception, Threshold):
            return reception.sinr_db
        if isinstance(reception, BitErrors):
            return -reception.gain_db
        return reception.sinr_db[0] if isinstance(reception, ErrorTable) else 0.0


def profile_names() -> list[str]:
    """Names of the profiles that come with GREX."""
    entries = (files("grex_link") / "modems").iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml"))


def own_profile(name: str) -> Path | None:
    """File of a user's own profile; None for one that comes with GREX."""
    return Path(name) if name.endswith(".toml") else None


def load_profile(name: str) -> ModemProfile:
    """Read a profile by name, or from a user's own file.

    Parameters
    ----------
    name : str
        One of `profile_names`, or the path of a file that ends in ``.toml``.

    Raises
    ------
    ConfigError
        If there is none of that name, or it is not sound.
    """
    own = own_profile(name)
    path = own or files("grex_link") / "modems" / f"{name}.toml"
    if own is None and name not in profile_names():
        known = ", ".join(profile_names())
        raise ConfigError(
            "$.link.profile",
            f"there is no modem profile {name!r}; there are: {known}; or give the path of your own file.toml",
        )
    try:
        return msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), ModemProfile)
    except OSError as error:
        raise ConfigError("$.link.profile", f"cannot read {name}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        problem = " ".join(str(error).split())
        raise ConfigError("$.link.profile", f"{name} is no modem profile: {problem}") from None


def _has(table: object, dotted: str) -> bool:
    """Whether a table has a field that is given, with the name of the table in it before a dot."""
    field, _, rest = dotted.partition(".")
    value = getattr(table, field, None) if field in getattr(table, "__struct_fields__", ()) else None
    return value is not None and (not rest or _has(value, rest))


def _check_table(name: str, places: Points, other: str, values: Shares) -> None:
    if len(places) != len(values):
        raise ValueError(f"{name} has {len(places)} points and {other} {len(values)}")
    if any(later <= earlier for earlier, later in pairwise(places)):
        raise ValueError(f"{name} must increase from point to point")


def _check_order(name: str, values: Sequence[float], never: str) -> None:
    if any(later < earlier for earlier, later in pairwise(values)):
        raise ValueError(f"{name} must not {never} from point to point")
