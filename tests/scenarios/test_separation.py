"""The guard in a whole mission.

::

    auv1 ──► 1.00 m/s          auv2 begins behind in the same lane with a screw that turns 40 % too fast,
    auv2 ────► 1.4 m/s         under a law that hardly holds it back
"""

from missions import fly_text

CATCHING_UP = """
duration_s = 200
[team]
estimator = "along_track"
gain_mps = 0.0
[fleet]
count = 3
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 400.0
[mission.formation]
type = "astern"
spacing_m = 25.0
[craft.auv2.vehicle]
speed_error_relative = 0.4
"""


def test_a_craft_that_catches_up_is_held_back():
    """Without the guard it runs through its mate; with it, it keeps off, says so, and everybody gets on."""
    free = fly_text(CATCHING_UP)
    assert free.closest.distance_m < 3.0
    assert free.closest.craft == ("auv1", "auv2")
    assert 0.0 < free.closest.t_s < 200.0
    kept = fly_text(CATCHING_UP, "team.separation_min_m=10.0")
    assert kept.closest.distance_m > 8.0
    assert kept.unhealthy_steps["auv2"]["separation"] > 0
    assert "auv1" not in kept.unhealthy_steps


def test_where_nobody_is_too_near_it_changes_nothing():
    """A team that keeps its formation goes the same way, to the last bit, with the guard as without."""
    calm = CATCHING_UP.replace("= 0.4", "= 0.01")
    assert fly_text(calm, "team.separation_min_m=10.0").digest == fly_text(calm).digest


def test_one_craft_alone_has_no_closest_approach():
    """Of one craft alone no approach is told."""
    assert fly_text(CATCHING_UP, "fleet.count=1", "craft={}", "duration_s=5").closest is None
