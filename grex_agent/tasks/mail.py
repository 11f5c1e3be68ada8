"""Task mail through the modem port: over cable or radio where there is one, else by sound, before team states."""

from grex_agent.modem.port import ModemPort
from grex_link.config import Scenario
from grex_link.mac import Mac, PureAlohaMac, SlottedAlohaMac
from grex_link.messages import Happening, Received, Request, TxEvent
from grex_link.task_wire import is_task_mail
from grex_link.tdma import Schedule
from grex_link.units import NS

#: Above rangings and team states.
PRIORITY = 2


class TaskMail:
    """Sends task mail, and picks it out of what comes.

    Parameters
    ----------
    port : ModemPort
        The craft's port.
    scenario : Scenario
        Its land links.
    craft : str
        Whose mail.
    ttl_s : float
        How long mail may wait for a slot.
    """

    def __init__(self, port: ModemPort, scenario: Scenario, craft: str, ttl_s: float) -> None:
        self._port = port
        self._ttl_s = ttl_s
        links = [land.between for land in scenario.link.land if craft in land.between]
        self._by_land = {mate for pair in links for mate in pair if mate != craft}
        self._waiting: list[tuple[int, bytes, str]] = []
        self._tickets: dict[int, int] = {}
        self._sent = 0
        self.received: list[Received] = []
        self.statuses: list[TxEvent] = []

    def send(self, payload: bytes, to: str, now_ns: int) -> int:
        """Have mail sent; return the ticket under which `statuses` tells its fate."""
        ticket = self._sent
        self._sent += 1
        if to in self._by_land:
            self._waiting.append((ticket, payload, to))
            return ticket
        # The first bytes are type, receiver and number.
        key = "task", to, payload[:2]
        self._tickets[self._port.next_ticket] = ticket
        self._port.send(payload, now_ns, to, priority=PRIORITY, ttl_s=self._ttl_s, supersede_key=key)
        return ticket

    def speak_by_land(self, now_ns: int) -> list[Request]:
        """Send what goes over land, now."""
        requests = []
        for ticket, payload, to in self._waiting:
            self._tickets[self._port.next_ticket] = ticket
            request = self._port.send_by_land(payload, now_ns, to)
            requests += [] if request is None else [request]
        self._waiting.clear()
        return requests

    def takes(self, happening: Happening) -> bool:
        """Take what is task mail, or about it; false if it is something else."""
        if isinstance(happening, Received) and is_task_mail(happening.payload):
            self.received.append(happening)
            return True
        if isinstance(happening, TxEvent) and happening.ticket in self._tickets:
            ticket = self._tickets[happening.ticket]
            if happening.status in {"SENT", "DELIVERED", "FAILED"}:
                del self._tickets[happening.ticket]
                self.statuses.append(TxEvent(ticket, happening.status, happening.reason))
            return True
        return False


def answer_ns(mac: Mac) -> int:
    """How long an answer may take: until everybody has had a chance to speak, and half as much again."""
    if isinstance(mac, Schedule):
        return mac.cycle_ns * 3 // 2
    if isinstance(mac, SlottedAlohaMac):
        return round(3.0 * mac.slot_ns / mac.probability)
    if isinstance(mac, PureAlohaMac):
        return round(3.0 * NS / mac.rate_per_s)
    return 60 * NS
