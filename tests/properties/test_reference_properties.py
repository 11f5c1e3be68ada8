"""`grex medium` against a second program that was written from the specification alone, packet by packet."""

import math
import random
from collections import Counter

from hypothesis import given, settings
from hypothesis import strategies as st
from reference_medium import Verdict, Water, outcomes

from grex_link.link_config import WenzNoise
from grex_link.replay import MediumConfig, ModemConfig, NodeConfig, Replay, ReplayConfig, Transmission

Row = tuple[float, str, int]

#: What the reference says in its own words.
SAME_REASON = {
    "": "",
    "busy": "busy",
    "missed_halfduplex": "halfduplex",
    "missed_busy": "busy",
    "missed_snr": "acquisition",
    "aborted_own_tx": "own_tx",
    "lost_noise": "sinr",
    "lost_collision": "sinr",
}


def replayed(water: Water, rows: list[Row]) -> list[tuple[str, ...]]:
    places = {name: place for place, name in enumerate(water.nodes)}
    config = ReplayConfig(
        MediumConfig(
            water.acquisition_sinr_db,
            water.survival_sinr_db,
            water.sound_speed_mps,
            "thorp",
            water.spreading,
            WenzNoise(water.wind_mps, water.shipping),
        ),
        ModemConfig(water.frequency_hz, water.bandwidth_hz, water.source_level_db, water.bit_rate_bps),
        tuple(NodeConfig(name, position) for name, position in water.nodes.items()),
    )
    schedule = [Transmission(repr(t_s), round(t_s * 1e9), places[source], size) for t_s, source, size in rows]
    replay = Replay(config, schedule)
    replay.run()
    return list(replay.rows())


def agrees(row: tuple[str, ...], verdict: Verdict) -> bool:
    numbers = [float(text) for text in row[5:9]]
    wanted = [verdict.range_m, verdict.delay_s, verdict.level_db, verdict.sinr_db]
    if verdict.outcome == "not_sent_busy":
        numbers, wanted = numbers[:3], wanted[:3]
    # Six decimals are printed: half a unit of the last, and what floats lose.
    near = all(math.isclose(got, want, rel_tol=1e-12, abs_tol=1e-6) for got, want in zip(numbers, wanted, strict=True))
    return near and row[3] == verdict.outcome and SAME_REASON[row[4]] == verdict.reason


def compare(water: Water, rows: list[Row]) -> Counter[tuple[str, str]]:
    """Assert that every row agrees, and count the outcomes and reasons."""
    verdicts = outcomes(water, rows)
    wanted = [(number, name) for number, row in enumerate(rows) for name in water.nodes if name != row[1]]
    got = replayed(water, rows)
    assert [(row[0], row[1], row[2]) for row in got] == [(repr(rows[k][0]), rows[k][1], name) for k, name in wanted]
    for row, which in zip(got, wanted, strict=True):
        assert agrees(row, verdicts[which]), (row, verdicts[which])
    return Counter((row[3], row[4]) for row in got)


# -- thousands of dense schedules --------------------------------------------------------------------------------


def positions(chance: random.Random, size: int) -> list[tuple[float, float, float]]:
    """Places anywhere, on a grid (some in the same place), far apart, or on a ring, so that arrivals tie."""
    kind = chance.choice(["anywhere", "grid", "far", "ring"])
    if kind == "anywhere":
        return [tuple(chance.uniform(-1000.0, 1000.0) for _ in range(3)) for _ in range(size)]
    if kind == "grid":
        pitch_m = chance.choice([0.0, 1.5, 150.0, 1500.0, 15_000.0])
        return [tuple(pitch_m * chance.choice([-1, 0, 1]) for _ in range(3)) for _ in range(size)]
    if kind == "far":
        return [
            tuple(chance.choice([100.0, 1e4, 1e5]) * chance.uniform(-1.0, 1.0) for _ in range(3)) for _ in range(size)
        ]
    angles = [2.0 * math.pi * place / size for place in range(size)]
    return [(750.0 * math.cos(angle), 750.0 * math.sin(angle), 0.0) for angle in angles]


