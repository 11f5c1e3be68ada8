"""The messages on the bus, one Struct each; units and frames are in the field docs.

Frame: NED about the mission datum – north, east and down in metres, angles in radians clockwise from north.
Mission time is integer nanoseconds since the start of the mission. A *tick* is the number of a step of the team.
"""

from typing import Literal

import msgspec

from grex_link.tasks import Task


class Message(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=False):
    """Base of everything that travels on the bus."""


class Fix(Message, frozen=True):
    """Frontseat → agent: where the craft is, as its own navigation knows it."""

    tick: int
    t_ns: int
    """Mission time at which the fix was valid."""
    north_m: float
    east_m: float
    down_m: float
    heading_rad: float
    """Direction of the bow, [-π, π)."""
    speed_mps: float
    """Speed through the water."""
    sigma_m: float
    """Standard deviation claimed for each horizontal axis."""
    valid: bool = True
    reason: str = ""
    """Why it is not valid, for a person."""
    modem_events: int = 0
    """Lockstep: how many modem events the agent must have, counted from the start, before it may act on this."""


class Setpoint(Message, frozen=True):
    """Agent → frontseat: what the craft should do until the next one."""

    tick: int
    t_ns: int
    mode: Literal["steer", "hold"]
    """``steer``: follow course, speed and depth. ``hold``: stop and keep the depth."""
    course_rad: float
    """Wanted course over ground."""
    speed_mps: float
    """Wanted speed over ground."""
    depth_m: float
    transmissions: int = 0
    """How many transmissions the agent has requested since the start, this step's included."""


#: Destination of what is for everyone who hears it.
BROADCAST = ""


class Transmit(Message, frozen=True, tag="transmit"):
    """Agent → modem: send one datagram."""

    seq: int
    """Number of the request, counted from 0 for each craft; also its ticket."""
    t_ns: int
    """When the transmission shall start (the opening of the slot), by the craft's clock."""
    payload: bytes
    destination: str = BROADCAST
    acknowledge: bool = False
    """Ask the one destination for an acknowledgement."""
    by_land: bool = False
    """Over cable or radio, to all craft that are linked by one with this craft, or to the destination among them."""


class RangeRequest(Message, frozen=True, tag="range"):
    """Agent → modem: measure the distance to another craft by asking it to answer."""

    seq: int
    """Numbered together with the transmissions."""
    t_ns: int
    destination: str


Request = Transmit | RangeRequest


class Received(Message, frozen=True, tag="received"):
    """Modem event: a datagram has arrived whole. What the modem does not measure is None."""

    source: str
    payload: bytes
    destination: str = BROADCAST
    rssi_db: float | None = None
    """Received level, dB re 1 µPa."""
    snr_db: float | None = None
    relative_speed_mps: float | None = None
    """Rate of change of the distance; negative when coming nearer."""
    one_way_s: float | None = None
    """Arrival by the own clock minus departure by the sender's; modulo the modem's ambiguity, if it has one."""


class TxEvent(Message, frozen=True, tag="tx_event"):
    """Modem event: what became of an own request.

    ``SENT`` says that it has left, never that anybody has it: a broadcast has no acknowledgement.
    """

    ticket: int
    status: Literal["QUEUED", "IN_PROGRESS", "SENT", "DELIVERED", "FAILED"]
    """``DELIVERED``: the destination has acknowledged it."""
    reason: str = ""
    """Why it failed: busy, size, address, expired, superseded, overflow, no_ack, off, error."""


class BadFrame(Message, frozen=True, tag="bad_frame"):
    """Modem event: something was heard that could not be decoded."""

    reason: str = "corrupt"


class RangeResult(Message, frozen=True, tag="range_result"):
    """Modem event: a measured range, or that there was no answer."""

    ticket: int
    destination: str
    range_m: float | None
    """Metres at the nominal speed of sound; None if nobody answered."""


class ModemStatus(Message, frozen=True, tag="status"):
    """Modem event: how the modem is."""

    state: Literal["ready", "off", "rebooted", "error"]
    detail: str = ""


Happening = Received | TxEvent | BadFrame | RangeResult | ModemStatus


