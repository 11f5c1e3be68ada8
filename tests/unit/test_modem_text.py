"""`grex modems`: a table of all modems, and everything about one of them."""

import json
import math
import sys

import msgspec
import pytest

from grex_link.profile import load_profile, profile_names
from grex_sim import cli
from grex_sim.modem_figures import Use, figures
from grex_sim.modem_text import modem_text, modems_text

USE = Use()


@pytest.fixture
def grex(monkeypatch, capsys):
    """Run the console in this process: (exit status, standard output, standard error)."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["grex", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return run


def comes_to(name, **use):
    """Figures of a modem that comes with GREX."""
    return figures(name, load_profile(name), Use(**use))


def row(text, name):
    """Give the cells of a modem's row, one blank between them."""
    return " ".join(next(line for line in text.splitlines() if line.startswith(f"  {name} ")).split())


# -- figures ------------------------------------------------------------------------------------------------------


def test_the_papers_cycle():
    """The paper's modem: three slots of 10 s and no guard, so a mean age of 10 + 30/2 s."""
    paper = comes_to("grex2008")
    assert (paper.airtime_s, paper.guard_s, paper.cycle_s, paper.age_s) == (10.0, 0.0, 30.0, 25.0)
    assert (paper.snr_db, paper.delivery, paper.ranging, paper.assumed) == (None, 1.0, [], ["payload_max_bytes"])


def test_slots_of_a_real_modem():
    """S2C, 15 bytes, 3 craft within 750 m: what sound takes is in the guard, and airtime and guard in the slot."""
    modem = comes_to("s2c_im", range_m=750.0)
    assert modem.airtime_s == pytest.approx(0.31665)
    assert modem.guard_s >= 0.5 + 2 * 0.01 + 0.01
    assert modem.slot_s == math.ceil(1000 * (modem.airtime_s + modem.guard_s)) / 1000
    assert modem.cycle_s == 3 * modem.slot_s
    assert modem.age_s == pytest.approx(0.31665 + 0.5 + 0.0904 + modem.cycle_s / 2)


def test_latency_before_the_sound():
    """The time a modem takes to begin is in the age, too (Nanomodem: 20 and 25 ms; 0.1 % is lost)."""
    modem = comes_to("nm3", range_m=150.0)
    assert modem.age_s == pytest.approx(0.02 + 0.4925 + 0.1 + 0.025 + modem.cycle_s * (1.0 / 0.999 - 0.5))


def test_loss_makes_old():
    """With a share p heard the mean age has C·(1/p - 1/2): ahoi at 152 m, where 51.5 % arrive."""
    modem = comes_to("ahoi", range_m=152.0)
    assert modem.delivery == pytest.approx(0.515)
    assert modem.age_s == pytest.approx(1.0392 + 152.0 / 1500.0 + modem.cycle_s * (1.0 / 0.515 - 0.5))


def test_signal():
    """Signal to noise is source level less 15 log r, absorption and noise in the band (nm3 at 1 km, by hand)."""
    # 168 - 45 - 6.175 (Ainslie and McColm at 28 kHz) - 37.59 (Wenz at 5 m/s) - 39.03 (8 kHz)
    assert comes_to("nm3", range_m=1000.0).snr_db == pytest.approx(40.2, abs=0.1)


def test_a_profiles_own_water():
    """Noise and spreading that a profile is defined with take the place of the sea's: by hand, at 100 m."""
    changes = {"noise_psd_db": 60.0, "spreading": 2.0}
    profile = msgspec.structs.replace(load_profile("nm3"), **changes)
    # 168 - 40 - 0.62 - 60 - 39.03
    assert figures("own", profile, Use(range_m=100.0)).snr_db == pytest.approx(28.35, abs=0.02)


@pytest.mark.parametrize(
    ("limit", "value", "heard"),
    [("range_max_m", 499.0, 0.0), ("range_max_m", 500.0, 0.999),
     ("acquisition_sinr_db", 60.0, 0.0), ("acquisition_sinr_db", 40.0, 0.999)],
)  # fmt: skip
def test_limits_of_a_profile(limit, value, heard):
    """Beyond the profile's reach, and below what it locks to, nothing is heard (nm3 at 500 m: 48 dB)."""
    profile = msgspec.structs.replace(load_profile("nm3"), **{limit: value})
    assert figures("own", profile, USE).delivery == pytest.approx(heard)


@pytest.mark.parametrize(
    ("name", "use", "lacks"),
    [
        ("janus", {}, ["payload too long"]),
        ("janus", {"payload_bytes": 5}, []),
        ("s2c_burst", {}, ["no broadcast"]),
        ("s2c_burst", {"craft": 2}, []),
        ("waterlinked_m64", {"payload_bytes": 8}, ["no broadcast", "only 2 addresses"]),
        ("waterlinked_m64", {"payload_bytes": 8, "craft": 2, "range_m": 100.0}, []),
        ("seatrac_x150", {"craft": 15}, []),
        ("seatrac_x150", {"craft": 16}, ["only 15 addresses"]),
    ],
)
def test_what_a_modem_lacks(name, use, lacks):
    """A modem that cannot serve the team has no slots and no age, and a reason."""
    modem = comes_to(name, **use)
    assert modem.lacks == lacks
    assert (modem.age_s is None) is (modem.slot_s is None) is bool(lacks)


