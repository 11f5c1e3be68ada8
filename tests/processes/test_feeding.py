"""A craft without satellites is told where it is: the agent's navigation, the adapter, an autopilot, a UDP socket."""

import math
import time

import pytest
from frontseat_benches import PACE, AdapterBench

from grex_link.messages import Fix

#: Where its navigation says that it lies; satellites would say (0, 0).
PLACE = 12.0, -7.0
DRIFT_MPS = 0.2


class Fed(AdapterBench):
    """An autopilot without satellites, and an adapter that may be given fixes."""

    def __init__(self, folder, family: str, feed: str, *parameters: str) -> None:
        self.family = family
        given = (word for parameter in parameters for word in ("--param", parameter))
        self.options = (*given, "--wind", "0,0", "--seed", "1")
        self.more = f'feed = "{feed}"'
        super().__init__(folder)

    def _start(self) -> None:
        """It is not ready before it is fed."""

    def go_on(self, seconds: float, north_mps: float | None = None) -> None:
        """Let seconds of the autopilot pass; with a speed its navigation speaks, and moves from where it was."""
        since = time.monotonic()
        while (passed := (time.monotonic() - since) * PACE) < seconds:
            if north_mps is not None:
                self.north = self._from + north_mps * passed
                self.say(self.north, PLACE[1], north_mps)
            self._turn()
        self._from = self.north

    north = _from = PLACE[0]

    def say(self, north_m: float, east_m: float, speed_mps: float, *, valid: bool = True) -> None:
        self._node.handle("nav", "auv1", Fix(0, 0, north_m, east_m, 0.0, 0.0, speed_mps, 0.4, valid=valid))

    def until(self, condition, seconds: float, north_mps: float | None = None) -> None:
        """Go on until something is so; a busy machine may need longer than an idle one."""
        give_up = time.monotonic() + 20.0 + seconds / PACE
        while not condition():
            assert time.monotonic() < give_up, (self._node.waits_for, self.estimate)
            self.go_on(1.0, north_mps)

    @property
    def estimate(self):
        now_ns = round(time.monotonic() * 1e9)
        return self.core.estimate(now_ns, now_ns)

    @property
    def control(self):
        return self.core.peer.control


KINDS = [
    pytest.param("rover", "gps_input", ("GPS1_TYPE=14",), marks=pytest.mark.slow),
    ("sub", "gps_input", ("GPS1_TYPE=14",)),
    ("sub", "vision", ("EK3_SRC1_POSXY=6", "VISO_TYPE=1")),
    pytest.param("px4", "vision", ("EKF2_EV_CTRL=1",), marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("family", "feed", "parameters"), KINDS)
def test_it_is_where_it_is_told_to_be(tmp_path, family: str, feed: str, parameters: tuple[str, ...]):
    """Not fed it has no position and is not armed; fed it is where it is told, arms, follows; starved it says so."""
    bench = Fed(tmp_path, family, feed, *parameters)
    try:
        bench.until(lambda: bench.core.peer is not None, 10.0)
        bench.go_on(30.0)
        assert not bench.estimate.valid
        assert bench._node.waits_for.startswith("no valid position: ")
        assert not bench.control.armed

        bench.until(lambda: not bench._node.waits_for, 30.0, 0.0)
        assert bench.control.obeys
        assert math.dist((bench.estimate.north_m, bench.estimate.east_m), PLACE) < 1.0

        bench.go_on(40.0, DRIFT_MPS)
        assert bench.north > PLACE[0] + 7.0
        assert math.dist((bench.estimate.north_m, bench.estimate.east_m), (bench.north, PLACE[1])) < 1.5

        bench.say(0.0, 0.0, 0.0, valid=False)
        bench.until(lambda: not bench.estimate.valid, 30.0)
        assert bench.estimate.reason
    finally:
        bench.close()


@pytest.mark.slow
def test_who_has_satellites_does_not_listen(tmp_path):
    """An autopilot that is not told to take positions from outside stays where its satellites say it is."""
    bench = Fed(tmp_path, "rover", "gps_input", "GPS1_TYPE=1")
    try:
        bench.until(lambda: not bench._node.waits_for, 30.0, 0.0)
        bench.go_on(20.0, 0.0)
        assert math.hypot(bench.estimate.north_m, bench.estimate.east_m) < 2.0
    finally:
        bench.close()
