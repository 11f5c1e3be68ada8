"""Everything about tasks aboard one craft: its own, those it gives to others, and the events it sees."""

from collections import deque
from collections.abc import Callable, Sequence

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan
from grex_agent.tasks.activity import Steering
from grex_agent.tasks.dispatch import Dispatcher
from grex_agent.tasks.mail import TaskMail
from grex_agent.tasks.post import TaskPost
from grex_agent.tasks.runner import TaskRunner
from grex_agent.team.interface import Report
from grex_link.config import Scenario
from grex_link.errors import WireError
from grex_link.messages import Fix, TaskNews, TaskOrder
from grex_link.task_wire import Status
from grex_link.tasks import Task
from grex_link.wire import ON_TASK

#: Name of the tasks that the scenario gives a craft from the start on.
START = "start"
#: Orders of the operator that are remembered, so that one that comes twice is one.
_REMEMBERED = 64


class TaskOffice:
    """See the module's docstring.

    Parameters
    ----------
    scenario : Scenario
        Tasks, events, tries.
    craft : str
        Whose office.
    plan : TeamPlan
        What everybody is for.
    processor : ManoeuvreProcessor
        Follows the own plan.
    mail : TaskMail
        To and from others.
    answer_ns : int
        How long an answer may take.

    Attributes
    ----------
    health : list of str
        Words of health of this step.
    news : list of TaskNews
        To be taken away by the owner.
    """

    def __init__(
        self,
        scenario: Scenario,
        craft: str,
        plan: TeamPlan,
        processor: ManoeuvreProcessor,
        mail: TaskMail,
        answer_ns: int,
    ) -> None:
        self._craft = craft
        self._team = list(scenario.craft)
        self._processor = processor
        self._mail = mail
        self._runner = TaskRunner(scenario, craft, plan, processor)
        self._post = TaskPost(craft, self._team, scenario.tasking.tries, answer_ns)
        self._dispatcher = Dispatcher(scenario, craft, plan)
        self._orders: deque[str] = deque(maxlen=_REMEMBERED)
        self._todo: list[TaskOrder] = []
        self._seen: dict[str, tuple[float, float]] = {}
        self._on_task: set[str] = set()
        self.health: list[str] = []
        self.news: list[TaskNews] = []
        if scenario.craft[craft].tasks:
            self._runner.order(scenario.craft[craft].tasks, START)

    @property
    def busy(self) -> bool:
        """Whether the craft does something else than what it is for."""
        return self._runner.busy

    @property
    def on_task(self) -> set[str]:
        """Others that have said that they are on a task of their own, and are not to be waited for."""
        return self._on_task

    @property
    def bad(self) -> int:
        """Payloads so far that were no order and no echo."""
        return self._post.bad

    def on_order(self, order: TaskOrder) -> None:
        """Take an order of the operator; it counts at the next step."""
        if order.order not in self._orders:
            self._orders.append(order.order)
            self._todo.append(order)

    def step(
        self, now_ns: int, fix: Fix | None, heard: Sequence[Report], mates: Sequence[float], *, lost: bool
    ) -> Steering | None:
        """Do everything of a step.

        Parameters
        ----------
        now_ns : int
            Time by the craft's clock.
        fix : Fix or None
            The newest.
        heard : sequence of Report
            Team states that have come.
        mates : sequence of float
            Progress of the members that this craft waits for.
        lost : bool
            Whether the fix is not to be trusted.

        Returns
        -------
        Steering or None
            What to do; None for what the plan says.
        """
        self.health = []
        for report in heard:
            self._seen[report.craft] = report.state.north_m, report.state.east_m
            (self._on_task.add if report.state.flags & ON_TASK else self._on_task.discard)(report.craft)
        self._take_orders(now_ns, lost=lost)
        self._take_mail(now_ns, lost=lost)
        self._look_at_events(now_ns)
        self._read_words(now_ns)
        formation = sum(mates) / len(mates) if mates else self._processor.progress
        steering = self._runner.step(now_ns, fix, formation, lost=lost)
        happenings, self._runner.happenings = self._runner.happenings, []
        for happening in happenings:
            self._tell(now_ns, happening.name, self._craft, happening.task, happening.status)
            self._answer(happening.name, happening.status, now_ns)
        self._post.step(now_ns, lambda payload, to: self._mail.send(payload, to, now_ns))
        self._read_words(now_ns)
        return steering

    # -- inside -------------------------------------------------------------------------------------------------

    def _take_orders(self, now_ns: int, *, lost: bool) -> None:
        """Do what the operator has ordered: aboard, or by another craft."""
        todo, self._todo = self._todo, []
        for order in todo:
            if order.craft not in self._team:
                self._tell(now_ns, order.order, order.craft, order.task, "refused", "no such craft in the team")
            elif order.craft == self._craft:
                self._tell(now_ns, order.order, self._craft, order.task, "queued")
                self._try(now_ns, order.order, order.task, lost=lost)
            else:
                self._send(now_ns, order.order, order.craft, order.task)

    def _take_mail(self, now_ns: int, *, lost: bool) -> None:
        statuses, self._mail.statuses = self._mail.statuses, []
        for status in statuses:
            self._post.on_status(status, now_ns)
        received, self._mail.received = self._mail.received, []
        for event in received:
            arrival = self._post.on_received(event)
            if arrival is None:
                continue
            refusal = self._try(now_ns, arrival.name, arrival.task, lost=lost)
            if refusal:
                self._post.answer(arrival.name, "refused", now_ns, refusal)

    def _try(self, now_ns: int, name: str, task: Task, *, lost: bool) -> str:
        """Start a task, or refuse it; returns why."""
        refusal = self._runner.refusal(task, lost=lost)
        if refusal:
            self._tell(now_ns, name, self._craft, task, "refused", refusal)
        else:
            self._runner.order((task,), name)
        return refusal

    def _send(self, now_ns: int, name: str, craft: str, task: Task) -> None:
        try:
            self._post.order(now_ns, name, craft, task)
        except WireError as error:
            self._tell(now_ns, name, craft, task, "refused", str(error))
            self._dispatcher.learn(name, "refused")

    def _look_at_events(self, now_ns: int) -> None:
        busy: Callable[[str], bool] = lambda craft: craft in self._on_task or self._post.unanswered(craft)  # noqa: E731
        for name, event, craft in self._dispatcher.choose(now_ns, self._seen, busy):
            if craft:
                self._send(now_ns, name, craft, event.task)
            else:
                self._tell(now_ns, name, "", event.task, "failed", "nobody on call is left to be asked")
                self.health.append("event_unanswered")

    def _read_words(self, now_ns: int) -> None:
        """Learn what has become of orders to others, and pass it on."""
        words, self._post.words = self._post.words, []
        for word in words:
            self._tell(now_ns, word.order, word.craft, word.task, word.status, word.detail)
            self._dispatcher.learn(word.order, word.status)
            if word.status == "failed":
                self.health.append("task_unechoed")
            elif word.status == "started":
                # Its next state will say so itself; until then this is known.
                self._on_task.add(word.craft)

    def _answer(self, name: str, status: str, now_ns: int) -> None:
        known: dict[str, Status] = {
            "started": "started",
            "done": "done",
            "returned": "returned",
            "interrupted": "interrupted",
        }
        self._post.answer(name, known[status], now_ns)

    def _tell(self, now_ns: int, name: str, craft: str, task: Task, status: str, detail: str = "") -> None:
        self.news.append(TaskNews(now_ns, name, craft, task, status, detail))  # type: ignore[arg-type]
