"""When a craft speaks: in its own openings and over land links, by its own clock, each time once."""

from collections.abc import Callable
from typing import Any, Protocol

from grex_agent.medium_access import medium_access
from grex_agent.mission import TeamPlan
from grex_agent.modem.port import ModemPort
from grex_agent.range_update import Range
from grex_agent.ranging import Ranging
from grex_agent.talk_policy import TalkPolicy
from grex_agent.tasks.mail import TaskMail, answer_ns
from grex_agent.team.interface import Report
from grex_link.config import Scenario
from grex_link.errors import WireError
from grex_link.messages import ModemEvent, PortLedger, RangeResult, Received, Request, TxEvent
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import Form

#: Gives what is to be told, or None if there is nothing worth telling.
Tell = Callable[[], Any]


class Talk(Protocol):
    """What is told and read: team states, or words of the shared reference.

    Attributes
    ----------
    bad_frames : int
        Datagrams so far that were nothing of the kind.
    """

    bad_frames: int

    def pack(self, told: Any, form: Form | None = None) -> tuple[bytes, Any]:
        """Pack it: what goes on the air, and what the mates will read. Raises WireError if it cannot be told."""

    def read(self, event: Received, now_s: float) -> Any:
        """Read what was heard; None, and counted, if it is nothing of the kind."""


