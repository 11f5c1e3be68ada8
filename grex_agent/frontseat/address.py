"""Addresses of autopilots, as users of MAVLink write them, and what a scenario must say for craft on MAVLink. Pure."""

import re
from dataclasses import dataclass
from pathlib import Path

from grex_link.config import MavlinkFrontseat, Scenario
from grex_link.errors import ConfigError

_FORMS = "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/DEVICE:BAUD"
_NETWORK = re.compile(r"^(udpin|udpout|tcp):(?://)?([^:/\s]+)(?::(\d{1,5}))?/?\Z")
_SERIAL = re.compile(r"^serial:(?://(?=/))?([^:,\s]+)(?:[:,](\d{2,7}))?\Z")
_PORTS = {"udpin": 14550, "udpout": 14550, "tcp": 5760}
_BAUD = 57600
_KEY_BYTES = 32
#: What to look at when an address is good and nobody speaks there.
_LOOK_AT = {
    "udpin": "look whether it is on and sends to this address",
    "udpout": "look whether it is on and listens there",
    "tcp": "look whether it is on and this is its address",
    "serial": "look whether it is on and has this baud rate",
}


@dataclass(frozen=True, slots=True)
class Address:
    """Where an autopilot is.

    Attributes
    ----------
    kind : str
        ``udpin``, ``udpout``, ``tcp`` or ``serial``.
    place : str
        Host, or device.
    number : int
        Port, or bits a second.
    """

    kind: str
    place: str
    number: int


def parse_url(url: str, path: str) -> Address:
    """Read an address.

    Parameters
    ----------
    url : str
        For instance ``udpin:127.0.0.1:14550``; ``udpin://127.0.0.1:14550`` is the same.
    path : str
        Where it stands, for the complaint.

    Raises
    ------
    ConfigError
        If it is no address.
    """
    if found := _NETWORK.match(url):
        kind, host, port = found[1], found[2], int(found[3] or _PORTS[found[1]])
        if 0 < port < 65536:
            return Address(kind, host, port)
    elif found := _SERIAL.match(url):
        return Address("serial", found[1], int(found[2] or _BAUD))
    raise ConfigError(path, f"{url!r} is no address of an autopilot; write {_FORMS}")


def what_to_look_at(url: str) -> str:
    """Say what a person should look at when nobody speaks at an address; an address is read by `parse_url`."""
    return _LOOK_AT.get(url.partition(":")[0], "look whether it is on")


def check_frontseats(scenario: Scenario) -> None:
    """Check what craft on MAVLink need, if there are any.

    Raises
    ------
    ConfigError
        If the pace is lockstep, there is no datum, an address cannot be read or is used twice, or a set-point would be
        stale before the agent can give the next.
    """
    addresses: dict[Address, str] = {}
    for craft, config in scenario.mavlink_craft.items():
        path = f"$.craft.{craft}.frontseat"
        if scenario.clock.lockstep:
            raise ConfigError(path, "an autopilot runs with the wall clock, not in lockstep; set clock.pace to 'live'")
        if scenario.datum is None:
            raise ConfigError(
                "$.datum",
                f"is missing: {craft} is on MAVLink, so say where on earth the mission frame lies, "
                "for instance datum = { latitude_deg = 54.1, longitude_deg = 10.7 }",
            )
        address = parse_url(config.url, f"{path}.url")
        other = addresses.setdefault(address, craft)
        if other != craft:
            _check_shared(scenario, craft, address)
        least_s = 1.5 * scenario.clock.tick_s
        if config.setpoint_age_max_s < least_s:
            problem = (
                f"{config.setpoint_age_max_s:g} s is too short: the agent speaks every {scenario.clock.tick_s:g} s"
            )
            raise ConfigError(f"{path}.setpoint_age_max_s", f"{problem}; {least_s:g} s would do")


def _check_shared(scenario: Scenario, craft: str, address: Address) -> None:
    """Check craft behind one router, which several adapters may connect to; a port or a device has one owner."""
    config, path = scenario.mavlink_craft[craft], f"$.craft.{craft}.frontseat"
    for other, theirs in scenario.mavlink_craft.items():
        if other == craft or parse_url(theirs.url, f"$.craft.{other}.frontseat.url") != address:
            continue
        if address.kind not in {"tcp", "udpout"}:
            raise ConfigError(f"{path}.url", f"{config.url} is the address of {other}, too; every craft needs its own")
        if None in {config.system, theirs.system} or config.system == theirs.system:
            raise ConfigError(f"{path}.system", f"{other} is behind the same router: give each of them its system id")
        if (config.own_system, config.own_component) == (theirs.own_system, theirs.own_component):
            raise ConfigError(
                f"{path}.own_component", f"{other} is behind the same router and has it, too: give one another, say 192"
            )


def read_key(config: MavlinkFrontseat, path: str) -> bytes | None:
    """Read the signing key of a craft, if it has one.

    Raises
    ------
    ConfigError
        If the file cannot be read, or does not hold 32 bytes in hexadecimal.
    """
    if config.signing_key_file is None:
        return None
    where = f"{path}.signing_key_file"
    try:
        key = bytes.fromhex(Path(config.signing_key_file).read_text(encoding="ascii").strip())
    except OSError as error:
        raise ConfigError(where, f"cannot read {config.signing_key_file}: {error.strerror}") from None
    except ValueError:
        key = b""
    if len(key) != _KEY_BYTES:
        raise ConfigError(
            where, f"{config.signing_key_file} must hold {_KEY_BYTES} bytes as {2 * _KEY_BYTES} hex digits"
        )
    return key
