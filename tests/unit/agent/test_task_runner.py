"""The task list of the manoeuvre processor: what is done, in what order, and what follows (literal times)."""

import math

import pytest
from task_bench import Swimmer, habitat

from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface

PLACE = Inspect((60.0, 50.0, 8.0), for_s=100.0, radius_m=10.0)


def aid(**tables) -> Swimmer:
    return Swimmer(habitat(**tables), "aid")


def test_without_tasks_a_craft_does_what_it_is_for():
    """A member follows its plan: its runner says nothing. One that stands by keeps its place."""
    assert Swimmer(habitat(), "low").step() is None
    swimmer = aid()
    assert swimmer.step().speed_mps == 0.0
    swimmer.north += 20.0
    steering = swimmer.step()
    assert (steering.course_rad, steering.speed_mps) == (pytest.approx(math.pi), pytest.approx(2.0))
    assert not swimmer.runner.busy


def test_inspect_and_return():
    """An inspection: 50 m there, 100 s round at 10 m, and back to its place; each is said once, in order."""
    swimmer = aid()
    swimmer.runner.order((PLACE,), "x")
    assert swimmer.run(swimmer.has("done")) == pytest.approx(50 + 100, abs=4)
    survey = swimmer.path[-90:]
    # This craft turns at once, and so is led too far into the circle by what is there for the lag of a real one.
    assert all(abs(math.dist(p[:2], (60.0, 50.0)) - 10.0) < 5.0 for p in survey)
    assert all(abs(p[2] - 8.0) < 1.0 for p in survey)
    # All sides have been seen.
    bearings = {round(math.degrees(math.atan2(p[1] - 50.0, p[0] - 60.0)) / 90.0) % 4 for p in survey}
    assert bearings == {0, 1, 2, 3}
    swimmer.run(swimmer.has("returned"))
    assert swimmer.said() == ["started", "done", "returned"]
    assert {(happening.name, happening.task) for happening in swimmer.runner.happenings} == {("x", PLACE)}
    assert math.dist(swimmer.path[-1], (0.0, 50.0, 5.0)) < 3.0
    assert not swimmer.runner.busy


def test_a_box():
    """A box is followed along its four sides, from the corner that is nearest."""
    swimmer = aid()
    swimmer.runner.order((Inspect((60.0, 50.0, 5.0), for_s=100.0, radius_m=12.0, shape="box"),), "x")
    swimmer.run(swimmer.has("done"))
    for corner in ((48.0, 38.0), (48.0, 62.0), (72.0, 62.0), (72.0, 38.0)):
        assert min(math.dist(p[:2], corner) for p in swimmer.path) < 4.0


@pytest.mark.parametrize(("then", "depth"), [("surface", 0.0), ("hold", 8.0)])
def test_what_follows_an_inspection(then, depth):
    """Then it surfaces and stays there, or holds where it is, until it is told something else."""
    swimmer = aid()
    swimmer.runner.order((Inspect(PLACE.at_ned_m, 40.0, 10.0, then=then),), "x")
    swimmer.run(swimmer.has("done"))
    for _ in range(200):
        swimmer.step()
    assert swimmer.said() == ["started", "done"]
    assert swimmer.runner.busy
    assert swimmer.path[-1] == swimmer.path[-2]
    assert swimmer.path[-1][2] == pytest.approx(depth, abs=1.0)


def test_a_list_is_done_in_order():
    """Tasks follow each other; the last of them is followed by the way back."""
    swimmer = aid()
    swimmer.runner.order((GoTo((30.0, 50.0, 5.0)), Hold(20.0), Surface(10.0)), "list")
    swimmer.run(swimmer.has("returned"))
    assert [(type(h.task).__name__, h.status) for h in swimmer.runner.happenings] == [
        ("GoTo", "started"), ("GoTo", "done"), ("Hold", "started"), ("Hold", "done"), ("Surface", "started"),
        ("Surface", "done"), ("Surface", "returned"),
    ]  # fmt: skip
    assert min(p[2] for p in swimmer.path) <= 1.0


def test_a_depth_that_was_not_reached_on_the_way():
    """A place that is near and deep is gone to, and then gone down to in a circle."""
    swimmer = aid()
    swimmer.runner.order((GoTo((5.0, 50.0, 25.0)),), "x")
    swimmer.run(swimmer.has("done"))
    assert swimmer.down == pytest.approx(25.0, abs=1.0)
    assert max(math.dist(p[:2], (5.0, 50.0)) for p in swimmer.path[6:]) < 25.0


