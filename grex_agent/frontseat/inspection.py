"""What of an autopilot is missing for GREX, and what a person should look at before trusting it with a craft. Pure.

Missing is that without which no mission starts. Advice is what stops the craft when something fails, or should.
"""

from grex_agent.frontseat.commands import Command
from grex_agent.frontseat.conversation import Conversation
from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.outputs import Output
from grex_agent.frontseat.parameters import ParameterReader

#: Below this share of the rate that was asked for a stream is too rare.
_TOO_RARE = 0.5
_PREARM = mavlink.MAV_SYS_STATUS_PREARM_CHECK
#: While it has none its origin is asked for this often, seconds.
_ORIGIN_S = 2.0
_RUN_PREARM_CHECKS = 401


class Inspection:
    """Asks an autopilot for what a conversation does not need, and judges it all.

    Parameters
    ----------
    peer : Conversation
        With the autopilot.
    own_system : int
        Our system id.
    """

    def __init__(self, peer: Conversation, own_system: int) -> None:
        self._peer = peer
        self._own_system = own_system
        names = [peer.family.frame.name, *(setting.name for setting in peer.family.settings)]
        self._reader = ParameterReader(names, peer.source, bytewise=peer.family.bytewise)
        self._checks: bool | None = None
        self._complaints: dict[str, None] = {}
        self.origin: tuple[float, float] | None = None
        self._origin_at_s = -1e9
        peer.ask(Command("state", *_request(mavlink.MAVLINK_MSG_ID_SYS_STATUS)))
        # It only says what would refuse arming; nothing is armed.
        peer.ask(Command("checks", _RUN_PREARM_CHECKS))

    @property
    def done(self) -> bool:
        """Whether every parameter has been read, or asked for in vain."""
        return self._reader.done

    @property
    def frame(self) -> str:
        """What kind of craft it takes itself to be on."""
        frame = self._peer.family.frame
        return frame.describe(self._reader.values.get(frame.name))

    def on_message(self, message: Mavlink) -> None:
        """Take a message, whoever sent it."""
        if (message.get_srcSystem(), message.get_srcComponent()) != self._peer.source:
            return
        kind = message.get_type()
        if kind == "PARAM_VALUE":
            self._reader.on_message(message)
        elif kind == "SYS_STATUS" and message.onboard_control_sensors_enabled & _PREARM:
            self._checks = bool(message.onboard_control_sensors_health & _PREARM)
        elif kind == "GPS_GLOBAL_ORIGIN" and (message.latitude or message.longitude):
            self.origin = message.latitude / 1e7, message.longitude / 1e7
        elif kind == "STATUSTEXT" and message.text.lower().startswith(("prearm:", "arm:", "preflight fail:")):
            self._complaints[message.text] = None

    def due(self, now_s: float) -> list[Output]:
        """Return what is to be asked now."""
        if self.origin is None and now_s >= self._origin_at_s:
            self._origin_at_s = now_s + _ORIGIN_S
            self._peer.ask(Command("origin of the probe", *_request(mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN)))
        return [*self._reader.due(now_s)]

    def missing(self, now_s: float) -> list[str]:
        """Return what no mission can start without, and what to do about each."""
        peer = self._peer
        if peer.muted:
            return [peer.muted]
        found = [f"message {name} does not come: {self._why_silent}" for name in peer.streams.missing()]
        estimate = peer.navigation.at(now_s, now_s, peer.rate)
        if not estimate.valid and estimate.reason == peer.navigation.misplaced:
            found.append(f"a craft near the datum: {estimate.reason}")
        elif not estimate.valid:
            found.append(f"a valid position: {estimate.reason}; {self._how_to_find_itself()}")
        return found

    def advice(self) -> list[str]:
        """Return what a person should look at, one line each."""
        values = self._reader.values
        settings = self._peer.family.settings
        lines = [each.advice(values[each.name], self._own_system) for each in settings if each.name in values]
        if self._checks is False:
            why = ", ".join(self._complaints) or "it does not say which; ask a ground station"
            lines.append(f"checks before arming are outstanding: {why}; put that right, or it will not arm")
        if settings and not values:
            lines.append("it answers no parameter, so its failsafes are unknown; look at them in a ground station")
        return [line for line in [*lines, *self._slow_streams()] if line]

    @property
    def _why_silent(self) -> str:
        if self._peer.keyless:
            return "it signs what it says, and obeys only what is signed; sign, or switch that off"
        if not self._reader.values:
            return (
                "it answers nothing; does SYSID_ENFORCE with another SYSID_MYGCS keep it from that, or goes the line "
                "one way only?"
            )
        return "it was asked for; has it an origin and a position yet?"

    def _how_to_find_itself(self) -> str:
        gps = self._peer.navigation.gps
        if gps is not None and gps[1] < mavlink.GPS_FIX_TYPE_3D_FIX:
            return "give its GPS a free view of the sky, or feed it positions (frontseat.feed)"
        if self.origin is None:
            return "its estimator has no origin yet; wait, some 40 s after power-on on an ArduPilot"
        return "wait for its estimator, and see what it says"

    def _slow_streams(self) -> list[str]:
        rates = self._peer.streams.rates
        return [
            f"{name} comes {rates[name]:.1f} times a second instead of {wanted:g}: another station asks for other "
            "rates, or the line is too slow"
            for name, wanted in self._peer.streams.wanted
            if 0.0 < rates.get(name, 0.0) < _TOO_RARE * wanted
        ]


def _request(number: int) -> tuple[int, tuple[float, ...]]:
    return mavlink.MAV_CMD_REQUEST_MESSAGE, (float(number),)
