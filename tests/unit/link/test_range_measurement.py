"""What modems measure of distances: there and back, and one way by clocks that need not agree."""

import math
from statistics import fmean, pstdev

import pytest
from acoustic_water import AcousticWater, plain

from grex_link.config import CraftClockConfig, CraftConfig
from grex_link.link_config import LinkConfig, RangingErrors, WaterConfig
from grex_link.messages import RangeResult, Received, TxEvent
from grex_link.profile import Ranging

PAIR = {"a": (0.0, 0.0, 0.0), "b": (750.0, 0.0, 0.0)}
MANY = 20_000


def heard(water: AcousticWater, craft: str) -> list[Received]:
    return [event for _, who, event in water.events() if who == craft and isinstance(event, Received)]


def two_way(**ranging) -> Ranging:
    return Ranging(**{"two_way": True, "sigma_m": 0.0, "reply_s": 0.3, "ping_bytes": 2} | ranging)


def range_of(water: AcousticWater, t_s: float = 0.0, destination: str = "b") -> RangeResult:
    water.ping("a", t_s, destination)
    (result,) = [event for *_, event in water.events() if isinstance(event, RangeResult)]
    return result


def test_two_way_range() -> None:
    """Without noise a range is the true one, whatever airtime, decoding and the other's reply take."""
    profile = plain(airtime_per_byte_s=0.07, decode_latency_s=0.11, turnaround_s=0.2, ranging=two_way())
    assert range_of(AcousticWater(PAIR, profile)) == RangeResult(0, "b", pytest.approx(750.0, abs=1e-6))


def test_range_at_the_nominal_speed_of_sound() -> None:
    """Modems reckon with the nominal speed of sound: where sound is 2 % faster, ranges are 2 % short."""
    link = LinkConfig(water=WaterConfig(sound_speed=1530.0))
    result = range_of(AcousticWater(PAIR, plain(ranging=two_way()), link))
    assert result.range_m == pytest.approx(750.0 * 1500.0 / 1530.0, abs=1e-5)


def test_range_to_nobody() -> None:
    """A range to who is out of reach is None; one to who is unknown, or on a modem that measures none, has failed."""
    profile = plain(ranging=two_way(), range_max_m=500.0)
    assert range_of(AcousticWater(PAIR, profile)) == RangeResult(0, "b", None)
    for water, destination, reason in (
        (AcousticWater(PAIR, profile), "nobody", "address"),
        (AcousticWater(PAIR), "b", "error"),
    ):
        water.ping("a", 0.0, destination)
        assert [event for *_, event in water.events()] == [TxEvent(0, "FAILED", reason)]


def pinged(ranging: Ranging, errors: RangingErrors, count: int) -> list[float]:
    water = AcousticWater(PAIR, plain(airtime_fixed_s=0.1, ranging=ranging), LinkConfig(ranging=errors))
    for number in range(count):
        water.ping("a", 3.0 * number, "b")
    return [event.range_m for *_, event in water.events() if isinstance(event, RangeResult)]


def test_noise_of_ranges() -> None:
    """Over 20 000 ranges mean and standard deviation are the modem's, within four standard errors."""
    errors = [range_m - 750.0 for range_m in pinged(two_way(sigma_m=0.1), RangingErrors(), MANY)]
    assert len(errors) == MANY
    assert abs(fmean(errors)) < 4.0 * 0.1 / math.sqrt(MANY)
    assert abs(pstdev(errors) - 0.1) < 4.0 * 0.1 / math.sqrt(2.0 * MANY)


def test_steps_of_ranges() -> None:
    """Ranges are whole steps, and no step is skipped: the nearest one is taken."""
    ranges = pinged(two_way(sigma_m=0.1, step_m=0.047), RangingErrors(), 500)
    steps = [range_m / 0.047 for range_m in ranges]
    assert all(abs(step - round(step)) < 1e-6 for step in steps)
    assert len({round(step) for step in steps}) > 8
    assert pinged(two_way(step_m=0.047), RangingErrors(), 1) == [pytest.approx(round(750.0 / 0.047) * 0.047)]


