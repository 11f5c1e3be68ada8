"""When a craft speaks: in its own openings and over land links, by its own clock, each time once."""

from collections.abc import Callable

from grex_agent.mission import TeamPlan, range_max_m
from grex_agent.team.interface import Report
from grex_agent.tell import TeamTalk
from grex_link.config import Scenario
from grex_link.errors import WireError
from grex_link.mac import plan_mac
from grex_link.messages import ModemEvent, Received, Request, Transmit, TxEvent
from grex_link.profile import ModemProfile
from grex_link.units import NS
from grex_link.wire import BYTES, Form, TeamState


class Messenger:
    """Speaks for a craft.

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
        How the own state goes on the air.

    Attributes
    ----------
    transmissions : int
        Requests to the modem so far.
    untold : bool
        Whether the last state could not be told.
    """

    def __init__(
        self, scenario: Scenario, craft: str, plan: TeamPlan, profile: ModemProfile, talk: TeamTalk, form: Form
    ) -> None:
        self._craft = craft
        self._talk = talk
        planned_m = 0.0 if profile.one_speaker_at_a_time else range_max_m(plan)
        self._mac = plan_mac(scenario, planned_m, BYTES[form])
        self._asked_until_ns = 0
        self._events: list[ModemEvent] = []
        self._on_air: dict[int, TeamState] = {}
        self.transmissions = 0
        self.untold = False

    def on_event(self, event: ModemEvent) -> None:
        """Take a modem event; it counts when `take` is called."""
        self._events.append(event)

    def take(self, now_ns: int) -> tuple[list[TeamState], list[Report]]:
        """Take what has been sent and heard since the last time."""
        sent: list[TeamState] = []
        heard: list[Report] = []
        for arrived in self._events:
            event = arrived.event
            if isinstance(event, Received):
                if report := self._talk.read(event, now_ns / NS):
                    heard.append(report)
            elif (
                isinstance(event, TxEvent)
                and (state := self._on_air.pop(event.ticket, None))
                and event.status == "SENT"
            ):
                sent.append(state)
        self._events.clear()
        return sent, heard

    def speak(self, now_ns: int, before_ns: int, state: Callable[[], TeamState | None]) -> list[Request]:
        """Ask the modem for what is to be said within [now, before).

        Parameters
        ----------
        now_ns, before_ns : int
            By the craft's clock.
        state : callable
            Gives the own state, or None if there is none worth telling.
        """
        self.untold = False
        from_ns = max(now_ns, self._asked_until_ns)
        self._asked_until_ns = max(before_ns, self._asked_until_ns)
        requests: list[Request] = []
        for t_ns in self._mac.openings(self._craft, from_ns, before_ns):
            told = state()
            if told is None:
                continue
            try:
                payload, read = self._talk.pack(told)
            except WireError:
                self.untold = True
                continue
            self._on_air[self.transmissions] = read
            requests.append(Transmit(self.transmissions, t_ns, payload))
            self.transmissions += 1
        return requests
