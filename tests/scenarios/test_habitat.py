"""Marine habitat mapping (GREX 2008, Fig. 1), flown in memory once, and what else can happen to it.

surface ═ cable ═ diver: the lawnmower     ★ event at 600 s     standby1, standby2: on call     ship: radio
"""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import pytest
from missions import SCENARIOS, fly, fly_text

from grex_link.recording import Recording
from grex_link.tasks import Inspect
from grex_sim.summary import Summary, TaskLine

EVENT, STANDBY2 = (180.0, 40.0), (300.0, 130.0)


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> tuple[Summary, Path]:
    """The scenario as it is."""
    out = tmp_path_factory.mktemp("habitat")
    return fly("habitat", out=out), out


def places(out: Path, craft: str) -> dict[float, tuple[float, float]]:
    with (out / "series.csv").open() as file:
        return {
            float(row["t_s"]): (float(row[f"{craft}_north_m"]), float(row[f"{craft}_east_m"]))
            for row in csv.DictReader(file)
        }


def told(lines: Sequence[TaskLine], who: str) -> dict[str, TaskLine]:
    """What somebody said of tasks, by status."""
    return {line.status: line for line in lines if line.said_by == who}


def test_the_nearest_craft_is_called_over_the_acoustic_channel(flown):
    """The diver sends the nearer of the two that stand by; it is queued, on air, echoed and started, in this order."""
    summary, _ = flown
    said = told(summary.tasks, "diver")
    assert [*said] == ["queued", "on_air", "echoed", "started", "done", "returned"]
    assert {line.craft for line in said.values()} == {"standby2"}
    assert 600.0 <= said["queued"].t_s < said["on_air"].t_s < said["echoed"].t_s < 660.0
    # Sound is slower than cable: an order takes a slot and its airtime.
    assert told(summary.tasks, "standby2")["started"].t_s >= said["queued"].t_s + 3.4
    assert not told(summary.tasks, "standby1")


def test_it_inspects_the_event(flown):
    """The called craft goes round the event at 12 m for two minutes, to a few metres."""
    summary, out = flown
    said = told(summary.tasks, "standby2")
    path = places(out, "standby2")
    survey = [place for t_s, place in path.items() if said["done"].t_s - 110.0 <= t_s <= said["done"].t_s]
    assert max(abs(math.dist(place, EVENT) - 12.0) for place in survey) < 4.0
    assert {math.floor(math.atan2(e - EVENT[1], n - EVENT[0]) / (math.pi / 2)) for n, e in survey} == {-2, -1, 0, 1}


def test_it_returns_to_its_place(flown):
    """After that it goes back to where it stands by, and stays there."""
    summary, out = flown
    path = places(out, "standby2")
    after = [place for t_s, place in path.items() if t_s > told(summary.tasks, "standby2")["returned"].t_s + 30.0]
    assert len(after) > 100
    assert max(math.dist(place, STANDBY2) for place in after) < 5.0


def test_the_pair_goes_on_as_if_nothing_had_happened(flown):
    """The formation's figure is that of the same run without the event."""
    summary, _ = flown
    assert fly("habitat", "events=[]").fd == pytest.approx(summary.fd, rel=0.01)
    assert summary.fd < 1.0


def test_the_cable_is_never_too_short(flown):
    """The true distance of the pair stays within the cable all the time, and the guard had nothing to do."""
    summary, _ = flown
    (cable,) = summary.cables
    assert cable.between == ("surface", "diver")
    assert 15.0 < cable.longest_m < 0.9 * cable.length_m
    assert cable.over_steps == 0
    assert summary.unhealthy_steps == {}


def test_news_of_tasks_are_recorded(flown):
    """The recording has what both craft said of the task, with the task itself."""
    _, out = flown
    news = list(Recording(out).entries({"task_news"}))
    assert {entry.craft for entry in news} == {"diver", "standby2"}
    assert all(isinstance(entry.message.task, Inspect) for entry in news)


def test_a_summary_for_a_person_tells_it(flown):
    """The text of the summary has the task and the cable."""
    from grex_sim.summary import as_text

    text = as_text(flown[0])
    assert "task event0: diver sends standby2 to inspect: queued at 600 s" in text
    assert "cable surface–diver: " in text


def test_readme_prints_what_comes_out(flown):
    """README's lines about this run are those of its summary."""
    from grex_sim.summary import as_text

    readme = (SCENARIOS.parents[1] / "README.md").read_text(encoding="utf-8")
    lines = as_text(flown[0]).splitlines()
    printed = [line for line in lines if line.startswith(("formation deviation", "task event0", "cable "))]
    assert len(printed) == 3
    assert "\n".join(printed) in readme


def test_with_losses_it_is_done_once():
    """With half of all datagrams lost the order is sent again until it is echoed, and started once."""
    summary = fly("habitat", "link.loss=0.5", "seed=3", "duration_s=800")
    started = [line for line in summary.tasks if line.status == "started" and line.said_by.startswith("standby")]
    assert len(started) == 1
    assert "echoed" in told(summary.tasks, "diver")


