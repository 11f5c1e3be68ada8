"""Tasks to and from other craft: an order is repeated until its echo has come, and is done once.

The sender numbers its orders. It sends one, waits for the echo for as long as the answer may take, and sends it again,
until it has been tried often enough: then it has failed, which is said. The receiver knows an order by sender, number
and hash; one it has had is not done again, but echoed again, with what has become of it by then. When a task has ended
the receiver says so of itself, a few times, because that is not acknowledged.

An order names its receiver, and an echo the sender of its order, modulo 16 only. In a team of more, the address that
the modem or the land link has delivered it to says for whom it is; what comes without one, and could be for two, is
for nobody, and is counted.
"""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import msgspec

from grex_link import task_wire
from grex_link.errors import WireError
from grex_link.messages import BROADCAST, Received, TxEvent
from grex_link.task_wire import Echo, Order, Status
from grex_link.tasks import Task

#: A status that has come is not taken back by an earlier one that is late.
_ORDER_OF: dict[Status, int] = {"started": 0, "done": 1, "refused": 2, "interrupted": 2, "returned": 2}
#: Another try would fail, too.
_HOPELESS = frozenset({"size", "address"})
#: How often the end of a task is said.
REPORTS = 3
#: Orders of one sender that a receiver remembers; far fewer than there are numbers, far more than can be under way.
_REMEMBERED = 32

#: Has a payload sent to a craft; gives the ticket under which its fate is told.
Send = Callable[[bytes, str], int]
SenderStatus = Literal["queued", "on_air", "echoed", "started", "done", "returned", "interrupted", "refused", "failed"]


class Word(NamedTuple):
    """What a sender learns of an order of its own."""

    order: str
    craft: str
    task: Task
    status: SenderStatus
    detail: str = ""


class Arrival(NamedTuple):
    """An order for this craft that has not been here before."""

    name: str
    task: Task


class _Sent(msgspec.Struct):
    """An own order under way."""

    order: str
    craft: str
    task: Task
    number: int
    payload: bytes
    tries_left: int
    next_ns: int
    ticket: int | None = None
    on_air: bool = False
    status: Status | None = None
    """What the echo said last; None before there is one."""


class _Had(msgspec.Struct):
    """An order of somebody else that this craft has had."""

    source: str
    number: int
    hash: int
    echo: Echo
    reports_left: int = 0
    next_ns: int = 0


