"""Modem profiles are data that says what it knows and what it assumes."""

from pathlib import Path

import msgspec
import pytest

from grex_link.errors import ConfigError
from grex_link.profile import BitErrors, ErrorTable, ModemProfile, Threshold, load_profile, profile_names

MICROMODEM_RANGING = {"ranging.sigma_m", "ranging.step_m", "ranging.reply_s", "ranging.ping_airtime_s"}

#: What the table of modems (acoustic-link §1) marks as assumed, and what we had to assume besides.
ASSUMED = {
    "ahoi": {"airtime_fixed_s", "source_level_db", "reception.sinr_db", "ranging.sigma_m"},
    "atm900": {"airtime_fixed_s", "airtime_per_byte_s", "source_level_db", "reception.sinr_db", "ranging.sigma_m"},
    "grex2008": {"payload_max_bytes"},
    "janus": {"source_level_db", "reception.sinr_db"},
    "nm3": {"airtime_fixed_s", "airtime_per_byte_s", "transmit_latency_s", "decode_latency_s"},
    "popoto": {
        "airtime_fixed_s", "airtime_per_byte_s", "frequency_hz", "bandwidth_hz", "source_level_db", "reception.sinr_db",
        "ranging.sigma_m",
    },
    "s2c_burst": {
        "payload_max_bytes", "airtime_fixed_s", "source_level_db", "reception.sinr_db", "ranging.sigma_m",
        "ranging.step_m",
    },
    "s2c_im": {"source_level_db", "reception.sinr_db", "ranging.sigma_m"},
    "seatrac_x150": {"airtime_fixed_s", "source_level_db", "reception.sinr_db", "ranging.sigma_m"},
    "umodem_fsk0": {
        "airtime_fixed_s", "decode_latency_s", "reception.sinr_db", "ranging.sigma_m", "ranging.step_m",
        "ranging.reply_s", "ranging.ping_airtime_s",
    },
    "umodem_psk1": {"airtime_fixed_s", "decode_latency_s", *MICROMODEM_RANGING},
    "umodem_psk3": {"airtime_fixed_s", "decode_latency_s", *MICROMODEM_RANGING},
    "umodem_psk5": {"airtime_fixed_s", "decode_latency_s", *MICROMODEM_RANGING},
    "umodem_psk6": {
        "decode_latency_s", "reception.sinr_db", "reception.per", "ranging.sigma_m", "ranging.step_m",
        "ranging.reply_s", "ranging.ping_airtime_s",
    },
    "unet_default": {"source_level_db", "ranging.sigma_m"},
    "waterlinked_m64": {"source_level_db", "reception.sinr_db"},
}  # fmt: skip

#: Lengths in bytes and times in seconds that were measured (DESERT Underwater, txduration_s2c_LUT.csv).
S2C_MEASURED = {
    1: 0.172102, 5: 0.213082, 8: 0.237660, 12: 0.286833, 15: 0.311411, 20: 0.368760, 24: 0.417916, 28: 0.458896,
    32: 0.499859, 36: 0.548965, 40: 0.589929, 44: 0.630909, 45: 0.663663, 48: 0.688241, 52: 0.737431, 56: 0.770201,
    60: 0.811148, 64: 0.860338,
}  # fmt: skip


def airtime_s(name, size_bytes):
    """Airtime of a payload on a modem that comes with GREX."""
    return load_profile(name).airtime_ns(size_bytes) / 1e9


# -- what comes with GREX -----------------------------------------------------------------------------------------


def test_there_are_sixteen():
    """All modems of the table are there, and no other."""
    assert profile_names() == sorted(ASSUMED)


@pytest.mark.parametrize("name", profile_names())
def test_every_profile(name):
    """Every profile loads, has a source, and marks exactly the numbers that nobody has published."""
    profile = load_profile(name)
    assert profile.title
    assert profile.sources
    assert set(profile.assumed) == ASSUMED[name]
    assert len(profile.assumed) == len(ASSUMED[name])


def test_the_papers_modem():
    """The paper's modem takes ten seconds a message, however short, and one craft speaks at a time."""
    profile = load_profile("grex2008")
    assert [profile.airtime_ns(size) for size in (0, 15, 32)] == [10_000_000_000] * 3
    assert profile.one_speaker_at_a_time
    assert profile.payload_max_bytes >= 15


