"""Which messages have been heard: every full team state says, of each mate, which of its latest ones are missing.

"I sent it" is not "they have it" (team-navigation, §3). What room the flags of the full form have is divided among the
mates. Each bit of a mate stands for an interval: the first for messages that were valid less than one interval before
this state, the second for those of the interval before, and so on. It is set if none of that interval has been heard.
The mate knows when its messages were valid, and so which of them is meant; of an interval without any it makes nothing.

Of one mate there are six bits, of two three each, of three two, of up to six one. In a team of more than seven there is
no room, and whatever has left is taken to have been heard.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from grex_agent.team.interface import Report
from grex_link.wire import HEARD_BITS, HEARD_SHIFT, TIME_STEP_S, TeamState

#: Of an interval: so near to a whole number of them is a whole number.
_ROUNDING = 1e-6


class Acknowledgements:
    """Says what is missing, and reads what the mates say.

    Parameters
    ----------
    craft : str
        Who says and reads.
    team : sequence of str
        The formation, in its order.
    interval_s : float
        Mean time between two openings of a craft.

    Attributes
    ----------
    intervals : int
        How many of them are told of each mate; 0 if there is no room, or no mate.
    """

    def __init__(self, craft: str, team: Sequence[str], interval_s: float) -> None:
        self._craft = craft
        self._mates_of = {speaker: [mate for mate in team if mate != speaker] for speaker in team}
        self._interval_s = interval_s
        mates = len(team) - 1
        self.intervals = HEARD_BITS // mates if mates else 0
        self._heard_s: dict[str, list[float]] = {}

    def hear(self, craft: str, t_s: float) -> None:
        """Note that a message has been heard which was valid at a time."""
        heard_s = self._heard_s.setdefault(craft, [])
        heard_s.append(t_s)
        oldest_s = max(heard_s) - self.intervals * self._interval_s
        heard_s[:] = [each for each in heard_s if each > oldest_s]

    def flags(self, now_s: float) -> int:
        """Say what is missing, in the flags of a state that is valid now."""
        # The mates read the time as it is rounded on the air.
        said_s = round(now_s / TIME_STEP_S) * TIME_STEP_S
        flags = 0
        for place, mate in enumerate(self._mates_of[self._craft]):
            ages = {self.age(t_s, said_s) for t_s in self._heard_s.get(mate, ())}
            for age in range(self.intervals):
                flags |= (age not in ages) << place * self.intervals + age
        return flags << HEARD_SHIFT

    def missing(self, report: Report, t_s: float) -> bool | None:
        """Read whether a mate misses an own message that was valid at a time; None if it does not say."""
        age = self.age(t_s, report.state.t_s)
        if age >= self.intervals:
            return None
        place = self._mates_of[report.craft].index(self._craft)
        return bool(report.state.flags >> HEARD_SHIFT + place * self.intervals + age & 1)

    def age(self, t_s: float, now_s: float) -> int:
        """Count the whole intervals from one time to another."""
        return max(math.floor((now_s - t_s) / self._interval_s + _ROUNDING), 0)


class News(NamedTuple):
    """What has become known of an own message: that a mate has it after all, or that it has not."""

    message: TeamState
    heard: bool


class _Sent(msgspec.Struct):
    """An own message, and who is known to have it (True) or not to have it (False)."""

    left_s: float
    message: TeamState
    heard_by: dict[str, bool]


class SentMessages:
    """Own messages of late, each taken to have been heard by everybody until it turns out otherwise.

    Parameters
    ----------
    acknowledgements : Acknowledgements
        Reads what the mates say.
    memory_s : float
        How long a message matters.
    """

    def __init__(self, acknowledgements: Acknowledgements, memory_s: float) -> None:
        self._acknowledgements = acknowledgements
        self._memory_s = memory_s
        self._sent: list[_Sent] = []

    def leave(self, message: TeamState, now_s: float) -> None:
        """Note that a message has left."""
        self._sent = [sent for sent in self._sent if now_s - sent.left_s <= self._memory_s]
        self._sent.append(_Sent(now_s, message, {}))

    def learn(self, report: Report) -> list[News]:
        """Learn from a mate's message which of the own ones it has; only what is news is given.

        What a mate has said it has, it has; what it has not, it may hear later: the message was still on its way.
        """
        mate, state = report
        if state.form != "full":
            return []
        news = []
        for sent in self._sent:
            before = sent.heard_by.get(mate)
            missing = self._acknowledgements.missing(report, sent.message.t_s)
            if before or missing is None or sent.left_s > state.t_s:
                continue
            heard = sent.heard_by[mate] = not missing
            if heard is (before is False):  # it was taken to be heard, as long as nothing was known
                news.append(News(sent.message, heard))
        return news
