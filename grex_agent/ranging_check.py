"""Can ranging work as a scenario wants it? Somebody to range to, a modem that can, and slots with room for answers."""

from grex_agent.mission import TeamPlan, range_max_m
from grex_agent.modem.outbox import NEARER
from grex_agent.ranging import ranged_to
from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.mac import plan_mac
from grex_link.profile import ModemProfile, load_profile, profile_names
from grex_link.tdma import Schedule, slowest_sound_mps, whole_ms_up
from grex_link.units import NS
from grex_link.wire import BYTES, Form


def check_ranging(scenario: Scenario, plan: TeamPlan, profile: ModemProfile, form: Form) -> None:
    """Refuse ranging that cannot work.

    Parameters
    ----------
    scenario : Scenario
        The run.
    plan : TeamPlan
        Its distances say how long an answer takes.
    profile : ModemProfile
        The modem.
    form : Form
        How a team state goes on the air.

    Raises
    ------
    ConfigError
        With the path of what cannot be, and what would do.
    """
    for craft, config in scenario.craft.items():
        if config.inertial is not None and scenario.team.own_filter is None:
            raise ConfigError(f"$.craft.{craft}.inertial", "needs the filter of the own fixes: add [team.own_filter]")
    if scenario.team.controller == "shared_reference" and (scenario.bases or scenario.team.ranging.mode != "off"):
        raise ConfigError(
            "$.team.controller",
            "ranges and bases need positions, which the words of the shared reference do not tell; take 'theta_p' or "
            "'theta_p_unbiased'",
        )
    if scenario.team.ranging.mode == "off":
        return
    _check_partners(scenario)
    _check_modem(scenario, profile)
    if form != "full":
        raise ConfigError(
            "$.link.message", f"ranging needs position and sigma, which the {form} form does not tell; use 'full'"
        )
    if scenario.team.ranging.mode == "two_way":
        _check_room(scenario, plan, profile, form)


def _check_partners(scenario: Scenario) -> None:
    users = [craft for craft in scenario.craft if scenario.craft[craft].inertial or scenario.craft[craft].base]
    if not users:
        raise ConfigError(
            "$.team.ranging.mode", "is of no use: no craft has [craft.NAME.inertial] or [craft.NAME.base]; use 'off'"
        )
    for craft in users:
        if not ranged_to(scenario, craft):
            raise ConfigError(
                f"$.craft.{craft}.inertial",
                "there is nobody to range to: at least one craft must be without [craft.NAME.inertial]",
            )


def _check_modem(scenario: Scenario, profile: ModemProfile) -> None:
    mode = scenario.team.ranging.mode
    if getattr(profile.ranging, mode):
        return
    able = [name for name in profile_names() if getattr(load_profile(name).ranging, mode)]
    raise ConfigError(
        "$.team.ranging.mode", f"{scenario.link.profile} measures no {mode} ranges; these do: {', '.join(able)}"
    )


def _check_room(scenario: Scenario, plan: TeamPlan, profile: ModemProfile, form: Form) -> None:
    """Refuse slots in which the answer does not come before the next one opens."""
    planned_m = 0.0 if profile.one_speaker_at_a_time else range_max_m(plan)
    mac = plan_mac(scenario, planned_m, BYTES[form])
    if not isinstance(mac, Schedule):
        return
    before_s = (mac.messages_per_slot - 1) * (profile.airtime_ns(BYTES[form]) / NS + profile.turnaround_s)
    needed_s = whole_ms_up(before_s * (1.0 + NEARER) + exchange_s(scenario, planned_m, profile))
    for slot in mac.slots:
        if ranged_to(scenario, slot.craft) and slot.length_ns < needed_s * NS:
            own = any(each.craft == slot.craft for each in scenario.link.mac.slots)  # type: ignore[union-attr]
            path = "$.link.mac.slots" if own else "$.link.mac.guard_s"
            missing_s = whole_ms_up(needed_s - (slot.length_ns - mac.guard_ns) / NS)
            would_do = f"length_s = {needed_s:g} would do" if own else f"{missing_s:g} would do"
            raise ConfigError(
                path,
                f"the slot of {slot.craft} has {slot.length_ns / NS:g} s, too few for a range; {would_do}",
            )


def exchange_s(scenario: Scenario, range_m: float, profile: ModemProfile) -> float:
    """Time from the beginning of a ping until its answer is out, with clocks as wrong as the guard allows for, s."""
    sound_s = range_m / slowest_sound_mps(scenario.link.water)
    latencies_s = 2.0 * profile.decode_latency_s + profile.transmit_latency_s + profile.ranging.reply_s
    slack_s = 2.0 * getattr(scenario.link.mac, "clock_error_s", 0.0) + getattr(scenario.link.mac, "jitter_s", 0.0)
    return 2.0 * (profile.ping_airtime_ns / NS + sound_s) + latencies_s + slack_s
