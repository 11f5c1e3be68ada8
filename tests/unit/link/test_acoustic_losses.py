"""What a packet that was locked to is worth: error tables, ranges, interference, fading, and the protocol model."""

import math
from statistics import fmean

import pytest
from acoustic_water import STILL, AcousticWater, fates, plain, triangle

from grex_link.link_config import FixedNoise, LinkConfig, WaterConfig
from grex_link.messages import BadFrame, Received
from grex_link.profile import ErrorTable, InterferenceTable, ModemProfile, Protocol, RangeTable, Threshold

PACKETS = 20_000


def at_range(range_m: float) -> dict[str, tuple[float, float, float]]:
    return {"a": (0.0, 0.0, 0.0), "b": (range_m, 0.0, 0.0)}


def reasons(places, profile: ModemProfile, link: LinkConfig = STILL, packets: int = PACKETS) -> list[str]:
    """Send packets from a that do not disturb each other, and return their fates at b."""
    water = AcousticWater(places, profile, link)
    for number in range(packets):
        water.send("a", 10.0 * number)
    return [reason for (_, _, receiver), reason in fates(water.run()).items() if receiver == "b"]


def assert_lost(fate: list[str], reason: str, share: float) -> None:
    assert set(fate) <= {"", reason}
    assert abs(fate.count(reason) / len(fate) - share) <= 4.0 * math.sqrt(share * (1.0 - share) / len(fate))


def quiet(snr_db: float) -> LinkConfig:
    """Return water in which the plain modem is heard with a given SNR a metre away."""
    psd_db = 185.0 - snr_db - 10.0 * math.log10(4000.0)
    return LinkConfig(water=WaterConfig(noise=FixedNoise(psd_db=psd_db), absorption="thorp"))


@pytest.mark.parametrize(("snr_db", "rate"), [(3.0, 0.9), (5.0, 0.7), (8.0, 0.3), (20.0, 0.1)])
def test_error_table(snr_db: float, rate: float) -> None:
    """Of 20 000 packets the share of the error table at their SNR is lost, between its points and beyond them."""
    profile = plain(reception=ErrorTable((4.0, 6.0, 10.0), (0.9, 0.5, 0.1)), acquisition_sinr_db=0.0)
    assert_lost(reasons(at_range(1.0), profile, quiet(snr_db)), "lost_noise", rate)


def test_range_table() -> None:
    """Of 20 000 packets the share of the range table arrives; beyond its last point nothing is heard."""
    table = RangeTable((12.0, 24.0, 152.0, 200.0), (0.95, 0.7, 0.5, 0.0))
    assert_lost(reasons(at_range(18.0), plain(range_pdr=table)), "lost_noise", 1.0 - 0.825)
    assert set(reasons(at_range(200.5), plain(range_pdr=table), packets=20)) == {"out_of_range"}


def test_interference_table() -> None:
    """Of two equal packets the locked one survives with the table's share at 0 dB, and the other is missed."""
    profile = plain(reception=Threshold(-10.0), interference_pdr=InterferenceTable((-1.0, 1.0), (0.0, 0.8)))
    water = AcousticWater(triangle(150.0), profile)
    for number in range(PACKETS):
        water.send("a", 10.0 * number)
        water.send("b", 10.0 * number + 0.5)
    log = fates(water.run())
    assert {log["b", number, "c"] for number in range(PACKETS)} == {"missed_busy"}
    assert_lost([log["a", number, "c"] for number in range(PACKETS)], "lost_collision", 0.6)


def test_who_is_blamed() -> None:
    """What noise alone would have spoiled as well is lost to noise, what it would not, to the collision."""
    water = AcousticWater(triangle(150.0), plain(reception=Threshold(6.0), acquisition_sinr_db=-20.0))
    water.send("a", 0.0)
    water.send("b", 0.5)
    assert fates(water.run())["a", 0, "c"] == "lost_collision"
    deaf = plain(reception=Threshold(6.0), acquisition_sinr_db=-20.0)
    assert reasons(at_range(1.0), deaf, quiet(5.0), 1) == ["lost_noise"]


