"""What an estimator of the team mates is: one method, called at every step."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from grex_agent.coordination import SpeedController
from grex_agent.mission import TeamPlan
from grex_agent.plugin import build_plugin
from grex_link.config import Scenario
from grex_link.messages import MateBelief
from grex_link.wire import TeamState

if TYPE_CHECKING:
    from grex_agent.team.acknowledgement import Acknowledgements

KNOWN = {
    "none": "grex_agent.team.baseline:Unaware",
    "ideal": "grex_agent.team.baseline:Ideal",
    "hold_last": "grex_agent.team.reckoning:HoldLast",
    "dead_reckoning": "grex_agent.team.reckoning:DeadReckoning",
    "first_level": "grex_agent.team.planar:FirstLevel",
    "second_level": "grex_agent.team.planar:SecondLevel",
    "biased_planar_first": "grex_agent.team.biased_planar:BiasedPlanarFirst",
    "biased_planar": "grex_agent.team.biased_planar:BiasedPlanar",
    "along_track_first": "grex_agent.team.along_track:AlongTrackFirst",
    "along_track": "grex_agent.team.along_track:AlongTrack",
}


@dataclass(frozen=True, slots=True)
class TeamContext:
    """What an estimator is built from; all of it is known aboard before the mission.

    Attributes
    ----------
    craft : str
        The craft it runs on.
    plan : TeamPlan
        The plan of everybody, in the order of the team.
    scenario : Scenario
        Parameters of guidance, team and Kalman filters.
    controller : SpeedController
        The coordination law, for models of the mates.
    acknowledgements : Acknowledgements or None
        Reads what the mates say they have heard; None if they do not say it.
    """

    craft: str
    plan: TeamPlan
    scenario: Scenario
    controller: SpeedController
    acknowledgements: "Acknowledgements | None" = None


class Own(NamedTuple):
    """The craft's own state as its navigation knows it: position in metres NED, progress = track number plus Θ."""

    north_m: float
    east_m: float
    progress: float


class Report(NamedTuple):
    """A team state and whose it is; `TeamState.t_s` tells when it was valid."""

    craft: str
    state: TeamState


class TeamEstimator(Protocol):
    """An estimator of the team mates.

    A class of yours with this one method plugs in as ``team.estimator = "your_package.module:YourEstimator"``. It is
    built with a `TeamContext`. If it has a method ``prepare(next_s)`` besides, that is called when the setpoint is out,
    with the time at which the next step is expected: to work in advance while there is time. The next step may come at
    another time all the same.
    """

    def step(self, now_s: float, own: Own, sent: Sequence[TeamState], heard: Sequence[Report]) -> list[MateBelief]:
        """Advance to a time and say what is believed then.

        Parameters
        ----------
        now_s : float
            Mission time, seconds; it never decreases.
        own : Own
            The own state now.
        sent : sequence of TeamState
            Own messages, as packed, of which the modem has said since the last step that they have left.
        heard : sequence of Report
            Messages that have arrived since the last step; late, and not necessarily in order.

        Returns
        -------
        list of MateBelief
            In the order of the team. A mate of whom nothing is believed is left out, and not waited for.
        """


def needs_oracle(scenario: Scenario) -> bool:
    """Whether the scenario's estimator reads the truth; the bench then gives it to the agents."""
    return scenario.team.estimator == "ideal"


def load_estimator(context: TeamContext) -> TeamEstimator:
    """Build the estimator a scenario names."""
    name = context.scenario.team.estimator
    estimator: TeamEstimator = build_plugin("$.team.estimator", name, KNOWN, context, "step")
    return estimator
