"""The simulated craft: four first-order lags with limits, moved through the water (paper, section III, Figs. 4 and 5).

For each of roll, pitch, heading and surge, over a step dt:

    x ← x + clip((clip(w, x_min, x_max) - x)·(1 - exp(-dt/T)), ± dx_max·dt)

The position follows from the mean of the old and the new heading, pitch and surge, plus the true current.
"""

import math

from grex_agent.path import wrap
from grex_link import draws
from grex_link.config import CraftConfig, Loop, SeaConfig, VehicleConfig
from grex_link.messages import Pose, Setpoint
from grex_sim.current import compensate


class LagLoop:
    """One controlled state as a first-order lag with limits on value and rate.

    Parameters
    ----------
    config : Loop
        Time constant and limits.
    dt : float
        Step, seconds.
    """

    def __init__(self, config: Loop, dt: float) -> None:
        self.min, self.max = config.min, config.max
        self._gain = 1.0 - math.exp(-dt / config.lag_s) if config.lag_s > 0.0 else 1.0
        self._change_max = config.rate_max * dt

    def limited(self, wanted: float) -> float:
        """Return a wanted value within the limits."""
        return self.min if wanted < self.min else self.max if wanted > self.max else wanted  # noqa: FURB136

    def change(self, error: float) -> float:
        """How far the state moves in one step towards a value that is `error` away."""
        change, most = error * self._gain, self._change_max
        return most if change > most else -most if change < -most else change  # noqa: FURB136


class SurgeActuator:
    """What is wrong with the thrusters: fixed errors, an error that wanders, and times of less power.

    surge = min((1 + relative + e)·ordered + offset, limit now),  e ← φ·e + σ·√(1 - φ²)·w,  φ = exp(-dt/time)

    Parameters
    ----------
    craft : str
        Its name keys the draws of w.
    config : VehicleConfig
        The errors.
    seed : int
        Seed of the run.
    dt : float
        Step, seconds.
    """

    def __init__(self, craft: str, config: VehicleConfig, seed: int, dt: float) -> None:
        self._key = seed, "speed_wander", craft
        self._dt = dt
        self._scale, self._offset = 1.0 + config.speed_error_relative, config.speed_error_mps
        self._limits = config.speed_limits
        wander = config.speed_wander
        self._sigma = wander.sigma_relative if wander else 0.0
        self._keep = math.exp(-dt / wander.time_s) if wander else 0.0
        self._step = 0
        self._error = self._sigma * self._draw() if self._sigma else 0.0

    def drive(self, ordered_mps: float) -> float:
        """Surge that the thrusters drive at in the next step, m/s."""
        wanted = ordered_mps * (self._scale + self._error) + (self._offset if ordered_mps else 0.0)
        now_s = self._step * self._dt
        for limit in self._limits:
            if limit.start_s <= now_s < limit.end_s:
                wanted = min(wanted, limit.max_mps)
        self._step += 1
        if self._sigma:
            self._error = self._keep * self._error + self._sigma * math.sqrt(1.0 - self._keep**2) * self._draw()
        return wanted

    def _draw(self) -> float:
        seed, *purpose = self._key
        return draws.normal(seed, *purpose, self._step)[0]


class Vehicle:
    """One simulated craft.

    Parameters
    ----------
    craft : str
        Its name.
    config : CraftConfig
        Loops, depth controller and actuator errors.
    sea : SeaConfig
        True and known current.
    start : tuple of float
        North, east, down (metres) and heading (radians) at the beginning.
    speed_mps : float
        Surge at the beginning.
    dt : float
        Step, seconds.
    seed : int
        Seed of the run, for what is drawn.

    Attributes
    ----------
    holdable : bool
        Whether the course last ordered can be made good against the known current.
    """

    def __init__(
        self,
        craft: str,
        config: CraftConfig,
        sea: SeaConfig,
        start: tuple[float, float, float, float],
        speed_mps: float,
        dt: float,
        seed: int = 0,
    ) -> None:
        vehicle = config.vehicle
        self._craft = craft
        self._dt = dt
        self._roll = LagLoop(vehicle.roll, dt)
        self._pitch = LagLoop(vehicle.pitch, dt)
        self._heading = LagLoop(vehicle.heading, dt)
        self._surge = LagLoop(vehicle.surge, dt)
        self._depth_gain = vehicle.depth_gain_rad_per_m
        self._actuator = SurgeActuator(craft, vehicle, seed, dt)
        self._current = sea.current_ned_mps
        known = sea.known_current_ned_mps
        self._known_current = sea.current_ned_mps if known is None else known
        self.north_m, self.east_m, self.down_m, self.heading_rad = start
        self.roll_rad = self.pitch_rad = 0.0
        self.surge_mps = speed_mps
        self.holdable = True

    def step(self, setpoint: Setpoint | None) -> None:
        """Move one step under a setpoint; without one, or on hold, the thrusters stop and the heading is kept."""
        heading, pitch, surge = self._orders(setpoint)
        old_heading, old_pitch, old_surge = self.heading_rad, self.pitch_rad, self.surge_mps
        turn = self._heading.change(wrap(heading - old_heading))
        self.heading_rad = wrap(old_heading + turn)
        self.pitch_rad += self._pitch.change(self._pitch.limited(pitch) - old_pitch)
        self.roll_rad += self._roll.change(self._roll.limited(0.0) - self.roll_rad)
        self.surge_mps += self._surge.change(self._actuator.drive(surge) - old_surge)
        self._move(old_heading + turn / 2.0, (old_pitch + self.pitch_rad) / 2.0, (old_surge + self.surge_mps) / 2.0)

    @property
    def pose(self) -> Pose:
        """The true state now."""
        return Pose(
            self._craft,
            self.north_m,
            self.east_m,
            self.down_m,
            self.roll_rad,
            self.pitch_rad,
            self.heading_rad,
            self.surge_mps,
        )

    def _orders(self, setpoint: Setpoint | None) -> tuple[float, float, float]:
        """Heading, pitch and surge to steer for a setpoint (depth controller and current compensation)."""
        if setpoint is None or setpoint.mode == "hold":
            return self.heading_rad, 0.0, 0.0
        # Depth controller, P only: deeper means bow down, and pitch is positive upwards.
        pitch = self._pitch.limited(-self._depth_gain * (setpoint.depth_m - self.down_m))
        steering = compensate(
            setpoint.course_rad,
            pitch,
            setpoint.speed_mps,
            self._known_current,
            self._surge.min,
            self._surge.max,
        )
        self.holdable = steering.holdable
        return steering.heading_rad, steering.pitch_rad, steering.surge_mps

    def _move(self, heading: float, pitch: float, surge: float) -> None:
        level = surge * math.cos(pitch)
        dt, current = self._dt, self._current
        self.north_m += dt * (level * math.cos(heading) + current[0])
        self.east_m += dt * (level * math.sin(heading) + current[1])
        # No craft flies.
        self.down_m = max(0.0, self.down_m + dt * (current[2] - surge * math.sin(pitch)))
