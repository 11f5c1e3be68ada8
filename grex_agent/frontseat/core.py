"""The adapter as a pure core: MAVLink messages and set-points go in, MAVLink messages and words come out.

Before a heartbeat of the wanted autopilot there is nobody to speak to; from then on a `Conversation` with it does the
work. All times are ours and never jump; timeouts are in the autopilot's own seconds, which may run faster.
"""

from collections import deque

from grex_agent.frontseat.address import what_to_look_at
from grex_agent.frontseat.conversation import Conversation
from grex_agent.frontseat.dialect import Mavlink, mavlink
from grex_agent.frontseat.families import describe, family_of
from grex_agent.frontseat.outputs import Estimate, Output, warn
from grex_link.config import DatumConfig, MavlinkFrontseat
from grex_link.messages import Fix, Setpoint
from grex_link.units import NS

_HEARTBEAT_S = 1.0
#: Types of those who speak MAVLink and are no vehicle.
_NO_VEHICLE = frozenset(
    {
        mavlink.MAV_TYPE_GCS,
        mavlink.MAV_TYPE_ANTENNA_TRACKER,
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
        mavlink.MAV_TYPE_GIMBAL,
        mavlink.MAV_TYPE_ADSB,
        mavlink.MAV_TYPE_CAMERA,
        mavlink.MAV_TYPE_CHARGING_STATION,
        mavlink.MAV_TYPE_FLARM,
        mavlink.MAV_TYPE_SERVO,
        mavlink.MAV_TYPE_ODID,
        mavlink.MAV_TYPE_BATTERY,
        mavlink.MAV_TYPE_LOG,
        mavlink.MAV_TYPE_IMU,
        mavlink.MAV_TYPE_GPS,
        mavlink.MAV_TYPE_WINCH,
    }
)


