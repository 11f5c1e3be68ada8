"""Tasks in an agent's core: orders of the operator, mail, news, and what the mates are told (literal times)."""

import pytest
from core_steps import NS
from task_bench import habitat

from grex_agent.core import AgentCore
from grex_link import wire
from grex_link.messages import Fix, ModemEvent, Received, TaskNews, TaskOrder, Transmit
from grex_link.task_wire import Echo, Order, hash_of, is_task_mail, pack_order, unpack_echo
from grex_link.tasks import GoTo, Hold, Inspect

HOLD = TaskOrder("o1", "aid", Hold(20.0))
#: 10 s a message; slots in the order top, low, aid, ship, so aid has 20 … 30 s of every 40 s.
SLOT_S, CYCLE_S = 20, 40


class Craft:
    """The core of one craft that stays where it is."""

    def __init__(self, craft: str, at=(0.0, 50.0, 5.0), **tables) -> None:
        self.core = AgentCore(habitat(**tables), craft)
        self.at = at
        self.now_s = 0
        self.news: list[TaskNews] = []
        self.sent: list[Transmit] = []
        self.states: list = []
        self.setpoints: list = []
        self._heard = 0

    def hear(self, source: str, payload: bytes) -> None:
        self.core.on_modem(ModemEvent(self._heard, self.now_s * NS, Received(source, payload)))
        self._heard += 1

    def step(self, seconds: int = 1, *, valid: bool = True) -> None:
        for _ in range(seconds):
            self.core.on_fix(Fix(self.now_s, self.now_s * NS, *self.at, 0.0, 0.0, 0.1, valid=valid))
            for topic, message in self.core.step(self.now_s, self.now_s * NS):
                kept = {"task_news": self.news, "modem_tx": self.sent, "state": self.states}
                kept.get(topic, self.setpoints).append(message)
            self.now_s += 1

    def said(self) -> list[tuple[str, str, str]]:
        return [(news.order, news.craft, news.status) for news in self.news]

    def echoes(self) -> list[Echo]:
        return [unpack_echo(each.payload) for each in self.sent if is_task_mail(each.payload)]


def test_an_order_for_the_own_craft_is_done_aboard():
    """It is queued, started and done, and nothing goes on the air for it."""
    craft = Craft("aid")
    craft.core.on_order(HOLD)
    craft.step(25)
    assert craft.said() == [("o1", "aid", status) for status in ("queued", "started", "done", "returned")]
    assert not craft.echoes()


def test_an_order_that_comes_twice_is_one():
    """The operator repeats an order until it is taken; by its name it is one."""
    craft = Craft("aid")
    craft.core.on_order(HOLD)
    craft.step()
    craft.core.on_order(HOLD)
    craft.step()
    assert craft.said() == [("o1", "aid", "queued"), ("o1", "aid", "started")]


def test_an_order_for_nobody():
    """An order for a craft that is not in the team is refused."""
    craft = Craft("aid")
    craft.core.on_order(TaskOrder("o2", "nix", Hold()))
    craft.step()
    assert craft.said() == [("o2", "nix", "refused")]


def test_an_order_that_does_not_fit_is_refused():
    """A place outside the frame of an order is refused with that reason."""
    craft = Craft("top", (0.0, 0.0, 0.0))
    craft.core.on_order(TaskOrder("o3", "aid", GoTo((1e6, 0.0, 0.0))))
    craft.step()
    assert craft.said() == [("o3", "aid", "refused")]
    assert "north 1e+06 does not fit" in craft.news[0].detail


