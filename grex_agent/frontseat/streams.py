"""The messages we want of an autopilot, and how often they really come.

Intervals are forgotten at a reboot, may be changed by another ground station, and may be refused: what comes too rarely
is asked for again, and what is refused is left alone until the next boot.
"""

from collections import Counter
from collections.abc import Mapping

from grex_agent.frontseat.commands import Answer, Command
from grex_agent.frontseat.dialect import mavlink
from grex_agent.frontseat.families.table import Family

#: Rates are measured over as many seconds of the autopilot.
_WINDOW_S = 5.0
#: Below this share of the wanted rate it is asked for again; losses on the way are no reason to.
_TOO_RARE = 0.5
_PURPOSE = "rate "


def wanted_rates(family: Family) -> dict[int, tuple[str, float]]:
    """Message ids with name and rate, hertz of the autopilot's time."""
    ids = {
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5.0,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 5.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE: 5.0,
        family.estimator: 2.0,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2.0,
    }
    return {number: (mavlink.mavlink_map[number].msgname, rate) for number, rate in ids.items()}


class Streams:
    """Asks for messages and measures them; see the module's docstring.

    Parameters
    ----------
    family : Family
        Whose messages.
    """

    def __init__(self, family: Family) -> None:
        self._wanted = wanted_rates(family)
        self._counts: Counter[str] = Counter()
        self._since_s: float | None = None
        self._refused: set[int] = set()
        self.rates: Mapping[str, float] = {}

    def reset(self) -> None:
        """Begin anew after a reboot."""
        self._counts.clear()
        self._since_s = None
        self._refused.clear()
        self.rates = {}

    def on_message(self, kind: str) -> None:
        """Count a message."""
        self._counts[kind] += 1

    def on_answer(self, answer: Answer) -> None:
        """Take note of what is refused."""
        if answer.status == "refused":
            self._refused.add(int(answer.command.parameters[0]))

    @staticmethod
    def is_mine(answer: Answer) -> bool:
        """Whether an answer is to a command of here."""
        return answer.command.purpose.startswith(_PURPOSE)

    def due(self, now_s: float, rate: float) -> list[Command]:
        """Return what is to be asked for, at a time of ours: all at first, then what is too rare."""
        if self._since_s is None:
            self._since_s = now_s
            return [self._command(number) for number in self._wanted]
        passed_s = (now_s - self._since_s) * rate
        if passed_s < _WINDOW_S:
            return []
        self.rates = {kind: count / passed_s for kind, count in sorted(self._counts.items())}
        self._counts.clear()
        self._since_s = now_s
        return [
            self._command(number)
            for number, (name, rate) in self._wanted.items()
            if number not in self._refused and self.rates.get(name, 0.0) < _TOO_RARE * rate
        ]

    def missing(self) -> list[str]:
        """Names of the messages that do not come."""
        return [name for name, _ in self._wanted.values() if not self.rates.get(name)]

    def _command(self, number: int) -> Command:
        name, rate = self._wanted[number]
        return Command(_PURPOSE + name, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, (float(number), 1e6 / rate))
