"""How a craft coordinates with its team: the law, what is believed of the mates, and what they are told.

Two ways: the laws of the speed controllers (eq. 2), with an estimator of the mates and team states on the air; and the
shared reference, which is law and estimator in one, with words of its own.
"""

from dataclasses import dataclass
from typing import Any

from grex_agent.coordination import SpeedController, check_unbiased, load_controller
from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.medium_access import medium_access
from grex_agent.messenger import Talk
from grex_agent.mission import TeamPlan
from grex_agent.reference_talk import ReferenceTalk
from grex_agent.shared_reference import SharedReference
from grex_agent.talk_policy import Periodic, TalkPolicy, make_policy
from grex_agent.team.acknowledgement import Acknowledgements
from grex_agent.team.baseline import Unaware
from grex_agent.team.interface import TeamContext, load_estimator
from grex_agent.tell import TeamTalk
from grex_link import reference_wire
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.messages import Fix
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import BYTES, Form

SHARED_REFERENCE = "shared_reference"


@dataclass(frozen=True, slots=True)
class Coordination:
    """The parts that belong together.

    Attributes
    ----------
    controller : SpeedController
        Orders the speed.
    estimator : TeamEstimator or SharedReference
        Says what is believed of the mates; it takes what the talk gives.
    talk : Talk
        Packs what is told, and reads.
    policy : TalkPolicy
        Whether to speak in an own slot.
    message_bytes : int
        Length of what is told.
    """

    controller: SpeedController
    estimator: Any
    talk: Talk
    policy: TalkPolicy
    message_bytes: int

    def word(self, fix: Fix, processor: ManoeuvreProcessor, speed_mps: float) -> Any:
        """Put together what is to be told: of the reference, or of the own state."""
        if isinstance(self.estimator, SharedReference):
            return self.estimator.word()
        assert isinstance(self.talk, TeamTalk)  # noqa: S101 - see `coordinate`
        return self.talk.state(fix, processor, speed_mps)


def coordinate(scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile, form: Form) -> Coordination:
    """Build what a scenario asks for.

    Raises
    ------
    ConfigError
        If a name is unknown, something it needs is missing, or the modem cannot carry it.
    """
    check_unbiased(scenario.team)
    if scenario.team.controller == SHARED_REFERENCE:
        return _by_reference(scenario, craft, plan, profile)
    controller = load_controller(scenario.team)
    acknowledgements = _acknowledgements(scenario, craft, plan, profile, form)
    context = TeamContext(craft, plan, scenario, controller, acknowledgements)
    if craft not in plan.craft:  # who stands by waits for nobody, and tells where it is
        return Coordination(controller, Unaware(context), TeamTalk(craft, plan, form), Periodic(), BYTES[form])
    estimator = load_estimator(context)
    policy = make_policy(scenario.team.talk, estimator)
    talk = TeamTalk(craft, plan, form, acknowledgements)
    return Coordination(controller, estimator, talk, policy, BYTES[form])


def _acknowledgements(
    scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile, form: Form
) -> Acknowledgements | None:
    """Say which messages are missing, where the form and the size of the team leave room for it."""
    if form != "full" or craft not in plan.craft:
        return None
    interval_s = medium_access(scenario, plan, profile, BYTES[form]).interval_ns / NS
    acknowledgements = Acknowledgements(craft, list(plan.craft), interval_s)
    return acknowledgements if acknowledgements.intervals else None


def _by_reference(scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile) -> Coordination:
    if scenario.team.estimator != "none":
        raise ConfigError("$.team.estimator", "the shared reference needs none: set it to 'none'")
    if scenario.standby or scenario.events or any(config.tasks for config in scenario.craft.values()):
        raise ConfigError(
            "$.team.controller",
            f"'{SHARED_REFERENCE}' knows neither tasks nor craft that stand by; take 'theta_p' or 'theta_p_unbiased'",
        )
    size = reference_wire.size_bytes(len(plan.craft))
    if 8 * size > profile.bits_max:
        raise ConfigError(
            "$.team.controller",
            f"'{SHARED_REFERENCE}' tells {size} bytes in a team of {len(plan.craft)}, and {scenario.link.profile} "
            f"carries {profile.bits_max} bits; take another profile, or controller 'theta_p'",
        )
    reference = SharedReference(scenario, craft, plan)
    talk = ReferenceTalk(craft, list(plan.craft), reference)
    return Coordination(reference, reference, talk, make_policy(scenario.team.talk, reference), size)
