"""Tasks, events, cables and parts in the mission that cannot work are found before anything starts."""

import pytest
from task_bench import habitat

from grex_agent.capabilities import check_capabilities
from grex_agent.mission import pair_range_max_m, plan_mission, range_max_m, range_min_m
from grex_link.errors import ConfigError
from grex_link.profile import load_profile

EVENT = {"at_s": 100.0, "at_ned_m": [0.0, 0.0, 5.0], "seen_by": "low"}
SHIP = {"ship": {"at_ned_m": [0.0, -50.0, 0.0], "on_call": False}}
AID = {"aid": {"at_ned_m": [0.0, 50.0, 5.0]}}
CRAFT = {"top": {}, "low": {}, "aid": {}, "ship": {}}
CABLE = {"between": ["top", "low"], "kind": "cable", "length_m": 15.0}


def check(tables: dict) -> None:
    """Do all that is done before a run."""
    scenario = habitat(**tables)
    check_capabilities(scenario, plan_mission(scenario), load_profile(scenario.link.profile))


def doing(craft: str, *tasks: dict) -> dict:
    return {"craft": CRAFT | {craft: {"tasks": list(tasks)}}}


@pytest.mark.parametrize(
    ("tables", "path", "words"),
    [
        ({"standby": AID}, "$.mission.formation_m.ship", "its place in [standby]"),
        ({"standby": SHIP | AID | {"low": {"at_ned_m": [0, 0, 0]}}}, "$.standby.low", "cannot stand by"),
        ({"standby": SHIP | AID | {"nix": {"at_ned_m": [0, 0, 0]}}}, "$.standby.nix", "unknown craft; there are top"),
        ({"events": [EVENT | {"seen_by": "nix"}]}, "$.events[0].seen_by", "unknown craft 'nix'"),
        ({"tasking": {"operator": "nix"}}, "$.tasking.operator", "unknown craft 'nix'"),
        (
            {"events": [EVENT], "standby": SHIP | {"aid": AID["aid"] | {"on_call": False}}},
            "$.events",
            "no craft in [standby] is on call",
        ),
        ({"events": [EVENT | {"speed_mps": 6.0}]}, "$.events[0]", "outside the craft's limits"),
        ({"events": [EVENT | {"radius_m": 2.0}]}, "$.events[0]", "too narrow"),
        ({"events": [EVENT | {"at_ned_m": [9000.0, 0.0, 0.0]}]}, "$.events[0]", "north 9000 does not fit"),
        ({"events": [EVENT], "link": {"profile": "janus", "land": [CABLE]}}, "$.link.profile", "order to inspect"),
        (doing("aid", {"type": "hold"}, {"type": "return"}), "$.craft.aid.tasks[0].for_s", "0 is for ever"),
        (doing("aid", {"type": "follow"}), "$.craft.aid.tasks[0]", "no such track"),
        (doing("top", {"type": "surface"}), "$.craft.top.tasks[0]", "tied to another one by cable"),
        ({"link": {"land": [CABLE | {"kind": "radio"}]}}, "$.link.land[0].length_m", "a radio has no length"),
        ({"link": {"land": [CABLE | {"length_m": 9.9}]}}, "$.link.land[0].length_m", "planned to be 10.0 m apart"),
        (
            {"mission": {"type": "lawnmower", "formation_m": {}},
             "standby": {craft: {"at_ned_m": [0, 0, 0]} for craft in CRAFT}},
            "$.mission.formation_m",
            "is empty",
        ),
    ],
)  # fmt: skip
def test_what_cannot_work(tables, path, words):
    """Each fault is one line that names its path and says what is wrong."""
    with pytest.raises(ConfigError) as caught:
        check(tables)
    assert caught.value.path == path
    assert words in str(caught.value)


def test_the_habitat_of_these_tests_is_sound():
    """None of the faults is there without being put there."""
    check({"events": [EVENT]})


def test_who_is_in_the_formation():
    """The plan has the formation by itself, those who stand by by themselves, and everybody in the team's order."""
    plan = plan_mission(habitat(craft={"ship": {}, "low": {}, "aid": {}, "top": {}}))
    assert [*plan.craft] == ["low", "top"]
    assert [*plan.standby] == ["ship", "aid"]
    assert [*plan.everybody] == ["ship", "low", "aid", "top"]
    assert plan.everybody["aid"].start[:2] == (0.0, 50.0)
    assert plan.everybody["aid"].start_depth_m == 5.0


def test_distances_count_who_stands_by_and_where_events_are():
    """Guards are for everybody, wherever they may be called; cables for their two craft alone."""
    near, far = habitat(), habitat(events=[EVENT | {"at_ned_m": [0.0, 3000.0, 5.0]}])
    assert range_max_m(plan_mission(far)) > 2900.0 > range_max_m(plan_mission(near))
    assert range_min_m(plan_mission(near)) == pytest.approx(10.0)
    assert pair_range_max_m(plan_mission(near), "top", "low") == pytest.approx(10.0)
    assert pair_range_max_m(plan_mission(near), "aid", "ship") == pytest.approx((100.0**2 + 5.0**2) ** 0.5)


@pytest.mark.parametrize(
    ("land", "given", "who"),
    [
        ([CABLE], None, "top"),
        ([CABLE, {"between": ["ship", "low"], "kind": "radio"}], None, "low"),
        ([], None, "top"),
        ([CABLE], "ship", "ship"),
    ],
)
def test_where_the_operator_is(land, given, who):
    """On the craft given; else on the first with radio, else with cable, else on the first."""
    tasking = {"tasking": {"operator": given}} if given else {}
    assert habitat(link={"land": land}, **tasking).operators_craft == who
