"""When a craft speaks: in its own openings and over land links, by its own clock, each time once."""

from collections.abc import Callable

from grex_agent.mission import TeamPlan, range_max_m
from grex_agent.modem.port import ModemPort
from grex_agent.tasks.mail import TaskMail, answer_ns
from grex_agent.team.interface import Report
from grex_agent.tell import TeamTalk
from grex_link.config import Scenario
from grex_link.errors import WireError
from grex_link.mac import plan_mac
from grex_link.messages import ModemEvent, PortLedger, Received, Request, TxEvent
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import BYTES, Form, TeamState

#: Gives the own state, or None if there is none worth telling.
Tell = Callable[[], TeamState | None]


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
    talk : TeamTalk
        What is said.
    form : Form
        How the own state goes on the air; over land it goes in full.

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
        self, scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile, talk: TeamTalk, form: Form
    ) -> None:
        self._talk = talk
        self._form = form
        planned_m = 0.0 if profile.one_speaker_at_a_time else range_max_m(plan)
        mac = plan_mac(scenario, planned_m, BYTES[form])
        self._port = ModemPort(craft, list(scenario.craft), profile, mac)
        self.answer_ns = answer_ns(mac)
        self.mail = TaskMail(self._port, scenario, craft, 2.0 * self.answer_ns / NS)
        self._reached_ns = 0
        self._land_ns, self._heard_by_all_on_land = _land(scenario, craft, plan)
        self._ledger_ns = round(scenario.link.ledger_s * NS)
        self._next_ledger_ns = self._ledger_ns
        self._events: list[ModemEvent] = []
        self._on_air: dict[int, TeamState] = {}
        self.untold = False

    @property
    def transmissions(self) -> int:
        """Requests to the modem so far."""
        return self._port.transmissions

    def on_event(self, event: ModemEvent) -> None:
        """Take a modem event; it counts when `take` is called."""
        self._events.append(event)

    def take(self, now_ns: int) -> tuple[list[TeamState], list[Report]]:
        """Take what has been sent and heard since the last time."""
        sent: list[TeamState] = []
        heard: list[Report] = []
        happenings = [happening for event in self._events for happening in self._port.on_event(event)]
        self._events.clear()
        for happening in [*happenings, *self._port.take_events()]:
            if self.mail.takes(happening):
                continue
            if isinstance(happening, Received):
                if report := self._talk.read(happening, now_ns / NS):
                    heard.append(report)
            elif isinstance(happening, TxEvent) and happening.status in {"SENT", "FAILED"}:
                state = self._on_air.pop(happening.ticket, None)
                if state is not None and happening.status == "SENT":
                    sent.append(state)
        return sent, heard

    def speak(self, now_ns: int, before_ns: int, tell: Tell) -> list[Request]:
        """Ask the modem for what is to be said within [now, before), by the craft's clock."""
        self.untold = False
        from_ns, before_ns = max(now_ns, self._reached_ns), max(before_ns, self._reached_ns)
        self._reached_ns = before_ns

        def pull(max_bytes: int) -> bytes | None:
            payload = self._payload(tell, self._form)
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

    def _payload(self, tell: Tell, form: Form, *, heard_by_all: bool = True) -> bytes | None:
        """Pack the own state, for the next request; what the mates will read is kept until it has been sent."""
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
