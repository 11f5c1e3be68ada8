"""The clocks of the craft: offset, drift, and GPS at the surface."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_link.config import CraftClockConfig
from grex_link.craft_clock import CraftClock, TeamClocks
from grex_link.messages import Pose, Truth
from grex_link.units import NS


def test_a_clock_without_errors_is_right() -> None:
    """By default a clock reads mission time, to the nanosecond, for ever."""
    clock = CraftClock(CraftClockConfig())
    for t_ns in (0, 1, 123_456_789_012_345_678):
        assert clock.local_ns(t_ns) == clock.true_ns(t_ns) == t_ns
        assert clock.error_ns(t_ns) == 0


def test_offset_and_drift_add_up() -> None:
    """After 3 h a clock that is 0.1 s ahead and gains 20 ppm is 0.316 s ahead."""
    clock = CraftClock(CraftClockConfig(offset_s=0.1, drift_ppm=20.0))
    assert clock.error_ns(0) == 100_000_000
    assert clock.error_ns(3 * 3600 * NS) == 316_000_000
    assert clock.local_ns(3 * 3600 * NS) == 3 * 3600 * NS + 316_000_000


def test_a_slow_clock() -> None:
    """A clock that loses reads less than true time."""
    clock = CraftClock(CraftClockConfig(offset_s=-2.0, drift_ppm=-100.0))
    assert clock.local_ns(1000 * NS) == 997_900_000_000


@given(
    st.floats(-3600.0, 3600.0),
    st.floats(-1000.0, 1000.0),
    st.integers(0, 10**15),
    st.integers(0, 10**14),
    st.booleans(),
)
def test_there_and_back(offset_s: float, drift_ppm: float, t_ns: int, set_ns: int, surfaces) -> None:
    """True time from a reading is the true time of that reading, to 2 ns, before and after it was set."""
    clock = CraftClock(CraftClockConfig(offset_s=offset_s, drift_ppm=drift_ppm, gps_at_surface=True))
    if surfaces:
        clock.see(set_ns, 0.0)
    assert abs(clock.true_ns(clock.local_ns(t_ns)) - t_ns) <= 2


def test_gps_sets_it_at_the_surface() -> None:
    """Above the given depth GPS takes away what has gathered; the drift goes on from there."""
    config = CraftClockConfig(offset_s=0.5, drift_ppm=100.0, gps_at_surface=True, surface_depth_m=0.5)
    clock = CraftClock(config)
    clock.see(1000 * NS, 0.51)
    assert clock.error_ns(1000 * NS) == 600_000_000
    clock.see(2000 * NS, 0.5)
    assert clock.error_ns(2000 * NS) == 0
    assert clock.error_ns(3000 * NS) == 100_000_000


def test_without_gps_the_surface_is_no_help() -> None:
    """A clock without GPS keeps its error at the surface."""
    clock = CraftClock(CraftClockConfig(offset_s=0.5))
    clock.see(10 * NS, 0.0)
    assert clock.error_ns(20 * NS) == 500_000_000


@pytest.mark.parametrize(
    ("config", "right"),
    [({}, True), ({"offset_s": 0.1}, False), ({"drift_ppm": 1.0}, False), ({"gps_at_surface": True}, True)],
)
def test_which_clocks_are_right(config: dict[str, float], right) -> None:
    """A clock is right if it neither is off nor goes off."""
    assert CraftClock(CraftClockConfig(**config)).right is right


def test_every_craft_has_its_own(make) -> None:
    """Poses set the clocks of those at the surface, and of nobody else."""
    gps = "{offset_s=1.0,gps_at_surface=true}"
    clocks = TeamClocks(make(f"craft.auv1.clock={gps}", f"craft.auv2.clock={gps}", "craft.auv3.clock={offset_s=1.0}"))
    poses = [
        Pose(craft, 0.0, 0.0, down, 0.0, 0.0, 0.0, 1.0) for craft, down in (("auv1", 0.0), ("auv2", 9.0), ("auv3", 0.0))
    ]
    clocks.see(Truth(5, 5 * NS, poses))
    assert [clock.error_ns(9 * NS) for clock in clocks.craft.values()] == [0, NS, NS]
