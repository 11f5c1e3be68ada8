"""Who is sent to an event: the nearest craft that stands by, is on call, and is free."""

import math
from collections.abc import Callable, Mapping

import msgspec

from grex_agent.mission import TeamPlan
from grex_link.config import Scenario
from grex_link.tasks import EventConfig
from grex_link.units import NS

#: Whether a craft is busy.
Busy = Callable[[str], bool]


class _Open(msgspec.Struct):
    """An event that nobody has been found for yet."""

    name: str
    event: EventConfig
    refused: set[str]
    """Who has been asked in vain."""
    asked: str = ""
    """Who is asked now."""


class Dispatcher:
    """Sends craft to the events that one craft sees.

    Parameters
    ----------
    scenario : Scenario
        Events, and who is on call.
    craft : str
        Who sees and decides.
    plan : TeamPlan
        Where those who have not been heard stand by.
    """

    def __init__(self, scenario: Scenario, craft: str, plan: TeamPlan) -> None:
        self._to_come = sorted(
            ((f"event{n}", event) for n, event in enumerate(scenario.events) if event.seen_by == craft),
            key=lambda entry: entry[1].at_s,
        )
        self._places = {
            name: each.tracks[0].point(0.0) for name, each in plan.standby.items() if scenario.standby[name].on_call
        }
        self._open: list[_Open] = []

    def choose(
        self, now_ns: int, seen: Mapping[str, tuple[float, float]], busy: Busy
    ) -> list[tuple[str, EventConfig, str]]:
        """Return events and whom to send, with '' if nobody is left to be asked.

        Parameters
        ----------
        now_ns : int
            Time.
        seen : mapping of str to (float, float)
            Where craft are, as they have told; the others are taken to be at their places.
        busy : callable
            Whether a craft is busy: then it is asked when it is free.
        """
        while self._to_come and self._to_come[0][1].at_s * NS <= now_ns:
            self._open.append(_Open(*self._to_come.pop(0), set()))
        chosen = []
        taken: set[str] = set()
        for each in [each for each in self._open if not each.asked]:
            left = [craft for craft in self._places if craft not in each.refused]
            free = [craft for craft in left if craft not in taken and not busy(craft)]
            if not left:
                self._open.remove(each)
                chosen.append((each.name, each.event, ""))
            elif free:
                at = each.event.at_ned_m[:2]
                each.asked = min(free, key=lambda craft: (math.dist(seen.get(craft, self._places[craft]), at), craft))
                taken.add(each.asked)
                chosen.append((each.name, each.event, each.asked))
        return chosen

    def learn(self, name: str, status: str) -> None:
        """Take note of what has become of an order for an event."""
        for each in [each for each in self._open if each.name == name]:
            if status in {"refused", "failed", "interrupted"}:
                # Who was given another order before it answered may be asked again.
                each.refused.update([each.asked] if status != "interrupted" else [])
                each.asked = ""
            elif status == "started":
                self._open.remove(each)
