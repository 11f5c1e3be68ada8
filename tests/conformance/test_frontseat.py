"""What an agent may rely on, whatever steers the craft: one contract of setpoint and fix, for all frontseats alike.

One flight of each, then many assertions: ahead, a turn, starboard and down, hold, ahead again, a silent agent, ahead;
and at the end, where there is something to lose, navigation is lost for a while.
"""

import math

import pytest
from frontseat_benches import AdapterBench, SerialBench, SimBench

from grex_agent.path import wrap

TURN_RAD_PER_S = 0.04
AHEAD = {"mode": "steer", "course_rad": 0.0, "speed_mps": 1.2, "depth_m": 0.0}
STARBOARD = {"mode": "steer", "course_rad": 1.2, "speed_mps": 0.8, "depth_m": 3.0}
HOLD = {"mode": "hold", "course_rad": 1.2, "speed_mps": 0.0, "depth_m": 3.0}
#: The autopilot's own seconds; the flight before takes less.
LOST_AT_S, LOST_FOR_S = 230.0, 20.0


class Flight:
    """A flight in legs, each the fixes of its time."""

    def __init__(self, bench) -> None:
        self.bench = bench
        self.legs: dict[str, list] = {}
        self.leg("ahead", 30, **AHEAD)
        start = len(bench.fixes)
        for second in range(30):
            bench.run(1, **AHEAD | {"course_rad": TURN_RAD_PER_S * second})
        self.legs["turn"] = bench.fixes[start:]
        self.leg("starboard", 40, **STARBOARD)
        self.leg("hold", 25, **HOLD)
        self.leg("before", 15, **AHEAD)
        self.leg("silent", 15)
        self.leg("again", 25, **AHEAD)
        if bench.loses_navigation:
            self.leg("lost", round(LOST_AT_S + LOST_FOR_S + 25.0) - 180, **AHEAD)

    def leg(self, name: str, seconds: int, **order) -> None:
        start = len(self.bench.fixes)
        self.bench.run(seconds, **order)
        self.legs[name] = self.bench.fixes[start:]


@pytest.fixture(scope="module", params=[SimBench, AdapterBench, SerialBench], ids=["sim", "mavlink-udp", "mavlink-pty"])
def flight(request, tmp_path_factory):
    """A flight with one kind of frontseat."""
    bench = request.param(tmp_path_factory.mktemp("frontseat"), f"gps@{LOST_AT_S:g}:{LOST_FOR_S:g}")
    try:
        yield Flight(bench)
    finally:
        bench.close()


def made_good(fixes) -> tuple[float, float]:
    """Course and speed from the places of the first and the last fix."""
    first, last = fixes[0], fixes[-1]
    north, east = last.north_m - first.north_m, last.east_m - first.east_m
    return math.atan2(east, north), math.hypot(north, east) / (last.tick - first.tick)


def degrees_between(a: float, b: float) -> float:
    return abs(math.degrees(wrap(a - b)))


def test_fixes_are_those_of_the_ticks(flight):
    """There is a fix for every tick but few, each once, in order, stamped with that tick's time."""
    ticks = [fix.tick for fix in flight.bench.fixes]
    assert ticks == sorted(set(ticks))
    assert len(ticks) >= 0.95 * (ticks[-1] - ticks[0] + 1)
    assert all(fix.t_ns == fix.tick * 10**9 for fix in flight.bench.fixes)


def test_fixes_are_valid_and_near_the_datum(flight):
    """At the start the craft lies at the datum; all is valid but for moments, with a sigma that is not negative."""
    first = flight.bench.fixes[0]
    # A boat has drifted a little while nobody steered it.
    assert math.hypot(first.north_m, first.east_m) < 15.0
    assert first.valid
    fixes = [fix for leg in ("ahead", "turn", "starboard", "hold", "before") for fix in flight.legs[leg]]
    assert sum(fix.valid for fix in fixes) >= 0.9 * len(fixes)
    assert all(fix.sigma_m >= 0.0 for fix in fixes)


@pytest.mark.parametrize(("leg", "order"), [("ahead", AHEAD), ("starboard", STARBOARD), ("again", AHEAD)])
def test_a_setpoint_is_followed(flight, leg: str, order: dict):
    """Settled, the craft makes good the course within 4 degrees and the speed within 0.2 m/s."""
    course, speed = made_good(flight.legs[leg][-10:])
    assert degrees_between(course, order["course_rad"]) < 4.0
    assert speed == pytest.approx(order["speed_mps"], abs=0.2)


def test_speed_and_heading_agree_with_the_motion(flight):
    """The fix's heading and speed are those of the motion between fixes, in a turn, too: places are of their ticks."""
    fixes = flight.legs["turn"][8:]
    course, _ = made_good(fixes)
    ahead = sum(wrap(fix.heading_rad - course) for fix in fixes) / len(fixes)
    assert abs(math.degrees(ahead)) < 2.5
    straight = flight.legs["ahead"][-10:]
    assert sum(fix.speed_mps for fix in straight) / 10 == pytest.approx(made_good(straight)[1], abs=0.1)


def test_a_depth_is_kept(flight):
    """A craft that dives goes to its depth and keeps it on hold; another stays up."""
    wanted = STARBOARD["depth_m"] if flight.bench.dives else 0.0
    assert flight.legs["starboard"][-1].down_m == pytest.approx(wanted, abs=0.6)
    assert flight.legs["hold"][-1].down_m == pytest.approx(flight.legs["hold"][0].down_m, abs=0.6)


def test_hold_stops(flight):
    """On hold the craft comes to rest, and stays."""
    resting = flight.legs["hold"][-10:]
    assert made_good(resting)[1] < 0.15
    assert resting[-1].speed_mps < 0.3


def test_a_silent_agent_stops_the_craft(flight):
    """An agent that says nothing has a craft that stops: within the timeout, a second, and the time it coasts."""
    silent = flight.legs["silent"]
    after = [fix for fix in silent if fix.tick - silent[0].tick >= flight.bench.stale_s + 1.0 + 5.0]
    assert flight.legs["before"][-1].speed_mps > 1.0
    assert len(after) >= 4
    assert made_good(after)[1] < 0.2


def test_a_fix_without_navigation_is_not_valid(flight):
    """While navigation is lost fixes are not valid and say why; when it is back they are valid again."""
    if not flight.bench.loses_navigation:
        pytest.skip("the simulated craft always knows where it is")
    lost = [fix for fix in flight.legs["lost"] if not fix.valid]
    assert len(lost) >= LOST_FOR_S - 5.0
    assert all(fix.reason for fix in lost)
    assert all(not fix.reason for fix in flight.bench.fixes if fix.valid)
    assert flight.legs["lost"][-1].valid, flight.legs["lost"][-1].reason
