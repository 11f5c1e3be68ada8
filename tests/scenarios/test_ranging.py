"""Drifting navigation with ranges to a boat that knows where it is, and a base that watches, in whole runs."""

import pytest
from missions import fly

import grex_sim.run
from grex_link.memory_bus import MemoryBus
from grex_link.messages import TaskOrder
from grex_link.tasks import Inspect
from grex_link.units import NS
from grex_sim.summary import as_text

DRIFTING = ("auv1", "auv2")
AROUND = "{type='inspect',at_ned_m=[100,-150,10],for_s=150}"


def errors(*overrides):
    """Errors of the own positions in the scenario of two drifting craft."""
    return fly("ins-drift", *overrides).navigation


def test_ranges_bound_the_drift():
    """After 20 minutes the drift has made 10 m; with ranges the error is less than 2 m rms, and known to be."""
    run = fly("ins-drift", "duration_s=1200")
    assert run.lost == 0  # a ping that follows a message at once is heard, though the craft come nearer
    lost, held = errors("duration_s=1200", "team.ranging.mode=off"), run.navigation
    for craft in DRIFTING:
        assert lost[craft].last_m > 9.0
        assert held[craft].rms_m < 2.0
        assert held[craft].last_m < 0.5
        assert held[craft].nees < 4.0
        assert held[craft].sigma_m < 3.0
    assert held["boat"].rms_m < 0.3


def test_a_person_is_told():
    """What is printed names those who did not know where they were, and how much."""
    run = fly("base", "duration_s=60")
    assert f"auv2 {run.navigation['auv2'].rms_m:.2f} m, base>auv2 " in as_text(run)
    assert "believed" not in as_text(fly("paper-d", "duration_s=60"))


def test_one_way_ranges_do_the_same():
    """With clocks that agree the ranges come with every message, seconds late, and nobody has to ask."""
    one_way = "link.profile=umodem_psk1", "team.ranging.mode=one_way", "team.ranging.sigma_m=0.4"
    run = fly("ins-drift", "duration_s=1200", *one_way, "link.mac.messages_per_slot=1")
    assert all("ping" not in source.purposes for source in run.sources.values())
    for craft in DRIFTING:
        assert run.navigation[craft].last_m < 1.0
        assert run.navigation[craft].nees < 4.0


def test_outliers_are_rejected_and_reported():
    """With a tenth of the ranges up to 50 m too long, health says so, and the position does not suffer."""
    run = fly("ins-drift", "duration_s=900", "link.ranging={outlier_probability=0.1,outlier_m=50.0}")
    for craft in DRIFTING:
        assert run.unhealthy_steps[craft]["range_rejected"] > 5
        assert run.navigation[craft].last_m < 0.6


def test_a_base_watches_and_has_no_part():
    """The base knows where its craft is to less than a metre; FD is that of three craft, and it tells nothing."""
    run = fly("base", "duration_s=600")
    watched = run.navigation["base>auv2"]
    assert watched.rms_m < 0.8
    assert watched.nees < 3.0
    assert run.fd < 0.5
    assert run.sources["base"].purposes == {"ping": run.sources["base"].started}
    assert run.bad_frames == {}
    assert run.ledger_faults == []


def test_a_base_watches_a_craft_on_a_task():
    """A craft that leaves its plan to go round a place is not thought to follow it: 1.9 m rms, and known (else 3.3)."""
    watched = fly("base", "duration_s=450", f"craft.auv2.tasks=[{AROUND}]").navigation["base>auv2"]
    assert watched.rms_m < 2.4
    assert watched.nees < 2.0


@pytest.mark.slow
def test_two_hours():
    """Over two hours the drifting craft are within 1 m rms; without ranges they are 60 m off at the end."""
    assert all(errors()[craft].rms_m < 1.0 for craft in DRIFTING)
    assert all(errors("team.ranging.mode=off")[craft].last_m > 60.0 for craft in DRIFTING)


class OrderingBus(MemoryBus):
    """Gives the boat an order at 600 s, as an operator would: `grex task` does not reach a run in lockstep."""

    def join(self, node, scenario, role, who):
        if (role, who) == ("agent", "boat"):
            self.boat = node._core
        super().join(node, scenario, role, who)

    def put(self, topic, craft, message):
        if (topic, craft) == ("fix", "boat") and message.t_ns == 600 * NS:
            self.boat.on_order(TaskOrder("away", "boat", Inspect((300.0, -400.0, 0.0), 300.0)))
        super().put(topic, craft, message)


@pytest.mark.slow
def test_the_boat_leaves_its_plan(monkeypatch):
    """The boat goes off for 18 minutes to inspect a place 400 m away: who ranges to it drifts, and is not thrown off.

    The two are within 1.3 m rms (0.9 and 0.5 m; 12 m without ranges, hundreds when the boat was thought to be on its
    plan), know it, and are right again once the boat is back.
    """
    monkeypatch.setattr(grex_sim.run, "MemoryBus", OrderingBus)
    run = fly("ins-drift", "duration_s=2400")
    said = {line.status: line.t_s for line in run.tasks}
    assert [*said] == ["queued", "started", "done", "returned"]
    assert said["returned"] - said["started"] > 1000.0
    for craft in DRIFTING:
        assert run.navigation[craft].rms_m < 1.3
        assert run.navigation[craft].nees < 4.0
        assert run.navigation[craft].last_m < 0.3
