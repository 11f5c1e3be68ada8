"""The operator's end of the bus: gives an order to the craft he is on, and says what becomes of it."""

import uuid
from collections.abc import Callable

import msgspec

from grex_link import clock
from grex_link.bus import DEFAULT_ENDPOINTS, ZenohBus
from grex_link.config import Scenario
from grex_link.errors import ConfigError, GrexError
from grex_link.messages import TaskNews, TaskOrder
from grex_link.tasks import Hold, Surface, Task, type_of
from grex_link.units import NS

#: Wall seconds in which somebody on the bus must show, and the craft must take the order.
ANSWER_S = 8.0
_AGAIN_S = 1.0
_GOOD = {
    "queued": "queued on {via}",
    "on_air": "on air",
    "echoed": "echoed by {craft}",
    "started": "started by {craft}",
    "done": "done by {craft}",
}


def give_order(scenario: Scenario, craft: str, task: Task, wait_s: float, say: Callable[[str], None]) -> None:
    """Give an order on the live bus and see it through.

    Parameters
    ----------
    scenario : Scenario
        That of the run, with its endpoints.
    craft : str
        Who shall do it.
    task : Task
        What; one that has no end is seen through until it has started.
    wait_s : float
        Wall seconds to wait for its end.
    say : callable
        Told every step of it, a line each.

    Raises
    ------
    GrexError
        If nobody is there or answers, or the task is refused, interrupted, never echoed, or not done in time.
    """
    via = scenario.operators_craft
    # Who is not on the bus now will not come because an operator waits.
    quick = msgspec.structs.replace(scenario.clock, start_timeout_s=ANSWER_S / 2.0)
    try:
        bus = ZenohBus(msgspec.structs.replace(scenario, clock=quick), "operator", "operator")
    except ConfigError:
        where = ", ".join(scenario.bus.endpoints or DEFAULT_ENDPOINTS)
        raise GrexError(f"nobody is on the bus at {where}; start the run first, with the same bus.endpoints") from None
    with bus:
        _Conversation(bus, TaskOrder(uuid.uuid4().hex[:12], craft, task), via, say).hold(wait_s)


class _Conversation:
    """One order and what is heard of it."""

    def __init__(self, bus: ZenohBus, order: TaskOrder, via: str, say: Callable[[str], None]) -> None:
        self._bus = bus
        self._order = order
        self._via = via
        self._say = say
        self._run_is_there = False
        self._heard: list[str] = []
        task = order.task
        endless = isinstance(task, Hold | Surface) and not task.for_s
        self._wanted = "started" if endless else "done"

    def hold(self, wait_s: float) -> None:
        """Repeat the order until it is taken, then listen until it has come to an end."""
        begin = clock.monotonic_s()
        put_at = begin
        while self._wanted not in self._heard:
            now = clock.monotonic_s()
            self._give_up(now - begin, wait_s)
            if self._run_is_there and not self._heard and now >= put_at:
                # A first message can be lost while the bus still learns who reads; the order's name makes it one.
                self._bus.put("task", self._via, self._order)
                put_at = now + _AGAIN_S
            envelope = self._bus.take(0.1)
            if envelope is None:
                continue
            topic, who, message = envelope
            if topic == "presence" and who == "sim":
                if self._run_is_there and not message.alive:
                    raise GrexError(f"the run is over; {self._so_far}")
                self._run_is_there = message.alive
            elif topic == "task_news" and who == self._via and message.order == self._order.order:
                self._on_news(message)

    @property
    def _so_far(self) -> str:
        last = f"the last word was {self._heard[-1]!r}" if self._heard else "there was no word of it"
        return f"{type_of(self._order.task)} of {self._order.craft}: {last}"

    def _give_up(self, passed_s: float, wait_s: float) -> None:
        if not self._heard and passed_s > ANSWER_S:
            why = f"the agent of {self._via} does not answer" if self._run_is_there else "no run is on the bus"
            raise GrexError(f"{why} for {ANSWER_S:g} s")
        if passed_s > wait_s:
            raise GrexError(f"not done in {wait_s:g} s; {self._so_far}")

    def _on_news(self, news: TaskNews) -> None:
        if news.status in self._heard:
            return
        self._heard.append(news.status)
        if news.status in _GOOD:
            text = _GOOD[news.status].format(via=self._via, craft=news.craft)
            self._say(f"{news.t_ns / NS:8.1f} s  {text}")
        if news.status in {"refused", "failed", "interrupted"}:
            detail = f": {news.detail}" if news.detail else ""
            raise GrexError(f"{type_of(news.task)} of {news.craft} {news.status}{detail}")
