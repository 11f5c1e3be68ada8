"""Runs the tasks of one craft, one after another; see `TaskRunner`.

=============  =======================================================================================
happening      what comes of it
=============  =======================================================================================
task done      the next of its list; after the last what follows from it: a place gone to is held, an
               inspection has its ``then``, a hold, and a time at the surface, are followed by return
returned       the craft does what it is for: a member follows the plan, others keep their place
a new order    interrupts what is being done, and what was to follow
no valid fix   the craft holds, and time does not count, until there is one
a bad task     is refused with a reason; what is being done goes on
=============  =======================================================================================
"""

from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan
from grex_agent.tasks.activity import DEPTH_M, Activity, Joining, Pilot, Running, Staying, Steering
from grex_agent.tasks.planner import Route, circle, straight, survey
from grex_link.config import Scenario
from grex_link.messages import Fix
from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface, Task
from grex_link.units import NS

#: Builds a part of a task when its time has come, from where the craft is then; None if there is nothing to do.
Part = Callable[[Fix], Activity | None]


class Happening(NamedTuple):
    """Something became of a task: ``started``, ``done``, ``returned``, ``interrupted``."""

    name: str
    task: Task
    status: str


class TaskRunner:
    """See the module's docstring.

    Parameters
    ----------
    scenario : Scenario
        Guidance, and what the craft can do.
    craft : str
        Whose tasks.
    plan : TeamPlan
        What the craft is for.
    processor : ManoeuvreProcessor
        Follows its plan; it is moved on when the craft comes back to it.

    Attributes
    ----------
    name : str
        Name of the order that is being done; empty for none.
    happenings : list of Happening
        To be taken away by the owner.
    """

    def __init__(self, scenario: Scenario, craft: str, plan: TeamPlan, processor: ManoeuvreProcessor) -> None:
        team, config = scenario.team, scenario.craft[craft]
        self._pilot = Pilot.of(scenario.guidance, team.speed_max_mps)
        surge = config.vehicle.surge
        self._speeds = max(team.speed_min_mps, surge.min), min(team.speed_max_mps, surge.max)
        self._turn_rate = config.vehicle.heading.rate_max
        pitch = config.vehicle.pitch
        self._dives = pitch.max > pitch.min
        self._tied = any(craft in land.between and land.length_m is not None for land in scenario.link.land)
        self._plan = plan.everybody[craft]
        self._member = craft in plan.craft
        self._processor = processor
        self._tasks: deque[Task] = deque()
        self._task: Task | None = None
        self._ordered: Task = Return()
        #: Whether what is being done only follows from the last task, which has been reported as done.
        self._over = False
        self._parts: deque[Part] = deque()
        self._activity: Activity | None = None
        self._stepped_ns: int | None = None
        self._last: Steering | None = None
        self._home = None if self._member else self._staying_home()
        self.name = ""
        self.happenings: list[Happening] = []

    @property
    def busy(self) -> bool:
        """Whether there is something to do besides what the craft is for."""
        return self._task is not None or bool(self._tasks)

    @property
    def task(self) -> Task | None:
        """What is being done."""
        return self._task

    def refusal(self, task: Task, *, lost: bool) -> str:
        """Say why a task cannot be done, one of `task_wire.REASONS`; else ''."""
        speed, (least, most) = getattr(task, "speed_mps", self._speeds[0]), self._speeds
        depth = getattr(task, "at_ned_m", (0.0, 0.0, 0.0))[2]
        round_it = isinstance(task, Inspect) and task.shape == "circle"
        reasons = {
            "no_fix": lost,
            "cable": self._tied and isinstance(task, GoTo | Follow | Inspect | Surface),
            "speed": not least <= speed <= most,
            "radius": round_it and getattr(task, "radius_m", 0.0) * self._turn_rate < speed,
            "depth": depth < 0.0 or not (self._dives or depth <= DEPTH_M),
            "tracks": isinstance(task, Follow) and (not self._member or task.track >= len(self._plan.tracks)),
        }
        return next((reason for reason, holds in reasons.items() if holds), "")

    def order(self, tasks: Sequence[Task], name: str) -> None:
        """Do these tasks from the next step on, instead of whatever is being done."""
        if self._task is not None and not self._over:
            self.happenings.append(Happening(self.name, self._task, "interrupted"))
        self._tasks, self._over = deque(tasks), False
        self.name, self._task, self._activity = name, None, None
        self._parts.clear()

    def step(self, now_ns: int, fix: Fix | None, formation: float, *, lost: bool) -> Steering | None:
        """Say what to do at a time.

        Parameters
        ----------
        now_ns : int
            Time.
        fix : Fix or None
            The newest fix.
        formation : float
            Progress at which the formation is, for a member that returns to it.
        lost : bool
            Whether the fix is not to be trusted.

        Returns
        -------
        Steering or None
            None for a member that follows its plan.
        """
        before_ns, self._stepped_ns = self._stepped_ns, now_ns
        if fix is None or lost:
            return None if not self.busy and self._home is None else self._last
        dt_s = 0.0 if before_ns is None else max(now_ns - before_ns, 0) / NS
        while self.busy:
            activity = self._next(fix)
            if activity is None:
                continue
            if isinstance(activity, Joining):
                activity.target = self._place_in_formation(formation)
            self._last = activity.steer(fix, dt_s)
            if not activity.done:
                return self._last
            if isinstance(activity, Joining):
                self._processor.go_to(int(formation))
            self._activity, dt_s = None, 0.0
        if self._home is None:
            return None
        self._last = self._home.steer(fix, dt_s)
        return self._last

    # -- inside -------------------------------------------------------------------------------------------------

    def _next(self, fix: Fix) -> Activity | None:
        """Return the activity of this step; None, and a step further, if one has just ended."""
        if self._activity is not None:
            return self._activity
        if self._task is None:
            self._task = self._tasks.popleft()
            self._parts = deque(self._parts_of(self._task, fix))
            if not self._over:
                self.happenings.append(Happening(self.name, self._task, "started"))
        if not self._parts:
            self._end(self._task)
            return None
        activity = self._parts.popleft()(fix)
        if activity is not None and not activity.done:
            self._activity = activity
        return self._activity

    def _end(self, task: Task) -> None:
        """Go on after a task: with the next one, or with what follows from the last."""
        self._task = None
        if not self._over:
            self._ordered = task
            self.happenings.append(Happening(self.name, task, "done"))
        if self._tasks:
            return
        following = _after(task)
        if following is not None:
            self._over = True
            self._tasks.append(following)
            return
        if isinstance(task, Return):
            self.happenings.append(Happening(self.name, self._ordered, "returned"))
        self._over, self.name = False, ""

    def _parts_of(self, task: Task, fix: Fix) -> list[Part]:
        pilot, parts = self._pilot, []
        match task:
            case GoTo():
                parts = self._going(task)
            case Follow():
                track = self._plan.tracks[task.track]
                parts = self._going(GoTo((*track.point(0.0), track.depth_m), task.speed_mps))
                parts.append(lambda _: self._processor.go_to(task.track))
            case Hold():
                at = fix.north_m, fix.east_m, fix.down_m
                parts = [lambda _: Staying(pilot, at, task.for_s)]
            case Inspect():
                parts = [lambda now: Running(pilot, survey(task, (now.north_m, now.east_m)), task.for_s)]
            case Surface():
                parts = [
                    lambda now: self._changing_depth(now, 0.0, task.speed_mps),
                    lambda now: Staying(pilot, (now.north_m, now.east_m, 0.0), task.for_s),
                ]
            case Return() if self._member:
                parts = [lambda _: Joining(pilot)]
            case Return():
                home = *self._plan.tracks[0].point(0.0), self._plan.start_depth_m
                parts = self._going(GoTo(home, task.speed_mps))
        return parts

    def _going(self, to: GoTo) -> list[Part]:
        return [
            lambda now: Running(self._pilot, Route(straight((now.north_m, now.east_m), to.at_ned_m, to.speed_mps))),
            lambda now: self._changing_depth(now, to.at_ned_m[2], to.speed_mps),
        ]

    def _changing_depth(self, fix: Fix, depth_m: float, speed_mps: float) -> Activity | None:
        """Circle until a depth has been reached; nothing if it has been."""
        if abs(fix.down_m - depth_m) <= DEPTH_M:
            return None
        route = circle((fix.north_m, fix.east_m), fix.heading_rad, depth_m, speed_mps)
        return Running(self._pilot, route, depth_m=depth_m)

    def _place_in_formation(self, progress: float) -> tuple[float, float, float, float]:
        number = min(max(int(progress), 0), len(self._plan.tracks) - 1)
        track = self._plan.tracks[number]
        return (*self._plan.point(progress), track.depth_m, track.speed_mps)

    def _staying_home(self) -> Staying:
        north, east = self._plan.tracks[0].point(0.0)
        return Staying(self._pilot, (north, east, self._plan.start_depth_m), 0.0)


def _after(task: Task) -> Task | None:
    """Say what follows the last task of a list."""
    speed_mps = getattr(task, "speed_mps", 1.0)
    following: dict[str, Task] = {"return": Return(speed_mps), "surface": Surface(0.0, speed_mps), "hold": Hold()}
    match task:
        case Inspect():
            return following[task.then]
        case GoTo():
            return following["hold"]
        case Hold() | Surface():
            return following["return"]
        case _:
            return None
