"""What the bench says beforehand about craft on MAVLink."""

import pytest

from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError
from grex_link.scenario import loads
from grex_sim.plan_text import plan_text
from grex_sim.run import check_scenario, simulate_in_process

TEXT = """
datum = { latitude_deg = 54.37, longitude_deg = 10.16 }
clock.pace = "live"
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 20, 0]
[craft.auv1]
[craft.auv2.frontseat]
type = "mavlink"
url = "udpin:127.0.0.1:14550"
system = 7
"""


def text_of(*overrides: str) -> str:
    scenario = loads(TEXT, overrides)
    return plan_text(scenario, plan_mission(scenario))


def test_check_tells_of_autopilots():
    """`grex check` says where each autopilot is, who arms it, where the datum is, and how it gets to its track."""
    text = text_of()
    assert "auv2   udpin:127.0.0.1:14550  7       a person sets the mode and arms" in text
    assert "the adapter sets the mode and arms" in text_of("craft.auv2.frontseat.arm=true")
    assert "North 0, east 0 is 54.370000°, 10.160000°." in text
    assert "these craft go to their first\ntrack, by their guidance" in text


def test_check_is_silent_without_autopilots():
    """A team of simulated craft hears nothing of autopilots, even with a datum."""
    assert "Autopilots" not in text_of('craft.auv2.frontseat={type="sim"}')


@pytest.mark.parametrize(
    ("overrides", "path"),
    [
        (["clock.pace=lockstep"], "$.craft.auv2.frontseat"),
        (["craft.auv2.frontseat.url=x"], "$.craft.auv2.frontseat.url"),
    ],
)
def test_what_cannot_work_is_found_beforehand(overrides: list[str], path: str):
    """Real craft in lockstep, and an address that is none, are refused before anything starts."""
    with pytest.raises(ConfigError) as error:
        check_scenario(loads(TEXT, overrides))
    assert error.value.path == path


def test_not_in_one_process():
    """A craft on MAVLink has a process of its own: in-process runs say so."""
    with pytest.raises(ConfigError, match=r"^\$\.craft\.auv2\.frontseat\.type: .* run without --in-process$"):
        simulate_in_process(loads(TEXT), None, lambda _: None)
