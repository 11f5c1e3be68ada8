"""What the Micro-Modem puts into one packet, and under which addresses: rates, padding, the team's numbers.

Sources: GobySoft goby, ``mm_driver`` (frames and bytes of the rates 0 to 5); acomms.whoi.edu (rate 6); WHOI libumutil.
"""

from dataclasses import dataclass
from pathlib import PurePath

from grex_link.config import Scenario, SerialModem
from grex_link.errors import ConfigError
from grex_link.profile import ModemProfile, load_profile
from grex_link.units import NS

#: Everybody's address on the air.
BROADCAST_ADDRESS = 15
HIGHEST_ADDRESS = 127
_PAD = b"\x80"
_ANSWER_RANGE_M = 5000.0
_SLOWEST_MPS = 1400.0


@dataclass(frozen=True, slots=True)
class Rate:
    """One kind of packet.

    Attributes
    ----------
    number : int
        Packet type of ``$CCCYC``; -1 for the user's minipacket of 13 bits.
    frames : int
        Most frames in a packet.
    frame_bytes : int
        Bytes of a frame.
    """

    number: int
    frames: int
    frame_bytes: int

    @property
    def mini(self) -> bool:
        """Whether this is the minipacket, which needs no cycle."""
        return self.number < 0

    def split(self, payload: bytes) -> list[bytes] | None:
        """Cut a payload into full frames, as few as hold it.

        The modem keeps the length of a packet, not that of a payload: one that does not fill its frames ends in 0x80
        and zeros. A payload that fills them goes as it is, unless it ends like that itself.

        Returns
        -------
        list of bytes or None
            The frames; None if the payload is too long, or if it fills the longest packet and ends in 0x80 and zeros,
            which is one of 256 among payloads of just that length: nobody could tell it from a shorter one.
        """
        if self.mini:
            return [payload] if len(payload) == 2 and payload[0] < 0x20 else None
        count = max(1, -(-len(payload) // self.frame_bytes))
        if len(payload) == count * self.frame_bytes and join([payload]) != payload:
            count += 1
        if count > self.frames:
            return None
        if len(payload) < count * self.frame_bytes:
            payload = (payload + _PAD).ljust(count * self.frame_bytes, b"\0")
        return [payload[at : at + self.frame_bytes] for at in range(0, len(payload), self.frame_bytes)]


def join(frames: list[bytes]) -> bytes:
    """Put the frames of a packet together and take off what `Rate.split` has added."""
    whole = b"".join(frames)
    bare = whole.rstrip(b"\0")
    return bare[:-1] if bare.endswith(_PAD) else whole


#: By the name of the modem profile.
RATES = {
    "umodem_mini": Rate(-1, 1, 2),
    "umodem_fsk0": Rate(0, 1, 32),
    "umodem_psk1": Rate(1, 3, 64),
    "umodem_psk2": Rate(2, 3, 64),
    "umodem_psk3": Rate(3, 2, 256),
    "umodem_psk4": Rate(4, 2, 256),
    "umodem_psk5": Rate(5, 8, 256),
    "umodem_psk6": Rate(6, 6, 32),
}


@dataclass(frozen=True, slots=True)
class Setup:
    """What the driver of one craft's modem must know.

    Attributes
    ----------
    craft : str
        Whose modem it is.
    addresses : dict of str to int
        Addresses of all craft.
    rate : Rate
        The packets it sends.
    payload_max_bytes : int
        Longest payload the profile allows.
    airtime_ns : int
        Of the longest packet, cycle initialisation included.
    answer_ns : int
        How long after a packet its acknowledgement may come, or the answer to a ping.
    nominal_mps : float
        Speed of sound that travel times are converted with.
    two_way, acknowledges : bool
        Whether ranges and acknowledgements may be asked for.
    """

    craft: str
    addresses: dict[str, int]
    rate: Rate
    payload_max_bytes: int
    airtime_ns: int
    answer_ns: int
    nominal_mps: float
    two_way: bool = True
    acknowledges: bool = True

    @property
    def own(self) -> int:
        """The own address."""
        return self.addresses[self.craft]


def plan_addresses(scenario: Scenario) -> dict[str, int]:
    """Give every craft its address: the configured one, or its place in the team, counted from 1 without 15.

    Raises
    ------
    ConfigError
        If two have the same, or one has an address that the Micro-Modem does not have or that means everybody.
    """
    addresses: dict[str, int] = {}
    for place, (craft, config) in enumerate(scenario.craft.items(), start=1):
        chosen = config.modem.address if isinstance(config.modem, SerialModem) else None
        address = place + (place >= BROADCAST_ADDRESS) if chosen is None else chosen
        path = f"$.craft.{craft}.modem.address"
        if address == BROADCAST_ADDRESS:
            raise ConfigError(path, f"{BROADCAST_ADDRESS} is the broadcast address; choose another")
        if address > HIGHEST_ADDRESS:
            raise ConfigError(path, f"{address} is above {HIGHEST_ADDRESS}, the highest address of a Micro-Modem")
        if address in addresses.values():
            other = next(name for name, taken in addresses.items() if taken == address)
            raise ConfigError(path, f"{address} is the address of {other}, too; give every craft its own")
        addresses[craft] = address
    return addresses


def plan_setup(scenario: Scenario, craft: str, profile: ModemProfile) -> Setup:
    """Work out what the driver of one craft's modem must know.

    Raises
    ------
    ConfigError
        If the scenario's modem profile is none of a Micro-Modem, or it has no addresses for the team.
    """
    name = PurePath(scenario.link.profile).stem
    if name not in RATES:
        known = ", ".join(RATES)
        raise ConfigError("$.link.profile", f"{name!r} is no rate of a serial Micro-Modem; these are: {known}")
    ping_ns = profile.ping_airtime_ns
    reach_m = min(profile.range_max_m or _ANSWER_RANGE_M, _ANSWER_RANGE_M)
    there_and_back_s = 2.0 * reach_m / _SLOWEST_MPS + profile.ranging.reply_s + 2.0 * profile.decode_latency_s
    return Setup(
        craft,
        plan_addresses(scenario),
        RATES[name],
        min(profile.payload_max_bytes, RATES[name].frames * RATES[name].frame_bytes),
        profile.airtime_ns(profile.payload_max_bytes),
        2 * ping_ns + round(there_and_back_s * NS),
        scenario.link.water.nominal_sound_speed_mps,
        profile.ranging.two_way,
        profile.acknowledges,
    )


def check_serial_modems(scenario: Scenario) -> None:
    """Check what the serial modems of a scenario need, if it has any.

    Raises
    ------
    ConfigError
        If the pace is not that of the wall clock, two modems share a port, or a land link ends at a craft with a
        serial modem; for rate and addresses see `plan_setup`.
    """
    ports: dict[str, str] = {}
    for craft, config in scenario.craft.items():
        if not isinstance(config.modem, SerialModem):
            continue
        path = f"$.craft.{craft}.modem"
        if scenario.clock.pace not in {"live", 1.0}:
            pace = scenario.clock.pace
            raise ConfigError(
                path, f"a real modem runs with the wall clock, not at clock.pace {pace!r}; 'live' would do"
            )
        other = ports.setdefault(config.modem.port, craft)
        if other != craft:
            raise ConfigError(f"{path}.port", f"{config.modem.port} is the port of {other}, too")
        for place, land in enumerate(scenario.link.land):
            if craft in land.between:
                raise ConfigError(f"$.link.land[{place}].between", f"{craft} has a serial modem and no other link")
        plan_setup(scenario, craft, load_profile(scenario.link.profile))
