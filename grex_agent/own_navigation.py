"""What a craft makes of its own fixes: as they are, or filtered."""

import math

import msgspec

from grex_agent.own_filter import OwnFilter
from grex_link.config import Scenario
from grex_link.messages import Fix, Setpoint


class OwnNavigation:
    """The own fixes of one craft, filtered if the scenario says so.

    Parameters
    ----------
    scenario : Scenario
        Filter, and the current that is known.
    """

    def __init__(self, scenario: Scenario) -> None:
        known = scenario.sea.known_current_ned_mps
        north, east, _ = scenario.sea.current_ned_mps if known is None else known
        self._known_current = north, east
        config = scenario.team.own_filter
        self._filter = None if config is None else OwnFilter(config, scenario.team.speed_model, (north, east))
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