def test_a_hold_lasts_so_long():
    """A hold of 20 s is done after 20 s."""
    swimmer = aid()
    swimmer.runner.order((Hold(20.0),), "x")
    assert swimmer.run(swimmer.has("done")) == pytest.approx(21, abs=1)


def test_a_new_order_interrupts():
    """What is being done is said to be interrupted, and the new order started, in the same step."""
    swimmer = aid()
    swimmer.runner.order((PLACE,), "old")
    swimmer.run(lambda: swimmer.now_s == 20)
    swimmer.runner.order((Return(),), "new")
    swimmer.step()
    assert [(h.name, h.status) for h in swimmer.runner.happenings] == [
        ("old", "started"), ("old", "interrupted"), ("new", "started"),
    ]  # fmt: skip
    swimmer.run(swimmer.has("returned"))
    assert swimmer.runner.happenings[-1].name == "new"


def test_an_order_during_the_way_back_interrupts_nothing():
    """A task that is done stays done, also if the craft is called again before it is back."""
    swimmer = aid()
    swimmer.runner.order((Inspect(PLACE.at_ned_m, 10.0, 10.0),), "old")
    swimmer.run(swimmer.has("done"))
    swimmer.step()
    swimmer.runner.order((PLACE,), "new")
    swimmer.run(swimmer.has("returned"))
    assert [(h.name, h.status) for h in swimmer.runner.happenings] == [
        ("old", "started"), ("old", "done"), ("new", "started"), ("new", "done"), ("new", "returned"),
    ]  # fmt: skip


def test_time_without_a_fix_does_not_count():
    """Thirty seconds without a valid fix make a hold of 20 s that much longer."""
    swimmer = aid()
    swimmer.runner.order((Hold(20.0),), "x")
    swimmer.step()
    for _ in range(30):
        swimmer.step(lost=True)
    assert swimmer.said() == ["started"]
    # The step in which it comes back is as long as it was away, and does not count as survey either.
    assert swimmer.run(swimmer.has("done")) == pytest.approx(20, abs=2)


def test_a_member_comes_back_to_the_formation_where_that_is_now():
    """A member called away for a while goes after the formation, and follows its plan from there."""
    swimmer = Swimmer(habitat(link={}), "low")
    swimmer.runner.order((Inspect((20.0, 40.0, 10.0), for_s=30.0, radius_m=8.0),), "x")

    def home() -> bool:
        swimmer.formation = min(swimmer.now_s / 200.0, 1.9)
        return "returned" in swimmer.said()

    swimmer.run(home)
    assert swimmer.processor.number == int(swimmer.formation)
    assert math.dist(swimmer.path[-1][:2], swimmer.plan.point(swimmer.formation)) < 8.0
    assert swimmer.step() is None


def test_follow_takes_up_a_track():
    """A member told to follow goes to the start of that track, and then by its plan."""
    swimmer = Swimmer(habitat(link={}), "low")
    swimmer.runner.order((Follow(2),), "x")
    swimmer.run(swimmer.has("done"))
    assert swimmer.runner.refusal(Follow(3), lost=False) == "tracks"
    assert swimmer.processor.number == 2
    assert math.dist(swimmer.path[-1][:2], swimmer.plan.tracks[2].point(0.0)) < 3.0
    assert swimmer.step() is None


@pytest.mark.parametrize(
    ("craft", "task", "reason"),
    [
        ("aid", Inspect((0.0, 0.0, 5.0), speed_mps=9.0), "speed"),
        ("aid", GoTo((0.0, 0.0, 5.0), speed_mps=0.1), "speed"),
        ("aid", Inspect((0.0, 0.0, 5.0), radius_m=2.0), "radius"),
        ("aid", GoTo((0.0, 0.0, -5.0)), "depth"),
        ("ship", GoTo((0.0, 0.0, 5.0)), "depth"),
        ("aid", Follow(0), "tracks"),
        ("top", Inspect((0.0, 0.0, 0.0)), "cable"),
        ("top", Follow(0), "cable"),
        ("top", Hold(), ""),
        ("aid", PLACE, ""),
        ("ship", GoTo((0.0, 0.0, 0.0)), ""),
        ("aid", Inspect((0.0, 0.0, 5.0), radius_m=2.0, shape="box"), ""),
    ],
)
def test_a_bad_task_is_refused_with_a_reason(craft, task, reason):
    """What a craft cannot do it does not try."""
    assert Swimmer(habitat(), craft).runner.refusal(task, lost=False) == reason


def test_a_craft_that_is_lost_refuses():
    """Without a valid fix no task is begun."""
    assert aid().runner.refusal(Hold(), lost=True) == "no_fix"
