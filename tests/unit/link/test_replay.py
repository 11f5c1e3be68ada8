"""`grex medium`: a schedule and a link in, a row for each transmission and receiver out."""

import csv
import math
from pathlib import Path

import pytest

from grex_link.errors import ConfigError
from grex_link.replay import COLUMNS, replay

#: Three nodes 50 m apart; 1 bit/s·8 000: a byte takes 1 ms.
LINK = """
[medium]
sound_speed_mps = 1500.0
absorption = "thorp"
spreading = 1.5
acquisition_sinr_db = 6.0
survival_sinr_db = 3.0
noise = { model = "wenz", wind_mps = 5.0, shipping = 0.5 }

[modem]
frequency_hz = 25000.0
bandwidth_hz = 4000.0
source_level_db = 185.0
bit_rate_bps = 8000.0

[[node]]
id = "n1"
position_ned_m = [0.0, 0.0, 0.0]

[[node]]
id = "n2"
position_ned_m = [50.0, 0.0, 0.0]

[[node]]
id = "n3"
position_ned_m = [25.0, 43.30127018922193, 0.0]
"""
HEAD = "time_s,source,payload_bytes\n"


def played(folder: Path, schedule: str, link: str = LINK) -> list[dict[str, str]]:
    (folder / "schedule.csv").write_text(HEAD + schedule, encoding="utf-8")
    (folder / "link.toml").write_text(link, encoding="utf-8")
    replay(folder / "schedule.csv", folder / "link.toml", folder / "out.csv")
    with (folder / "out.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def at(rows: list[dict[str, str]], receiver: str) -> list[tuple[str, str, str]]:
    return [(row["time_s"], row["source"], row["outcome"]) for row in rows if row["receiver"] == receiver]


def test_unit_vectors(tmp_path: Path) -> None:
    """Three nodes 50 m apart, packets of 2 s: sent at 1 and 3.001 s both arrive, at 1 and 2.99 s both are lost."""
    assert at(played(tmp_path, "1,n1,2000\n3.001,n2,2000\n"), "n3") == [("1", "n1", "ok"), ("3.001", "n2", "ok")]
    assert at(played(tmp_path, "1,n1,2000\n2.99,n2,2000\n"), "n3") == [("1", "n1", "error"), ("2.99", "n2", "missed")]


def test_a_row(tmp_path: Path) -> None:
    """Columns and their order are those of the issue; time is printed as given, the rest follows from the formulas."""
    rows = played(tmp_path, "1.50,n1,100\n")
    assert tuple(rows[0]) == COLUMNS
    assert COLUMNS == (
        "time_s", "source", "receiver", "outcome", "reason", "range_m", "delay_s", "level_db", "sinr_db", "per"
    )  # fmt: skip
    assert [row["receiver"] for row in rows] == ["n2", "n3"]
    row = rows[0]
    assert (row["time_s"], row["outcome"], row["reason"], row["per"]) == ("1.50", "ok", "", "0")
    absorption = 0.11 * 625 / 626 + 44 * 625 / 4725 + 2.75e-4 * 625 + 0.003
    noise = [17 - 30 * math.log10(25), 40 + 26 * math.log10(25) - 60 * math.log10(25.03)]
    noise += [50 + 7.5 * math.sqrt(5) + 20 * math.log10(25) - 40 * math.log10(25.4), -15 + 20 * math.log10(25)]
    noise_db = 10 * math.log10(sum(10 ** (level / 10) for level in noise)) + 10 * math.log10(4000)
    level_db = 185 - 15 * math.log10(50) - absorption * 0.05
    assert float(row["range_m"]) == pytest.approx(50.0, abs=1e-6)
    assert float(row["delay_s"]) == pytest.approx(50.0 / 1500.0, abs=1e-9)
    assert float(row["level_db"]) == pytest.approx(level_db, abs=1e-6)
    assert float(row["sinr_db"]) == pytest.approx(level_db - noise_db, abs=1e-6)


def test_every_outcome(tmp_path: Path) -> None:
    """All four outcomes occur, each with its reason, and the counts that are returned are those of the file."""
    schedule = "0,n1,1000\n0.5,n1,10\n0.9,n2,1000\n5.0,n2,100\n5.0,n3,100\n"
    rows = played(tmp_path, schedule)
    found = [(row["time_s"], row["receiver"], row["outcome"], row["reason"]) for row in rows]
    assert found == [
        ("0", "n2", "missed", "aborted_own_tx"),
        ("0", "n3", "error", "lost_collision"),
        ("0.5", "n2", "not_sent_busy", "busy"),
        ("0.5", "n3", "not_sent_busy", "busy"),
        ("0.9", "n1", "missed", "missed_halfduplex"),
        ("0.9", "n3", "missed", "missed_busy"),
        ("5.0", "n1", "error", "lost_collision"),
        ("5.0", "n3", "missed", "missed_halfduplex"),
        ("5.0", "n1", "missed", "missed_busy"),
        ("5.0", "n2", "missed", "missed_halfduplex"),
    ]
    counts = replay(tmp_path / "schedule.csv", tmp_path / "link.toml", tmp_path / "out.csv")
    assert counts == {"ok": 0, "error": 2, "missed": 6, "not_sent_busy": 2}


def test_lost_in_noise(tmp_path: Path) -> None:
    """A survival threshold above the acquisition's loses what was locked to; one that nothing reaches misses it."""
    link = LINK.replace("source_level_db = 185.0", "source_level_db = 80.0").replace(
        "bandwidth_hz = 4000.0", "bandwidth_hz = 1.0"
    )
    heard_db = float(played(tmp_path, "0,n1,10\n", link)[0]["sinr_db"])
    deaf = link.replace("acquisition_sinr_db = 6.0", f"acquisition_sinr_db = {heard_db + 0.01}")
    assert [row["reason"] for row in played(tmp_path, "0,n1,10\n", deaf)] == ["missed_snr", "missed_snr"]
    fragile = link.replace("survival_sinr_db = 3.0", f"survival_sinr_db = {heard_db + 0.01}")
    rows = played(tmp_path, "0,n1,10\n", fragile)
    assert [(row["outcome"], row["reason"], row["per"]) for row in rows] == [("error", "lost_noise", "1")] * 2


def test_back_to_back(tmp_path: Path) -> None:
    """A source may send again in the nanosecond in which it has finished, and both packets arrive."""
    rows = played(tmp_path, "0,n1,100\n0.1,n1,100\n0.199999999,n1,100\n")
    assert [row["outcome"] for row in rows] == ["ok"] * 4 + ["not_sent_busy"] * 2


def test_order_of_the_schedule(tmp_path: Path) -> None:
    """Rows may come in any order: outcomes are the same, written in the order of the file."""
    lines = ["0,n1,1000", "0.9,n2,1000", "3,n3,10", "3.001,n2,10", "3,n3,20"]
    forth = played(tmp_path, "\n".join(lines))
    back = played(tmp_path, "\n".join([*reversed(lines[:3]), *lines[3:]]))
    assert [row["time_s"] for row in back[:6]] == ["3", "3", "0.9", "0.9", "0", "0"]
    key = [tuple(row.values()) for row in forth]
    assert sorted(key) == sorted(tuple(row.values()) for row in back)


def test_spellings(tmp_path: Path) -> None:
    """Columns in any order, spaces, a byte order mark, numbers as ids and exponents are understood; no rows is fine."""
    link = LINK.replace('"n1"', "1").replace('"n2"', "2").replace('"n3"', "3")
    (tmp_path / "link.toml").write_text(link, encoding="utf-8")
    schedule = "\ufeffsource, payload_bytes, time_s, remark\n 1, 100, 1e-1, first\n2, 100, 2, \n"
    (tmp_path / "schedule.csv").write_text(schedule, encoding="utf-8")
    replay(tmp_path / "schedule.csv", tmp_path / "link.toml", tmp_path / "out.csv")
    rows = list(csv.reader((tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()))
    assert [row[:4] for row in rows[1:]] == [
        ["1e-1", "1", "2", "ok"], ["1e-1", "1", "3", "ok"], ["2", "2", "1", "ok"], ["2", "2", "3", "ok"]
    ]  # fmt: skip
    assert played(tmp_path, "") == []


@pytest.mark.parametrize(
    ("schedule", "message"),
    [
        ("soon,n1,10\n", r"schedule\.csv line 2: time_s 'soon' is no number"),
        ("0,n1,10\nnan,n1,10\n", r"line 3: time_s nan is not between 0 and"),
        ("-1,n1,10\n", "line 2: time_s -1 is not between"),
        ("1e300,n1,10\n", "line 2: time_s 1e300 is not between"),
        ("0,n9,10\n", "line 2: source 'n9' is no node; there are n1, n2, n3"),
        ("0,n1,0\n", "line 2: payload_bytes '0' is no whole number"),
        ("0,n1,1.5\n", "line 2: payload_bytes '1.5' is no whole number"),
        ("0,n1,-1\n", "line 2: payload_bytes '-1' is no whole number"),
        ("0,n1\n", "line 2: payload_bytes '' is no whole number"),
        ("0,n1,²\n", "line 2: payload_bytes '²' is no whole number"),
    ],
)
def test_a_bad_schedule(tmp_path: Path, schedule: str, message: str) -> None:
    """A fault of the schedule is said with file and line."""
    with pytest.raises(ConfigError, match=message):
        played(tmp_path, schedule)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("acquisition_sinr_db = 6.0\n", "", r"missing required field `acquisition_sinr_db` - at `\$\.medium`"),
        ("spreading = 1.5", "spreadin = 1.5", "unknown field `spreadin`"),
        ('"thorp"', '"urick"', "urick"),
        ("bit_rate_bps = 8000.0", "bit_rate_bps = 0.0", "0.0"),
        ("[50.0, 0.0, 0.0]", "[nan, 0.0, 0.0]", "position_ned_m|node"),
        ("[50.0, 0.0, 0.0]", "[50.0, 0.0]", "length"),
        ('"n2"', '"n1"', "id 'n1' is given twice"),
        ("[modem]", "[modem", r"link\.toml"),
    ],
)
def test_a_bad_link(tmp_path: Path, old: str, new: str, message: str) -> None:
    """A fault of the link is said in one line with the file and the path."""
    with pytest.raises(ConfigError, match=message):
        played(tmp_path, "0,n1,10\n", LINK.replace(old, new, 1))


def test_files_that_are_not_there(tmp_path: Path) -> None:
    """A file that cannot be read or written, or lacks a column, is named."""
    link, schedule = tmp_path / "link.toml", tmp_path / "schedule.csv"
    with pytest.raises(ConfigError, match=r"link\.toml: cannot read it"):
        replay(schedule, link, tmp_path / "out.csv")
    link.write_text(LINK, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"schedule\.csv: cannot read it"):
        replay(schedule, link, tmp_path / "out.csv")
    schedule.write_text("time_s,source\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="column payload_bytes is missing"):
        replay(schedule, link, tmp_path / "out.csv")
    schedule.write_text(HEAD, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"out\.csv: cannot write it"):
        replay(schedule, link, tmp_path / "nowhere" / "out.csv")
    schedule.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"schedule\.csv: cannot read it"):
        replay(schedule, link, tmp_path / "out.csv")