class FrontseatCore:
    """One craft's adapter.

    Parameters
    ----------
    config : MavlinkFrontseat
        Whom to speak to, and what is allowed.
    datum : DatumConfig or None
        Origin of the mission frame; None for who only looks, wherever the craft is.
    pace : float
        How fast the autopilot's clock is expected to run.
    unix_offset_ns : int
        Wall time minus the time that is given here.

    Attributes
    ----------
    fault : str
        Why this can never work, in one line; empty when all is well.
    """

    def __init__(
        self, config: MavlinkFrontseat, datum: DatumConfig | None, pace: float = 1.0, unix_offset_ns: int = 0
    ) -> None:
        self._config = config
        self._datum = datum
        self._pace = pace
        self._unix_offset_ns = unix_offset_ns
        self._next_heartbeat_s = -1e9
        self._started_ns: int | None = None
        self._told: set[str] = set()
        self._others: set[int] = set()
        self._unfit = ""
        self._early: deque[Output] = deque()
        self.fault = ""
        self.peer: Conversation | None = None

    # -- what comes in ------------------------------------------------------------------------------------------

    def on_message(self, message: Mavlink, now_ns: int) -> list[Output]:
        """Take one MAVLink message, whoever sent it."""
        now_s = now_ns / NS
        source = message.get_srcSystem(), message.get_srcComponent()
        if source == (self._config.own_system, self._config.own_component):
            return self._on_own_ids(message)
        if self.peer is None:
            return self._meet(message, now_s)
        return self.peer.on_message(message, now_s) if source == self.peer.source else []

    def on_start(self, from_ns: int) -> list[Output]:
        """Begin the mission: from a time on, which may be yet to come, an agent that has been silent is stale."""
        self._started_ns = from_ns
        if self.peer is not None:
            self.peer.on_start(from_ns / NS)
        return []

    def on_setpoint(self, setpoint: Setpoint, now_ns: int) -> list[Output]:
        """Take what the agent wants."""
        return [] if self.peer is None else self.peer.on_setpoint(setpoint, now_ns / NS)

    def on_navigation(self, fix: Fix, now_ns: int) -> list[Output]:
        """Take a position that is to be fed into the autopilot."""
        if self.peer is not None and self.peer.feeder is not None:
            self.peer.feeder.on_fix(fix, now_ns / NS, self.peer.rate)
        return []

    def on_time(self, now_ns: int) -> list[Output]:
        """Do what is due."""
        now_s = now_ns / NS
        out: list[Output] = []
        rate = self._pace if self.peer is None else self.peer.rate
        if now_s >= self._next_heartbeat_s:
            self._next_heartbeat_s = now_s + _HEARTBEAT_S / rate
            out.append(_heartbeat())
        return out if self.peer is None else out + self.peer.on_time(now_s)

    def release(self, now_ns: int) -> list[Output]:
        """Give the craft back to its autopilot, to hold; `released` says when that has happened."""
        if self.peer is None:
            return []
        self.peer.control.release()
        return self.on_time(now_ns)

    # -- what is known ------------------------------------------------------------------------------------------

    def estimate(self, at_ns: int, now_ns: int) -> Estimate:
        """Find where the craft is at a time that has just passed."""
        if self.peer is None:
            return Estimate(reason="no autopilot has been heard")
        if self.fault:
            return Estimate(reason=self.fault)
        return self.peer.estimate(at_ns / NS, now_ns / NS)

    def waits_for(self, now_ns: int) -> str:
        """Say what is missing before the mission may start; empty when nothing is."""
        if self.fault:
            return self.fault
        if self.peer is None:
            return self._nobody
        return self.peer.waits_for(now_ns / NS)

    @property
    def _nobody(self) -> str:
        """Whom we miss, and whom we hear instead."""
        wanted = self._config.system
        missing = "no heartbeat of an autopilot" + (f" with system id {wanted}" if wanted else "")
        missing += f" on {self._config.url}"
        if self._others:
            ids = f"id{'s' if len(self._others) > 1 else ''} {', '.join(map(str, sorted(self._others)))}"
            return f"{missing} (heard system {ids}: set frontseat.system, or the autopilot's SYSID_THISMAV)"
        return f"{missing} ({self._unfit})" if self._unfit else f"{missing}; {what_to_look_at(self._config.url)}"

    @property
    def released(self) -> bool:
        """Whether the craft has been given back."""
        return self.peer is None or self.peer.control.released

    @property
    def target_system(self) -> int | None:
        """System id of the autopilot, once it has been heard."""
        return None if self.peer is None else self.peer.source[0]

    # -- inside -------------------------------------------------------------------------------------------------

    def _meet(self, message: Mavlink, now_s: float) -> list[Output]:
        """Look for the heartbeat of the wanted vehicle; others have heartbeats, too."""
        if message.get_type() != "HEARTBEAT":
            return []
        system = message.get_srcSystem()
        if message.type in _NO_VEHICLE or message.autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            return []
        if self._config.system not in {None, system}:
            self._others.add(system)
            return self._once(f"heard system id {system}; waiting for {self._config.system}")
        family = family_of(message, self._config.family)
        if family is None:
            self._unfit = (
                f"{describe(message)}, system id {system}, is of no known family; "
                "if it takes velocity set-points as one of them does, name that in frontseat.family"
            )
            return self._once(self._unfit)
        source = system, message.get_srcComponent()
        self.peer = Conversation(self._config, self._datum, family, source, self._pace, self._unix_offset_ns)
        if self._started_ns is not None:
            self.peer.on_start(now_s)
        return [*self.peer.on_first_heartbeat(message, now_s)]

    def _on_own_ids(self, message: Mavlink) -> list[Output]:
        if message.get_type() != "HEARTBEAT" or self.fault:
            return []
        system, component = self._config.own_system, self._config.own_component
        self.fault = (
            f"somebody else on this link is system {system}, component {component}, which are our ids: "
            "give own_system or own_component another value, or stop the other one"
        )
        if self.peer is not None:
            self.peer.muted = self.fault
        return [warn(self.fault)]

    def _once(self, text: str) -> list[Output]:
        if text in self._told:
            return []
        self._told.add(text)
        return [warn(text)]


def _heartbeat() -> Mavlink:
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
    )
