"""Paths from true poses, and levels that change slowly."""

import math

import numpy as np
import pytest

from grex_link.acoustics import Water, absorption_ainslie_mccolm
from grex_link.link_config import ShadowingConfig, WaterConfig
from grex_link.propagation import Propagation, Shadowing
from grex_link.units import NS

THORP = WaterConfig(absorption="thorp")
#: Thorp at 25 kHz, dB/km.
ALPHA = 0.11 * 625.0 / 626.0 + 44.0 * 625.0 / 4725.0 + 2.75e-4 * 625.0 + 0.003
PLACES = [(0.0, 0.0, 0.0), (3000.0, 4000.0, 0.0), (0.0, 0.0, 150.0), (0.0, 0.0, 0.5)]


def propagation(places=PLACES, water: WaterConfig = THORP, shadowing: Shadowing | None = None) -> Propagation:
    return Propagation(Water(water, 25_000.0, 4_000.0), 185.0, places, shadowing)


def test_paths() -> None:
    """Receivers come in the order of their delays, with range, delay and level; within a metre nothing spreads."""
    paths = propagation().paths(0, 0)
    assert paths.receivers == [3, 2, 1]
    assert paths.range_m.tolist() == pytest.approx([0.5, 150.0, 5000.0])
    assert paths.delay_ns == [round(0.5 / 1500.0 * NS), NS // 10, round(5000.0 / 1500.0 * NS)]
    assert paths.gap_ns == np.diff(paths.delay_ns).tolist()
    levels = [185.0 - 15.0 * math.log10(max(r, 1.0)) - ALPHA * r / 1000.0 for r in (0.5, 150.0, 5000.0)]
    assert paths.level_db.tolist() == pytest.approx(levels, abs=1e-9)


def test_absorption_at_depth() -> None:
    """Absorption is that of the mean depth of a path."""
    some = propagation([(0.0, 0.0, 500.0), (3000.0, 0.0, 2500.0)], WaterConfig())
    absorption = float(absorption_ainslie_mccolm(25.0, 10.0, 35.0, 8.0, 1.5))
    length_m = math.hypot(3000.0, 2000.0)
    level_db = 185.0 - 15.0 * math.log10(length_m) - absorption * length_m / 1000.0
    assert some.paths(0, 0).level_db.tolist() == pytest.approx([level_db], abs=1e-9)


def test_there_and_back() -> None:
    """A path is as long, slow and loud in one direction as in the other, through layers, too."""
    layered = WaterConfig(layers=((0.0, 1520.0), (50.0, 1480.0), (200.0, 1500.0)))
    somewhere = propagation([(0.0, 0.0, 10.0), (400.0, -300.0, 120.0), (5.0, 0.0, 10.0)], layered)
    columns = {}
    for source in range(3):
        paths = somewhere.paths(source, 0)
        for row in zip(paths.receivers, paths.delay_ns, paths.range_m, paths.level_db, strict=True):
            columns[source, row[0]] = row[1:]
    for (source, receiver), (delay_ns, *there) in columns.items():
        back_ns, *back = columns[receiver, source]
        assert abs(delay_ns - back_ns) <= 1  # rounding
        assert there == pytest.approx(back, rel=1e-12)


def test_prepared_paths_are_the_same() -> None:
    """Paths that are computed together are bit for bit those that are computed one by one, wherever the craft go."""
    alone, together = propagation(), propagation()
    moved = [(n + 2.0, e - 1.0, d) for n, e, d in PLACES]
    for some in (alone, together):
        some.place(0, PLACES)
        some.place(NS, moved)
    sends = [(source, NS + 123_456_789 * number) for number in range(9) for source in range(4)]
    together.prepare(sends)
    for source, t_ns in reversed(sends):
        one, other = alone.paths(source, t_ns), together.paths(source, t_ns)
        assert one[:3] == other[:3]
        assert (one.range_m == other.range_m).all()
        assert (one.level_db == other.level_db).all()


def test_prepared_paths_are_forgotten() -> None:
    """New poses count at once, whatever was prepared for that time."""
    some = propagation()
    some.prepare([(0, 5), (1, 5)])
    some.place(4, [(0.0, 0.0, 0.0), (30.0, 40.0, 0.0), (0.0, 0.0, 150.0), (0.0, 0.0, 0.5)])
    assert some.paths(0, 5).range_m.tolist() == pytest.approx([0.5, 50.0, 150.0])


def test_carried_on_for_a_while() -> None:
    """Between poses a craft goes straight on, for ten seconds at most: nobody has said that it still moves."""
    some = propagation([(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
    some.place(0, [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0)])
    some.place(2 * NS, [(0.0, 0.0, 0.0), (104.0, 0.0, 0.0)])
    distances = [float(some.paths(0, t_s * NS).range_m[0]) for t_s in (2, 3, 12, 60)]
    assert distances == pytest.approx([104.0, 106.0, 124.0, 124.0])
    assert some.closing_mps(0, 1, 3 * NS) == pytest.approx(2.0)
    assert some.closing_mps(1, 0, 3 * NS) == pytest.approx(2.0)


def test_in_one_place() -> None:
    """Two craft in one place hear each other at once, and their distance does not change."""
    some = propagation([(1.0, 2.0, 3.0), (1.0, 2.0, 3.0)])
    paths = some.paths(0, 0)
    assert (paths.delay_ns, paths.level_db.tolist()) == ([0], [185.0])
    assert some.closing_mps(0, 1, 0) == 0.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_positions_that_are_no_numbers(bad: float) -> None:
    """Such a position is counted once and replaced by where the craft would be; the others' are taken."""
    some = propagation([(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
    some.place(0, [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0)])
    some.place(NS, [(0.0, 0.0, 0.0), (101.0, 0.0, 0.0)])
    some.place(2 * NS, [(0.0, 50.0, 0.0), (5000.0, bad, 0.0)])
    assert some.bad_positions == 1
    assert some.paths(0, 2 * NS).range_m.tolist() == pytest.approx([math.hypot(102.0, 50.0)])


def test_from_a_point() -> None:
    """A source that is no craft is heard by all of them, in their order."""
    delays_ns, losses_db = propagation().from_point((0.0, 0.0, 300.0), 0)
    assert delays_ns[0] == NS // 5
    assert delays_ns[2] == NS // 10
    assert losses_db[2] == pytest.approx(15.0 * math.log10(150.0) + ALPHA * 0.15)


# -- shadowing -------------------------------------------------------------------------------------------------------

NAMES = [f"n{number}" for number in range(201)]
PAIRS = np.triu_indices(len(NAMES), 1)


def test_shadowing() -> None:
    """20 100 paths have the standard deviation asked for, and correlate by e⁻¹ after the correlation time."""
    shadowing = Shadowing(ShadowingConfig(sigma_db=5.0, correlation_s=120.0), 1, NAMES)
    before = shadowing.gains(0)[PAIRS].copy()
    after = shadowing.gains(120 * NS)[PAIRS].copy()
    count = len(before)
    assert count >= 20_000
    for gains_db in (before, after):
        assert abs(gains_db.mean()) < 4.0 * 5.0 / math.sqrt(count)
        assert abs(gains_db.std() - 5.0) < 4.0 * 5.0 / math.sqrt(2.0 * count)
    correlation = float((before * after).mean()) / 25.0
    assert abs(correlation - math.exp(-1.0)) < 4.0 * math.sqrt((1.0 + math.exp(-2.0)) / count)


def test_shadowing_is_the_same_both_ways() -> None:
    """A path is as deep in shadow in one direction as in the other, and nobody is in its own."""
    shadowing = Shadowing(ShadowingConfig(sigma_db=5.0), 1, NAMES[:5])
    for t_s in (0, 100, 1000):
        gains_db = shadowing.gains(t_s * NS)
        assert (gains_db == gains_db.T).all()
        assert (np.diag(gains_db) == 0.0).all()


def test_shadowing_does_not_depend_on_traffic() -> None:
    """Asked every second or once in a thousand, the levels are the same; it stays constant within a step."""
    often, once = (Shadowing(ShadowingConfig(sigma_db=5.0, correlation_s=16.0), 1, NAMES[:3]) for _ in range(2))
    seen = [often.gains(t_ns).copy() for t_ns in range(0, 1000 * NS + 1, NS)]
    assert (once.gains(1000 * NS) == seen[-1]).all()
    assert (Shadowing(ShadowingConfig(sigma_db=5.0, correlation_s=16.0), 1, NAMES[:3]).gains(NS - 1) == seen[0]).all()
    assert (seen[0] != seen[1])[0, 1]


def test_levels_with_shadowing() -> None:
    """What shadowing takes or gives is in the received level, and in nothing else."""
    shadowing = Shadowing(ShadowingConfig(sigma_db=5.0), 1, NAMES[:4])
    gains_db = Shadowing(ShadowingConfig(sigma_db=5.0), 1, NAMES[:4]).gains(0)
    shaded, clear = propagation(shadowing=shadowing).paths(1, 0), propagation().paths(1, 0)
    assert shaded[:3] == clear[:3]
    assert (shaded.level_db - clear.level_db).tolist() == pytest.approx(gains_db[1][clear.receivers].tolist())
