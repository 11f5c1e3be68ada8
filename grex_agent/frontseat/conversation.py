"""The conversation with one autopilot: clock, streams, position, control, set-points. Pure; see `FrontseatCore`."""

from collections.abc import Callable

from grex_agent.frontseat.belief import Belief
from grex_agent.frontseat.commands import Answer, Command, Commander
from grex_agent.frontseat.control import ARM, HOLD, MODE, Control
from grex_agent.frontseat.dialect import Mavlink, is_signed, mavlink
from grex_agent.frontseat.families import describe
from grex_agent.frontseat.families.table import Family
from grex_agent.frontseat.feeding import RATE_HZ, Feeder
from grex_agent.frontseat.navigation import Navigation
from grex_agent.frontseat.outputs import Estimate, Note, Output, warn
from grex_agent.frontseat.silence import Silence
from grex_agent.frontseat.steering import Steering
from grex_agent.frontseat.streams import Streams
from grex_agent.frontseat.texts import StatusTexts
from grex_agent.frontseat.timekeeping import Timekeeper
from grex_agent.frontseat.timesync import BootClock
from grex_link.config import DatumConfig, MavlinkFrontseat
from grex_link.messages import Setpoint

_SYNC_S = 1.0
#: Words of the autopilot that come this close to a refusal are its reason.
_WORDS_S = 3.0
_VERSION, _ORIGIN = "version", "origin"


