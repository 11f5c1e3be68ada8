"""The edge: bytes, signatures, links and the command line."""

import os
import re
import socket

import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from grex_link.errors import ConfigError
from grex_sim.autopilot.codec import Codec
from grex_sim.autopilot.links import open_link
from grex_sim.autopilot.message import Message
from grex_sim.autopilot.options import Checked, read_key, read_parameters, read_start, read_vector
from grex_sim.autopilot.telemetry import BUILDERS

KEY = bytes(range(32))


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_the_numbers_of_messages_are_mavlinks(name):
    """Every message that can be asked for by number has that number in the dialect."""
    assert dialect.mavlink_map[BUILDERS[name][0]].msgname == name


def test_there_and_back():
    """A message comes out of the bytes as it went in, with the sender's ids; fields left out are 0."""
    data = Codec(7).pack(Message("GLOBAL_POSITION_INT", {"lat": 543_700_000, "vx": -12}))
    (read,) = Codec(9).read(data)
    assert (read.name, read.system, read.component) == ("GLOBAL_POSITION_INT", 7, 1)
    assert (read["lat"], read["vx"], read["lon"]) == (543_700_000, -12, 0)


def test_garbage_between_messages():
    """Random bytes before, between and after messages cost none of them."""
    codec, reader = Codec(1), Codec(2)
    noise = bytes(range(0, 250, 7))
    data = noise + codec.pack(Message("HEARTBEAT", {})) + noise + codec.pack(Message("VFR_HUD", {})) + noise
    names = [message.name for message in reader.read(data)]
    assert names == ["HEARTBEAT", "VFR_HUD"]
    assert reader.garbage > 0


def test_garbage_that_looks_like_a_beginning():
    """What looks like a long message that never ends costs none: at once in datagrams, after its length in a stream."""
    beat = Codec(1).pack(Message("HEARTBEAT", {"mavlink_version": 3}))
    false = bytes([0xFD, 255, 0, 0])
    reader = Codec(2)
    assert [m.name for m in reader.read(false + beat, datagram=True)] == []
    assert [m.name for m in reader.read(b"\xfd" * 280, datagram=True)] == []
    assert [m.name for m in reader.read(beat, datagram=True)] == ["HEARTBEAT"]
    stream = Codec(3)
    assert [m.name for m in stream.read(b"\xfd" * 280 + beat)] == ["HEARTBEAT"]
    assert sum(1 for _ in range(20) for m in stream.read(false + beat if _ == 0 else beat)) == 20


def test_two_senders_do_not_mix():
    """Halves of messages of two senders on one link come together rightly."""
    one, two, reader = Codec(1).pack(Message("HEARTBEAT", {})), Codec(2).pack(Message("HEARTBEAT", {})), Codec(3)
    halves = [("a", one[:8]), ("b", two[:8]), ("a", one[8:]), ("b", two[8:])]
    assert [m.system for sender, data in halves for m in reader.read(data, sender)] == [1, 2]


def test_an_event_is_unknown_to_pymavlink():
    """PX4's EVENT arrives as UNKNOWN_410, as it does with pymavlink from a real one."""
    data = Codec(1).pack(Message("EVENT", {"id": 5, "event_time_boot_ms": 1000}))
    assert [m.get_type() for m in dialect.MAVLink(None).parse_buffer(data)] == ["UNKNOWN_410"]
    assert list(Codec(2).read(data)) == []


def test_signatures():
    """With a key everything is signed; who has the key is heard, who has another or none is not."""
    signed = Codec(1, KEY, 1.8e9).pack(Message("HEARTBEAT", {}))
    plain = Codec(1).pack(Message("HEARTBEAT", {}))
    assert [m.name for m in Codec(2, KEY, 1.8e9).read(signed)] == ["HEARTBEAT"]
    assert [m.name for m in Codec(2, bytes(32), 1.8e9).read(signed)] == []
    assert [m.name for m in Codec(2, KEY, 1.8e9).read(plain)] == []


@pytest.mark.parametrize(
    "url",
    [
        "nonsense",
        "udpout:127.0.0.1",
        "udpin:127.0.0.1:x",
        "udpin:127.0.0.1:70000",
        "ftp:127.0.0.1:1",
        "serial:/dev/x:9",
    ],
)
def test_links_that_cannot_be(url):
    """A link of unknown form, or a device that is not there, is one line."""
    with pytest.raises(ConfigError, match="--url") as caught:
        open_link(url)
    assert "\n" not in str(caught.value)


def test_a_port_in_use():
    """A port that somebody has is refused in one line that names the link."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        url = f"udpin:127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(ConfigError, match=re.escape(url)):
            open_link(url)


def test_a_pty_with_a_name(tmp_path):
    """A pty carries bytes both ways under its name, replaces a name left behind, and takes it away at the end."""
    name = tmp_path / "boat"
    name.symlink_to("/nowhere")
    link = open_link(f"pty:{name}")
    device = os.open(name, os.O_RDWR | os.O_NOCTTY)
    link.send(b"\xfd\x00\r\n")
    assert os.read(device, 10) == b"\xfd\x00\r\n"
    os.write(device, b"hello")
    assert [data for _, data in link.receive(0.0)] == [b"hello"]
    os.close(device)
    link.close()
    assert not name.is_symlink()


def test_the_command_line_is_checked():
    """Start, current, parameters, numbers and key are read, and refused in one line when they cannot be."""
    place, heading = read_start("54.5,10.25,90")
    assert (place.latitude_deg, place.longitude_deg) == (54.5, 10.25)
    assert heading == pytest.approx(1.5708, abs=1e-4)
    assert read_vector("--wind", "0.5,-1") == (0.5, -1.0)
    assert read_parameters(("wp_speed=2",)) == {"WP_SPEED": 2.0}
    for read in (
        lambda: read_start("54.5"),
        lambda: read_start("95,10"),
        lambda: read_start("here"),
        lambda: read_vector("--wind", "1"),
        lambda: read_vector("--wind", "nan,1"),
        lambda: read_parameters(("WP_SPEED",)),
        lambda: Checked(sysid=0, speedup=1.0, ready_s=None, noise_m=0.0),
        lambda: Checked(sysid=1, speedup=0.0, ready_s=None, noise_m=0.0),
        lambda: Checked(sysid=1, speedup=1.0, ready_s=0.0, noise_m=0.0),
        lambda: Checked(sysid=1, speedup=1.0, ready_s=None, noise_m=-1.0),
    ):
        with pytest.raises(ConfigError, match=r"^--"):
            read()


def test_the_key_file(tmp_path):
    """A key of 64 hexadecimal digits is read; a shorter one, none, or a file that is not there is one line."""
    path = tmp_path / "key"
    path.write_text(KEY.hex() + "\n")
    assert read_key(path) == KEY
    assert read_key(None) is None
    path.write_text("abc")
    with pytest.raises(ConfigError, match="64 hexadecimal digits"):
        read_key(path)
    with pytest.raises(ConfigError, match="cannot read"):
        read_key(tmp_path / "none")
