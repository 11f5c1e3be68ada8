"""What a viewer is told once: the team, its planned tracks, its slots."""

from collections.abc import Iterable
from typing import Any

from grex_agent.capabilities import state_form
from grex_agent.medium_access import medium_access
from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_link.errors import GrexError
from grex_link.profile import load_profile
from grex_link.tdma import Schedule
from grex_link.units import NS
from grex_link.wire import BYTES
from grex_sim.outline import outline


def scene(scenario: Scenario, plan: TeamPlan) -> dict[str, Any]:
    """Describe what does not change in a run, for the page.

    Returns
    -------
    dict
        Seconds, metres (north, east) and names.
    """
    return {
        "title": scenario.title,
        "team": scenario.team.name,
        "estimator": scenario.team.estimator,
        "pace": scenario.clock.pace,
        "tick_s": scenario.clock.tick_s,
        "factor": None if scenario.clock.lockstep else scenario.clock.factor,
        "duration_s": scenario.duration_s or plan.duration_s,
        "craft": list(scenario.craft),
        "modem": scenario.link.profile,
        # Who has no part in the formation has no track to be drawn.
        "plan": {name: _rounded(outline(plan.craft[name])) if name in plan.craft else [] for name in scenario.craft},
        "tracks": len(next(iter(plan.craft.values())).tracks),
        **_medium_access(scenario, plan),
    }


def _medium_access(scenario: Scenario, plan: TeamPlan) -> dict[str, Any]:
    """Say who may speak when; where nobody has a slot of his own, only how it is decided."""
    try:
        profile = load_profile(scenario.link.profile)
        mac = medium_access(scenario, plan, profile, BYTES[state_form(scenario, profile)])
    except GrexError:  # a modem whose profile is on another machine: no wheel is better than no page
        return {"access": "unknown", "cycle_s": None, "slots": []}
    if not isinstance(mac, Schedule):
        return {"access": type(scenario.link.mac).__name__, "cycle_s": None, "slots": []}
    slots = [(slot.craft, slot.start_ns / NS, slot.length_ns / NS) for slot in mac.slots]
    return {"access": "TDMA", "cycle_s": mac.cycle_ns / NS, "slots": slots}


def _rounded(places: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    return [(round(north, 2), round(east, 2)) for north, east in places]
