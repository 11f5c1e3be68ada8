"""What a modem comes to in a use: airtime, signal, slots and age of information, and what of it is assumed."""

from dataclasses import dataclass

import msgspec

from grex_link.acoustics import Water
from grex_link.link_config import Tdma, WaterConfig
from grex_link.profile import ModemProfile, Protocol
from grex_link.reception import Reception
from grex_link.tdma import SlotNeeds, slowest_sound_mps

#: What the numbers of a row rest on: the field's symbol, and the fields of a profile.
BASES = {
    "n": ("payload_max_bytes", "payload_max_bits"),
    "T": ("airtime_fixed_s", "airtime_per_byte_s", "frame_bytes"),
    "L": ("transmit_latency_s", "decode_latency_s", "turnaround_s"),
    "B": ("frequency_hz", "bandwidth_hz", "noise_psd_db", "spreading"),
    "SL": ("source_level_db",),
    "PER": ("reception", "range_pdr", "range_max_m", "acquisition_sinr_db"),
}


@dataclass(frozen=True, slots=True)
class Use:
    """What a modem is wanted for.

    Attributes
    ----------
    payload_bytes : int
        Length of a message.
    range_m : float
        Distance of the craft that are farthest apart.
    craft : int
        Size of the team.
    """

    payload_bytes: int = 15
    range_m: float = 500.0
    craft: int = 3


class Figures(msgspec.Struct, frozen=True, kw_only=True):
    """What a modem comes to in a use; None for what it cannot do or does not have."""

    name: str
    title: str
    payload_max_bytes: int
    payload_max_bits: int
    airtime_s: float | None
    """Of the payload; None if it does not fit."""
    snr_db: float | None
    """At the range, in a scenario's water without changes; None for a modem whose profile has no levels."""
    delivery: float
    """Share of packets heard at the range with nobody else speaking."""
    guard_s: float | None
    slot_s: float | None
    cycle_s: float | None
    age_s: float | None
    """Mean age of information; None for a modem that cannot serve the team, or is not heard."""
    ranging: list[str]
    lacks: list[str]
    """Why it cannot serve the team."""
    assumed: list[str]
    """Fields of the profile that these figures rest on, and nobody has published."""


def figures(name: str, profile: ModemProfile, use: Use) -> Figures:
    """Compute what a modem comes to in a use, in a scenario's water and TDMA without changes.

    Parameters
    ----------
    name : str
        What to call it.
    profile : ModemProfile
        The modem.
    use : Use
        Payload, range and team.
    """
    snr_db = _snr_db(profile, use.range_m)
    delivery, lacks = _delivery(profile, snr_db, use), _lacks(profile, use)
    fits = use.payload_bytes <= profile.payload_max_bytes
    needs = _slot_needs(profile, use)
    slot_s = None if lacks else needs.slot_s(needs.guard_s)
    cycle_s = None if slot_s is None else slot_s * use.craft
    # Without levels nothing rests on them.
    unused = {"", "SL", "B"} if snr_db is None else {""}
    return Figures(
        name=name,
        title=profile.title,
        payload_max_bytes=profile.payload_max_bytes,
        payload_max_bits=profile.bits_max,
        airtime_s=needs.speaking_s if fits else None,
        snr_db=snr_db,
        delivery=delivery,
        guard_s=None if lacks else needs.guard_s,
        slot_s=slot_s,
        cycle_s=cycle_s,
        age_s=None if cycle_s is None or not delivery else _age_s(needs, cycle_s, delivery),
        ranging=[kind for kind, able in _kinds(profile) if able],
        lacks=lacks,
        assumed=[field for field in profile.assumed if base_of(field) not in unused],
    )


def base_of(field: str) -> str:
    """Symbol of what a field of a profile, with a dotted name perhaps, is a base of; "" if of nothing here."""
    top = field.partition(".")[0]
    return next((symbol for symbol, tops in BASES.items() if top in tops), "")


def _slot_needs(profile: ModemProfile, use: Use) -> SlotNeeds:
    mac = Tdma()
    return SlotNeeds(
        profile=profile,
        message_bytes=use.payload_bytes,
        planned_m=use.range_m,
        reach_m=use.range_m,
        clock_error_s=mac.clock_error_s,
        jitter_s=mac.jitter_s,
        sound_speed_mps=slowest_sound_mps(WaterConfig()),
    )


def _age_s(needs: SlotNeeds, cycle_s: float, delivery: float) -> float:
    """Mean age of a state that is sampled when a slot opens (acoustic-link §6), with the modems' own latencies."""
    modem = needs.profile
    known_s = modem.transmit_latency_s + needs.speaking_s + needs.delay_s + modem.decode_latency_s
    return known_s + cycle_s * (1.0 / delivery - 0.5)


def _snr_db(profile: ModemProfile, range_m: float) -> float | None:
    level_db, frequency_hz, bandwidth_hz = profile.source_level_db, profile.frequency_hz, profile.bandwidth_hz
    if level_db is None or frequency_hz is None or bandwidth_hz is None or isinstance(profile.reception, Protocol):
        return None
    here = Water(
        WaterConfig(), frequency_hz, bandwidth_hz, spreading=profile.spreading, noise_psd_db=profile.noise_psd_db
    )
    return level_db - float(here.loss_db(range_m)) - here.noise_db


def _delivery(profile: ModemProfile, snr_db: float | None, use: Use) -> float:
    if profile.range_max_m is not None and use.range_m > profile.range_max_m:
        return 0.0
    if isinstance(model := profile.reception, Protocol):
        near = use.range_m <= min(model.communication_m, model.detection_m)
        return model.detection * model.communication if near else 0.0
    if snr_db is None:
        return 1.0
    if snr_db <= profile.lock_sinr_db:
        return 0.0
    reception = Reception(profile)
    return (1.0 - reception.packet_error_rate(snr_db, use.payload_bytes)) * reception.range_delivery(use.range_m)


def _lacks(profile: ModemProfile, use: Use) -> list[str]:
    lacks = []
    if use.payload_bytes > profile.payload_max_bytes:
        lacks.append("payload too long")
    if not profile.broadcast and use.craft > 2:
        lacks.append("no broadcast")
    if profile.addresses_max is not None and use.craft > profile.addresses_max:
        lacks.append(f"only {profile.addresses_max} addresses")
    return lacks


def _kinds(profile: ModemProfile) -> tuple[tuple[str, bool], ...]:
    return ("two-way", profile.ranging.two_way), ("one-way", profile.ranging.one_way)
