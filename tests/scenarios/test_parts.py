"""A team in which not everybody has a part in the formation."""

import pytest
from missions import fly_text

from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError
from grex_link.scenario import loads
from grex_sim.report import _read
from grex_sim.run import check_scenario, simulate_in_process
from grex_sim.summary import SERIES_FILE

TEAM = """
duration_s = 120.0
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 400.0
[mission.formation_m]
auv1 = [0.0, 0.0, 5.0]
auv2 = [0.0, 20.0, 5.0]
[link]
profile = "s2c_im"
[standby.aid]
at_ned_m = [60.0, 80.0, 5.0]
[craft.buoy.base]
place_ned_m = [0.0, -60.0, 2.0]
watch = "auv1"
[craft.auv1]
[craft.aid]
[craft.auv2]
[craft.ship.base]
place_ned_m = [50.0, -60.0, 2.0]
watch = "auv2"
"""


def test_a_base_and_a_craft_that_stands_by():
    """Beside a pair a craft stands by and two bases watch: nobody waits for them, nor are they scored."""
    summary = fly_text(TEAM)
    assert summary.complete
    assert summary.fd < 0.2
    assert summary.navigation["buoy>auv1"].rms_m < 2.0
    assert summary.navigation["ship>auv2"].rms_m < 2.0
    assert not summary.bad_frames
    assert summary.sources["aid"].started > 10


def test_the_picture_shows_each_craft_where_it_was(tmp_path):
    """A base before others in the file does not push the tracks of the picture to other names."""
    scenario = loads(TEAM)
    simulate_in_process(scenario, tmp_path, lambda _: None)
    plan = plan_mission(scenario)
    run = _read(tmp_path / SERIES_FILE, list(plan.everybody), list(plan.craft))
    places = dict(zip(plan.everybody, run.positions[-1].tolist(), strict=True))
    assert places["aid"] == pytest.approx([60.0, 80.0], abs=10.0)
    assert places["auv2"] == pytest.approx([120.0, 20.0], abs=5.0)


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("mission.formation_m.buoy=[0.0, 40.0, 5.0]", r"\$\.mission\.formation_m\.buoy: is a base"),
        ("standby.buoy={at_ned_m=[0.0, 0.0, 5.0]}", r"\$\.standby\.buoy: is a base"),
        ("craft.buoy.base.watch=aid", r"\$\.craft\.buoy\.base\.watch: no craft that moves"),
        ("events=[{at_s=10, at_ned_m=[0.0, 0.0, 5.0], seen_by='buoy'}]", r"\$\.events\[0\]\.seen_by: buoy is a base"),
        ("tasking.operator=buoy", r"\$\.tasking\.operator: buoy is a base"),
        ("craft.buoy.tasks=[{type='hold', for_s=10.0}]", r"\$\.craft\.buoy\.tasks: a base stays"),
        ("link.land=[{between=['auv1', 'buoy'], kind='cable', length_m=90.0}]", r"length_m: buoy is a base"),
        ("team={controller='shared_reference', estimator='none', own_filter={}}", r"\$\.team\.controller"),
    ],
)
def test_parts_that_cannot_be(override, line):
    """A part that cannot be is one line with its path."""
    with pytest.raises(ConfigError, match=line):
        check_scenario(loads(TEAM, [override]))
