"""From true poses to paths: how far it is to everybody, how long sound takes, and how loud it is there."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grex_link import draws
from grex_link.acoustics import Water, transmission_loss
from grex_link.link_config import ShadowingConfig
from grex_link.units import NS

Vector = NDArray[np.float64]

#: Farther from the datum is nobody.
_FARTHEST_M = 1e7
#: Poses are carried on with the last velocity for this long at most; older ones stand still.
_EXTRAPOLATED_NS = 10 * NS


class Paths(NamedTuple):
    """The paths from one node to all others at one time, in the order of their delays."""

    receivers: list[int]
    delay_ns: list[int]
    gap_ns: list[int]
    """From each receiver's delay to the next one's."""
    range_m: Vector
    level_db: Vector
    """Received level, dB re 1 µPa."""


class Propagation:
    """Where everybody is, and the paths between them.

    Parameters
    ----------
    water : Water
        Speed of sound and transmission loss.
    source_level_db : float
        dB re 1 µPa at 1 m.
    positions_m : array_like, shape (nodes, 3)
        NED positions to begin with, metres.
    shadowing : Shadowing or None
        Slow change of levels.

    Attributes
    ----------
    bad_positions : int
        Positions that were no numbers.
    """

    def __init__(
        self,
        water: Water,
        source_level_db: float,
        positions_m: Sequence[Sequence[float]],
        shadowing: "Shadowing | None" = None,
    ) -> None:
        self._water = water
        self._source_level_db = source_level_db
        self._positions = np.array(positions_m, dtype=float).reshape(-1, 3)
        self._velocities = np.zeros_like(self._positions)
        self._t_ns = 0
        self._placed = False
        self._shadowing = shadowing
        # What depends on depths only: computed for all pairs at once, when it is first needed after the poses change.
        self._slowness_ns: Vector | None = None
        self._prepared: dict[tuple[int, int], Paths] = {}
        self._absorption_db_per_km: Vector = np.empty(0)
        self.bad_positions = 0

    def place(self, t_ns: int, positions_m: Sequence[Sequence[float]]) -> None:
        """Take note of the positions at a time.

        One that is no number, or out of this world, is counted, and that node goes straight on.
        """
        fresh = np.array(positions_m, dtype=float)
        sound = np.abs(fresh) <= _FARTHEST_M  # no number is
        if not sound.all():
            bad = ~sound.all(axis=1)
            self.bad_positions += int(bad.sum())
            fresh[bad] = self._at(t_ns)[bad]
        elapsed_s = (t_ns - self._t_ns) / NS
        if self._placed and elapsed_s > 0.0:
            self._velocities = (fresh - self._positions) / elapsed_s
        self._positions, self._t_ns, self._placed = fresh, t_ns, True
        self._slowness_ns = None
        self._prepared = {}

    def prepare(self, sends: Sequence[tuple[int, int]]) -> None:
        """Compute at once the paths of several sounds that will leave before the poses change, which costs less.

        Parameters
        ----------
        sends : sequence of (int, int)
            Node and time of each.
        """
        if len(sends) > 1 and self._shadowing is None:
            self._prepared = dict(zip(sends, self._compute(sends), strict=True))

    def paths(self, source: int, t_ns: int) -> Paths:
        """Find the paths from a node at the time at which its sound leaves."""
        prepared = self._prepared.pop((source, t_ns), None)
        return self._compute([(source, t_ns)])[0] if prepared is None else prepared

    def _compute(self, sends: Sequence[tuple[int, int]]) -> list[Paths]:
        slowness_ns = self._slowness_ns if self._slowness_ns is not None else self._look_at_depths()
        sources = np.array([source for source, _ in sends])
        rows = np.arange(len(sends))
        here = np.array([self._at(t_ns) for _, t_ns in sends])
        path = here - here[rows, sources][:, None]
        north, east, down = path[..., 0], path[..., 1], path[..., 2]
        range_m = np.sqrt(north * north + east * east + down * down)
        delay_ns = np.rint(range_m * slowness_ns[sources]).astype(np.int64)
        delay_ns[rows, sources] = -1  # the source itself comes first, and is left out
        order = delay_ns.argsort(axis=1, kind="stable")[:, 1:]
        delay_ns, range_m = (np.take_along_axis(values, order, 1) for values in (delay_ns, range_m))
        absorption_db_per_km = np.take_along_axis(self._absorption_db_per_km[sources], order, 1)
        level_db = self._source_level_db - transmission_loss(range_m, self._water.spreading, absorption_db_per_km)
        if self._shadowing is not None:
            gains_db = np.array([self._shadowing.gains(t_ns)[source] for source, t_ns in sends])
            level_db += np.take_along_axis(gains_db, order, 1)
        columns = order.tolist(), delay_ns.tolist(), np.diff(delay_ns).tolist(), range_m, level_db
        return [Paths(*row) for row in zip(*columns, strict=True)]

    def from_point(self, point_m: Sequence[float], t_ns: int) -> tuple[list[int], list[float]]:
        """Delay in nanoseconds and loss in dB from a point to every node."""
        here, point = self._at(t_ns), np.array(point_m, dtype=float)
        range_m = np.sqrt(((here - point) ** 2).sum(axis=1))
        delay_ns = np.rint(self._water.delay_s(range_m, point[2], here[:, 2]) * NS).astype(np.int64)
        loss_db: Vector = self._water.loss_db(range_m, 0.5 * (point[2] + here[:, 2]))
        return delay_ns.tolist(), loss_db.tolist()

    def closing_mps(self, source: int, receiver: int, t_ns: int) -> float:
        """Rate of change of the distance between two nodes, metres a second."""
        here = self._at(t_ns)
        path = here[receiver] - here[source]
        length = math.sqrt(float(path @ path))
        return float((self._velocities[receiver] - self._velocities[source]) @ path) / length if length > 0.0 else 0.0

    def _look_at_depths(self) -> Vector:
        depth_m = self._positions[:, 2]
        pairs = depth_m[:, None], depth_m[None, :]
        ones = np.ones((len(depth_m), len(depth_m)))
        self._slowness_ns = slowness_ns = self._water.delay_s(ones, *pairs) * NS
        mean_m = 0.5 * (pairs[0] + pairs[1])
        self._absorption_db_per_km = np.broadcast_to(self._water.absorption_db_per_km(mean_m), ones.shape)
        return slowness_ns

    def _at(self, t_ns: int) -> Vector:
        ahead_ns = min(t_ns - self._t_ns, _EXTRAPOLATED_NS)
        return self._positions + self._velocities * (ahead_ns / NS) if ahead_ns > 0 else self._positions


class Shadowing:
    """Levels that change slowly: first-order autoregressive on a fixed grid of steps, the same both ways of a path.

    Parameters
    ----------
    config : ShadowingConfig
        Standard deviation in dB, and correlation time.
    seed : int
        Seed of the link.
    names : sequence of str
        The nodes.
    """

    #: Steps within a correlation time.
    _STEPS = 16

    def __init__(self, config: ShadowingConfig, seed: int, names: Sequence[str]) -> None:
        self._sigma_db = config.sigma_db
        self._step_ns = round(config.correlation_s * NS / self._STEPS)
        self._keep = math.exp(-1.0 / self._STEPS)
        self._seed = seed
        self._names = list(names)
        self._step = 0
        self._gains_db = config.sigma_db * self._draw(0)

    def gains(self, t_ns: int) -> Vector:
        """Gains at a time that does not decrease, dB, shape (nodes, nodes)."""
        step = t_ns // self._step_ns
        while self._step < step:
            self._step += 1
            change = self._sigma_db * math.sqrt(1.0 - self._keep**2)
            self._gains_db = self._keep * self._gains_db + change * self._draw(self._step)
        return self._gains_db

    def _draw(self, step: int) -> Vector:
        size = len(self._names)
        drawn = np.zeros((size, size))
        for first in range(size):
            for second in range(first + 1, size):
                value, _ = draws.normal(self._seed, "shadowing", self._names[first], self._names[second], step)
                drawn[first, second] = drawn[second, first] = value
        return drawn