def test_outliers_of_ranges() -> None:
    """Of 20 000 ranges the share asked for is too long, evenly up to the longest extra path, and none is too short."""
    share = 0.05
    extra = [range_m - 750.0 for range_m in pinged(two_way(), RangingErrors(share, 40.0), MANY)]
    outliers = [more for more in extra if more > 1e-3]
    assert abs(len(outliers) / MANY - share) < 4.0 * math.sqrt(share * (1.0 - share) / MANY)
    assert max(outliers) <= 40.0
    assert min(extra) > -1e-6
    assert abs(fmean(outliers) - 20.0) < 4.0 * 40.0 / math.sqrt(12.0 * len(outliers))


def one_way_s(offset_a_s: float = 0.0, offset_b_s: float = 0.0, drift_b_ppm: float = 0.0, t_s: float = 0.0) -> float:
    profile = plain(ranging=Ranging(one_way=True, sigma_m=0.0, ambiguity_s=1.0))
    craft = {
        "a": CraftConfig(clock=CraftClockConfig(offset_a_s)),
        "b": CraftConfig(clock=CraftClockConfig(offset_b_s, drift_b_ppm)),
    }
    water = AcousticWater(PAIR, profile, craft=craft)
    water.send("a", t_s)
    (event,) = heard(water, "b")
    return event.one_way_s


def test_one_way_range_with_clocks_that_agree() -> None:
    """With clocks that agree the one-way travel time is the true one."""
    assert one_way_s() == pytest.approx(0.5, abs=1e-9)
    assert one_way_s(2.0, 2.0) == pytest.approx(0.5, abs=1e-9)


def test_one_way_range_with_clocks_that_disagree() -> None:
    """A receiver's clock that is 1 ms ahead makes 1.5 m more; a sender's, 1.5 m less; 20 ppm make 0.4 s in 20 000 s."""
    assert (one_way_s(offset_b_s=0.001) - 0.5) * 1500.0 == pytest.approx(1.5, abs=1e-5)
    assert (one_way_s(offset_a_s=0.001) - 0.5) * 1500.0 == pytest.approx(-1.5, abs=1e-5)
    assert one_way_s(drift_b_ppm=20.0, t_s=20_000.0) == pytest.approx(0.9, abs=1e-4)


def test_one_way_range_is_ambiguous() -> None:
    """One-way travel times are known modulo a second: clocks 0.7 s apart say 0.2 s, and never less than nothing."""
    assert one_way_s(offset_b_s=0.7) == pytest.approx(0.2, abs=1e-9)
    assert one_way_s(offset_a_s=0.7) == pytest.approx(0.8, abs=1e-9)
    assert one_way_s(offset_b_s=3.0) == pytest.approx(0.5, abs=1e-9)


def test_no_one_way_range() -> None:
    """A modem that cannot measure it shows none: a travel time would be a range for nothing."""
    water = AcousticWater(PAIR)
    water.send("a", 0.0)
    assert [event.one_way_s for event in heard(water, "b")] == [None]


def test_noise_of_one_way_ranges() -> None:
    """Over 20 000 packets the noise of one-way ranges is the modem's."""
    water = AcousticWater(PAIR, plain(ranging=Ranging(one_way=True, sigma_m=0.3)))
    for number in range(MANY):
        water.send("a", 2.0 * number)
    errors = [event.one_way_s * 1500.0 - 750.0 for event in heard(water, "b")]
    assert len(errors) == MANY
    assert abs(fmean(errors)) < 4.0 * 0.3 / math.sqrt(MANY)
    assert abs(pstdev(errors) - 0.3) < 4.0 * 0.3 / math.sqrt(2.0 * MANY)