def test_an_order_by_sound_goes_before_the_own_state():
    """It takes the next own slot, addressed to its craft, and the state is told in the one after."""
    craft = Craft("top", (0.0, 0.0, 0.0))
    craft.step(2)
    craft.core.on_order(TaskOrder("o4", "aid", Hold(20.0)))
    craft.step(85)
    by_sound = [each for each in craft.sent if not each.by_land]
    assert [(each.t_ns // NS, each.destination, len(each.payload)) for each in by_sound] == [
        (0, "", 15), (40, "aid", 12), (80, "", 15),
    ]  # fmt: skip


def test_an_order_over_cable_goes_at_once():
    """The craft at the other end of a cable gets it without waiting for a slot."""
    craft = Craft("top", (0.0, 0.0, 0.0))
    craft.step(2)
    craft.core.on_order(TaskOrder("o5", "low", Hold(20.0)))
    craft.step(2)
    orders = [each for each in craft.sent if is_task_mail(each.payload)]
    assert [(each.by_land, each.t_ns // NS) for each in orders] == [(True, 2)]


def test_an_order_that_comes_is_echoed_in_the_own_slot_and_done():
    """It is started at the next step, and echoed with its number and hash when the craft may speak."""
    craft = Craft("aid")
    craft.step(3)
    payload = pack_order(Order(2, 9, Hold(40.0)))
    craft.hear("low", payload)
    craft.step()
    assert craft.said() == [("low#9", "aid", "started")]
    craft.step(20)
    assert craft.echoes() == [Echo(1, 9, hash_of(payload), "started")]
    assert craft.states[-1].bad_frames == 0


def test_a_refusal_is_echoed():
    """What cannot be done is refused, and that is echoed with the reason."""
    craft = Craft("aid")
    craft.hear("low", pack_order(Order(2, 9, Inspect((0.0, 0.0, 5.0), radius_m=1.0))))
    craft.step(25)
    assert craft.said() == [("low#9", "aid", "refused")]
    assert [(echo.status, echo.reason) for echo in craft.echoes()] == [("refused", "radius")]


def test_the_mates_are_told_that_a_craft_is_on_a_task():
    """In its full form a state says so while it lasts, and no longer."""
    craft = Craft("aid")
    craft.core.on_order(TaskOrder("o6", "aid", Hold(30.0)))
    craft.step(SLOT_S + CYCLE_S + 1)
    flags = [wire.unpack(each.payload, 0.0).flags for each in craft.sent if len(each.payload) == 15]
    assert flags == [wire.NAVIGATION_VALID | wire.ON_TASK, wire.NAVIGATION_VALID]


def test_a_task_steers():
    """Setpoints are those of the task: towards the place, at its speed and depth."""
    craft = Craft("aid")
    craft.core.on_order(TaskOrder("o7", "aid", GoTo((100.0, 50.0, 9.0), 0.7)))
    craft.step(2)
    setpoint = craft.setpoints[-1]
    assert (setpoint.mode, setpoint.speed_mps, setpoint.depth_m) == ("steer", 0.7, 9.0)
    assert setpoint.course_rad == pytest.approx(0.0, abs=1e-9)


def test_without_a_fix_a_task_holds_and_none_is_begun():
    """A craft that is lost holds, whatever it was doing, and refuses what comes."""
    craft = Craft("aid")
    craft.core.on_order(TaskOrder("o7", "aid", GoTo((100.0, 50.0, 9.0), 0.7)))
    craft.step(2)
    craft.step(2, valid=False)
    assert craft.setpoints[-1].mode == "hold"
    craft.core.on_order(TaskOrder("o8", "aid", Hold()))
    craft.step(valid=False)
    assert craft.said()[-1] == ("o8", "aid", "refused")
    assert craft.news[-1].detail == "no_fix"
    craft.step(2)
    assert craft.setpoints[-1].mode == "steer"


def test_who_stands_by_waits_for_nobody():
    """A craft that stands by believes nothing of the formation and keeps its place, whatever it hears."""
    craft = Craft("aid", (0.0, 45.0, 5.0))
    craft.step(3)
    state = wire.TeamState(1, 2.0, 0.0, 0.0, 10.0, 1.0, 0.0, 0, 0.01, 0.1)
    craft.hear("low", wire.pack(state))
    craft.step(2)
    assert craft.states[-1].mates == []
    assert (craft.setpoints[-1].mode, craft.setpoints[-1].speed_mps) == ("steer", pytest.approx(0.5))


def test_rubbish_is_a_bad_frame():
    """What looks like an order and is none is counted with the bad frames."""
    craft = Craft("aid")
    craft.hear("low", b"\x30" + bytes([0, 0xE0]) + bytes(9))
    craft.step(2)
    assert craft.states[-1].bad_frames == 1