def test_who_does_not_echo_is_replaced_by_the_next():
    """With the modem of the nearest off, its order fails after three tries, and the other one is called."""
    off = "link.outages=[{craft='standby2',start_s=1,end_s=1e6}]"
    summary = fly("habitat", off, "tasking.tries=3", "duration_s=850")
    lines = [(line.craft, line.status) for line in summary.tasks if line.said_by == "diver"]
    assert lines[:3] == [("standby2", "queued"), ("standby2", "on_air"), ("standby2", "failed")]
    assert ("standby1", "started") in lines
    assert summary.unhealthy_steps["diver"] == {"task_unechoed": 1}


def test_nobody_left_is_said():
    """When nobody answers, the one who saw it says so, once; the pair goes on."""
    off = ",".join(f"{{craft='standby{n}',start_s=1,end_s=1e6}}" for n in (1, 2))
    summary = fly("habitat", f"link.outages=[{off}]", "tasking.tries=1", "duration_s=720")
    last = [line for line in summary.tasks if line.said_by == "diver"][-1]
    assert (last.craft, last.status, last.detail) == ("", "failed", "nobody on call is left to be asked")
    assert summary.unhealthy_steps["diver"]["event_unanswered"] == 1
    assert summary.complete


def test_the_guard_keeps_the_cable_when_one_craft_is_slow():
    """A diver that can do 0.5 m/s only: without coordination the surface craft waits for it, and says so."""
    slow = "craft.diver.vehicle.speed_limits=[{start_s=100,end_s=500,max_mps=0.5}]"
    summary = fly("habitat", slow, "team.gain_mps=0.0", "events=[]", "duration_s=600")
    assert summary.unhealthy_steps["surface"]["cable_taut"] > 50
    assert summary.cables[0].over_steps == 0
    loose = fly("habitat", slow, "team.gain_mps=0.0", "events=[]", "duration_s=600", "link.land=[]")
    assert loose.cables == []
    assert loose.fd > 2.0 * summary.fd


MEMBER = """
# auv2 is called out of the line by its own list of tasks, and comes back; auv1 and auv3 do not wait for it.
duration_s = 600.0
[team]
gain_mps = 3.0
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 1000.0
[mission.formation_m]
auv1 = [0.0, 0.0, 5.0]
auv2 = [0.0, 40.0, 5.0]
auv3 = [0.0, 80.0, 5.0]
[link]
profile = "s2c_im"
[craft.auv1]
[craft.auv2]
tasks = [{ type = "inspect", at_ned_m = [30.0, 40.0, 5.0], for_s = 200.0, radius_m = 10.0 }]
[craft.auv3]
"""


def test_a_member_on_a_task_is_not_waited_for(tmp_path):
    """The others go on at their speed while a member is on a task of its own; it catches up and takes its place."""
    summary = fly_text(MEMBER, out=tmp_path)
    assert [line.status for line in summary.tasks] == ["started", "done", "returned"]
    path = {craft: places(tmp_path, craft) for craft in ("auv1", "auv2", "auv3")}
    back = summary.tasks[-1].t_s
    # At 1 m/s, less what they waited before they knew; the one that was away is beside them again.
    assert path["auv1"][240.0][0] > 0.97 * 240.0
    assert 240.0 < back < 500.0
    assert path["auv1"][600.0][0] == pytest.approx(path["auv2"][600.0][0], abs=3.0)
    assert path["auv2"][600.0][1] == pytest.approx(40.0, abs=1.0)


MANY = """
duration_s = 90
[mission]
type = "lawnmower"
leg_length_m = 400.0
formation_m = { top = [0.0, 0.0, 0.0], low = [-20.0, 0.0, 5.0] }
[standby]
%s
[[events]]
at_s = 5.0
at_ned_m = [50.0, 180.0, 5.0]
seen_by = "top"
[link]
profile = "s2c_im"
land = [{ between = ["top", "aid1"] }, { between = ["top", "aid17"] }]
[craft.top]
[craft.low]
%s
"""


def test_an_order_by_radio_is_for_one_craft_of_two_with_the_same_place_modulo_16():
    """Of 20 craft aid1 and aid17 look alike in an order, and both are on the ship's radio: aid17, the nearer, goes."""
    aids = [f"aid{number}" for number in range(18)]
    text = MANY % (
        "\n".join(f"{aid} = {{ at_ned_m = [50.0, {10.0 * number}, 5.0] }}" for number, aid in enumerate(aids)),
        "\n".join(f"[craft.{aid}]" for aid in aids),
    )
    summary = fly_text(text)
    assert {line.said_by for line in summary.tasks} == {"top", "aid17"}
    assert [*told(summary.tasks, "top")] == ["queued", "on_air", "echoed", "started"]
    assert summary.bad_frames == {}
