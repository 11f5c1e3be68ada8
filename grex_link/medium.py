"""What the link process drives, whatever water lies behind it.

A medium is a pure core in integer nanoseconds of true mission time: requests go in, events with their times come out.
The same seed, poses and requests give the same events, in whatever order the requests of one step are handed over.
"""

from typing import Protocol

from grex_link.config import Scenario
from grex_link.messages import Happening, LinkEvent, Request, Truth
from grex_link.profile import load_profile

#: A modem event on its way: (true mission time ns, craft it is for, what its modem says).
Due = tuple[int, str, Happening]


class Medium(Protocol):
    """The water between the craft.

    Attributes
    ----------
    lookahead_ns : int
        A request for time t causes no modem event before t + lookahead. The hub may run that far ahead.
    """

    lookahead_ns: int

    def place(self, truth: Truth) -> None:
        """Take note of the true poses at a time, once everything before it has been worked through."""

    def request(self, source: str, request: Request, start_ns: int) -> None:
        """Accept a request for a true time; one that is in the past already begins at once."""

    def advance(self, until_ns: int) -> None:
        """Work through everything before a time: all requests that begin before it are known."""

    def events(self, before_ns: int) -> list[Due]:
        """Take the modem events before a time, in the order of (time, receiver, cause)."""

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Take the log lines before a time, in the order of time."""

    def next_event_ns(self) -> int | None:
        """Next time at which anything happens; None if nothing is on its way."""


def make_medium(scenario: Scenario) -> Medium:
    """Build the medium a scenario asks for."""
    profile = load_profile(scenario.link.profile)
    water: Medium
    if profile.one_speaker_at_a_time:
        from grex_link.slot_medium import SlotMedium

        water = SlotMedium(scenario, profile)
    else:
        from grex_link.acoustic_medium import AcousticMedium

        water = AcousticMedium(scenario, profile)
    if not scenario.link.land:
        return water
    from grex_link.land import WaterAndLand

    return WaterAndLand(scenario, water)
