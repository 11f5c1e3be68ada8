"""Teams of many craft: fifty in a V, and craft that are kept apart."""

import pytest
from missions import fly, fly_text


def test_fifty_craft():
    """Fifty craft in a V, each with filters of the other forty-nine, keep their formation and their distance."""
    summary = fly("fifty", "duration_s=120")
    assert summary.complete
    assert summary.messages_sent == 12
    assert summary.delivered == 49 * 11
    assert summary.fd < 2.0
    assert summary.closest.distance_m == pytest.approx(12.0, abs=3.0)
    assert not summary.unhealthy_steps


CHASE = """
duration_s = 240.0
[team]
gain_mps = 0.0
speed_max_mps = 3.0
estimator = "along_track"
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 400.0
[mission.formation_m]
auv1 = [0.0, 0.0, 0.0]
auv2 = [-20.0, 0.0, 0.0]
[craft.auv1]
[craft.auv2.vehicle]
speed_error_relative = 0.2
"""


def test_a_craft_that_catches_up_is_kept_apart():
    """A craft a fifth too fast, with no coordination, runs over its mate; with the guard it stays behind."""
    free, kept = fly_text(CHASE), fly_text(CHASE, "team.separation_min_m=8")
    assert free.closest.distance_m < 1.0
    assert free.closest.craft == ("auv1", "auv2")
    assert kept.closest.distance_m > 7.0
    assert kept.unhealthy_steps["auv2"]["separation"] > 0
    assert "auv1" not in kept.unhealthy_steps