class ModemEvent(Message, frozen=True):
    """Modem → agent: one event, numbered for each craft from 0 in the order of its time."""

    seq: int
    t_ns: int
    """By the craft's clock."""
    event: Happening


class MateBelief(Message, frozen=True):
    """What a craft believes about one team mate."""

    craft: str
    north_m: float
    east_m: float
    progress: float
    """Track number plus degree of execution Θ (eq. 1)."""
    sigma_m: float
    """Standard deviation of each horizontal axis; 0 when the estimator claims none."""
    age_s: float
    """Age of the newest information in it, seconds; -1 when there has been none."""


class PlaceBelief(Message, frozen=True):
    """Where a craft is, as some agent believes, with the covariance it claims."""

    craft: str
    north_m: float
    east_m: float
    covariance_m2: tuple[float, float, float]
    """Variance north, variance east, and their covariance, m²."""


class AgentState(Message, frozen=True):
    """Agent → bench: what the agent believes and does; nothing aboard reads it."""

    tick: int
    t_ns: int
    track: int
    theta: float
    """Degree of execution of the present track (eq. 1)."""
    xte_m: float
    """Cross-track error, starboard positive, by the own navigation."""
    planned_mps: float
    ordered_mps: float
    quality: float
    """Q_m = Σ (Θ_i − Θ_m), cumulative Θ (eq. 3)."""
    mates: list[MateBelief]
    health: list[str]
    """Empty when all is well; otherwise words such as ``stale_fix``."""
    bad_frames: int
    """Datagrams since the start that were no team state of a mate."""
    places: list[PlaceBelief] = []
    """Its own position; of a base, that of the craft it watches. Empty while it knows none."""
    modem_events: int = 0
    """Modem events since the start that this step and those before it had: what a replay has to give it."""


class AgentStates(Message, frozen=True):
    """Agent → bench: one or several states, oldest first; in lockstep they are sent in bundles."""

    states: list[AgentState]


class TaskOrder(Message, frozen=True):
    """Operator → agent of the craft he is on: see that a craft does a task."""

    order: str
    """Name of this order, new for each; one that comes twice is one."""
    craft: str
    """Who shall do it."""
    task: Task


class TaskNews(Message, frozen=True):
    """Agent → bench and operator: what becomes of a task, aboard or on another craft."""

    t_ns: int
    """By the craft's clock."""
    order: str
    """Name of the order, or of the event; for one that came by sound, its sender and number."""
    craft: str
    """Who is to do it."""
    task: Task
    status: Literal[
        "queued", "on_air", "echoed", "started", "done", "returned", "interrupted", "refused", "failed"
    ]  # fmt: skip
    """Its sender: ``queued``, ``on_air`` (sent for the first time), ``echoed``, then what the echo says, or ``failed``
    (no echo). Who does it: ``started`` or ``refused``, ``done`` or ``interrupted``, ``returned``."""
    detail: str = ""
    """Why, for a person."""


class Pose(Message, frozen=True):
    """The true state of one craft."""

    craft: str
    north_m: float
    east_m: float
    down_m: float
    roll_rad: float
    pitch_rad: float
    heading_rad: float
    surge_mps: float


class Truth(Message, frozen=True):
    """The sea → link, recorder and score: the true poses, in the order of the team."""

    tick: int
    t_ns: int
    poses: list[Pose]


class Step(Message, frozen=True):
    """One tick of the sea, and how many transmissions each craft has requested up to it."""

    truth: Truth
    transmissions: list[int]


class Advance(Message, frozen=True):
    """Lockstep, hub → link: ticks that are complete, in order."""

    steps: list[Step]


class LinkEvent(Message, frozen=True):
    """One line of the medium's log: a transmission that started or was refused, or its outcome at one receiver."""

    t_ns: int
    """True mission time."""
    kind: Literal["started", "delivered", "overheard", "lost", "refused"]
    """``overheard``: whole, but for somebody else."""
    source: str
    seq: int
    """Number of the request that caused it."""
    destination: str = ""
    """Receiver; empty where the event concerns the sender only."""
    size_bytes: int = 0
    reason: str = ""
    """Why it was lost: out_of_range, missed_snr, missed_busy, missed_halfduplex, missed_off, aborted_own_tx,
    aborted_off, lost_cut (the modem of the sender went off), lost_collision, lost_noise, lost_burst, lost_land; or why
    it was refused: busy, size, address, error, off."""
    purpose: Literal["data", "ping", "answer", "ack", "land"] = "data"
    asked_by: str = ""
    """Whose request an answer or an acknowledgement answers."""
    lasting_ns: int = 0
    """``started``: airtime. ``delivered``: from the start until the payload is out."""
    sinr_db: float | None = None
    """Lowest SINR of a packet the receiver was locked to."""


