"""Medium access of a team: `grex_link.mac` for the distances that are planned."""

from grex_agent.mission import TeamPlan, range_max_m
from grex_link.config import Scenario
from grex_link.mac import Mac, plan_mac
from grex_link.profile import ModemProfile


def medium_access(scenario: Scenario, plan: TeamPlan, profile: ModemProfile, message_bytes: int) -> Mac:
    """Work out who may speak when, with messages of a length.

    Raises
    ------
    ConfigError
        If it cannot work; see `grex_link.mac.plan_mac`.
    """
    planned_m = 0.0 if profile.one_speaker_at_a_time else range_max_m(plan)
    return plan_mac(scenario, planned_m, message_bytes)
