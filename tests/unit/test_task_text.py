"""What `grex check` says of tasks, of who stands by, of events and cables."""

from task_bench import habitat

from grex_agent.mission import plan_mission
from grex_sim.task_text import tasking

EVENT = {"at_s": 100.0, "at_ned_m": [9.0, 8.0, 7.0], "seen_by": "low", "shape": "box"}


def text(**tables) -> str:
    scenario = habitat(**tables)
    return " ".join(" ".join(tasking(scenario, plan_mission(scenario))).split())


def test_everything_is_told():
    """Formation, places, calls, tasks, events with who would come, orders, and how far the cable reaches."""
    tasks = [{"type": "goto", "at_ned_m": [1, 2, 3]}, {"type": "hold", "for_s": 9.0}, {"type": "surface"}]
    craft = {"top": {}, "low": {"tasks": [{"type": "follow", "track": 1}]}, "aid": {"tasks": tasks}, "ship": {}}
    said = text(events=[EVENT], tasking={"operator": "ship"}, craft=craft)
    for words in (
        "top, low: they wait for each other, and are scored",
        "aid at north 0 m, east 50 m, depth 5 m, on call",
        "ship at north 0 m, east -50 m, depth 0 m, not on call",
        "low: follow, track 1",
        "aid: goto, north 1 m, east 2 m, depth 3 m; hold, for 9 s; surface, until told otherwise",
        "event0 at 100 s, seen by low: inspect, north 9 m, east 8 m, depth 7 m, for 120 s, box of 15 m, then return;",
        "nearest on call, if all are at their places: aid",
        "12 bytes, echoed in 6; sent up to 8 times; `grex task` is typed on ship",
        "top and low: 15 m, at most 10.0 m apart by the plan",
    ):
        assert words in said


def test_a_scenario_without_any_says_nothing():
    """Where all are in the formation and there are no tasks, there is nothing to tell."""
    mission = {"type": "lawnmower", "formation_m": {"top": [0.0, 0.0, 0.0], "low": [0.0, 9.0, 0.0]}}
    assert text(mission=mission, standby={}, link={}, craft={"top": {}, "low": {}}) == ""