@pytest.mark.parametrize(
    ("name", "payload_max_bytes", "times"),
    [
        ("umodem_fsk0", 32, {1: 4.2, 15: 4.2, 32: 4.2}),
        ("umodem_psk1", 192, {1: 3.4, 192: 3.4}),
        ("umodem_psk3", 512, {1: 3.4, 512: 3.4}),
        ("umodem_psk5", 2048, {1: 3.6, 2048: 3.6}),
        ("umodem_psk6", 192, {1: 3.25, 192: 3.25}),
        ("s2c_im", 64, {0: 0.1503, 15: 0.31665, 64: 0.86006}),
        ("s2c_burst", 1024, {1024: 0.7 + 8192 / 13_900}),
        ("nm3", 64, {0: 0.305, 15: 0.4925, 64: 1.105}),
        ("ahoi", 128, {0: 0.3 + 9 * 0.0308, 15: 0.3 + 24 * 0.0308, 128: 0.3 + 137 * 0.0308}),
        ("janus", 5, {5: 1.1}),
        ("seatrac_x150", 31, {0: 0.5, 31: 2.98}),
        ("waterlinked_m64", 8, {1: 1.0, 8: 1.0}),
        ("unet_default", 64, {0: 0.005, 64: 0.21812}),
        ("atm900", 4091, {0: 1.5, 4091: 235.0961}),
        ("popoto", 1024, {0: 0.5, 15: 2.0}),
    ],
)
def test_airtimes(name, payload_max_bytes, times):
    """Every modem takes as long as the table of modems says, padding, header and checksum included."""
    assert load_profile(name).payload_max_bytes == payload_max_bytes
    for size_bytes, seconds in times.items():
        assert airtime_s(name, size_bytes) == pytest.approx(seconds, abs=1e-4)


def test_s2c_airtime_is_what_was_measured():
    """The fit for S2C is within 15 ms of every measured airtime, 11 ms at 1, 15 and 64 bytes, and 7 ms rms."""
    errors_s = {size: airtime_s("s2c_im", size) - measured for size, measured in S2C_MEASURED.items()}
    assert max(map(abs, errors_s.values())) < 0.015
    assert max(abs(errors_s[size]) for size in (1, 15, 64)) < 0.011
    assert sum(error**2 for error in errors_s.values()) / len(errors_s) < 0.007**2


@pytest.mark.parametrize(
    ("name", "bit_rate_bps", "within"),
    [
        ("nm3", 463.0, 0.002),  # of a full packet, all included
        ("umodem_psk5", 5000.0, 0.10),  # without the probe before it
        ("umodem_psk6", 490.0, 0.05),
        ("waterlinked_m64", 64.0, 1e-9),
    ],
)
def test_published_rates(name, bit_rate_bps, within):
    """A full packet comes to the published bit rate."""
    size_bytes = load_profile(name).payload_max_bytes
    assert 8 * size_bytes / airtime_s(name, size_bytes) == pytest.approx(bit_rate_bps, rel=within)


@pytest.mark.parametrize(
    ("name", "low_hz", "high_hz"),
    [("s2c_im", 18e3, 34e3), ("s2c_burst", 18e3, 34e3), ("nm3", 24e3, 32e3), ("ahoi", 50e3, 75e3),
     ("janus", 9440.0, 13_600.0), ("seatrac_x150", 24e3, 32e3), ("waterlinked_m64", 31e3, 250e3), ("atm900", 9e3, 14e3),
     ("popoto", 20e3, 40e3), ("umodem_fsk0", 23e3, 27e3), ("umodem_psk1", 22.5e3, 27.5e3)],
)  # fmt: skip
def test_bands(name, low_hz, high_hz):
    """Centre and width are those of the published band."""
    profile = load_profile(name)
    assert (profile.frequency_hz - profile.bandwidth_hz / 2, profile.frequency_hz + profile.bandwidth_hz / 2) == (
        pytest.approx(low_hz), pytest.approx(high_hz),
    )  # fmt: skip


PSK1 = {-7.96: 1.0, -7.6: 0.937, -7.23: 0.727, -6.85: 0.17, -6.44: 0.02, -6.01: 0.0}


@pytest.mark.parametrize(
    ("name", "frame_bytes", "points"),
    [
        ("umodem_psk1", 64, PSK1),
        ("umodem_psk3", 256, {-2.92: 1.0, -2.28: 0.91, -1.59: 0.57, -0.83: 0.115, 0.004: 0.025}),
        ("umodem_psk5", 256, {3.1: 1.0, 4.44: 0.135, 6.02: 0.0}),
        ("umodem_psk6", 32, PSK1),
        (
            "nm3",
            None,
            {-2.0: 1.0, -1.0: 0.8, 0.0: 0.4, 1.0: 0.23, 2.0: 0.09, 3.0: 0.03, 4.0: 0.01, 5.0: 0.003, 6.0: 0.001},
        ),
    ],
)
def test_error_tables(name, frame_bytes, points):
    """Error rates over SNR are the published ones, of frames where they are of frames."""
    table = load_profile(name).reception
    assert dict(zip(table.sinr_db, table.per, strict=True)) == points
    assert table.frame_bytes == frame_bytes


