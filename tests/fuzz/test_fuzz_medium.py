"""The water takes anything: whatever modems and craft come up with has its counter, and nothing stops the process."""

import math
import random
from collections import Counter

import pytest
from fuzzing import INPUTS
from slot_water import team_scenario

from grex_link.config import SelfNoiseConfig
from grex_link.link_config import (
    BurstConfig,
    FixedNoise,
    JammerConfig,
    LandConfig,
    LinkConfig,
    OutageConfig,
    ShadowingConfig,
    WaterConfig,
)
from grex_link.medium import Medium, make_medium
from grex_link.messages import ModemStatus, Pose, RangeRequest, RangeResult, Request, Transmit, Truth, TxEvent
from grex_link.units import NS

TEAM = ["auv1", "auv2", "auv3", "gate"]
ADDRESSES = ["", "", "", *TEAM, "nobody", "auv1 ", "*", "ünbekannt"]
NUMBERS = [0.0, 1.0, -80.0, 300.0, 1e5, -1e9, math.nan, math.inf, -math.inf]


def rough_water(profile: str) -> LinkConfig:
    """Everything that can be wrong with a link, at once."""
    return LinkConfig(
        profile=profile,
        loss=0.1,
        burst=BurstConfig(loss=0.2, mean_length_s=20.0, loss_bad=0.9),
        shadowing=ShadowingConfig(sigma_db=6.0, correlation_s=60.0),
        water=WaterConfig(layers=((0.0, 1500.0), (30.0, 1480.0)), noise=FixedNoise(psd_db=60.0)),
        jammers=(JammerConfig((50.0, 50.0, 5.0), 160.0, 100.0, 130.0),),
        outages=tuple(OutageConfig("auv2", 50.0 * n + 20.0, 50.0 * n + 31.7) for n in range(100)),
        land=(LandConfig(("auv1", "gate"), loss=0.1),),
    )


def anything(draw: random.Random, seq: int, now_ns: int) -> Request:
    """A request as no agent would make it."""
    t_ns = now_ns + draw.choice([0, 0, 1, 10**6, 10**8, NS - 1, -1, -NS, -(10**18)])
    seq = draw.choice([seq, seq, seq, seq, max(0, seq - 1), draw.randrange(10**9)])
    if draw.random() < 0.2:
        return RangeRequest(seq, t_ns, draw.choice(ADDRESSES))
    size = draw.choice([0, 1, 15, 15, 15, 64, 65, 128, 192, 193, 5000])
    return Transmit(seq, t_ns, draw.randbytes(size), draw.choice(ADDRESSES), draw.random() < 0.2, draw.random() < 0.1)


def somewhere(draw: random.Random, tick: int) -> Truth:
    """Poses of which now and then one is no number, or beyond the world."""

    def number() -> float:
        return draw.choice(NUMBERS) if draw.random() < 0.02 else draw.uniform(-400.0, 400.0)

    return Truth(
        tick, tick * NS, [Pose(craft, number(), number(), number(), 0.0, 0.0, 0.0, number()) for craft in TEAM]
    )


def feed(medium: Medium, draw: random.Random, inputs: int) -> tuple[Counter, Counter]:
    """Work through many inputs; return what was requested, and what became of it."""
    asked, told, given, tick, seq = Counter(), Counter(), 0, 0, 0
    while given < inputs:
        medium.place(somewhere(draw, tick))
        for _ in range(draw.randrange(4)):
            request = anything(draw, seq, tick * NS)
            source = draw.choice(TEAM)
            medium.request(source, request, request.t_ns)
            asked[source] += not (isinstance(request, Transmit) and request.by_land)
            seq += 1
            given += 1
        tick += 1
        given += 1
        medium.advance(tick * NS)
        count(medium, tick * NS, told)
    medium.advance((tick + 1000) * NS)
    count(medium, (tick + 1000) * NS, told)
    return asked, told


def count(medium: Medium, before_ns: int, told: Counter) -> None:
    for _, craft, event in medium.events(before_ns):
        if isinstance(event, TxEvent | RangeResult | ModemStatus):
            told[type(event).__name__, craft] += 1
    for line in medium.log(before_ns):
        told[line.kind, line.source] += line.purpose in {"data", "ping"}
        told["outcome", line.source] += line.kind in {"delivered", "overheard", "lost"} and line.purpose in {
            "data",
            "ping",
        }
        told[line.reason or line.kind] += 1


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("profile", ["umodem_psk1", "ahoi", "unet_default", "waterlinked_m64", "grex2008"])
def test_the_water_takes_anything(profile: str) -> None:
    """Every request is started or refused, every one started has one outcome a receiver, bad positions are counted."""
    draw = random.Random(profile)
    medium = make_medium(team_scenario(TEAM, rough_water(profile)))
    asked, told = feed(medium, draw, INPUTS // 5)
    for craft in TEAM:
        assert told["started", craft] + told["refused", craft] == asked[craft] > 0
        assert told["outcome", craft] == told["started", craft] * (len(TEAM) - 1)
    reasons = set(told)
    assert {"size", "address", "off", "missed_off"} <= reasons
    if profile not in {"grex2008", "waterlinked_m64"}:
        assert {"busy", "missed_busy", "missed_halfduplex", "lost_noise"} <= reasons


@pytest.mark.timeout(3600)
def test_positions_that_are_no_numbers_are_counted() -> None:
    """A position that is NaN or infinite is counted, its craft goes straight on, and levels stay numbers."""
    medium = make_medium(team_scenario(TEAM, LinkConfig(profile="nm3")))
    draw, bad = random.Random(4), 0
    for tick in range(2000):
        truth = somewhere(draw, tick)
        bad += sum(not all(abs(x) < 1e7 for x in (p.north_m, p.east_m, p.down_m)) for p in truth.poses)
        medium.place(truth)
        medium.request("auv1", Transmit(tick, tick * NS, bytes(15)), tick * NS)
        medium.advance((tick + 1) * NS)
        for line in medium.log((tick + 1) * NS):
            assert line.sinr_db is None or math.isfinite(line.sinr_db)
    assert bad > 50
    assert medium.bad_positions == bad


def test_noise_of_a_craft_whose_speed_is_no_number() -> None:
    """A speed that is NaN gives the noise of a craft at rest."""
    from grex_link.noise_sources import self_noise

    config = SelfNoiseConfig(level_db=80.0, slope_db_per_mps=10.0)
    assert self_noise(config, math.nan) == self_noise(config, 0.0) < self_noise(config, 1.0)
