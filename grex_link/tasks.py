"""Tasks as data: what a craft can be told to do, in the scenario and in flight; who stands by, and what comes up.

A craft that has a part in the mission is a *member* of the formation: members wait for each other and are scored.
Every other craft *stands by* at a place: nobody waits for it, and it is not scored. After its last task a craft goes
back to what it is for: a member to its place in the formation, one that stands by to its place.
"""

from typing import Annotated, Literal

from msgspec import Meta

from grex_link.config_base import Config, Finite, Name, NonNegative, Positive

Place = tuple[Finite, Finite, Finite]


class GoTo(Config, frozen=True, tag="goto"):
    """Go to a place and a depth; without a further task, hold there."""

    at_ned_m: Place
    speed_mps: Positive = 1.0


class Follow(Config, frozen=True, tag="follow"):
    """Go to the start of a track of the own plan, and follow the plan from there."""

    track: Annotated[int, Meta(ge=0, le=255)] = 0
    speed_mps: Positive = 1.0


class Hold(Config, frozen=True, tag="hold"):
    """Hold where the craft is; then return."""

    for_s: NonNegative = 0.0
    """0: until it is told something else."""


class Inspect(Config, frozen=True, tag="inspect"):
    """Go to a place and survey it, round and round."""

    at_ned_m: Place
    for_s: Positive = 120.0
    """Time of the survey; the way there is not counted, nor is time without a valid fix."""
    radius_m: Positive = 15.0
    """Of the circle; half the side of the box."""
    shape: Literal["circle", "box"] = "circle"
    speed_mps: Positive = 1.0
    then: Literal["return", "surface", "hold"] = "return"
    """What follows if there is no further task."""


class Surface(Config, frozen=True, tag="surface"):
    """Come up in a circle and stay there; then return."""

    for_s: NonNegative = 0.0
    """Time at the surface; 0: until it is told something else."""
    speed_mps: Positive = 1.0


class Return(Config, frozen=True, tag="return"):
    """Go back: a member to its place in the formation, one that stands by to its place."""

    speed_mps: Positive = 1.0


Task = GoTo | Follow | Hold | Inspect | Surface | Return
TaskList = Annotated[tuple[Task, ...], Meta(max_length=50)]


class StandbyConfig(Config, frozen=True):
    """A craft that stands by."""

    at_ned_m: Place
    """Where it stands by, and starts."""
    on_call: bool = True
    """Whether it is called to events; an operator can always call it."""


class EventConfig(Config, frozen=True):
    """Something of interest: the nearest craft on call is sent to inspect it."""

    at_s: NonNegative
    at_ned_m: Place
    seen_by: Name
    """Who sees it, and decides by what it knows of where the others are."""
    for_s: Positive = 120.0
    radius_m: Positive = 15.0
    shape: Literal["circle", "box"] = "circle"
    speed_mps: Positive = 1.0
    then: Literal["return", "surface", "hold"] = "return"

    @property
    def task(self) -> Inspect:
        """What is to be done about it."""
        return Inspect(self.at_ned_m, self.for_s, self.radius_m, self.shape, self.speed_mps, self.then)


class TaskingConfig(Config, frozen=True):
    """How tasks travel."""

    operator: Name | None = None
    """Craft on which ``grex task`` is typed; left out: the first with radio, else with cable, else the first."""
    tries: Annotated[int, Meta(ge=1, le=100)] = 8
    """How often a task is sent before its sender gives up."""


def type_of(task: Task) -> str:
    """Name of a kind of task, as in a scenario."""
    return str(task.__struct_config__.tag)
