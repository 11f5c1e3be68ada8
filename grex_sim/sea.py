"""The sea: all simulated craft of a scenario, moved tick by tick."""

from collections.abc import Mapping, Sequence

import msgspec

from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_link.craft_clock import TeamClocks
from grex_link.messages import Fix, Setpoint, Truth
from grex_link.units import tick_ns
from grex_sim.navigation import Navigation
from grex_sim.vehicle import Vehicle


class Sea:
    """Simulated craft that start where their plan starts, on its course and at its speed.

    Parameters
    ----------
    scenario : Scenario
        The run.
    plan : TeamPlan
        Where everybody starts.
    """

    def __init__(self, scenario: Scenario, plan: TeamPlan) -> None:
        self._tick_ns = tick_ns(scenario.clock.tick_s)
        self.tick = 0
        self._vehicles: dict[str, Vehicle] = {}
        self._navigation: list[Navigation] = []
        self._clocks = TeamClocks(scenario)
        self._all_right = all(clock.right for clock in self._clocks.craft.values())
        for craft, config in scenario.craft.items():
            north, east, course = plan.craft[craft].start
            start = north, east, plan.craft[craft].start_depth_m, course
            speed = plan.craft[craft].tracks[0].speed_mps
            self._vehicles[craft] = Vehicle(
                craft, config, scenario.sea, start, speed, scenario.clock.tick_s, scenario.seed
            )
            self._navigation.append(Navigation(craft, config.navigation, scenario.seed))
        self.truth = self._see()

    def advance(self, setpoints: Mapping[str, Setpoint]) -> None:
        """Move everybody one tick under the setpoints in force."""
        for craft, vehicle in self._vehicles.items():
            vehicle.step(setpoints.get(craft))
        self.tick += 1
        self.truth = self._see()

    def fixes(self, modem_events: Sequence[int]) -> list[Fix]:
        """Fix everybody's position now, at a time by its own clock.

        Parameters
        ----------
        modem_events : sequence of int
            What each agent must have, see `Fix`.
        """
        truth = self.truth
        fixes = [
            navigation.fix(pose, truth.tick, truth.t_ns, count)
            for navigation, pose, count in zip(self._navigation, truth.poses, modem_events, strict=True)
        ]
        if self._all_right:
            return fixes
        clocks = self._clocks.craft.values()
        return [
            msgspec.structs.replace(fix, t_ns=clock.local_ns(truth.t_ns))
            for fix, clock in zip(fixes, clocks, strict=True)
        ]

    @property
    def adrift(self) -> list[str]:
        """Craft whose ordered course the current does not let them make good."""
        return [craft for craft, vehicle in self._vehicles.items() if not vehicle.holdable]

    def _see(self) -> Truth:
        truth = Truth(self.tick, self.tick * self._tick_ns, [vehicle.pose for vehicle in self._vehicles.values()])
        self._clocks.see(truth)
        return truth
