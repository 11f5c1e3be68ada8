"""The agent as a node: when it steps, and what it does when messages do not come."""

from itertools import permutations
from typing import ClassVar

import pytest

from grex_agent.__main__ import agent
from grex_agent.shell import Agent
from grex_link import wire
from grex_link.clock import unix_ns
from grex_link.errors import ConfigError, FaultError
from grex_link.messages import Clock, Fix, ModemEvent, Pose, Presence, Received, Truth
from grex_link.scenario import decode

NS = 1_000_000_000
CRAFT = {"auv1": [0.0, 0.0, 0.0], "auv2": [0.0, 20.0, 0.0]}


class Collected(list):
    """An outlet that keeps what is put: (topic, craft, message)."""

    def put(self, topic, craft, message):
        self.append((topic, craft, message))

    def setpoints(self):
        """All setpoints so far."""
        return [message for topic, _, message in self if topic == "setpoint"]

    def ticks(self):
        """Their ticks."""
        return [setpoint.tick for setpoint in self.setpoints()]

    def states(self):
        """All states so far, bundled or not."""
        return [state for topic, _, message in self if topic == "state" for state in message.states]


def aboard(pace="lockstep", estimator="first_level"):
    """An agent of auv1 and what it puts on the bus."""
    document = {
        "mission": {"type": "lawnmower", "formation_m": CRAFT},
        "craft": {craft: {} for craft in CRAFT},
        "team": {"estimator": estimator},
        "clock": {"pace": pace},
    }
    outlet = Collected()
    return Agent(decode(document), "auv1", outlet), outlet


def fix(tick, modem_events=0, t_s=None):
    """A fix on the plan."""
    t_ns = tick * NS if t_s is None else round(t_s * NS)
    return Fix(tick, t_ns, t_ns / NS, 0.0, 0.0, 0.0, 1.0, 0.1, modem_events=modem_events)


def event(seq, t_s, north_m):
    """A modem event: auv2's state of a time."""
    payload = wire.pack(wire.TeamState(1, t_s, north_m, 20.0, 0.0, 1.0, 0.0, 0, 0.1, 0.1))
    return ModemEvent(seq, 12 * NS, Received("auv2", payload))


def truth(tick):
    """True poses of a tick."""
    poses = [Pose(craft, 9.0, place[1], 0.0, 0.0, 0.0, 0.0, 1.0) for craft, place in CRAFT.items()]
    return Truth(tick, tick * NS, poses)


# -- lockstep -----------------------------------------------------------------------------------------------------


def test_a_fix_alone_is_a_step():
    """With no modem event to wait for, each fix gives one step, at the fix's time."""
    node, outlet = aboard()
    node.handle("clock", "auv1", Clock("start"))
    for tick in range(3):
        node.handle("fix", "auv1", fix(tick))
    assert outlet.ticks() == [0, 1, 2]
    assert [setpoint.t_ns for setpoint in outlet.setpoints()] == [0, NS, 2 * NS]
    assert {craft for _, craft, _ in outlet} == {"auv1"}
    assert node.wall_s_to_deadline() is None
    assert not node.in_idle_time()


@pytest.mark.parametrize("estimator", ["first_level", "ideal"])
def test_any_order_of_arrival(estimator):
    """A step happens when the last of its inputs is there, and is the same in whatever order they come."""
    inputs = [("fix", fix(12, modem_events=2)), ("modem_rx", event(0, 3.0, 9.0)), ("modem_rx", event(1, 9.0, 2.0))]
    if estimator == "ideal":
        inputs.append(("oracle", truth(12)))
    results = []
    for order in permutations(inputs):
        node, outlet = aboard(estimator=estimator)
        for count, (topic, message) in enumerate(order, 1):
            node.handle(topic, "auv1", message)
            assert outlet.ticks() == ([12] if count == len(order) else [])
        node.handle("clock", "auv1", Clock("bye"))
        results.append(list(outlet))
    assert all(result == results[0] for result in results)
    (mate,) = results[0][-2][2].states[0].mates
    assert mate.age_s == (0.0 if estimator == "ideal" else 3.0)


def test_takes_the_counted_events_and_no_more():
    """An event that comes before the fix that counts it waits for that fix."""
    node, outlet = aboard()
    for number in (2, 0, 1):
        node.handle("modem_rx", "auv1", event(number, 5.0 + number, 6.0))
    for tick, counted in ((10, 0), (11, 2), (12, 2), (13, 3)):
        node.handle("fix", "auv1", fix(tick, counted))
    node.handle("clock", "auv1", Clock("bye"))
    assert [state.mates[0].age_s for state in outlet.states()] == pytest.approx([-1.0, 5.0, 6.0, 6.0])


