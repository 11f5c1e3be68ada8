"""From true poses to paths: how far it is to everybody, how long sound takes, and how loud it is there."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grex_link import draws
from grex_link.acoustics import Water
from grex_link.config import ShadowingConfig
from grex_link.units import NS

Vector = NDArray[np.float64]

#: Poses are carried on with the last velocity for this long at most; older ones stand still.
_EXTRAPOLATED_NS = 10 * NS


class Paths:
    """The paths from one node to all others at one time, in the order of their delays.

    Attributes
    ----------
    receivers : list of int
    range_m : list of float
    delay_ns : list of int
    level_db : list of float
        Received level, dB re 1 µPa.
    """

    __slots__ = ("delay_ns", "level_db", "range_m", "receivers")

    def __init__(self, receivers: list[int], range_m: Vector, delay_ns: NDArray[np.int64], level_db: Vector) -> None:
        order = np.argsort(delay_ns, kind="stable")
        self.receivers = [receivers[place] for place in order.tolist()]
        self.range_m: list[float] = range_m[order].tolist()
        self.delay_ns: list[int] = delay_ns[order].tolist()
        self.level_db: list[float] = level_db[order].tolist()


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
        size = len(self._positions)
        self._others = [[node for node in range(size) if node != source] for source in range(size)]
        self.bad_positions = 0

    def place(self, t_ns: int, positions_m: Sequence[Sequence[float]]) -> None:
        """Take note of the positions at a time; one that is no number is counted, and that node goes straight on."""
        fresh = np.array(positions_m, dtype=float)
        here = self._at(t_ns)
        bad = ~np.isfinite(fresh).all(axis=1)
        if bad.any():
            self.bad_positions += int(bad.sum())
            fresh[bad] = here[bad]
        elapsed_s = (t_ns - self._t_ns) / NS
        if self._placed and elapsed_s > 0.0:
            self._velocities = (fresh - self._positions) / elapsed_s
        self._positions, self._t_ns, self._placed = fresh, t_ns, True

    def paths(self, source: int, t_ns: int, extra_db: Sequence[float] | None = None) -> Paths:
        """Compute the paths from a node at the time at which its sound leaves.

        Parameters
        ----------
        source : int
            The node.
        t_ns : int
            True time.
        extra_db : sequence of float or None
            Added to the levels at the others, in the order of the nodes.
        """
        here = self._at(t_ns)
        others = self._others[source]
        range_m, delay_ns, loss_db = self._travel(here[source], here[others])
        level_db = self._source_level_db - loss_db
        if self._shadowing is not None:
            level_db = level_db + self._shadowing.gains(t_ns)[source][others]
        if extra_db is not None:
            level_db = level_db + np.asarray(extra_db)
        return Paths(others, range_m, delay_ns, level_db)

    def from_point(self, point_m: Sequence[float], t_ns: int) -> tuple[list[int], list[float]]:
        """Delay in nanoseconds and loss in dB from a point to every node."""
        _, delay_ns, loss_db = self._travel(np.array(point_m, dtype=float), self._at(t_ns))
        return delay_ns.tolist(), loss_db.tolist()

    def closing_mps(self, source: int, receiver: int, t_ns: int) -> float:
        """Rate of change of the distance between two nodes, metres a second."""
        here = self._at(t_ns)
        path = here[receiver] - here[source]
        length = math.sqrt(float(path @ path))
        return float((self._velocities[receiver] - self._velocities[source]) @ path) / length if length > 0.0 else 0.0

    def _travel(self, start: Vector, ends: Vector) -> tuple[Vector, NDArray[np.int64], Vector]:
        range_m = np.sqrt(((ends - start) ** 2).sum(axis=1))
        delay_ns = np.rint(self._water.delay_s(range_m, start[2], ends[:, 2]) * NS).astype(np.int64)
        return range_m, delay_ns, self._water.loss_db(range_m, 0.5 * (start[2] + ends[:, 2]))

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
