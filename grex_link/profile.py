"""Modem profiles: data, one TOML file a modem."""

import tomllib
from importlib.resources import files
from typing import Annotated

import msgspec
from msgspec import Meta

from grex_link.errors import ConfigError
from grex_link.units import NS


class ModemProfile(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What a modem can do. ``assumed`` names the numbers nobody has published."""

    title: str
    payload_max_bytes: Annotated[int, Meta(ge=1)]
    airtime_fixed_s: Annotated[float, Meta(gt=0.0)]
    airtime_per_byte_s: Annotated[float, Meta(ge=0.0)]
    one_speaker_at_a_time: bool
    sources: list[str]
    assumed: list[str]

    def airtime_ns(self, size_bytes: int) -> int:
        """Time on the air of a payload, nanoseconds."""
        return round((self.airtime_fixed_s + self.airtime_per_byte_s * size_bytes) * NS)


def load_profile(name: str) -> ModemProfile:
    """Read a profile by name.

    Raises
    ------
    ConfigError
        If there is none of that name.
    """
    folder = files("grex_link") / "modems"
    path = folder / f"{name}.toml"
    if not path.is_file():
        known = ", ".join(sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir()))
        raise ConfigError("$.link.profile", f"there is no modem profile {name!r}; there are: {known}")
    return msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), ModemProfile)