@pytest.mark.parametrize(
    ("name", "near_m", "far_m"), [("ahoi", 199.0, 201.0), ("unet_default", 2000.0, 2001.0), ("nm3", 3000.0, 30_000.0)]
)
def test_out_of_reach(name, near_m, far_m):
    """Beyond its table, its protocol model or its signal a modem is not heard, and has slots but no age."""
    assert comes_to(name, range_m=near_m).age_s > 0.0
    far = comes_to(name, range_m=far_m)
    assert (far.delivery, far.age_s) == (0.0, None)
    assert far.slot_s > 0.0


def test_assumptions_that_do_not_enter():
    """Only what the figures rest on is marked: no noise of ranges, and no source level where there are no levels."""
    assert comes_to("s2c_im").assumed == ["source_level_db", "reception.sinr_db"]
    assert comes_to("unet_default").assumed == []


# -- text ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("use", [USE, Use(8, 3000.0, 20), Use(0, 0.0, 1), Use(4000, 100_000.0, 200), Use(1, 0.001, 2)])
def test_the_table_fits(use):
    """All modems are in the table, a row each, in 110 columns whatever is asked."""
    text = modems_text(profile_names(), use)
    assert [line.split()[0] for line in text.splitlines()[4:20]] == profile_names()
    assert max(map(len, text.splitlines())) <= 110


def test_rows():
    """A row says what fits, how long it takes, how it is heard, what follows, and what of it is assumed."""
    text = modems_text(profile_names(), USE)
    assert row(text, "grex2008") == "grex2008 32 B 10.000 – 100 0.000 10.000 30.00 25.00 none n"
    assert row(text, "janus") == "janus 34 bit – 61 100 – – – – none SL PER"
    assert row(text, "umodem_psk1").startswith("umodem_psk1 192 B 3.400 66 100 ")
    assert row(text, "umodem_psk1").endswith(" two-way one-way T L")
    assert "janus: payload too long" in " ".join(text.split())


@pytest.mark.parametrize("name", profile_names())
def test_all_about_one(name):
    """One modem's text has every field, marks exactly what is assumed, and names the sources; in 110 columns."""
    profile = load_profile(name)
    text = modem_text(name, USE)
    lines = text.splitlines()
    assert all(any(line.startswith(f"  {field}") for line in lines)
               for field in profile.__struct_fields__ if field not in {"title", "sources", "assumed"})  # fmt: skip
    assert {line.split()[0] for line in lines if line.endswith("   assumed")} == set(profile.assumed)
    assert all(source in " ".join(text.split()) for source in profile.sources)
    assert max(map(len, lines)) <= 110


# -- the console --------------------------------------------------------------------------------------------------


def test_command(grex):
    """`grex modems` prints the table; payload, range and team are options."""
    status, out, err = grex("modems", "--payload", "32", "--range", "1000", "--craft", "4")
    assert (status, err) == (0, "")
    assert "messages of 32 bytes among 4 craft within 1000 m" in out
    assert row(out, "grex2008").endswith(" 40.00 30.00 none n")


def test_command_as_json(grex):
    """With --json there is an array of figures, or an object with the figures and the profile of one modem."""
    every = json.loads(grex("modems", "--json")[1])
    assert [modem["name"] for modem in every] == profile_names()
    one = json.loads(grex("modems", "nm3", "--json")[1])
    assert one["figures"] == every[profile_names().index("nm3")]
    assert one["profile"]["reception"]["per"][0] == 1.0


def test_command_with_an_own_file(grex, tmp_path):
    """A user's own file is shown like any other."""
    path = tmp_path / "mine.toml"
    path.write_text(
        'title = "Mine"\npayload_max_bytes = 9\nairtime_fixed_s = 2.0\nairtime_per_byte_s = 0.5\n'
        'one_speaker_at_a_time = true\nsources = ["my own tank"]\nassumed = ["airtime_per_byte_s"]\n'
    )
    status, out, _ = grex("modems", str(path), "--payload", "4", "--craft", "2")
    assert status == 0
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert {"airtime T 4.000 s", "mean age 8.00 s", "airtime_per_byte_s 0.5 s a byte assumed", "my own tank"} < set(
        lines
    )


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        (["nosuch"], "NAME: there is no modem profile 'nosuch'; there are: ahoi, "),
        (["none.toml"], "NAME: cannot read none.toml: "),
        (["--payload", "-1"], "--payload: -1 is not within 0 … 65535"),
        (["--range", "nan"], "--range: nan is not within 0 … 100000"),
        (["nm3", "--craft", "0"], "--craft: 0 is not within 1 … 200"),
    ],
)
def test_bad_arguments(grex, arguments, start):
    """What makes no sense ends with status 2 and one line."""
    status, out, err = grex("modems", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"grex: {start}")
    assert err.count("\n") == 1
