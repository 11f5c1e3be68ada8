"""Addresses as users of MAVLink write them, and what a scenario must say for craft on MAVLink."""

import re

import pytest

from grex_agent.frontseat.address import Address, check_frontseats, parse_url, read_key
from grex_link.config import MavlinkFrontseat
from grex_link.errors import ConfigError
from grex_link.scenario import loads

TEXT = """
datum = { latitude_deg = 54.37, longitude_deg = 10.16 }
clock.pace = "live"
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 20, 0]
[craft.auv1.frontseat]
type = "mavlink"
url = "udpin:127.0.0.1:14550"
[craft.auv2.frontseat]
type = "mavlink"
url = "udpin:127.0.0.1:14560"
"""


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("udpin:127.0.0.1:14550", Address("udpin", "127.0.0.1", 14550)),
        ("udpin://0.0.0.0:14551", Address("udpin", "0.0.0.0", 14551)),
        ("udpout:192.168.2.2:14550", Address("udpout", "192.168.2.2", 14550)),
        ("tcp:boat.local", Address("tcp", "boat.local", 5760)),
        ("serial:/dev/ttyACM0:115200", Address("serial", "/dev/ttyACM0", 115200)),
        ("serial:///dev/ttyUSB0:57600", Address("serial", "/dev/ttyUSB0", 57600)),
        ("serial:/dev/ttyACM0", Address("serial", "/dev/ttyACM0", 57600)),
        ("serial:/dev/ttyACM0,921600", Address("serial", "/dev/ttyACM0", 921600)),
    ],
)
def test_addresses(url: str, address: Address):
    """Every form in use is read, with or without slashes, with the usual port or speed where none is given."""
    assert parse_url(url, "$.x") == address


@pytest.mark.parametrize(
    "url", ["", "14550", "/dev/ttyACM0", "udp:1.2.3.4:1", "tcp:", "tcp:h:0", "tcp:h:99999", "udpin:h:p"]
)
def test_no_addresses(url: str):
    """What cannot be an address is refused with its path and the forms there are."""
    with pytest.raises(ConfigError, match=r"^\$\.x: .* is no address of an autopilot; write udpin:HOST:PORT, "):
        parse_url(url, "$.x")


def test_a_sound_scenario():
    """Two boats on ports of their own, a datum and a pace of the wall clock are all it takes."""
    check_frontseats(loads(TEXT))


@pytest.mark.parametrize(
    ("overrides", "complaint"),
    [
        (
            ["clock.pace=lockstep"],
            "$.craft.auv1.frontseat: an autopilot runs with the wall clock, not in lockstep; set",
        ),
        (
            ["craft.auv2.frontseat.url=udpin://127.0.0.1:14550"],
            "$.craft.auv2.frontseat.url: udpin://127.0.0.1:14550 is",
        ),
        (["craft.auv2.frontseat.url=com3"], "$.craft.auv2.frontseat.url: 'com3' is no address"),
        (
            ["clock.tick_s=2"],
            "$.craft.auv1.frontseat.setpoint_age_max_s: 2 s is too short: the agent speaks every 2 s;",
        ),
    ],
)
def test_what_cannot_work(overrides: list[str], complaint: str):
    """Lockstep, a shared address, no address and set-points that are stale at once are refused with their path."""
    with pytest.raises(ConfigError, match="^" + re.escape(complaint)):
        check_frontseats(loads(TEXT, overrides))


def test_no_datum():
    """Without a datum nobody knows where on earth the mission is: the line shows how to say it."""
    with pytest.raises(ConfigError, match=r"^\$\.datum: is missing: auv1 is on MAVLink, .*latitude_deg"):
        check_frontseats(loads(TEXT.replace("datum =", "title = 'x'\n#")))


def test_keys(tmp_path):
    """A key is 32 bytes in hexadecimal; a file that is not there or holds something else is named."""
    file = tmp_path / "key"
    config = MavlinkFrontseat(url="x", signing_key_file=str(file))
    assert read_key(MavlinkFrontseat(url="x"), "$") is None
    with pytest.raises(ConfigError, match=r"^\$\.f\.signing_key_file: cannot read .*: No such file"):
        read_key(config, "$.f")
    for text in ("00" * 31, "zz" * 32, ""):
        file.write_text(text)
        with pytest.raises(ConfigError, match=r"must hold 32 bytes as 64 hex digits"):
            read_key(config, "$.f")
    file.write_text("0f" * 32 + "\n")
    assert read_key(config, "$.f") == b"\x0f" * 32