def random_water(chance: random.Random) -> Water:
    acquisition_db = chance.choice([-10.0, -3.0, 0.0, 3.0, 6.0, 10.0, 15.0])
    places = positions(chance, chance.choice([3, 4, 5]))
    return Water(
        sound_speed_mps=chance.choice([1500.0, 1500.0, 1480.3]),
        spreading=chance.choice([1.0, 1.5, 2.0]),
        acquisition_sinr_db=acquisition_db,
        survival_sinr_db=acquisition_db + chance.choice([0.0, -2.0, -6.0, 3.0]),
        wind_mps=chance.choice([0.0, 5.0, 15.0]),
        shipping=chance.choice([0.0, 0.5, 1.0]),
        frequency_hz=chance.choice([10e3, 25e3, 60e3]),
        bandwidth_hz=chance.choice([1e3, 4e3]),
        source_level_db=chance.choice([60.0, 100.0, 140.0, 185.0]),
        bit_rate_bps=chance.choice([80.0, 500.0, 1000.0, 8000.0]),
        nodes={f"n{place}": position for place, position in enumerate(places)},
    )


def random_rows(chance: random.Random, names: list[str]) -> list[Row]:
    """Dense traffic, in any order; times to the millisecond, to the tenth or to the second, so that many tie."""
    span_s = chance.choice([5, 20, 60])
    times = [lambda: round(chance.uniform(0, span_s), 3), lambda: chance.randint(0, 10 * span_s) / 10]
    times.append(lambda: float(chance.randint(0, span_s)))
    count = chance.randint(3, 40)
    return [(chance.choice(times)(), chance.choice(names), chance.choice([1, 8, 16, 32, 64])) for _ in range(count)]


def test_every_packet_of_thousands_of_schedules() -> None:
    """With Thorp, fixed sound speed and fixed noise every outcome, reason, delay, level and SINR is the reference's."""
    seen: Counter[tuple[str, str]] = Counter()
    for seed in range(1500):
        chance = random.Random(seed)
        water = random_water(chance)
        seen += compare(water, random_rows(chance, list(water.nodes)))
    # The schedules are worth something only if everything that can happen happens often.
    assert len(seen) == len(SAME_REASON)
    assert min(seen.values()) > 150, seen


@given(st.integers(3, 5), st.data())
@settings(max_examples=150)
def test_levels_at_the_thresholds(size: int, data: st.DataObject) -> None:
    """Where every level is within a tenth of a decibel of a threshold, the outcomes still are the reference's."""
    # In a row 50 m apart, so that neighbours tie; no threshold is met exactly, which would be for rounding to decide.
    nodes = {f"n{place}": (50.0 * place, 0.0, 0.0) for place in range(size)}
    alone = Water(1500.0, 1.5, 0.0, 0.0, 5.0, 0.5, 25e3, 4e3, 120.0, 100.0, nodes)
    silent = outcomes(alone, [(0.0, "n0", 1)])
    crowded = outcomes(alone, [(0.0, "n0", 1), (0.0, "n2", 1)])
    heard_db = st.sampled_from([verdict.sinr_db for verdict in (*silent.values(), *crowded.values())])
    threshold_db = st.builds(lambda db, steps: db + (2 * steps + 1) / 200, heard_db, st.integers(-10, 9))
    water = Water(
        1500.0, 1.5, data.draw(threshold_db), data.draw(threshold_db), 5.0, 0.5, 25e3, 4e3, 120.0, 100.0, nodes
    )
    row = st.tuples(st.integers(0, 40).map(lambda tenths: tenths / 10), st.sampled_from(list(nodes)), st.integers(1, 9))
    compare(water, data.draw(st.lists(row, min_size=1, max_size=15)))


@given(st.lists(st.tuples(st.integers(0, 12), st.sampled_from("abcd"), st.integers(1, 3)), min_size=1, max_size=20))
def test_grid_of_ties(grid: list[tuple[int, str, int]]) -> None:
    """Where starts, ends and arrivals all fall on the same ticks, the order of equal times is the reference's."""
    # 750 m take half a second; a byte at 16 bit/s takes half a second, too. c and d are in one place.
    nodes = {"a": (0.0, 0.0, 0.0), "b": (750.0, 0.0, 0.0), "c": (0.0, 750.0, 0.0), "d": (0.0, 750.0, 0.0)}
    for threshold_db in (-6.0, 0.0, 6.0):
        water = Water(1500.0, 1.5, threshold_db, threshold_db, 5.0, 0.5, 25e3, 4e3, 150.0, 16.0, nodes)
        compare(water, [(ticks / 2, source, size) for ticks, source, size in grid])