class Conversation:
    """See the module's docstring. Times are ours, seconds.

    Parameters
    ----------
    config : MavlinkFrontseat
        Whom to speak to, and what is allowed.
    datum : DatumConfig or None
        Origin of the mission frame; None for who only looks.
    family : Family
        What the autopilot is.
    source : tuple of int
        Its system and component.
    pace : float
        How fast its clock is expected to run.
    unix_offset_ns : int
        Wall time minus the time that is given here.

    Attributes
    ----------
    muted : str
        Why nothing but heartbeats may be sent; empty when all is well.
    keyless : bool
        Whether its messages are signed and ours are not.
    """

    def __init__(
        self,
        config: MavlinkFrontseat,
        datum: DatumConfig | None,
        family: Family,
        source: tuple[int, int],
        pace: float,
        unix_offset_ns: int,
    ) -> None:
        self.family = family
        self.source = source
        self.muted = ""
        self.time = Timekeeper(pace)
        self.streams = Streams(family)
        self.navigation = Navigation(datum, needs_gps=config.feed != "vision", under_water=family.under_water)
        self.control = Control(family, may_arm=config.arm)
        self.texts = StatusTexts()
        self.feeder = None if config.feed == "none" or datum is None else Feeder(config.feed, datum, unix_offset_ns)
        self.version = ""
        self._config = config
        self._commander = Commander(*source, config.own_system, config.own_component)
        self._steering = Steering(family, source, config.setpoint_age_max_s)
        self.keyless = False
        self._silence = Silence()
        self._belief = Belief()
        self._due = dict.fromkeys(("setpoint", "sync", "feed"), -1e9)

    @property
    def clock(self) -> BootClock:
        """The autopilot's seconds since boot."""
        return self.time.clock

    @property
    def rate(self) -> float:
        """Seconds of the autopilot in one of ours."""
        return self.clock.rate

    # -- what comes in ------------------------------------------------------------------------------------------

    def on_first_heartbeat(self, message: Mavlink, now_s: float) -> list[Output]:
        """Begin."""
        self._ask_version()
        title = f"found {self.family.title} ({describe(message)}), system {self.source[0]}"
        return [Note(title), *self._check_feed(), *self.on_message(message, now_s)]

    def ask(self, command: Command) -> None:
        """Ask the autopilot for something, when there is nothing more urgent."""
        self._commander.ask(command)

    def on_start(self, from_s: float) -> None:
        """Begin the mission; see `FrontseatCore.on_start`."""
        self._steering.start(from_s)

    def on_setpoint(self, setpoint: Setpoint, now_s: float) -> list[Output]:
        """Take what the agent wants; sent at once, so that it is not older than it must be."""
        self._steering.on_setpoint(setpoint, now_s)
        return self._send_setpoint(now_s)

    def on_message(self, message: Mavlink, now_s: float) -> list[Output]:
        """Take a message of the autopilot."""
        if self.time.is_echo(message):
            return []
        notes: list[Output] = [*self._silence.on_message(now_s)]
        kind = message.get_type()
        self.streams.on_message(kind)
        notes += self._on_boot_time(message, now_s)
        if self.time.doubtful and hasattr(message, "time_boot_ms"):
            return notes
        self.navigation.on_message(message, now_s, self.clock)
        handler = self._HANDLERS.get(kind)
        return notes if handler is None else notes + handler(self, message, now_s)

    # -- what is due --------------------------------------------------------------------------------------------

    def on_time(self, now_s: float) -> list[Output]:
        """Do what is due."""
        out: list[Output] = [*self._silence.look(now_s, self.rate), *self.texts.on_time(now_s), *self._doubts(now_s)]
        if self._silence.linked and not self.muted:
            out += self._talk(now_s)
            out += self._send_due(now_s)
        return out

    def estimate(self, at_s: float, now_s: float) -> Estimate:
        """Find where the craft is at a time that has just passed."""
        if self.muted:
            return Estimate(reason=self.muted)
        return self.navigation.at(at_s, now_s, self.rate)

    def waits_for(self, now_s: float) -> str:
        """Say what is missing before the mission may start."""
        if self.muted:
            return self.muted
        if not self._silence.linked:
            return "the autopilot is silent"
        estimate = self.estimate(now_s, now_s)
        if not estimate.valid:
            if self.navigation.misplaced:
                return f"no valid position: {estimate.reason}"
            said = f'; it says "{self.texts.last}"' if self.texts.last else ""
            return f"no valid position: {estimate.reason}{said}{self._key_is_missing}"
        missing = self.control.waits_for if self._config.arm else ""
        return missing and missing + self._key_is_missing

    @property
    def _key_is_missing(self) -> str:
        return "; its messages are signed and ours are not: name its key in signing_key_file" if self.keyless else ""

    # -- talk ---------------------------------------------------------------------------------------------------

    def _talk(self, now_s: float) -> list[Output]:
        """Control and streams ask, the commander sends."""
        valid = self.navigation.at(now_s, now_s, self.rate).valid
        fresh, lost = self._steering.fresh(now_s, self.rate), self._belief.lost(now_s, self.rate)
        commands, notes = self.control.step(now_s, position=valid, fresh=fresh, lost=lost)
        for command in commands:
            self._commander.ask(command, urgent=True)
        for command in self.streams.due(now_s, self.rate):
            self._commander.ask(command)
        if self.feeder is not None and self.feeder.needs_origin:
            self._commander.ask(_request(_ORIGIN, mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN))
        messages, unanswered = self._commander.on_time(now_s)
        return [*notes, *messages, *(note for answer in unanswered for note in self._on_answer(answer, now_s))]

    def _send_due(self, now_s: float) -> list[Output]:
        out: list[Output] = []
        if self._is_due("sync", _SYNC_S, now_s):
            out.append(self.time.question(now_s))
        if self._is_due("setpoint", 1.0 / self._config.setpoint_rate_hz, now_s):
            out += self._send_setpoint(now_s)
        if self.feeder is not None and self._is_due("feed", 1.0 / RATE_HZ, now_s):
            message = self.feeder.due(now_s, self.rate)
            out += [] if message is None else [message]
        return out

    def _is_due(self, what: str, every_s: float, now_s: float) -> bool:
        """Whether something is due that happens every so many seconds of the autopilot."""
        if now_s < self._due[what]:
            return False
        step_s = every_s / self.rate
        # Steady, but nothing is made up for.
        self._due[what] = max(self._due[what] + step_s, now_s + step_s / 2.0)
        return True

    def _send_setpoint(self, now_s: float) -> list[Output]:
        """Send the set-point in force; none to an autopilot that somebody else has, or when the agent is stale."""
        if (
            not self.control.streams
            or self.muted
            or not self._silence.linked
            or not self._steering.fresh(now_s, self.rate)
        ):
            return []
        return [self._steering.message(self.navigation, self.clock, now_s)]

    # -- what the messages say ----------------------------------------------------------------------------------

    def _on_heartbeat(self, message: Mavlink, now_s: float) -> list[Output]:
        armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        self.keyless = is_signed(message) and self._config.signing_key_file is None
        return [*self.control.on_heartbeat(message.custom_mode, now_s, armed=armed)]

    def _on_ack(self, message: Mavlink, now_s: float) -> list[Output]:
        answer = self._commander.on_ack(message, now_s)
        return [] if answer is None else self._on_answer(answer, now_s)

    def _on_answer(self, answer: Answer, now_s: float) -> list[Output]:
        if self.streams.is_mine(answer):
            return [*self.streams.on_answer(answer, self.source)]
        if answer.command.purpose in {MODE, ARM, HOLD}:
            why = self.texts.last if now_s - self.texts.last_s <= _WORDS_S else ""
            return [*self.control.on_answer(answer, now_s, why)]
        if answer.command.purpose == _ORIGIN and answer.status != "accepted" and self.feeder is not None:
            return [self.feeder.origin(self.source[0])]
        return []

    def _on_timesync(self, message: Mavlink, now_s: float) -> list[Output]:
        return [*self.time.on_timesync(message, now_s)]

    def _on_date(self, message: Mavlink, now_s: float) -> list[Output]:
        del now_s
        return [*self.time.on_date(message)]

    def _on_text(self, message: Mavlink, now_s: float) -> list[Output]:
        return [*self.texts.on_message(message, now_s)]

    def _on_version(self, message: Mavlink, now_s: float) -> list[Output]:
        del now_s
        number = message.flight_sw_version
        known, self.version = self.version, ".".join(str(number >> shift & 0xFF) for shift in (24, 16, 8))
        return [] if known else [Note(f"its version is {self.version}")]

    def _on_origin(self, message: Mavlink, now_s: float) -> list[Output]:
        del now_s
        if self.feeder is not None:
            self.feeder.on_origin(message)
        return []

    _HANDLERS: dict[str, Callable[["Conversation", Mavlink, float], list[Output]]] = {  # noqa: RUF012 - constant
        "HEARTBEAT": _on_heartbeat,
        "COMMAND_ACK": _on_ack,
        "TIMESYNC": _on_timesync,
        "SYSTEM_TIME": _on_date,
        "STATUSTEXT": _on_text,
        "AUTOPILOT_VERSION": _on_version,
        "GPS_GLOBAL_ORIGIN": _on_origin,
    }

    # -- boot, link, belief -------------------------------------------------------------------------------------

    def _on_boot_time(self, message: Mavlink, now_s: float) -> list[Output]:
        finding = self.time.see(message, now_s)
        if finding == "duplicate":
            return self._mute(f"two autopilots have system id {self.source[0]}: give one of them another one")
        if finding == "reboot":
            self._begin_anew()
            return [warn("the autopilot has booted: its message rates are asked for again")]
        return [warn("the autopilot's clock has jumped: its time is measured anew")] if finding == "jump" else []

    def _begin_anew(self) -> None:
        self._steering.reset()
        self.streams.reset()
        self.navigation.reset()
        self.control.on_reboot()
        self._commander.clear()
        self._ask_version()

    def _mute(self, why: str) -> list[Output]:
        if self.muted:
            return []
        self.muted = why
        return [warn(why)]

    def _check_feed(self) -> list[Output]:
        feed = self._config.feed
        if feed in {"none", *self.family.feeds}:
            return []
        return self._mute(f'{self.family.title} has no use for feed = "{feed}"; it takes "{self.family.feeds[0]}"')

    def _doubts(self, now_s: float) -> list[Output]:
        """Say when the position becomes valid, and when it is no longer, and why."""
        estimate = self.navigation.at(now_s, now_s, self.rate)
        misplaced = estimate.reason == self.navigation.misplaced != ""
        return [*self._belief.look(estimate, now_s, linked=self._silence.linked, misplaced=misplaced)]

    def _ask_version(self) -> None:
        self._commander.ask(_request(_VERSION, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION))


def _request(purpose: str, number: int) -> Command:
    return Command(purpose, mavlink.MAV_CMD_REQUEST_MESSAGE, (float(number),))
