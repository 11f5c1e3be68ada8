"""The manoeuvre processor: which track, and how far (paper, Fig. 8)."""

import pytest

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import CraftPlan, plan_mission
from grex_agent.path import Line
from grex_link.scenario import decode

CORNERS = [(0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0)]
PLAN = CraftPlan(tuple(Line(CORNERS[i], CORNERS[i + 1], 1.0, 0.0) for i in range(3)), 0.0, hold_at_end=False)


def test_progress_is_track_number_plus_theta():
    """Progress counts the tracks done and adds Θ of the present one."""
    processor = ManoeuvreProcessor(PLAN)
    assert (processor.number, processor.progress) == (0, 0.0)
    place = processor.follow(25.0, 3.0)
    assert place == processor.place
    assert (place.theta, place.xte_m) == pytest.approx((0.25, 3.0))
    assert processor.progress == pytest.approx(0.25)
    processor.go_to(1)
    processor.follow(100.0, 20.0)
    assert processor.progress == pytest.approx(1.4)
    assert processor.track is PLAN.tracks[1]


def test_the_track_changes_at_one():
    """The next track is taken up when Θ reaches 1, and its own Θ is given at once."""
    processor = ManoeuvreProcessor(PLAN)
    processor.follow(99.999, 0.0)
    assert processor.number == 0
    assert processor.follow(100.0, 5.0).theta == pytest.approx(0.1)
    assert (processor.number, processor.progress) == (1, pytest.approx(1.1))


def test_never_back():
    """A craft that noise throws back behind a corner stays on its new track, with Θ below 0."""
    processor = ManoeuvreProcessor(PLAN)
    processor.follow(101.0, 0.0)
    place = processor.follow(98.0, -2.0)
    assert processor.number == 1
    assert place.theta == pytest.approx(-0.04)
    assert processor.progress == pytest.approx(0.96)


def test_several_tracks_in_one_step():
    """A fix that is tracks ahead is found at once."""
    processor = ManoeuvreProcessor(PLAN)
    processor.follow(150.0, 60.0)
    assert processor.number == 2


def test_the_last_track_never_ends():
    """On the last track Θ grows beyond 1."""
    processor = ManoeuvreProcessor(PLAN)
    processor.go_to(2)
    assert processor.follow(-50.0, 50.0).theta == pytest.approx(1.5)
    assert processor.progress == pytest.approx(3.5)
    assert processor.number == 2


@pytest.mark.parametrize(("number", "taken"), [(-1, 0), (1, 1), (3, 2), (255, 2)])
def test_go_to_is_limited(number, taken):
    """A track number that there is not becomes the nearest there is."""
    processor = ManoeuvreProcessor(PLAN)
    processor.go_to(number)
    assert processor.number == taken
    assert processor.track is PLAN.tracks[taken]


def test_progress_runs_through_all_joints():
    """Along a lawnmower with arcs, progress grows as planned and does not jump where tracks change."""
    mission = {"type": "lawnmower", "formation_m": {"auv1": [-6.0, -25.0, 0.0]}, "legs": 4}
    plan = plan_mission(decode({"mission": mission, "craft": {"auv1": {}}})).craft["auv1"]
    processor = ManoeuvreProcessor(plan)
    for step in range(1, 790):
        processor.follow(*plan.point(step / 100.0 + 1e-6))
        assert processor.progress == pytest.approx(step / 100.0 + 1e-6, abs=1e-9)
