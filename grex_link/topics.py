"""The one table of topics: key, Struct, who writes, who reads, how, how often, recorded or not.

The bus, the recorder, the health page, access control and the tests are all driven by it.
"""

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from grex_link import messages as m

Role = Literal["frontseat", "navigation", "agent", "modem", "sim", "link", "view", "operator"]

#: Names a craft may not have: they are the places of other participants on the bus.
RESERVED = frozenset({"sim", "link", "up", "truth", "operator"})
_MODEM = "modem_"
_FRONTSEAT = "frontseat_"


def is_reserved(name: str) -> bool:
    """Whether a craft may not have this name."""
    return name in RESERVED or name.startswith((_MODEM, _FRONTSEAT))


def modem_place(craft: str) -> str:
    """Place on the bus of the driver of a craft's own modem."""
    return _MODEM + craft


def frontseat_place(craft: str) -> str:
    """Place on the bus of what steers a real craft."""
    return _FRONTSEAT + craft


def craft_of(who: str) -> str:
    """Craft that a participant belongs to."""
    return who.removeprefix(_MODEM).removeprefix(_FRONTSEAT)


@dataclass(frozen=True, slots=True)
class Topic:
    """One row of the table.

    Attributes
    ----------
    name : str
        What the code calls it.
    key : str
        Key expression below ``grex/<team>/``; ``{craft}`` stands for the craft (or ``link``).
    type : type
        The Struct that travels there.
    writers, readers : tuple of str
        Roles; ``sim`` reads what it must count or record, ``view`` is whoever watches.
    rate : str
        Nominal rate: every tick, or on an event.
    recorded : type or None
        The Struct that goes into the MCAP file; None if it is not recorded.
    flush : bool
        Whether a write leaves at once. A message that is followed by another one at once need not.
    """

    name: str
    key: str
    type: Any
    writers: tuple[Role, ...]
    readers: tuple[Role, ...]
    rate: Literal["tick", "event"]
    recorded: Any
    flush: bool = True

    @property
    def per_craft(self) -> bool:
        """Whether there is one such topic for each craft."""
        return "{craft}" in self.key


TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        Topic("fix", "{craft}/fix", m.Fix, ("frontseat", "sim"), ("agent", "sim"), "tick", recorded=m.Fix),
        Topic("nav", "{craft}/nav", m.Fix, ("navigation",), ("frontseat",), "event", recorded=None),
        Topic("setpoint", "{craft}/setpoint", m.Setpoint, ("agent",), ("frontseat", "sim"), "tick",
              recorded=m.Setpoint),
        Topic("modem_tx", "{craft}/modem/tx", m.Request, ("agent",), ("modem", "link", "sim"), "event",
              recorded=m.Request, flush=False),
        Topic("modem_rx", "{craft}/modem/rx", m.ModemEvent, ("modem", "link"), ("agent", "sim"), "event",
              recorded=m.ModemEvent),
        Topic("state", "{craft}/state", m.AgentStates, ("agent",), ("sim",), "tick",
              recorded=m.AgentState),
        Topic("port", "{craft}/port", m.PortLedger, ("agent",), ("sim",), "event",
              recorded=m.PortLedger),
        Topic("task", "{craft}/task", m.TaskOrder, ("operator",), ("agent",), "event", recorded=None),
        Topic("task_news", "{craft}/task/news", m.TaskNews, ("agent",), ("sim", "operator"), "event",
              recorded=m.TaskNews),
        Topic("oracle", "{craft}/oracle", m.Truth, ("sim",), ("agent",), "tick", recorded=None, flush=False),
        Topic("clock", "{craft}/clock", m.Clock, ("sim",), ("agent", "frontseat", "modem", "link"), "event",
              recorded=None),
        Topic("truth", "truth", m.Truth, ("sim",), ("link",), "tick", recorded=m.Truth),
        Topic("advance", "link/advance", m.Advance, ("sim",), ("link",), "event", recorded=None),
        Topic("report", "link/report", m.LinkReport, ("link",), ("sim",), "event", recorded=None),
        Topic("ledger", "link/ledger", m.LinkLedger, ("link",), ("sim",), "event", recorded=m.LinkLedger),
        Topic("status", "sim/status", m.RunStatus, ("sim",), ("view",), "event", recorded=None),
        Topic("link_event", "link/event", m.LinkEvent, (), (), "event", recorded=m.LinkEvent),
    )
}  # fmt: skip


def key(team: str, topic: str, craft: str) -> str:
    """Full key expression of a topic; ``craft`` may be ``*`` for all, and is ``""`` where there is none."""
    return f"grex/{team}/{TOPICS[topic].key.format(craft=craft)}"


def presence_key(team: str, who: str, scenario: str) -> str:
    """Key of the liveliness token a participant holds while it is up."""
    return f"grex/{team}/up/{who}/{scenario}"


def is_presence(name: str) -> bool:
    """Whether a key is that of a liveliness token."""
    parts = name.split("/")
    return len(parts) == 5 and parts[2] == "up"


def who_of(name: str) -> tuple[str, str]:
    """Team and place of the participant whose liveliness token this key is."""
    _, team, _, who, _ = name.split("/")
    return team, who


class Place(NamedTuple):
    """What a key on the bus stands for."""

    team: str
    topic: Topic
    craft: str
    """Or the place of a participant; empty for a topic that there is once."""


def place_of(name: str) -> Place | None:
    """Tell what a whole key stands for; None if it is none of the table's.

    Parameters
    ----------
    name : str
        For instance ``grex/grex/auv1/modem/tx``.
    """
    root, _, rest = name.partition("/")
    team, _, below = rest.partition("/")
    first, _, last = below.partition("/")
    if root != "grex":
        return None
    for topic in TOPICS.values():
        if topic.key == below:
            return Place(team, topic, "")
        if last and topic.key == "{craft}/" + last:
            return Place(team, topic, first)
    return None


def subscriptions(role: Role, who: str) -> list[tuple[str, str]]:
    """Return (topic, craft) pairs that a participant reads; ``*`` for all craft.

    The craft is ``""`` for a topic that there is once.

    Parameters
    ----------
    role : str
        ``agent``, ``frontseat``, ``modem``, ``link``, ``sim`` or ``operator``.
    who : str
        Its place on the bus: the craft's name for an agent, `frontseat_place` for a frontseat, `modem_place` for a
        modem's driver, else the role.
    """
    pairs = []
    for topic in TOPICS.values():
        if role in topic.readers:
            # What is aboard reads its own craft's keys; the clock is everyone's own; the bench reads all craft's keys.
            craft = who if topic.name == "clock" else craft_of(who) if role in {"agent", "frontseat", "modem"} else "*"
            pairs.append((topic.name, craft if topic.per_craft else ""))
    return pairs
