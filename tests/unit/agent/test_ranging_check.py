"""Ranging that cannot work is refused before anything starts, with what would do."""

import pytest

from grex_agent.core import AgentCore
from grex_link.errors import ConfigError
from grex_link.scenario import loads

TEAM = """
[team]
own_filter = {}
[team.ranging]
mode = "two_way"
[mission]
type = "lawnmower"
[mission.formation_m]
boat = [0.0, 0.0, 0.0]
auv1 = [0.0, -30.0, 10.0]
[link]
profile = "s2c_im"
[link.mac]
type = "tdma"
messages_per_slot = 2
guard_s = 0.6
[craft.boat]
[craft.auv1.inertial]
"""
BASE = "craft.base.base={place_ned_m=[100, -50, 20], watch='auv1'}"


def fault(*overrides, text=TEAM):
    """The complaint about a scenario."""
    with pytest.raises(ConfigError) as caught:
        AgentCore(loads(text, overrides), "auv1")
    assert "\n" not in str(caught.value)
    return caught.value.path, caught.value.problem


def test_a_scenario_that_can_work():
    """The scenario that the others spoil is a sound one, with a base as well."""
    AgentCore(loads(TEAM), "auv1")
    AgentCore(loads(TEAM, [BASE, "link.mac.guard_s=1.6"]), "auv1")


def test_a_drift_needs_a_filter():
    """An inertial navigation without filter of the own fixes is refused, ranging or not."""
    path, problem = fault("team.ranging.mode=off", text=TEAM.replace("own_filter = {}", ""))
    assert path == "$.craft.auv1.inertial"
    assert "[team.own_filter]" in problem


def test_somebody_must_need_ranges():
    """Ranging in a team where all have GPS, and there is no base, is of no use."""
    path, problem = fault(text=TEAM.replace("[craft.auv1.inertial]", "[craft.auv1]"))
    assert path == "$.team.ranging.mode"
    assert "use 'off'" in problem


def test_somebody_must_know_where_he_is():
    """A team that drifts altogether has nobody to range to."""
    path, problem = fault("craft.boat.inertial={}")
    assert path == "$.craft.boat.inertial"
    assert "nobody to range to" in problem


def test_the_modem_must_measure():
    """A modem without the kind of range wanted is refused, and those that have it are named."""
    path, problem = fault("team.ranging.mode=one_way")
    assert path == "$.team.ranging.mode"
    assert "umodem_psk1" in problem
    assert "s2c_im" not in problem.split("these do: ")[1]
    assert fault("link.profile=grex2008", "link.mac.messages_per_slot=1")[0] == "$.team.ranging.mode"


def test_the_message_must_tell_position_and_sigma():
    """The short forms of the team state are not enough."""
    path, problem = fault("link.message=short")
    assert path == "$.link.message"
    assert "'full'" in problem


def test_the_slot_needs_room_for_the_answer():
    """A slot too short for ping and answer is refused, and what is said would do does."""
    path, problem = fault("link.mac.guard_s=0.1")
    assert path == "$.link.mac.guard_s"
    would_do = problem.rsplit("; ", 1)[1].split()[0]
    AgentCore(loads(TEAM, [f"link.mac.guard_s={would_do}"]), "auv1")
    slots = "link.mac.slots=[{craft='boat',start_s=0,length_s=1},{craft='auv1',start_s=1,length_s=%s}]"
    path, problem = fault(slots % "0.8", "link.mac.guard_s=0.1")
    assert path == "$.link.mac.slots"
    would_do = problem.split("length_s = ")[1].split()[0]
    AgentCore(loads(TEAM, [slots % would_do, "link.mac.guard_s=0.1"]), "auv1")


def test_a_base_watches_a_craft_that_moves():
    """A base that watches nobody, itself or another base is refused; so is one with a part in the mission."""
    assert fault(BASE.replace("'auv1'", "'auv9'"))[0] == "$.craft.base.base.watch"
    assert fault(BASE.replace("'auv1'", "'base'"))[0] == "$.craft.base.base.watch"
    assert fault(BASE, "mission.formation_m.base=[0, 9, 0]")[0] == "$.mission.formation_m.base"
    assert fault(BASE, "craft.base.inertial={}")[0] == "$.craft.base.inertial"
    with pytest.raises(ConfigError, match="only bases"):
        loads("[mission]\ntype='lawnmower'\nformation_m={}\n[craft.b.base]\nplace_ned_m=[0,0,0]\nwatch='b'\n")
