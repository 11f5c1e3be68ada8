"""Which messages have been heard: every full team state says, of each mate, how old the newest word of it is.

"I sent it" is not "they have it" (team-navigation, §3). What room the flags of the full form have is divided among the
mates. Of each one it says how many whole intervals ago, at the time of this state, the newest of its messages that has
been heard was valid; the greatest number stands for all that is older, and for none. The mate knows when its messages
were valid, and so which of them is meant. Zero is what is said by who says nothing of it: that the last one was heard.

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
    """Says what has been heard, and reads what the mates say.

    Parameters
    ----------
    craft : str
        Who says and reads.
    team : sequence of str
        The formation, in its order.
    interval_s : float
        Mean time between two openings of a craft.
    """

    def __init__(self, craft: str, team: Sequence[str], interval_s: float) -> None:
        self._craft = craft
        self._mates_of = {speaker: [mate for mate in team if mate != speaker] for speaker in team}
        self._interval_s = interval_s
        self._bits = HEARD_BITS // max(len(team) - 1, 1)
        self.oldest = (1 << self._bits) - 1
        self._newest_s: dict[str, float] = {}

    @property
    def told(self) -> bool:
        """Whether there is room for it in a message."""
        return self._bits > 0

    def hear(self, craft: str, t_s: float) -> None:
        """Note that a message has been heard which was valid at a time."""
        self._newest_s[craft] = max(self._newest_s.get(craft, -math.inf), t_s)

    def flags(self, now_s: float) -> int:
        """Say what has been heard, in the flags of a state that is valid now."""
        # The mates read the time as it is rounded on the air.
        said_s = round(now_s / TIME_STEP_S) * TIME_STEP_S
        flags = 0
        for place, mate in enumerate(self._mates_of[self._craft]):
            newest_s = self._newest_s.get(mate)
            age = self.oldest if newest_s is None else min(self.age(newest_s, said_s), self.oldest)
            flags |= age << place * self._bits
        return flags << HEARD_SHIFT

    def read(self, report: Report) -> int:
        """Read how old the newest of the own messages is that a mate has heard; `oldest`: or older, or none."""
        place = self._mates_of[report.craft].index(self._craft)
        return report.state.flags >> HEARD_SHIFT + place * self._bits & self.oldest

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
        newest = self._acknowledgements.read(report)
        news = []
        for sent in self._sent:
            before = sent.heard_by.get(mate)
            if before or sent.left_s > state.t_s:
                continue
            age = self._acknowledgements.age(sent.message.t_s, state.t_s)
            if age < newest and before is None:
                sent.heard_by[mate] = False
                news.append(News(sent.message, heard=False))
            elif age == newest < self._acknowledgements.oldest:
                sent.heard_by[mate] = True
                if before is False:
                    news.append(News(sent.message, heard=True))
        return news
