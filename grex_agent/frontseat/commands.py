"""Commands to the autopilot, one at a time, each until it is acknowledged, refused, or unanswered after four tries."""

from collections import deque
from dataclasses import dataclass, replace
from typing import Literal

from grex_agent.frontseat.dialect import Mavlink, mavlink

#: Seconds until it is sent again, and how often it is sent.
_RETRY_S = 0.5
_TRIES = 4
_IN_PROGRESS_S = 3.0


@dataclass(frozen=True, slots=True)
class Command:
    """A COMMAND_LONG.

    Attributes
    ----------
    purpose : str
        What it is for; one purpose is asked for once at a time.
    number : int
        MAV_CMD.
    parameters : tuple of float
        The first ones; the others are 0.
    """

    purpose: str
    number: int
    parameters: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a command.

    Attributes
    ----------
    command : Command
        Which it was.
    status : str
        ``unanswered`` after the last try.
    result : str
        The autopilot's word, for instance ``DENIED``.
    """

    command: Command
    status: Literal["accepted", "refused", "unanswered"]
    result: str = ""


@dataclass(frozen=True, slots=True)
class _Sent:
    command: Command
    tries: int
    again_s: float


class Commander:
    """Sends commands and matches what is acknowledged; see the module's docstring.

    Parameters
    ----------
    system, component : int
        Whom the commands are for.
    own_system, own_component : int
        Who we are: an acknowledgement of somebody else's command is not ours.
    """

    def __init__(self, system: int, component: int, own_system: int, own_component: int) -> None:
        self._to = system, component
        self._us = own_system, own_component
        self._waiting: deque[Command] = deque()
        self._sent: _Sent | None = None

    def ask(self, command: Command, *, urgent: bool = False) -> None:
        """Ask for something, unless that is being asked for; what is urgent goes before all that waits."""
        if self.asking(command.purpose):
            return
        if urgent:
            self._waiting.appendleft(command)
        else:
            self._waiting.append(command)

    def asking(self, purpose: str) -> bool:
        """Whether something is being asked for."""
        sent = self._sent is not None and self._sent.command.purpose == purpose
        return sent or any(command.purpose == purpose for command in self._waiting)

    def clear(self) -> None:
        """Forget everything: there is nobody left to answer."""
        self._waiting.clear()
        self._sent = None

    def on_ack(self, ack: Mavlink, now_s: float) -> Answer | None:
        """Take a COMMAND_ACK; late and foreign ones count for nothing."""
        sent = self._sent
        target = ack.target_system, ack.target_component
        if sent is None or ack.command != sent.command.number or target not in {self._us, (self._us[0], 0), (0, 0)}:
            return None
        if ack.result == mavlink.MAV_RESULT_IN_PROGRESS:
            # To send it again would begin anew.
            self._sent = replace(sent, again_s=now_s + _IN_PROGRESS_S)
            return None
        self._sent = None
        accepted = ack.result == mavlink.MAV_RESULT_ACCEPTED
        return Answer(sent.command, "accepted" if accepted else "refused", _word(ack.result))

    def on_time(self, now_s: float) -> tuple[list[Mavlink], list[Answer]]:
        """Return what is to be sent now, and what nobody has answered."""
        if self._sent is not None:
            if now_s < self._sent.again_s:
                return [], []
            if self._sent.tries < _TRIES:
                return [self._send(self._sent.command, self._sent.tries, now_s)], []
            unanswered = [Answer(self._sent.command, "unanswered")]
            self._sent = None
            return [], unanswered
        if not self._waiting:
            return [], []
        return [self._send(self._waiting.popleft(), 0, now_s)], []

    def _send(self, command: Command, tries: int, now_s: float) -> Mavlink:
        self._sent = _Sent(command, tries + 1, now_s + _RETRY_S)
        parameters = (*command.parameters, *[0.0] * 7)[:7]
        return mavlink.MAVLink_command_long_message(*self._to, command.number, tries, *parameters)


def _word(result: int) -> str:
    entry = mavlink.enums["MAV_RESULT"].get(result)
    return entry.name.removeprefix("MAV_RESULT_") if entry else f"result {result}"
