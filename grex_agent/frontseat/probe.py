"""``grex frontseat --probe URL``: who answers there, how good its position is, and what is missing for GREX."""

from contextlib import closing

from grex_agent.frontseat.address import parse_url, what_to_look_at
from grex_agent.frontseat.connection import Connection
from grex_agent.frontseat.conversation import Conversation
from grex_agent.frontseat.core import FrontseatCore
from grex_agent.frontseat.dialect import Codec, mavlink
from grex_agent.frontseat.geodesy import say_distance
from grex_agent.frontseat.inspection import Inspection
from grex_agent.frontseat.outputs import Note
from grex_link import clock
from grex_link.config import DatumConfig, MavlinkFrontseat
from grex_link.errors import GrexError
from grex_link.units import NS

#: Wall seconds until nobody answers, and to look at whoever does.
_ANSWER_S = 10.0
_LOOK_S = 7.0
_LOOK_MAX_S = 12.0
_POLL_S = 0.01
_OWN = 255, 191


class Looker:
    """Takes in what an autopilot says, without ever asking for a mode or to arm.

    Parameters
    ----------
    connection : Connection
        The line.
    datum : DatumConfig or None
        Where the mission lies, if that is known; the craft should be near.
    """

    def __init__(self, connection: Connection, datum: DatumConfig | None = None) -> None:
        self._connection = connection
        self._datum = datum
        self._core = FrontseatCore(MavlinkFrontseat(url="probe:"), datum)
        self.inspection: Inspection | None = None
        self.said: list[str] = []
        self.kinds: set[str] = set()

    def look(self) -> None:
        """Exchange what there is now."""
        now_ns = round(clock.monotonic_s() * NS)
        out = []
        for message in self._connection.receive():
            self.kinds.add(message.get_type())
            out += self._core.on_message(message, now_ns)
            if self.inspection is not None:
                self.inspection.on_message(message)
        self._connection.target = self._core.target_system
        if self.peer is not None and self.inspection is None:
            self.inspection = Inspection(self.peer, _OWN[0])
        if self.inspection is not None:
            out += self.inspection.due(now_ns / NS)
        for item in [*out, *self._core.on_time(now_ns)]:
            if isinstance(item, Note):
                self.said.append(item.text)
            else:
                self._connection.send(item)

    @property
    def place(self) -> str:
        """Where the craft is on earth, and how far from the datum."""
        place = None if self.peer is None else self.peer.navigation.place
        if self.peer is None or place is None:
            return "it does not know"
        away = f", {say_distance(self.peer.navigation.away_m)} from the datum" if self._datum else ""
        return f"{place[0]:.6f}, {place[1]:.6f}{away}"

    @property
    def peer(self) -> Conversation | None:
        """The autopilot, once it has been heard."""
        return self._core.peer

    @property
    def fault(self) -> str:
        """Why it can never work."""
        return self._core.fault or (self.peer.muted if self.peer else "")


def look(url: str, datum: DatumConfig | None = None) -> None:
    """Say who answers at an address.

    Parameters
    ----------
    url : str
        The address.
    datum : DatumConfig or None
        Where the mission lies, if that is known; the craft should be near.

    Raises
    ------
    ConfigError
        If it is no address, or cannot be opened.
    GrexError
        If nobody answers, or something is missing for GREX.
    """
    connection = Connection(parse_url(url, "--probe"), Codec(*_OWN, None, clock.unix_ns()))
    with closing(connection):
        connection.open("--probe")
        looker = Looker(connection, datum)
        give_up_s = clock.monotonic_s() + _ANSWER_S
        while looker.peer is None and not looker.fault and clock.monotonic_s() < give_up_s:
            _wait(looker)
        if looker.peer is None or looker.inspection is None:
            raise GrexError(_nobody(url, connection, looker))
        since_s = clock.monotonic_s()
        while (passed_s := clock.monotonic_s() - since_s) < _LOOK_S or (
            passed_s < _LOOK_MAX_S and not looker.inspection.done
        ):
            _wait(looker)
        missing = _report(url, looker, looker.peer, looker.inspection)
    if missing:
        raise GrexError(f"{url}: missing for GREX: {'; '.join(missing)}")


def _wait(looker: Looker) -> None:
    clock.sleep_s(_POLL_S)
    looker.look()


def _nobody(url: str, connection: Connection, looker: Looker) -> str:
    if looker.fault:
        return f"{url}: {looker.fault}"
    if looker.said:
        return f"{url}: {looker.said[-1]}"
    if looker.kinds:
        return f"{url}: messages come ({', '.join(sorted(looker.kinds)[:5])}), but no heartbeat of an autopilot"
    if connection.garbage:
        return f"{url}: bytes come, but no MAVLink; is the baud rate right, and is the link signed?"
    if connection.trouble:
        return f"{url}: {connection.trouble}"
    return f"{url}: nobody answers; {what_to_look_at(url)}"


def _report(url: str, looker: Looker, peer: Conversation, inspection: Inspection) -> list[str]:
    """Print what was found, and return what is missing."""
    now_s = clock.monotonic_s()
    estimate = peer.navigation.at(now_s, now_s, peer.rate)
    mode = peer.family.mode_name(peer.control.mode)
    modes = ", ".join(peer.family.mode_name(number) for number in (peer.family.guided, *peer.family.holds))
    trip_s = peer.clock.round_trip_s
    lines = {
        "Found": looker.said[0].removeprefix("found ") if looker.said else peer.family.title,
        "Version": peer.version or "it does not say",
        "Frame": inspection.frame,
        "State": f"{mode}, {'armed' if peer.control.armed else 'disarmed'}",
        "Modes used": modes,
        "Position": _position(peer, estimate.sigma_m) if estimate.valid else f"not valid: {estimate.reason}",
        "Place": looker.place,
        "Origin": "{:.6f}, {:.6f}".format(*inspection.origin) if inspection.origin else "its estimator has none yet",
        "Clock": f"{peer.rate:.3f} of ours"
        + (f", round trip {trip_s * 1e3:.0f} ms" if trip_s is not None else ", no answer to TIMESYNC"),
        "Rates, Hz": ", ".join(f"{kind} {rate:.1f}" for kind, rate in peer.streams.rates.items()),
        "It says": f'"{peer.texts.last}"' if peer.texts.last else "nothing",
    }
    print(f"{url}")  # noqa: T201
    for name, words in lines.items():
        print(f"  {name:<11} {words}")  # noqa: T201
    missing = [looker.fault] if looker.fault else inspection.missing(now_s)
    for line in missing or ["nothing"]:
        print(f"  {'Missing':<11} {line}")  # noqa: T201
    for line in inspection.advice():
        print(f"  {'Warning':<11} {line}")  # noqa: T201
    return missing


def _position(peer: Conversation, sigma_m: float) -> str:
    gps = peer.navigation.gps
    fix = "no GPS" if gps is None else _fix_name(gps[1])
    depth = f", depth {peer.navigation.depth_m:.1f} m" if peer.family.under_water else ""
    return f"valid, to {sigma_m:.1f} m ({fix}){depth}"


def _fix_name(number: int) -> str:
    entry = mavlink.enums["GPS_FIX_TYPE"].get(number)
    return "GPS " + (entry.name.removeprefix("GPS_FIX_TYPE_").lower().replace("_", " ") if entry else str(number))
