"""Modem profiles are data that says what it knows and what it assumes."""

from importlib.resources import files

import msgspec
import pytest

from grex_link.errors import ConfigError
from grex_link.profile import ModemProfile, load_profile

NAMES = sorted(
    entry.name.removesuffix(".toml")
    for entry in (files("grex_link") / "modems").iterdir()
    if entry.name.endswith(".toml")
)


@pytest.mark.parametrize("name", NAMES)
def test_every_profile(name: str) -> None:
    """Every profile in the package loads, has a source, and marks as assumed only numbers that it has."""
    profile = load_profile(name)
    assert profile.title
    assert profile.sources
    assert set(profile.assumed) <= set(profile.__struct_fields__)


def test_the_papers_modem() -> None:
    """The paper's modem takes ten seconds a message, however short, and one craft speaks at a time."""
    profile = load_profile("grex2008")
    assert [profile.airtime_ns(size) for size in (0, 15, 32)] == [10_000_000_000] * 3
    assert profile.one_speaker_at_a_time
    assert profile.payload_max_bytes >= 15


def test_airtime_grows_with_size() -> None:
    """Airtime is the fixed part and the bytes' part, to the nanosecond (Nanomodem: 0.305 + 0.0125 n s)."""
    profile = ModemProfile(
        title="nm3", payload_max_bytes=64, airtime_fixed_s=0.305, airtime_per_byte_s=0.0125,
        one_speaker_at_a_time=True, sources=["published"], assumed=[],
    )  # fmt: skip
    assert profile.airtime_ns(0) == 305_000_000
    assert profile.airtime_ns(15) == 492_500_000
    assert profile.airtime_ns(20) == 555_000_000


@pytest.mark.parametrize("name", ["nosuch", "", "README"])
def test_unknown_profile(name: str) -> None:
    """A profile that does not exist is named, beside those that do."""
    with pytest.raises(ConfigError, match="grex2008") as caught:
        load_profile(name)
    assert caught.value.path == "$.link.profile"
    assert repr(name) in caught.value.problem


@pytest.mark.parametrize("wrong", [{"payload_max_bytes": 0}, {"airtime_fixed_s": 0.0}, {"airtime_fixd_s": 1.0}])
def test_profile_bounds(wrong: dict) -> None:
    """A profile with a number out of range, or a key nobody knows, is no profile."""
    good = msgspec.to_builtins(load_profile("grex2008"))
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(good | wrong, ModemProfile)
