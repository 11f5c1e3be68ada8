"""The guard in a whole mission.

::

    auv1 ──► 1.00 m/s          auv2 begins behind in the same lane with a screw that turns 40 % too fast,
    auv2 ────► 1.4 m/s         under a law that hardly holds it back
"""

import pytest
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


COLUMN = """
duration_s = 220
[team]
separation_min_m = 8.0
[fleet]
count = 3
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 1200.0
[mission.formation]
type = "astern"
spacing_m = 12.0
[craft.auv1]
vehicle = { speed_limits = [{ start_s = 40.0, end_s = 600.0, max_mps = 0.8 }] }
"""


@pytest.mark.parametrize(
    ("link", "estimator", "spacing_m", "kept_m"),
    [
        ("s2c_im", "along_track", 12.0, 7.9),
        ("s2c_im", "second_level", 12.0, 7.0),
        # 0.2 m/s for 40 s are 8 m: nothing can be done about them, but the column has to stay a column.
        ("grex2008", "along_track", 12.0, 4.0),
        ("grex2008", "second_level", 12.0, 3.0),
        ("grex2008", "along_track", 16.0, 7.9),
        ("grex2008", "second_level", 20.0, 6.5),
    ],
)
def test_a_column_follows_a_slow_mate(link, estimator, spacing_m, kept_m):
    """Behind one that cannot keep up the minimum is kept, as far as messages are in time, and the first goes on."""
    summary = fly_text(
        COLUMN, f'link.profile="{link}"', f'team.estimator="{estimator}"', f"mission.formation.spacing_m={spacing_m}"
    )
    assert kept_m < summary.closest.distance_m
    assert "auv1" not in summary.unhealthy_steps
    assert summary.unhealthy_steps["auv2"]["separation"] > 100


def test_a_column_of_ten_follows():
    """Each of ten in a column slows down in time for the one in front."""
    summary = fly_text(
        COLUMN, "fleet.count=10", 'link.profile="s2c_im"', 'team.estimator="along_track"', "duration_s=120"
    )
    assert summary.closest.distance_m > 7.9
    assert len(summary.unhealthy_steps) >= 4


TURNING = """
duration_s = 400
[team]
estimator = "along_track"
[fleet]
count = 4
[mission]
type = "lawnmower"
legs = 3
leg_length_m = 100.0
turn_radius_m = 40.0
[mission.formation]
type = "astern"
spacing_m = 12.0
[craft.auv2.vehicle]
speed_error_relative = 0.01
[craft.auv3.vehicle]
speed_error_relative = -0.01
"""


@pytest.mark.parametrize("formation", ["astern", "abreast", "v"])
def test_a_formation_that_is_kept_turns_as_without(formation):
    """Through turns, too, a guard of two thirds of the spacing changes nothing, to the last bit."""
    shape = f'mission.formation.type="{formation}"'
    assert fly_text(TURNING, shape, "team.separation_min_m=8.0").digest == fly_text(TURNING, shape).digest


CROSSING = """
duration_s = 300
[team]
estimator = "along_track"
gain_mps = 0.0
[mission]
type = "tracks"
[mission.craft.a]
start_ned_m = [0.0, 0.0, 0.0]
tracks = [{ type = "line", to_ned_m = [300.0, 300.0, 0.0], speed_mps = 1.0 }]
[mission.craft.b]
start_ned_m = [300.0, -15.0, 0.0]
tracks = [{ type = "line", to_ned_m = [0.0, 285.0, 0.0], speed_mps = 1.0 }]
[craft.a]
[craft.b.vehicle]
speed_error_relative = 0.12
"""


@pytest.mark.parametrize("link", ["s2c_im", "grex2008"])
def test_where_tracks_cross_one_waits(link):
    """Of two whose tracks cross, one lets the other pass, though the plan would have had it through before."""
    free = fly_text(CROSSING, f'link.profile="{link}"')
    assert free.closest.distance_m < 3.0
    kept = fly_text(CROSSING, f'link.profile="{link}"', "team.separation_min_m=8.0")
    assert kept.closest.distance_m > 7.9
    assert [*kept.unhealthy_steps] == ["b"]


CONVERGING = """
duration_s = 300
[team]
estimator = "along_track"
gain_mps = 0.0
[link]
profile = "grex2008"
[mission]
type = "tracks"
[mission.craft.a]
start_ned_m = [12.0, 0.0, 0.0]
tracks = [{ type = "line", to_ned_m = [212.0, 0.0, 0.0], speed_mps = 1.0 },
          { type = "line", to_ned_m = [412.0, 0.0, 0.0], speed_mps = 1.0 }]
[mission.craft.b]
start_ned_m = [0.0, 60.0, 0.0]
tracks = [{ type = "line", to_ned_m = [200.0, 0.0, 0.0], speed_mps = 1.04403 },
          { type = "line", to_ned_m = [400.0, 0.0, 0.0], speed_mps = 1.0 }]
[craft.a.vehicle]
speed_error_relative = -0.1
[craft.b]
"""


def test_where_tracks_meet_somebody_goes_first():
    """Of two whose tracks run into one, one falls in behind the other, though the other is slower than planned."""
    assert fly_text(CONVERGING).closest.distance_m < 7.5
    assert fly_text(CONVERGING, "team.separation_min_m=8.0").closest.distance_m > 7.9


BREAKING_OFF = """
duration_s = 200
[team]
estimator = "along_track"
[link]
profile = "s2c_im"
[fleet]
count = 2
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 600.0
[mission.formation]
type = "abreast"
spacing_m = 40.0
[craft.auv1]
tasks = [{ type = "goto", at_ned_m = [120.0, 60.0, 0.0], speed_mps = 1.2 }, { type = "return" }]
"""


def test_who_leaves_for_a_task_lets_the_others_pass():
    """A craft that breaks off across the track of its mate keeps off it, and still gets there and back."""
    assert fly_text(BREAKING_OFF).closest.distance_m < 2.0
    kept = fly_text(BREAKING_OFF, "team.separation_min_m=10.0")
    assert kept.closest.distance_m > 9.5
    assert [*kept.unhealthy_steps] == ["auv1"]
    assert [line.status for line in kept.tasks] == ["started", "done", "started", "done", "returned"]


CREEPING = BREAKING_OFF.replace('"abreast"\nspacing_m = 40.0', '"astern"\nspacing_m = 20.0').replace(
    "at_ned_m = [120.0, 60.0, 0.0], speed_mps = 1.2", "at_ned_m = [150.0, 0.0, 0.0], speed_mps = 0.5"
)


def test_who_is_on_a_task_ahead_is_followed():
    """Behind a mate whose task makes it slow the minimum is kept from where it is, not from where its plan says."""
    assert fly_text(CREEPING).closest.distance_m < 2.0
    kept = fly_text(CREEPING, "team.separation_min_m=10.0")
    assert kept.closest.distance_m > 9.0
    assert kept.unhealthy_steps["auv2"]["separation"] > 50
