"""Can this modem do what the plan needs? An agent that finds it cannot does not start."""

from collections.abc import Callable

from grex_agent.frontseat.address import check_frontseats
from grex_agent.mission import TeamPlan, range_min_m
from grex_agent.modem.micromodem_rates import check_serial_modems
from grex_agent.ranging_check import check_ranging
from grex_agent.tasks.check import check_task_plan
from grex_link.config import Scenario
from grex_link.errors import ConfigError, WireError
from grex_link.link_config import WaterConfig
from grex_link.profile import ModemProfile, Protocol, load_profile, profile_names
from grex_link.wire import BITS, Form, choose_form


def check_capabilities(scenario: Scenario, plan: TeamPlan, profile: ModemProfile) -> None:
    """Refuse what cannot work, before anything starts.

    Parameters
    ----------
    scenario : Scenario
        The run: its team, its modems, and everything said about the link between them.
    plan : TeamPlan
        What the team is to do.
    profile : ModemProfile
        What its modems can do.

    Raises
    ------
    ConfigError
        With the path of what cannot be, and what would do.
    """
    _check_team(scenario, profile)
    form = state_form(scenario, profile)
    check_ranging(scenario, plan, profile, form)
    _check_reach(scenario, plan, profile)
    check_serial_modems(scenario)
    check_frontseats(scenario)
    check_task_plan(scenario, plan, profile)
    _check_water(scenario, profile)


def state_form(scenario: Scenario, profile: ModemProfile) -> Form:
    """Choose how a team state goes on the air.

    Raises
    ------
    ConfigError
        If the modem carries no form of it, or not the one wanted.
    """
    wanted = scenario.link.message
    try:
        return choose_form(profile.bits_max, wanted)
    except WireError as error:
        fit = [form for form, bits in BITS.items() if bits <= profile.bits_max]
        if fit:
            raise ConfigError("$.link.message", f"{error}; 'auto' would do, that is {fit[0]!r}") from None
        raise ConfigError("$.link.profile", f"{scenario.link.profile} carries no team state: {error}") from None


def _check_reach(scenario: Scenario, plan: TeamPlan, profile: ModemProfile) -> None:
    """Refuse a modem that is not heard over any distance of the plan."""
    reach_m = heard_up_to_m(profile)
    if len(scenario.craft) < 2 or reach_m is None:
        return
    nearest_m = range_min_m(plan)
    if nearest_m > reach_m:
        raise ConfigError(
            "$.link.profile",
            f"{scenario.link.profile} is not heard beyond {reach_m:g} m, and the plan keeps all craft at least "
            f"{nearest_m:.0f} m apart",
        )


def heard_up_to_m(profile: ModemProfile) -> float | None:
    """Distance beyond which a modem is never heard, whatever the noise; None if its profile gives none."""
    limits = [profile.range_max_m] if profile.range_max_m is not None else []
    if profile.range_pdr is not None:
        limits.append(profile.range_pdr.range_m[-1])
    if isinstance(profile.reception, Protocol):
        limits.append(min(profile.reception.communication_m, profile.reception.detection_m))
    return min(limits, default=None)


def _check_team(scenario: Scenario, profile: ModemProfile) -> None:
    name, size = scenario.link.profile, len(scenario.craft)
    if size > 2 and not profile.broadcast:
        others = _others(lambda other: other.broadcast)
        raise ConfigError(
            "$.link.profile", f"{name} serves a pair, it has no broadcast; for {size} craft there are {others}"
        )
    most = profile.addresses_max
    if most is not None and size > most:
        others = _others(lambda other: other.addresses_max is None or other.addresses_max >= size)
        raise ConfigError("$.link.profile", f"{name} has {most} addresses; for {size} craft there are {others}")


def _others(able: Callable[[ModemProfile], bool]) -> str:
    return ", ".join(name for name in profile_names() if able(load_profile(name)))


def _check_water(scenario: Scenario, profile: ModemProfile) -> None:
    """Refuse physics asked of a modem that has none."""
    link = scenario.link
    if profile.one_speaker_at_a_time:
        asked = {
            "shadowing": link.shadowing is not None,
            "jammers": bool(link.jammers),
            "water": link.water != WaterConfig(),
        }
        for name in [name for name, given in asked.items() if given]:
            raise ConfigError(
                f"$.link.{name}",
                f"has no effect: {link.profile} has no acoustics; take another profile, or leave it out",
            )