class TaskPost:
    """See the module's docstring.

    Parameters
    ----------
    craft : str
        Whose post.
    team : sequence of str
        Everybody, in order.
    tries : int
        How often an order is sent.
    answer_ns : int
        How long after an order has left its echo may take.
    """

    def __init__(self, craft: str, team: Sequence[str], tries: int, answer_ns: int) -> None:
        self._craft = craft
        self._team = list(team)
        self._tries = tries
        self._answer_ns = answer_ns
        self._number = 0
        self._sent: list[_Sent] = []
        self._had: dict[str, deque[_Had]] = {}
        self._echoes: list[_Had] = []
        self.words: list[Word] = []
        """To be taken away by the owner."""
        self.bad = 0

    def unanswered(self, craft: str) -> bool:
        """Whether an order to a craft has not been echoed yet."""
        return any(sent.craft == craft and sent.status is None for sent in self._sent)

    def order(self, now_ns: int, name: str, craft: str, task: Task) -> None:
        """Have a craft do a task; what becomes of it comes as `words`.

        Raises
        ------
        WireError
            If the task does not fit into an order.
        """
        payload = task_wire.pack_order(Order(self._team.index(craft), self._number, task))
        for older in [sent for sent in self._sent if sent.craft == craft]:
            self._sent.remove(older)
            if older.status in {None, "started"}:
                self._word(older, "interrupted", "by a newer order")
        told = task_wire.unpack_order(payload).task
        self._sent.append(_Sent(name, craft, told, self._number, payload, self._tries, now_ns))
        self._number = (self._number + 1) % 256
        self.words.append(Word(name, craft, told, "queued"))

    def step(self, now_ns: int, send: Send) -> None:
        """Send what is to be sent now."""
        for sent in [each for each in self._sent if each.status is None and now_ns >= each.next_ns]:
            if not sent.tries_left:
                self._sent.remove(sent)
                self._word(sent, "failed", f"no echo in {self._tries} tries")
                continue
            sent.tries_left -= 1
            sent.ticket = send(sent.payload, sent.craft)
            # Until the modem says that it has left; should it never say so, the next try comes all the same.
            sent.next_ns = now_ns + 4 * self._answer_ns
        for had in [had for line in self._had.values() for had in line if had.reports_left]:
            if now_ns >= had.next_ns:
                had.reports_left -= 1
                had.next_ns = now_ns + self._answer_ns
                self._say(had)
        echoes, self._echoes = self._echoes, []
        for had in echoes:
            send(task_wire.pack_echo(had.echo), had.source)

    def on_status(self, event: TxEvent, now_ns: int) -> None:
        """Take what the modem says of something sent."""
        for sent in self._sent:
            if sent.ticket == event.ticket and sent.status is None and event.status in {"SENT", "FAILED"}:
                sent.ticket = None
                sent.next_ns = now_ns + self._answer_ns
                if event.reason in _HOPELESS:
                    self._sent.remove(sent)
                    self._word(sent, "failed", f"the modem cannot send it: {event.reason}")
                    return
                if event.status == "SENT" and not sent.on_air:
                    sent.on_air = True
                    self._word(sent, "on_air")

    def on_received(self, event: Received) -> Arrival | None:
        """Take task mail; returns an order for this craft that is to be looked at, and then answered."""
        if event.destination not in {BROADCAST, self._craft}:
            return None
        try:
            if event.source not in self._team:
                raise WireError(f"{event.source} is not of the team")  # noqa: TRY301 - one way to count what is bad
            if task_wire.is_order(event.payload):
                return self._on_order(event)
            self._on_echo(event, task_wire.unpack_echo(event.payload))
        except WireError:
            self.bad += 1
        return None

    def answer(self, name: str, status: Status, now_ns: int, reason: str = "") -> None:
        """Say what becomes of an order that has come; what ends it is said several times."""
        for line in self._had.values():
            for had in line:
                if _name(had.source, had.number) == name:
                    had.echo = had.echo._replace(status=status, reason=reason)
                    if status in {"started", "refused"}:
                        self._say(had)
                    else:
                        had.reports_left, had.next_ns = REPORTS, now_ns

    # -- inside -------------------------------------------------------------------------------------------------

    def _on_order(self, event: Received) -> Arrival | None:
        order = task_wire.unpack_order(event.payload)
        if not self._is_for_me(order.to, event):
            return None
        line = self._had.setdefault(event.source, deque(maxlen=_REMEMBERED))
        its_hash = task_wire.hash_of(event.payload)
        for had in line:
            if (had.number, had.hash) == (order.number, its_hash):
                self._say(had)
                return None
        echo = Echo(self._team.index(event.source) % 16, order.number, its_hash, "started")
        # A number that comes again with another task is another order.
        for had in [had for had in line if had.number == order.number]:
            line.remove(had)
        line.append(_Had(event.source, order.number, its_hash, echo))
        return Arrival(_name(event.source, order.number), order.task)

    def _say(self, had: _Had) -> None:
        if had not in self._echoes:
            self._echoes.append(had)

    def _on_echo(self, event: Received, echo: Echo) -> None:
        if not self._is_for_me(echo.to, event):
            return
        for sent in self._sent:
            if (sent.craft, sent.number, task_wire.hash_of(sent.payload)) == (event.source, echo.number, echo.hash):
                self._learn(sent, echo)
                return

    def _is_for_me(self, to: int, event: Received) -> bool:
        """Whether task mail that names a place modulo 16 is for this craft and nobody else."""
        if to != self._team.index(self._craft) % 16:
            return False
        if event.destination == BROADCAST and len(self._team[to::16]) > 1:
            raise WireError(f"{event.source} does not say to which of {', '.join(self._team[to::16])}")
        return True

    def _learn(self, sent: _Sent, echo: Echo) -> None:
        if sent.status is None:
            self._word(sent, "echoed")
            if echo.status not in {"started", "refused"}:
                self._word(sent, "started")
        elif _ORDER_OF[echo.status] <= _ORDER_OF[sent.status]:
            return  # an old echo, late
        sent.status = echo.status
        self._word(sent, echo.status, echo.reason)
        if echo.status in {"refused", "interrupted", "returned"}:
            self._sent.remove(sent)

    def _word(self, sent: _Sent, status: SenderStatus, detail: str = "") -> None:
        self.words.append(Word(sent.order, sent.craft, sent.task, status, detail))


def _name(source: str, number: int) -> str:
    return f"{source}#{number}"