def test_waits_for_the_truth_of_its_tick():
    """The ideal estimator's agent does not step on the truth of another tick."""
    node, outlet = aboard(estimator="ideal")
    node.handle("oracle", "auv1", truth(11))
    node.handle("fix", "auv1", fix(12))
    assert outlet.ticks() == []
    node.handle("oracle", "auv1", truth(12))
    assert outlet.ticks() == [12]


def test_states_are_complete_at_the_end():
    """Every step's state has been put when the node is done, in order."""
    node, outlet = aboard()
    for tick in range(23):
        node.handle("fix", "auv1", fix(tick))
    assert not node.done
    node.handle("clock", "auv1", Clock("bye"))
    assert node.done
    assert [state.tick for state in outlet.states()] == list(range(23))


def test_the_last_word_is_the_ledger():
    """When the mission is over the agent puts the ledger of its modem port, by its own clock, if it has stepped."""
    node, outlet = aboard()
    node.handle("clock", "auv1", Clock("bye"))
    assert outlet == []
    node, outlet = aboard()
    node.handle("fix", "auv1", fix(0, t_s=5.0))
    node.handle("clock", "auv1", Clock("bye"))
    topic, craft, ledger = outlet[-1]
    assert (topic, craft, ledger.t_ns) == ("port", "auv1", 5 * NS)


def test_transmissions_come_before_the_setpoint_that_counts_them():
    """A setpoint's count covers what has been put before it."""
    node, outlet = aboard()
    for tick in range(25):
        node.handle("fix", "auv1", fix(tick))
    put = 0
    for topic, _, message in outlet:
        put += topic == "modem_tx"
        if topic == "setpoint":
            assert message.transmissions == put
    assert put == 2


def test_the_simulator_lost():
    """In lockstep an agent without its simulator ends with a fault that names it and the mission time."""
    node, _ = aboard()
    gone = Presence("sim", alive=False, scenario="")
    with pytest.raises(FaultError, match="sim left the bus without saying goodbye before the first tick"):
        node.handle("presence", "sim", gone)
    node.handle("fix", "auv1", fix(12))
    with pytest.raises(FaultError, match=r"at mission time 12\.0 s"):
        node.handle("presence", "sim", gone)


def test_presences_that_are_no_fault():
    """The simulator's arrival, its leaving after goodbye, and anybody else's leaving are no faults."""
    node, _ = aboard()
    node.handle("presence", "sim", Presence("sim", alive=True, scenario=""))
    node.handle("presence", "link", Presence("link", alive=False, scenario=""))
    node.handle("clock", "auv1", Clock("bye"))
    node.handle("presence", "sim", Presence("sim", alive=False, scenario=""))
    assert node.done


def test_other_topics_are_nothing_to_it():
    """A message it has no use for changes nothing."""
    node, outlet = aboard()
    node.handle("truth", "", truth(12))
    assert outlet == []


# -- live ---------------------------------------------------------------------------------------------------------


def live(now_s, pace="live", estimator="first_level"):
    """An agent whose wall clock says that it is a mission time."""
    node, outlet = aboard(pace, estimator)
    rate = 1.0 if pace == "live" else pace
    node.handle("clock", "auv1", Clock("start", unix_ns() - round(now_s * NS / rate)))
    return node, outlet


def test_live_waits_for_nobody():
    """At a live pace a fix is a step at once, with the events that are there, in their order."""
    node, outlet = live(12.0)
    node.handle("modem_rx", "auv1", event(1, 9.0, 9.0))
    node.handle("modem_rx", "auv1", event(0, 3.0, 3.0))
    node.handle("fix", "auv1", fix(12, modem_events=5))
    (state,) = outlet.states()
    assert outlet.ticks() == [12]
    assert state.mates[0].age_s == pytest.approx(3.0)


def test_live_says_each_state_at_once():
    """At a live pace no state waits for a bundle."""
    node, outlet = live(12.0)
    for tick in (10, 11, 12):
        node.handle("fix", "auv1", fix(tick))
        assert outlet.states()[-1].tick == tick


def wall_goes_on(node, now_s):
    """Let the wall clock say that it is a later mission time."""
    node.handle("clock", "auv1", Clock("start", unix_ns() - round(now_s * NS)))


def test_overdue_fix():
    """When no fix has come for the fix timeout, the agent steps without: it holds, and says why."""
    node, outlet = live(12.0)
    assert node.wall_s_to_deadline() == 0.0
    node.on_deadline()
    (state,) = outlet.states()
    assert state.health == ["no_fix"]
    assert outlet.setpoints()[-1].mode == "hold"
    assert node.wall_s_to_deadline() == pytest.approx(5.0, abs=0.5)