class Messenger:
    """Speaks for a craft through its modem port, and takes what comes back.

    The clock may be set by GPS in the middle of a mission. Set forward, openings that have passed are lost; set back,
    those that come a second time are not used again, so that it is silent for as long as it was set back.

    Parameters
    ----------
    scenario : Scenario
        Slots, land links and ledger.
    craft : str
        For whom.
    plan : TeamPlan
        Its distances make the guard.
    profile : ModemProfile
        The modem.
    talk : Talk
        What is said; a team state goes in full over land.
    policy : TalkPolicy
        Whether to speak in an own slot; over land the craft always does.
    message_bytes : int
        Length of what is said on the air.

    Attributes
    ----------
    untold : bool
        Whether the state was to be told the last time, and could not.
    mail : TaskMail
        Tasks and their echoes.
    answer_ns : int
        How long an answer of another craft may take.
    """

    def __init__(
        self,
        scenario: Scenario,
        craft: str,
        plan: TeamPlan,
        profile: ModemProfile,
        talk: Talk,
        policy: TalkPolicy,
        message_bytes: int,
    ) -> None:
        self._talk = talk
        self._policy = policy
        mac = medium_access(scenario, plan, profile, message_bytes)
        self._port = ModemPort(craft, list(scenario.craft), profile, mac)
        self._ranging = Ranging(scenario, craft, plan, profile)
        self._asking: int | None = None
        self.answer_ns = answer_ns(mac)
        self.mail = TaskMail(self._port, scenario, craft, 2.0 * self.answer_ns / NS)
        self._reached_ns = 0
        self._land_ns, self._heard_by_all_on_land = _land(scenario, craft, plan)
        self._ledger_ns = round(scenario.link.ledger_s * NS)
        self._next_ledger_ns = self._ledger_ns
        self._events: list[ModemEvent] = []
        self._on_air: dict[int, Any] = {}
        self.untold = False

    @property
    def transmissions(self) -> int:
        """Requests to the modem so far."""
        return self._port.transmissions

    def on_event(self, event: ModemEvent) -> None:
        """Take a modem event; it counts when `take` is called."""
        self._events.append(event)

    def take(self, now_ns: int) -> tuple[list[Any], list[Any]]:
        """Take what has been sent and heard since the last time."""
        sent: list[Any] = []
        heard: list[Any] = []
        happenings = [(event.t_ns, happening) for event in self._events for happening in self._port.on_event(event)]
        self._events.clear()
        for t_ns, happening in [*happenings, *((now_ns, happening) for happening in self._port.take_events())]:
            if self.mail.takes(happening):
                continue
            if isinstance(happening, Received):
                if report := self._talk.read(happening, now_ns / NS):
                    heard.append(report)
                    if isinstance(report, Report):
                        self._ranging.on_message(happening, t_ns, report.state)
            elif isinstance(happening, RangeResult):
                self._ranging.on_range(happening, t_ns)
                self._asking = None
            elif isinstance(happening, TxEvent) and happening.status in {"SENT", "FAILED"}:
                state = self._on_air.pop(happening.ticket, None)
                if state is not None and happening.status == "SENT":
                    sent.append(state)
                if happening.ticket == self._asking and happening.status == "FAILED":
                    self._asking = None
        self._ask_for_range(now_ns, len(sent))
        return sent, heard

    def take_ranges(self) -> list[Range]:
        """Take the ranges that have been measured until the last `take`."""
        return self._ranging.take()

    def speak(self, now_ns: int, before_ns: int, tell: Tell, *, must: bool = False) -> list[Request]:
        """Ask the modem for what is to be said within [now, before), by the craft's clock; `must`: in any case."""
        self.untold = False
        from_ns, before_ns = max(now_ns, self._reached_ns), max(before_ns, self._reached_ns)
        self._reached_ns = before_ns

        def pull(max_bytes: int) -> bytes | None:
            payload = self._payload(tell) if self._policy.speaks() or must else None
            return payload if payload is None or len(payload) <= max_bytes else None

        requests = self._port.open_slots(from_ns, before_ns, pull)
        requests += self.mail.speak_by_land(from_ns)
        if self._land_ns:
            requests += self._speak_by_land(from_ns, before_ns, tell)
        return requests

    def ledger(self, now_ns: int) -> PortLedger:
        """Count what has become of everything that was to be said."""
        return self._port.ledger(now_ns)

    def ledger_due(self, now_ns: int) -> bool:
        """Whether it is time for the ledger; once each time."""
        if now_ns < self._next_ledger_ns:
            return False
        self._next_ledger_ns = (now_ns // self._ledger_ns + 1) * self._ledger_ns
        return True

    # -- inside -------------------------------------------------------------------------------------------------

    def _ask_for_range(self, now_ns: int, own_messages: int) -> None:
        """Have the next range measured in the next own slot, one at a time."""
        self._ranging.on_own_messages(own_messages)
        if self._asking is None and (mate := self._ranging.next_to_ask()) is not None:
            self._asking = self._port.range(mate, now_ns)

    def _payload(self, tell: Tell, form: Form | None = None, *, heard_by_all: bool = True) -> bytes | None:
        """Pack what is to be told, for the next request; what the mates will read is kept until it has been sent."""
        state = tell()
        if state is None:
            return None
        try:
            payload, read = self._talk.pack(state, form)
        except WireError:
            self.untold = True
            return None
        if heard_by_all:
            self._on_air[self._port.next_ticket] = read
        return payload

    def _speak_by_land(self, from_ns: int, before_ns: int, tell: Tell) -> list[Request]:
        requests: list[Request] = []
        first_ns = -(-from_ns // self._land_ns) * self._land_ns
        for t_ns in range(first_ns, before_ns, self._land_ns):
            payload = self._payload(tell, "full", heard_by_all=self._heard_by_all_on_land)
            if payload is not None and (request := self._port.send_by_land(payload, t_ns)) is not None:
                requests.append(request)
        return requests


def _land(scenario: Scenario, craft: str, plan: TeamPlan) -> tuple[int, bool]:
    """How often a craft speaks over its land links, nanoseconds (0: never), and whether all mates hear that.

    What it says goes over all of its links, so the one that wants it most often decides.
    """
    links = [land for land in scenario.link.land if craft in land.between]
    mates = {mate for land in links for mate in land.between if mate != craft}
    every_s = min((land.every_s for land in links), default=0.0)
    return max(round(every_s * NS), 1) if links else 0, mates >= plan.craft.keys() - {craft}
