"""Energy of what is said under water: source level times airtime."""

from grex_link.profile import ModemProfile

#: Source level of one watt of sound from a source that radiates evenly, dB re 1 µPa at 1 m: p²·4π·r² / (ρ·c) at
#: 1000 kg/m³ and 1500 m/s.
WATT_DB = 170.8


def sound_power_w(source_level_db: float) -> float:
    """Acoustic power of a source level (dB re 1 µPa at 1 m), watts; a source that does not radiate evenly has less."""
    power: float = 10.0 ** ((source_level_db - WATT_DB) / 10.0)
    return power


def sound_energy_j(profile: ModemProfile, airtime_s: float) -> float | None:
    """Acoustic energy of what a modem says for so long, joules; None if its profile has no source level.

    What its amplifier takes from the battery is more, several times as a rule, and no profile gives it.
    """
    return None if profile.source_level_db is None else sound_power_w(profile.source_level_db) * airtime_s