@pytest.mark.parametrize(
    ("name", "sinr_db"),
    [("s2c_im", 3.0), ("s2c_burst", 8.0), ("janus", -2.0), ("seatrac_x150", 0.0), ("waterlinked_m64", 5.0),
     ("atm900", 3.0), ("popoto", 0.0), ("ahoi", 0.0), ("umodem_fsk0", 0.0)],
)  # fmt: skip
def test_thresholds(name, sinr_db):
    """Where nobody has published error rates a threshold takes their place, and is marked as assumed."""
    profile = load_profile(name)
    assert profile.reception == Threshold(sinr_db=sinr_db)
    assert "reception.sinr_db" in profile.assumed


@pytest.mark.parametrize(
    ("name", "level_db"),
    [("umodem_fsk0", 185.0), ("umodem_psk6", 185.0), ("s2c_im", 184.0), ("s2c_burst", 184.0), ("nm3", 168.0),
     ("ahoi", 166.0), ("janus", 183.0), ("seatrac_x150", 176.0), ("waterlinked_m64", 155.0), ("atm900", 185.0)],
)  # fmt: skip
def test_source_levels(name, level_db):
    """Source levels are those of the table of modems."""
    assert load_profile(name).source_level_db == level_db


def test_ahoi_tables():
    """What DESERT measured with ahoi: shares over range and over interference."""
    profile = load_profile("ahoi")
    assert dict(zip(profile.range_pdr.range_m, profile.range_pdr.pdr, strict=True)) == {
        12.0: 0.95, 24.0: 0.7, 46.0: 0.885, 99.0: 0.99, 152.0: 0.515, 200.0: 0.0,
    }  # fmt: skip
    survive = dict(zip(profile.interference_pdr.sir_db, profile.interference_pdr.pdr, strict=True))
    assert {sir_db: round(survive[sir_db], 3) for sir_db in (0.0, 2.0412, 2.3045, 2.5527)} == {
        0.0: 0.0, 2.0412: 0.315, 2.3045: 0.707, 2.5527: 1.0,
    }  # fmt: skip


def test_what_modems_cannot():
    """S2C bursts and the M64 know no broadcast, the M64 is for a pair, SeaTrac has 15 addresses, JANUS 34 bits."""
    every = {name: load_profile(name) for name in profile_names()}
    assert {name for name, modem in every.items() if not modem.broadcast} == {"s2c_burst", "waterlinked_m64"}
    assert {name: modem.addresses_max for name, modem in every.items() if modem.addresses_max} == {
        "seatrac_x150": 15, "waterlinked_m64": 2,
    }  # fmt: skip
    assert {name: modem.bits_max for name, modem in every.items() if modem.bits_max != 8 * modem.payload_max_bytes} == {
        "janus": 34
    }
    assert {name for name, modem in every.items() if not modem.ranging.two_way} == {
        "grex2008", "janus", "waterlinked_m64",
    }  # fmt: skip


def test_ranging():
    """Micro-Modems know one-way times modulo a second; S2C and ahoi measure to 1 µs, Nanomodems to 4.7 cm."""
    every = {name: load_profile(name).ranging for name in profile_names()}
    assert {name: modem.ambiguity_s for name, modem in every.items() if modem.one_way} == {
        f"umodem_{rate}": 1.0 for rate in ("fsk0", "psk1", "psk3", "psk5", "psk6")
    }
    assert {name: modem.step_m for name, modem in every.items() if not name.startswith("umodem") and modem.step_m} == {
        "ahoi": 0.0015, "atm900": 0.1, "nm3": 0.047, "s2c_burst": 0.0015, "s2c_im": 0.0015, "seatrac_x150": 0.1,
    }  # fmt: skip
    assert (every["nm3"].sigma_m, every["nm3"].reply_s) == (0.1, 0.04)


def test_unet():
    """UnetStack's numbers: 2000, 2500, 3000 m, all chances 1; 60 dB re 1 µPa²/Hz, spherical, K = 10."""
    profile = load_profile("unet_default")
    model = profile.reception
    assert (model.communication_m, model.detection_m, model.interference_m) == (2000.0, 2500.0, 3000.0)
    assert (model.detection, model.communication) == (1.0, 1.0)
    assert (profile.noise_psd_db, profile.spreading, profile.rician_k) == (60.0, 2.0, 10.0)


# -- the Struct ---------------------------------------------------------------------------------------------------


def test_airtime_grows_with_size():
    """Airtime is the fixed part and the bytes' part, to the nanosecond; whole frames where a modem sends frames."""
    profile = load_profile("nm3")
    assert [profile.airtime_ns(size) for size in (0, 15, 20)] == [305_000_000, 492_500_000, 555_000_000]
    framed = msgspec.structs.replace(profile, frame_bytes=32)
    assert [framed.airtime_ns(size) for size in (0, 1, 32, 33)] == [705_000_000] * 3 + [1_105_000_000]


