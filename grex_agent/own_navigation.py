"""What a craft makes of its own fixes: as they are, or filtered."""

import math
from collections.abc import Sequence

import msgspec

from grex_agent.coordination import UNBIASED
from grex_agent.own_filter import OwnFilter
from grex_agent.path import wrap
from grex_agent.range_update import Range
from grex_link.config import Scenario
from grex_link.messages import Fix, PlaceBelief, Setpoint

#: What the limits take of an order is told if it is more: less is the noise of the estimate at a limit.
_LIMITED_MPS = 0.01


class OwnNavigation:
    """The own fixes of one craft, filtered if the scenario says so.

    Parameters
    ----------
    scenario : Scenario
        Filter, and the current that is known.
    craft : str
        Whose fixes they are.
    """

    def __init__(self, scenario: Scenario, craft: str) -> None:
        self._craft = craft
        known = scenario.sea.known_current_ned_mps
        north, east, _ = scenario.sea.current_ned_mps if known is None else known
        self._known_current = north, east
        config = scenario.team.own_filter
        team, inertial = scenario.team, scenario.craft[craft].inertial
        self._filter = (
            None if config is None else OwnFilter(config, team.speed_model, (north, east), inertial, team.ranging)
        )
        self._bias_max = team.bias_max_relative if team.controller in UNBIASED else 0.0
        self._speed_min_mps, self._speed_max_mps = team.speed_min_mps, team.speed_max_mps
        self._taken: Fix | None = None
        self._through_water_mps = 0.0

    def filtered(self, now_s: float, fix: Fix | None, *, lost: bool) -> Fix | None:
        """Filter the fix of this step; an old or an invalid one is left as it is, and nothing is learned from it."""
        own = self._filter
        if own is None:
            return fix
        new = fix is not None and fix is not self._taken and not lost
        own.step(now_s, fix if new else None, self._through_water_mps)
        if not new or fix is None or own.state is None:
            return fix
        self._taken = msgspec.structs.replace(fix, north_m=own.state[0], east_m=own.state[1], sigma_m=own.sigma_m)
        return self._taken

    @property
    def speed_error(self) -> float:
        """Own speed error that is removed: the filter's estimate within its limit, or 0 if the law removes none."""
        if self._filter is None or self._filter.state is None:
            return 0.0
        return min(max(self._filter.state[3], -self._bias_max), self._bias_max)

    def corrected(self, setpoint: Setpoint, health: list[str]) -> Setpoint:
        """Correct an order for what the frontseat does not know: the rest of the current, and the own speed error.

        w = (order - estimated current) / (1 + β), order' = w + known current. The frontseat makes w of order' by taking
        the known current away, and the actuator makes (1 + β)·w of that. What comes out is limited to the speeds a
        controller may order, so that an estimate that has gone astray cannot run away with the craft; then the craft
        does not make the speed and course that were wanted, and `health` says ``speed_limited``.
        """
        if self._filter is None or setpoint.mode == "hold" or setpoint.speed_mps == 0.0:
            return setpoint
        estimated, known, gain = self._filter.current, self._known_current, 1.0 / (1.0 + self.speed_error)
        cos, sin = math.cos(setpoint.course_rad), math.sin(setpoint.course_rad)
        north = gain * (setpoint.speed_mps * cos - estimated[0]) + known[0]
        east = gain * (setpoint.speed_mps * sin - estimated[1]) + known[1]
        wanted = math.hypot(north, east)
        speed = min(max(wanted, self._speed_min_mps), self._speed_max_mps)
        if abs(wanted - speed) > _LIMITED_MPS and "speed_limited" not in health:
            health.append("speed_limited")
        return msgspec.structs.replace(setpoint, course_rad=wrap(math.atan2(east, north)), speed_mps=speed)

    def hear_ranges(self, ranges: Sequence[Range]) -> list[str]:
        """Work in ranges, of which the next fix profits; return what is to be reported as health."""
        own = self._filter
        good = [own is not None and own.hear_range(heard) for heard in ranges]
        return [] if all(good) else ["range_rejected"]

    def place(self, fix: Fix | None) -> list[PlaceBelief]:
        """Say where the craft takes itself to be, if it knows: by a fix from `filtered`."""
        if fix is None:
            return []
        if self._filter is None or self._filter.covariance is None:
            covariance = fix.sigma_m**2, fix.sigma_m**2, 0.0
        else:
            p = self._filter.covariance
            covariance = float(p[0, 0]), float(p[1, 1]), float(p[0, 1])
        return [PlaceBelief(self._craft, fix.north_m, fix.east_m, covariance)]

    def ordered(self, setpoint: Setpoint) -> None:
        """Note what has been ordered: over ground, and so through the water, as far as the current is known."""
        if setpoint.mode == "hold":
            self._through_water_mps = 0.0
            return
        north, east = self._known_current
        speed, course = setpoint.speed_mps, setpoint.course_rad
        self._through_water_mps = math.hypot(speed * math.cos(course) - north, speed * math.sin(course) - east)

    def speed_over_ground(self, fix: Fix) -> float:
        """Speed through the water and the current, as far as it is known or estimated, m/s."""
        north, east = self._known_current if self._filter is None else self._filter.current
        return math.hypot(
            fix.speed_mps * math.cos(fix.heading_rad) + north, fix.speed_mps * math.sin(fix.heading_rad) + east
        )
