"""The sea: all simulated craft of a scenario, moved tick by tick; craft on MAVLink only say where they are."""

from collections.abc import Mapping, Sequence

import msgspec

from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_link.craft_clock import TeamClocks
from grex_link.messages import Fix, Pose, Setpoint, Truth
from grex_link.units import tick_ns
from grex_sim.anchored import Anchored
from grex_sim.external import External
from grex_sim.navigation import Navigation
from grex_sim.vehicle import Vehicle


class Sea:
    """Simulated craft that start where their plan starts, on its course and at its speed, and craft on MAVLink.

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
        self._team = list(scenario.craft)
        self._vehicles: dict[str, Vehicle | Anchored] = {}
        self._navigation: dict[str, Navigation] = {}
        self.external: dict[str, External] = {}
        """Craft on MAVLink: their fixes are all that is known of them, and the best."""
        self._clocks = TeamClocks(scenario)
        self._all_right = all(clock.right for clock in self._clocks.craft.values())
        plans = plan.everybody
        for craft, config in scenario.craft.items():
            if config.base is not None:
                self._vehicles[craft] = Anchored(craft, config.base.place_ned_m)
                self._navigation[craft] = Navigation(craft, config.navigation, scenario.seed)
                continue
            north, east, course = plans[craft].start
            start = north, east, plans[craft].start_depth_m, course
            if craft in scenario.mavlink_craft:
                self.external[craft] = External(craft, start)
                continue
            speed = plans[craft].tracks[0].speed_mps if craft in plan.craft else 0.0
            self._vehicles[craft] = Vehicle(
                craft, config, scenario.sea, start, speed, scenario.clock.tick_s, scenario.seed
            )
            self._navigation[craft] = Navigation(craft, config.navigation, scenario.seed)
        self.truth = self._see()

    def advance(self, setpoints: Mapping[str, Setpoint]) -> None:
        """Move everybody one tick under the setpoints in force."""
        for craft, vehicle in self._vehicles.items():
            vehicle.step(setpoints.get(craft))
        self.tick += 1
        self.truth = self._see()

    def fixes(self, modem_events: Sequence[int]) -> list[Fix]:
        """Fix the position of every simulated craft now, in the order of `simulated`, at a time by its own clock.

        Parameters
        ----------
        modem_events : sequence of int
            What each agent must have, see `Fix`.
        """
        truth = self.truth
        fixes = [
            self._navigation[pose.craft].fix(pose, truth.tick, truth.t_ns, count)
            for pose, count in zip(truth.poses, modem_events, strict=True)
            if pose.craft in self._navigation
        ]
        if self._all_right:
            return fixes
        clocks = [self._clocks.craft[craft] for craft in self._navigation]
        return [
            msgspec.structs.replace(fix, t_ns=clock.local_ns(truth.t_ns))
            for fix, clock in zip(fixes, clocks, strict=True)
        ]

    @property
    def simulated(self) -> list[str]:
        """Craft that the sea moves, in the order of the team."""
        return list(self._vehicles)

    @property
    def adrift(self) -> list[str]:
        """Craft whose ordered course the current does not let them make good."""
        return [craft for craft, vehicle in self._vehicles.items() if not vehicle.holdable]

    def _see(self) -> Truth:
        t_ns = self.tick * self._tick_ns
        truth = Truth(self.tick, t_ns, [self._pose(craft, t_ns) for craft in self._team])
        self._clocks.see(truth)
        return truth

    def _pose(self, craft: str, t_ns: int) -> Pose:
        vehicle = self._vehicles.get(craft)
        return self.external[craft].pose(t_ns) if vehicle is None else vehicle.pose