def test_range_max() -> None:
    """Beyond the modem's reach nothing is heard, however loud."""
    profile = plain(range_max_m=100.0)
    assert reasons(at_range(100.0), profile, packets=1) == [""]
    assert reasons(at_range(100.1), profile, packets=1) == ["out_of_range"]


@pytest.mark.parametrize("k", [0.0, 10.0])
def test_rician_fading(k: float) -> None:
    """Over 20 000 packets the received power has mean 1 and variance (1 + 2K)/(1 + K)²; K = 0 is Rayleigh's."""
    water = AcousticWater(at_range(1.0), plain(rician_k=k), quiet(90.0))
    for number in range(PACKETS):
        water.send("a", 10.0 * number)
    heard = [event for *_, event in water.events() if isinstance(event, Received)]
    assert len(heard) == PACKETS
    # The path is a metre long: nothing but 3 mdB of absorption at most, within the rounding of the level.
    power = [10.0 ** ((event.rssi_db - 185.0) / 10.0) for event in heard]
    variance = (1.0 + 2.0 * k) / (1.0 + k) ** 2
    assert abs(fmean(power) - 1.0) < 4.0 * math.sqrt(variance / PACKETS) + 0.003
    measured = fmean((p - 1.0) ** 2 for p in power)
    fourth = fmean((p - 1.0) ** 4 for p in power)
    assert abs(measured - variance) < 4.0 * math.sqrt((fourth - measured**2) / PACKETS) + 0.003


# -- the protocol model ----------------------------------------------------------------------------------------------

UNET = plain(reception=Protocol(communication_m=2000.0, detection_m=2500.0, interference_m=3000.0))


@pytest.mark.parametrize(
    ("range_m", "reason", "frames"),
    [(2000.0, "", 0), (2001.0, "lost_noise", 1), (2500.0, "lost_noise", 1), (2501.0, "out_of_range", 0)],
)
def test_ranges_of_the_protocol_model(range_m: float, reason: str, frames: int) -> None:
    """Within Rc a packet is whole, within Rd it is detected and garbled, beyond it is not heard."""
    water = AcousticWater(at_range(range_m), UNET)
    water.send("a", 0.0)
    assert sum(isinstance(event, BadFrame) for *_, event in water.events()) == frames
    assert fates(water.run())["a", 0, "b"] == reason


@pytest.mark.parametrize(("range_m", "reason"), [(2999.0, "lost_collision"), (3001.0, "")])
def test_interference_of_the_protocol_model(range_m: float, reason: str) -> None:
    """Who speaks within Ri spoils a packet, though nobody could hear it itself; beyond it does not."""
    places = {"a": (0.0, 0.0, 0.0), "b": (100.0, 0.0, 0.0), "c": (100.0 + range_m, 0.0, 0.0)}
    water = AcousticWater(places, UNET)
    water.send("a", 10.0)
    water.send("c", 10.5 - range_m / 1500.0)
    log = fates(water.run())
    assert (log["a", 0, "b"], log["c", 0, "b"]) == (reason, "out_of_range")


def test_chances_of_the_protocol_model() -> None:
    """Of 20 000 packets the shares that are detected and whole are the model's."""
    chances = Protocol(
        communication_m=2000.0, detection_m=2500.0, interference_m=3000.0, detection=0.9, communication=0.7
    )
    fate = reasons(at_range(500.0), plain(reception=chances))
    undetected, garbled = fate.count("out_of_range"), fate.count("lost_noise")
    assert undetected + garbled + fate.count("") == PACKETS
    assert abs(undetected / PACKETS - 0.1) < 4.0 * math.sqrt(0.09 / PACKETS)
    detected = PACKETS - undetected
    assert abs(garbled / detected - 0.3) < 4.0 * math.sqrt(0.21 / detected)
