"""Who is sent to an event, by what is known of where the others are (literal times)."""

from task_bench import NS, habitat

from grex_agent.mission import plan_mission
from grex_agent.tasks.dispatch import Dispatcher

EVENT = {"at_s": 100.0, "at_ned_m": [0.0, 0.0, 5.0], "seen_by": "low"}
STANDBY = {
    "aid": {"at_ned_m": [0.0, 50.0, 5.0]},
    "far": {"at_ned_m": [0.0, 90.0, 5.0]},
    "ship": {"at_ned_m": [0.0, -5.0, 0.0], "on_call": False},
}
CRAFT = {"top": {}, "low": {}, "far": {}, "aid": {}, "ship": {}}


def dispatcher(craft: str = "low", *events: dict, standby: dict | None = None) -> Dispatcher:
    scenario = habitat(standby=standby or STANDBY, craft=CRAFT, events=[*(events or (EVENT,))])
    return Dispatcher(scenario, craft, plan_mission(scenario))


def free(_: str) -> bool:
    return False


def chosen(dispatcher: Dispatcher, t_s: float, seen=None, busy=free) -> list[tuple[str, str]]:
    return [(name, craft) for name, _, craft in dispatcher.choose(round(t_s * NS), seen or {}, busy)]


def test_the_nearest_on_call_goes():
    """At its time, not before, and once: the nearest by the plan; not the ship, which is not on call."""
    office = dispatcher()
    assert chosen(office, 99.9) == []
    assert chosen(office, 100.0) == [("event0", "aid")]
    assert chosen(office, 101.0) == []


def test_what_has_been_heard_counts():
    """Who has said that it is elsewhere is taken to be there."""
    assert chosen(dispatcher(), 100.0, {"far": (0.0, 20.0)}) == [("event0", "far")]


def test_a_tie_is_broken_by_name():
    """Of two at the same distance the first by name goes, whatever the order of the team."""
    assert chosen(dispatcher(), 100.0, {"aid": (0.0, 30.0), "far": (0.0, -30.0)}) == [("event0", "aid")]


def test_who_does_not_echo_is_not_asked_again():
    """When the nearest does not echo, or refuses, the next is asked; when nobody is left, that is said, once."""
    office = dispatcher()
    chosen(office, 100.0)
    office.learn("event0", "failed")
    assert chosen(office, 200.0) == [("event0", "far")]
    office.learn("event0", "refused")
    assert chosen(office, 201.0) == [("event0", "")]
    assert chosen(office, 202.0) == []


def test_an_order_that_was_replaced_is_given_again():
    """When the called craft is given another order before it has answered, the event is not forgotten."""
    office = dispatcher()
    chosen(office, 100.0)
    office.learn("event0", "interrupted")
    assert chosen(office, 101.0, busy=lambda craft: craft == "aid") == [("event0", "far")]


def test_who_is_busy_is_waited_for():
    """As long as all are busy nobody is asked; the event is not forgotten."""
    office = dispatcher()
    assert chosen(office, 100.0, busy=lambda craft: True) == []
    assert chosen(office, 150.0, busy=lambda craft: craft == "aid") == [("event0", "far")]


def test_two_events_at_once_get_two_craft():
    """One craft is not sent to two places in one step."""
    assert chosen(dispatcher("low", EVENT, EVENT), 100.0) == [("event0", "aid"), ("event1", "far")]


def test_an_event_that_is_attended_to_is_closed():
    """Once somebody has started, what becomes of it later asks nobody else."""
    office = dispatcher()
    chosen(office, 100.0)
    office.learn("event0", "started")
    office.learn("event0", "failed")
    assert chosen(office, 200.0) == []


def test_only_who_sees_it_decides():
    """An event is seen by one craft; the others do nothing about it."""
    assert chosen(dispatcher("top"), 1000.0) == []
