"""What the autopilot's estimator says of its position: readiness, an origin of its own, lies when it is lost."""

import math
from typing import NamedTuple

from grex_link import draws
from grex_link.config import NavigationConfig
from grex_link.messages import Pose
from grex_link.units import NS
from grex_sim.autopilot.boot import Boot
from grex_sim.autopilot.family import LossTimes
from grex_sim.autopilot.message import Ekf
from grex_sim.navigation import Navigation

#: Fixes from outside: that long they must come before they are used, and may stay away.
_ALIGN_S = 21.9
_FIX_AGE_S = 4.0
#: How much of a fix's difference the estimator takes over: a jump of 3.3 m moves it 0.5 m.
_GAIN = 0.15
_NOISE_HZ = 5.0
_ORIGIN_SIGMA_M = 1.5


class Belief(NamedTuple):
    """What the estimator believes, NED about the start (m, m/s); that start is nobody's business on the link."""

    north_m: float
    east_m: float
    down_m: float
    north_mps: float
    east_mps: float
    down_mps: float


class Estimator:
    """The estimator of one start.

    Parameters
    ----------
    boot : Boot
        Its phases.
    loss : LossTimes
        What happens when satellites are lost.
    who : str
        Keys the draws.
    seed : int
        Seed of the run.
    noise_m : float
        Standard deviation of its position error on north and east each.
    external : bool
        Whether positions come in messages instead of from satellites.

    Attributes
    ----------
    origin : tuple of float or None
        Where its own local frame begins, NED about the start, metres; None before it has one.
    """

    def __init__(self, boot: Boot, loss: LossTimes, who: str, seed: int, noise_m: float, *, external: bool) -> None:
        self._boot, self._loss, self._external = boot, loss, external
        self._navigation = Navigation(who, NavigationConfig(white_m=noise_m), seed)
        self._who, self._seed = who, seed
        self._first_fix_s = self._last_fix_s = -math.inf
        self._bias = (0.0, 0.0)
        self._lost_s: float | None = None
        self._back_s: float | None = None
        self._lie: Belief | None = None
        self.aiding = False
        self.origin: tuple[float, float, float] | None = None
        self.belief = Belief(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    # -- what comes in ------------------------------------------------------------------------------------------

    def on_fix(self, north_m: float, east_m: float, truth: Pose, now_s: float) -> None:
        """Take a position from a message, NED about the start."""
        if not self._external:
            return
        self._first_fix_s = now_s if now_s - self._last_fix_s > _FIX_AGE_S else self._first_fix_s
        self._last_fix_s = now_s
        wanted = north_m - truth.north_m, east_m - truth.east_m
        gain = _GAIN if self.aiding else 1.0
        self._bias = (
            self._bias[0] + gain * (wanted[0] - self._bias[0]),
            self._bias[1] + gain * (wanted[1] - self._bias[1]),
        )

    def set_origin(self, ned: tuple[float, float, float], *, moves: bool) -> bool:
        """Set the origin of the local frame; False, and nothing, if there is one that does not move."""
        if self.origin is not None and not moves:
            return False
        self.origin = ned
        return True

    # -- time ---------------------------------------------------------------------------------------------------

    def step(self, truth: Pose, velocity: tuple[float, float, float], satellites: bool, now_s: float) -> list[str]:  # noqa: FBT001
        """Go on to a time and return what it has to say."""
        self._watch(satellites, now_s)
        said = self._change_aiding(truth, now_s)
        if self._lie is None:
            fix = self._navigation.fix(truth, int(now_s * _NOISE_HZ), int(now_s * NS), 0)
            north, east = fix.north_m + self._bias[0], fix.east_m + self._bias[1]
            self.belief = Belief(north, east, fix.down_m, *velocity)
        else:
            self._tell_lie(self._lie, now_s)
        return said

    def fix_type(self, now_s: float) -> int:
        """``GPS_RAW_INT.fix_type``: 0 none, 1 no fix, 3 a good one."""
        if not self._boot.past(self._boot.times.position_s * 0.5, now_s):
            return 0
        if self._external:
            return 3 if now_s - self._last_fix_s < _FIX_AGE_S else 1
        if self._lost_s is not None and now_s - self._lost_s >= self._loss.fix_s:
            return 1
        return 3

    def flags(self) -> int:
        """Return the flags of its status."""
        return Ekf.GOOD if self.aiding else Ekf.NO_POSITION

    @property
    def lost_for(self) -> float | None:
        """When satellites were lost; None while there are some."""
        return self._lost_s

    @property
    def lies(self) -> bool:
        """Whether it goes on telling a global position that is wrong."""
        return self._lie is not None

    # -- inside -------------------------------------------------------------------------------------------------

    def _watch(self, satellites: bool, now_s: float) -> None:  # noqa: FBT001
        present = now_s - self._last_fix_s < _FIX_AGE_S if self._external else satellites
        if present:
            self._back_s = now_s if self._lost_s is not None else self._back_s
            self._lost_s = None
        elif self._lost_s is None:
            self._lost_s = self._last_fix_s if self._external and math.isfinite(self._last_fix_s) else now_s

    def _usable(self, now_s: float) -> bool:
        """Whether there is something to navigate by."""
        if self._lost_s is not None:
            return self.aiding and now_s - self._lost_s < self._loss.aiding_s
        if self._external:
            return self.aiding or now_s - self._first_fix_s >= _ALIGN_S * self._boot.scale
        returned = self._back_s is None or now_s - self._back_s >= self._loss.return_s
        return self._boot.past(self._boot.times.ready_s, now_s) and (self.aiding or returned)

    def _change_aiding(self, truth: Pose, now_s: float) -> list[str]:
        usable = self._usable(now_s)
        if usable == self.aiding:
            return []
        self.aiding = usable
        if not usable:
            # What it reckoned last goes on as a lie: without velocity, but the position may run.
            self._lie = self.belief
            self._lie_s = now_s
            return [self._loss.text] if self._loss.text else []
        self._lie = None
        if self.origin is None:
            self.origin = self._first_origin(truth)
            return ["EKF3 IMU0 origin set", "EKF3 IMU0 is using GPS"]
        return ["EKF3 IMU0 is using GPS"]

    def _first_origin(self, truth: Pose) -> tuple[float, float, float]:
        """Where the estimator started: at the craft, as wrong as the first fixes were."""
        if self._external:
            return truth.north_m + self._bias[0], truth.east_m + self._bias[1], 0.0
        north, east = draws.normal(self._seed, "origin", self._who)
        return truth.north_m + _ORIGIN_SIGMA_M * north, truth.east_m + _ORIGIN_SIGMA_M * east, 0.0

    def _tell_lie(self, lie: Belief, now_s: float) -> None:
        ran_s = min(now_s - self._lie_s, self._loss.lie_s) if self._loss.lie == "runs_on" else 0.0
        north, east = lie.north_m + lie.north_mps * ran_s, lie.east_m + lie.east_mps * ran_s
        self.belief = Belief(north, east, lie.down_m, 0.0, 0.0, 0.0)