def test_fix_that_stopped():
    """When fixes stop, the next step counts on and calls the last fix stale."""
    node, outlet = live(10.0)
    node.handle("fix", "auv1", fix(10))
    wall_goes_on(node, 16.0)
    node.on_deadline()
    assert outlet.ticks() == [10, 11]
    assert outlet.states()[-1].health == ["stale_fix"]
    assert outlet.states()[-1].t_ns == pytest.approx(16 * NS, abs=NS // 2)


@pytest.mark.parametrize("offset_s", [-3000.0, -7.0, 0.0, 7.0, 3000.0])
def test_the_alarm_does_not_depend_on_the_crafts_clock(offset_s):
    """Fixes are overdue when none has come for so long, whatever the craft's clock says; the step is by that clock."""
    node, outlet = live(100.0)
    node.handle("fix", "auv1", fix(100, t_s=100.0 + offset_s))
    assert outlet.states()[-1].health == []
    assert node.wall_s_to_deadline() == pytest.approx(5.0, abs=0.5)
    wall_goes_on(node, 104.0)
    node.on_deadline()
    assert outlet.ticks() == [100]
    wall_goes_on(node, 106.0)
    assert node.wall_s_to_deadline() == 0.0
    node.on_deadline()
    assert outlet.ticks() == [100, 101]
    assert outlet.states()[-1].health == ["stale_fix"]
    assert outlet.states()[-1].t_ns == pytest.approx((106.0 + offset_s) * NS, abs=NS // 2)


@pytest.mark.parametrize("jump_s", [-50.0, 50.0])
def test_a_clock_that_is_set_raises_no_alarm(jump_s):
    """When GPS sets the clock, forward or back, the next fix is neither stale nor overdue."""
    node, outlet = live(100.0)
    node.handle("fix", "auv1", fix(100, t_s=100.0 - jump_s))
    wall_goes_on(node, 101.0)
    node.handle("fix", "auv1", fix(101))
    assert [state.health for state in outlet.states()] == [[], []]
    assert node.wall_s_to_deadline() == pytest.approx(5.0, abs=0.5)


def test_not_yet_overdue():
    """Called before its time, the deadline does nothing; so it does before the clock is known."""
    node, outlet = live(-1000.0)
    node.on_deadline()
    assert node.wall_s_to_deadline() == pytest.approx(1005.0, abs=0.5)
    unstarted, nothing = aboard("live")
    unstarted.on_deadline()
    assert unstarted.wall_s_to_deadline() is None
    assert outlet == nothing == []


def test_scaled_pace():
    """At pace 4 the wall seconds to the deadline are a quarter of the mission's."""
    node, _ = live(-400.0, pace=4.0)
    assert node.wall_s_to_deadline() == pytest.approx(405.0 / 4.0, abs=0.5)


def test_live_goes_on_without_the_simulator():
    """At a live pace the loss of the simulator is no fault: the fixes become stale, and that is all."""
    node, outlet = live(12.0)
    node.handle("presence", "sim", Presence("sim", alive=False, scenario=""))
    assert not node.done
    node.on_deadline()
    assert outlet.setpoints()[-1].mode == "hold"


class Watch:
    """A user's estimator that writes down the time it is told."""

    times: ClassVar[list] = []

    def __init__(self, context):
        self.times.clear()

    def step(self, now_s, own, sent, heard):
        self.times.append(now_s)
        return []


def test_time_never_runs_back():
    """An estimator is promised that time never decreases, even when a fix comes after the alarm for its delay."""
    node, _ = live(6.0, estimator=f"{__name__}:Watch")
    node.handle("fix", "auv1", fix(6))
    wall_goes_on(node, 12.0)
    node.on_deadline()
    node.handle("fix", "auv1", fix(7))
    node.handle("fix", "auv1", fix(13))
    assert len(Watch.times) == 4
    assert sorted(Watch.times) == Watch.times


# -- the command --------------------------------------------------------------------------------------------------


def test_unknown_craft(tmp_path):
    """The agent's command refuses a craft that the scenario does not have, and says which there are."""
    file = tmp_path / "team.toml"
    file.write_text('[mission]\ntype = "lawnmower"\nformation_m = { auv1 = [0, 0, 0] }\n[craft.auv1]\n', "utf-8")
    with pytest.raises(ConfigError, match=r"^--craft: unknown craft 'auv9'; there are auv1$"):
        agent(file, "auv9")