@pytest.mark.parametrize(
    ("reception", "sinr_db"),
    [(ErrorTable(sinr_db=(-2.0, 1.0), per=(1.0, 0.0)), -2.0), (BitErrors(modulation="bpsk", gain_db=12.0), -12.0)],
)
def test_lock(reception, sinr_db):
    """A receiver locks where errors begin to be less than certain, or where the profile says."""
    profile = msgspec.structs.replace(load_profile("nm3"), reception=reception)
    assert profile.lock_sinr_db == sinr_db
    assert msgspec.structs.replace(profile, acquisition_sinr_db=5.0).lock_sinr_db == 5.0


@pytest.mark.parametrize("wrong", [{"payload_max_bytes": 0}, {"airtime_fixed_s": 0.0}, {"airtime_fixd_s": 1.0}])
def test_profile_bounds(wrong):
    """A profile with a number out of range, or a key nobody knows, is no profile."""
    good = msgspec.to_builtins(load_profile("grex2008"))
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(good | wrong, ModemProfile)


# -- a user's own -------------------------------------------------------------------------------------------------


@pytest.fixture
def own(tmp_path):
    """Write a profile of a user's own, with a change: the path of the file."""

    def write(old="", new=""):
        text = (Path(__file__).parents[3] / "grex_link" / "modems" / "nm3.toml").read_text(encoding="utf-8")
        assert old in text
        path = tmp_path / "mine.toml"
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return str(path)

    return write


def test_a_users_own_file(own):
    """A file of the user's own needs no code."""
    assert load_profile(own()) == load_profile("nm3")
    assert load_profile(own("source_level_db = 168.0", "source_level_db = 175.0")).source_level_db == 175.0


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("payload_max_bytes = 64", "payload_max_bytes = 64 bytes", "line 3"),
        ("payload_max_bytes = 64", "payload_max_bytes = 0", r"\$.payload_max_bytes"),
        ("payload_max_bytes = 64", "payload_max = 64", "unknown field `payload_max`"),
        ("payload_max_bytes = 64", '"payload\\nmax" = 64', "payload max"),
        ("airtime_fixed_s = 0.305", "", "missing required field `airtime_fixed_s`"),
        ("frequency_hz = 28000.0", "", "frequency_hz, bandwidth_hz, source_level_db and reception are needed"),
        ("frequency_hz = 28000.0", "frequency_hz = nan", r"\$.frequency_hz"),
        ("acknowledges", "one_speaker_at_a_time = true\nacknowledges", "has no acoustics"),
        ("[1.0, 0.8", "[0.8", "sinr_db has 9 points and per 8"),
        ("[1.0, 0.8", "[0.8, 1.0", "per must not rise"),
        ("[-2.0, -1.0", "[-1.0, -2.0", "sinr_db must increase"),
        ("[-2.0, -1.0", "[nan, -1.0", r"\$.reception.sinr_db"),
        ("0.8, 0.4", "0.8, 1.4", r"\$.reception.per"),
        ('type = "table"', 'type = "tabel"', "tabel"),
        ('assumed = ["airtime_fixed_s"', 'assumed = ["airtime"', "assumed names 'airtime'"),
        ('assumed = ["airtime_fixed_s"', 'assumed = ["ranging.sigma"', "assumed names 'ranging.sigma'"),
        ('assumed = ["airtime_fixed_s"', 'assumed = ["range_pdr.pdr"', "assumed names 'range_pdr.pdr'"),
        ("[ranging]", "[interference_pdr]\nsir_db = [0, 1]\npdr = [0.5, 0.4]\n[ranging]", "pdr must not fall"),
    ],
)
def test_a_fault_in_a_users_own_file(own, old, new, problem):
    """Whatever is wrong with the file, one line says so and names it."""
    with pytest.raises(ConfigError, match=problem) as caught:
        load_profile(own(old, new))
    assert caught.value.path == "$.link.profile"
    assert "mine.toml" in caught.value.problem
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["nosuch", "", "README", "../modems/nm3"])
def test_unknown_profile(name):
    """A profile that does not exist is named, beside those that do."""
    with pytest.raises(ConfigError, match="grex2008") as caught:
        load_profile(name)
    assert caught.value.path == "$.link.profile"
    assert repr(name) in caught.value.problem


def test_a_file_that_cannot_be_read(tmp_path):
    """A file that is not there, is a folder or is no text is named."""
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "noise.toml").write_bytes(b"\xff\xfe\x00")
    for name, problem in (("none", "No such file"), ("folder", "directory"), ("noise", "is no modem profile")):
        with pytest.raises(ConfigError, match=f"{name}.*{problem}"):
            load_profile(str(tmp_path / f"{name}.toml"))
