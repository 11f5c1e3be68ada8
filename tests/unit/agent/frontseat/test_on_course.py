"""The adapter and the simulated autopilot of each family together: where a craft goes, and where its bow is."""

import math

import pytest
from mavlink_duet import Duet

from grex_link.messages import Setpoint

FAMILIES = ("rover", "sub", "px4")
#: Neither where the craft looks at the start, nor along an axis.
COURSE_RAD = math.radians(110.0)


def sail(duet: Duet, mode: str, speed_mps: float, seconds: int) -> None:
    """Order the same every second."""
    for tick in range(seconds):
        duet.steer(Setpoint(tick, round(duet.now * 1e9), mode, COURSE_RAD, speed_mps, 0.0, 0))
        duet.run(1.0)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_bow_is_on_the_course(family):
    """Whoever goes on a course looks there, also a sub, which could go sideways."""
    duet = Duet(family, adapter={"arm": True}).run(3.0)
    sail(duet, "steer", 0.8, 40)
    craft = duet.pilot.brain.craft
    north, east, _ = craft.velocity
    assert math.atan2(east, north) == pytest.approx(COURSE_RAD, abs=math.radians(3.0))
    assert craft.truth.heading_rad == pytest.approx(COURSE_RAD, abs=math.radians(3.0))
    assert craft.speed_mps == pytest.approx(0.8, abs=0.2)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_craft_on_hold_lies_still(family):
    """On hold it stops, and does not turn away."""
    duet = Duet(family, adapter={"arm": True}).run(3.0)
    sail(duet, "steer", 0.8, 40)
    sail(duet, "hold", 0.0, 15)
    craft = duet.pilot.brain.craft
    assert craft.speed_mps < 0.02
    assert craft.truth.heading_rad == pytest.approx(COURSE_RAD, abs=math.radians(5.0))
