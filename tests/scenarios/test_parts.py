"""A team in which not everybody has a part in the formation."""

import pytest
from missions import fly_text

from grex_link.errors import ConfigError
from grex_link.scenario import loads
from grex_sim.run import check_scenario

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


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("mission.formation_m.buoy=[0.0, 40.0, 5.0]", r"\$\.mission\.formation_m\.buoy: is a base"),
        ("standby.buoy={at_ned_m=[0.0, 0.0, 5.0]}", r"\$\.standby\.buoy: is a base"),
        ("craft.buoy.base.watch=aid", r"\$\.craft\.buoy\.base\.watch: no craft that moves"),
        ("team={controller='shared_reference', estimator='none', own_filter={}}", r"\$\.team\.controller"),
    ],
)
def test_parts_that_cannot_be(override, line):
    """A part that cannot be is one line with its path."""
    with pytest.raises(ConfigError, match=line):
        check_scenario(loads(TEAM, [override]))