class PortLedger(Message, frozen=True):
    """One craft's modem port since the start: requested = refused + superseded + expired + queued + started."""

    t_ns: int
    """By the craft's clock."""
    requested: int
    refused: dict[str, int]
    """By reason: size, address, overflow."""
    superseded: int
    expired: int
    queued: int
    """Waiting now."""
    started: int
    """Handed to the modem, all fragments."""
    failed: dict[str, int]
    """Of those started, what the modem then said had failed, by reason."""
    slots_owned: int
    slots_used: int
    slots_skipped: int
    reassembled: int
    """Payloads put together from fragments."""
    abandoned: int
    """Payloads of which fragments were missing for too long."""
    bad_frames: int
    """What the modem could not decode."""


class SourceLedger(Message, frozen=True):
    """One craft's transmissions since the start, its modem's own answers included."""

    craft: str
    started: int
    """Under water, all purposes."""
    refused: dict[str, int]
    """Requests, by reason."""
    airtime_s: float
    """Under water, as are the bytes."""
    bytes_sent: int
    purposes: dict[str, int]
    """Of those started: data, ping, answer, ack."""
    by_land: int
    """Over cable or radio, counted for each craft they go to."""
    land_requests: int
    """Requests that these were."""
    oldest_on_the_way_s: float
    """Age of the oldest transmission that has not had its outcome everywhere; 0 if there is none."""


class PathLedger(Message, frozen=True):
    """One directed link since the start: every transmission of the source has one outcome here, or is on its way."""

    source: str
    destination: str
    delivered: int
    overheard: int
    lost: dict[str, int]
    """By reason, see `LinkEvent`."""
    on_the_way: int
    latency_counts: list[int]
    """Deliveries by latency; the edges of the bins are `grex_link.ledger.EDGES_S`."""
    latency_mean_s: float
    """From the start of the transmission until the payload is out; -1 as long as nothing has been delivered."""
    age_seconds: list[float]
    """Seconds of the mission by age of information, same bins; from the first delivery on."""
    age_mean_s: float
    """Mean age of information, the time since the newest datagram that has arrived was sent; -1 before there is one."""
    sent: int
    """Transmissions of the source that have their outcome here or will have."""


class LinkLedger(Message, frozen=True):
    """Link → bench: everything that happened in the water since the start."""

    t_ns: int
    sources: list[SourceLedger]
    paths: list[PathLedger]


class LinkReport(Message, frozen=True):
    """Link → hub: what has become final in the water."""

    through_tick: int
    """Lockstep: the newest tick this answers; -1 at live paces."""
    modem_events: list[list[int]]
    """For each craft, the mission times (ns) of the modem events published since the last report."""
    log: list[LinkEvent]


class Clock(Message, frozen=True):
    """Hub → everyone: the mission starts, or is over."""

    phase: Literal["start", "bye"]
    epoch_unix_ns: int = 0
    """Live paces: wall time of mission time zero."""
    reason: str = ""
    """Why the mission is over before its time; empty when all went well."""
    t_ns: int = 0
    """``bye``: mission time at which it is over."""


class RunStatus(Message, frozen=True):
    """Hub → whoever watches, about once a wall second: what is run, and how the pace is kept."""

    t_ns: int
    scenario: str
    """The whole scenario, as JSON."""
    everybody: list[str]
    """Places of all who take part, besides the simulator."""
    late_ticks: int
    late_setpoints: int


class Presence(Message, frozen=True):
    """The bus → hub and agents: somebody has appeared or is gone (a liveliness token, not a topic)."""

    who: str
    alive: bool
    scenario: str
    """Fingerprint of the scenario that participant runs."""
