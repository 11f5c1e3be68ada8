"""The bus: Zenoh between processes. The only module that knows Zenoh.

The simulator's session is the router (no daemon is needed), all others are clients with explicit endpoints. Multicast
scouting, gossip and shared memory are off. A participant declares its subscribers first and its liveliness token last,
so whoever sees the token knows that nothing put from then on is missed.
"""

import json
import os
import queue
import random
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from types import TracebackType
from typing import Any, NamedTuple, Self

# One Rust receive thread is enough and wakes faster; read when zenoh opens its first session.
os.environ.setdefault("ZENOH_RUNTIME", "(rx:(worker_threads:1))")

import msgspec
import zenoh

from grex_link import clock, log
from grex_link.config import ClockConfig, Scenario
from grex_link.errors import BusError, ConfigError
from grex_link.messages import Message, Presence
from grex_link.node import Node
from grex_link.scenario import fingerprint
from grex_link.topics import TOPICS, Role, is_presence, key, presence_key, subscriptions

DEFAULT_ENDPOINTS = ("tcp/127.0.0.1:7447",)
_RETRY_S = 0.1
#: After this long without a sign a link is taken for dead. A killed process is known at once: its socket closes.
_LEASE_MS = 5000
#: A listener that is too slow holds no more than so many messages.
_HEARD_MAX = 50_000

#: (topic, craft, message)
Envelope = tuple[str, str, Any]


def session_config(
    *, router: bool, endpoints: Sequence[str], lockstep: bool, connect_timeout_s: float = 1.0
) -> zenoh.Config:
    """Session configuration of a participant; see the module's docstring.

    In lockstep a slow reader stalls the writer for as long as it takes, at live paces for half a second at most.
    """
    config: dict[str, Any] = {
        "mode": "router" if router else "client",
        "listen": {"endpoints": list(endpoints) if router else []},
        "connect": {"endpoints": []},
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": {
            "shared_memory": {"enabled": False},
            "link": {
                "tx": {
                    "lease": _LEASE_MS,
                    "queue": {
                        "congestion_control": {"block": {"wait_before_close": 600_000_000 if lockstep else 500_000}}
                    },
                }
            },
        },
    }
    if not router:
        config["connect"] = {
            "endpoints": list(endpoints),
            "timeout_ms": int(connect_timeout_s * 1000),
            "exit_on_failure": True,
            "retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2},
        }
    return zenoh.Config.from_json5(json.dumps(config))


def open_session(scenario: Scenario, *, router: bool) -> zenoh.Session:
    """Open a session, waiting for the router if this is a client.

    Raises
    ------
    ConfigError
        If the endpoint cannot be listened on, or nobody answers there within the start timeout.
    """
    endpoints = scenario.bus.endpoints or DEFAULT_ENDPOINTS
    where = ", ".join(endpoints)
    config = session_config(router=router, endpoints=endpoints, lockstep=scenario.clock.lockstep)
    deadline = clock.monotonic_s() + scenario.clock.start_timeout_s
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError:
            if router:
                problem = f"cannot listen on {where}: the port is in use, or the address is not of this machine"
                raise ConfigError("$.bus.endpoints", problem) from None
            if clock.monotonic_s() > deadline:
                problem = f"nobody answers at {where}; start the simulator, or correct the endpoint"
                raise ConfigError("$.bus.endpoints", problem) from None
            clock.sleep_s(_RETRY_S)


class Session:
    """A place on the bus below the topics: keys and bytes.

    Zenoh hands samples to one queue through a thread of its own a subscriber; that costs less than callbacks on Zenoh's
    receive thread, and the order between keys, which nobody relies on, is open. These threads end with `close` only: a
    session that is not closed keeps the interpreter from ending.

    Parameters
    ----------
    scenario : Scenario
        Names the endpoints and the pace.
    router : bool
        Whether this is the hub, which listens; all others connect.
    """

    def __init__(self, scenario: Scenario, *, router: bool) -> None:
        self._inbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._block = scenario.clock.lockstep
        self._session = open_session(scenario, router=router)
        self._declared: list[Any] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def subscribe(self, key_expression: str) -> None:
        """Receive what others put there."""
        self._declared.append(
            self._session.declare_subscriber(key_expression, self._inbox.put, allowed_origin=zenoh.Locality.REMOTE)
        )

    def appear(self, token: str, watched: str) -> None:
        """Hold a liveliness token and receive those of others; to be done last, when all subscribers are there."""
        liveliness = self._session.liveliness()
        self._declared.append(liveliness.declare_subscriber(watched, self._inbox.put, history=True))
        self._declared.append(liveliness.declare_token(token))

    def publisher(
        self, key_expression: str, *, flush: bool = True, must_arrive: bool = True
    ) -> Callable[[bytes], None]:
        """Return a function that puts bytes there; in lockstep nothing is ever dropped."""
        control = zenoh.CongestionControl
        publisher = self._session.declare_publisher(
            key_expression,
            express=flush,
            congestion_control=control.BLOCK if self._block or must_arrive else control.DROP,
        )
        return publisher.put

    @property
    def idle(self) -> bool:
        """Whether no sample is waiting."""
        return self._inbox.empty()

    def receive(self, timeout_s: float | None) -> zenoh.Sample | None:
        """Take the next sample, waiting `timeout_s` wall seconds at most; None if there was none."""
        try:
            sample: zenoh.Sample = self._inbox.get(timeout=timeout_s)
        except queue.Empty:
            return None
        return sample

    def close(self) -> None:
        """Leave the bus. A close that times out on a loaded machine is not worth an error."""
        try:
            self._session.close()  # type: ignore[no-untyped-call]
        except zenoh.ZError as error:
            log.warn("the bus did not close in time", error=str(error))


class ZenohBus(Session):
    """One participant's place on the bus between processes.

    Parameters
    ----------
    scenario : Scenario
        Names the team, the endpoints and the pace.
    role : str
        See `grex_link.topics`.
    who : str
        Its place, see `grex_link.topics.subscriptions`.
    present : bool
        Whether it is there at once; else it hears, and is seen by nobody before `announce`.

    Attributes
    ----------
    bad_payloads : Counter
        Messages that did not decode, by key; logged once each, and dropped.
    """

    def __init__(self, scenario: Scenario, role: Role, who: str, *, present: bool = True) -> None:
        super().__init__(scenario, router=role == "sim")
        self._team = scenario.team.name
        self._encode = msgspec.msgpack.Encoder().encode
        self._routes: dict[str, tuple[str, str, msgspec.msgpack.Decoder[Any]]] = {}
        self._publishers: dict[tuple[str, str], Callable[[bytes], None]] = {}
        self.bad_payloads: Counter[str] = Counter()
        try:
            for topic, craft in subscriptions(role, who):
                self.subscribe(key(self._team, topic, craft))
            watched = presence_key(self._team, "*" if role == "sim" else "sim", "*")
            self._tokens = presence_key(self._team, who, fingerprint(scenario)), watched
            if present:
                self.announce()
        except BaseException:
            self.close()
            raise

    def announce(self) -> None:
        """Let everybody see that this participant is there."""
        self.appear(*self._tokens)

    def put(self, topic: str, craft: str, message: Message) -> None:
        """Write a message to a topic. In lockstep it is never dropped."""
        put = self._publishers.get((topic, craft))
        if put is None:
            row = TOPICS[topic]
            name = key(self._team, topic, craft)
            put = self._publishers[topic, craft] = self.publisher(
                name, flush=row.flush, must_arrive=row.rate == "event"
            )
        put(self._encode(message))

    def take(self, timeout_s: float | None) -> Envelope | None:
        """Take the next message, waiting `timeout_s` wall seconds at most; None if there was none that decodes."""
        sample = self.receive(timeout_s)
        if sample is None:
            return None
        name = str(sample.key_expr)
        topic, craft, decoder = self._routes.get(name) or self._route(name)
        if topic == "presence":
            alive = sample.kind == zenoh.SampleKind.PUT
            return topic, craft, Presence(craft, alive, name.rpartition("/")[2])
        try:
            return topic, craft, decoder.decode(sample.payload.to_bytes())
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            self.bad_payloads[name] += 1
            if self.bad_payloads[name] == 1:
                log.warn("dropped a message that does not decode", key=name, error=str(error))
            return None

    def _route(self, name: str) -> tuple[str, str, msgspec.msgpack.Decoder[Any]]:
        below = name.removeprefix(f"grex/{self._team}/")
        craft, _, rest = below.partition("/")
        route = ("presence", rest.partition("/")[0], msgspec.msgpack.Decoder(Presence))
        for topic in TOPICS.values():
            if topic.key in {below, "{craft}/" + rest}:
                route = (topic.name, craft if topic.per_craft else "", msgspec.msgpack.Decoder(topic.type))
        self._routes[name] = route
        return route


class Heard(NamedTuple):
    """What somebody outside the run has heard: a message, or that a liveliness token has come or gone."""

    key: str
    payload: bytes
    alive: bool | None
    """None for a message."""


class Listener:
    """Hears what is on the bus and says nothing: it has no publishers, and no token that anybody could wait for.

    Parameters
    ----------
    endpoints : sequence of str
        Where the simulator listens.

    Attributes
    ----------
    dropped : int
        What came faster than it was taken, and found no room.

    Raises
    ------
    BusError
        If nobody answers there within two seconds.
    """

    def __init__(self, endpoints: Sequence[str] = DEFAULT_ENDPOINTS) -> None:
        where = ", ".join(endpoints)
        self._inbox: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
        self._declared: dict[str, Any] = {}
        self.dropped = 0
        try:
            config = session_config(router=False, endpoints=endpoints, lockstep=False, connect_timeout_s=2.0)
            self._session = zenoh.open(config)
        except zenoh.ZError:
            raise BusError(f"nobody answers at {where}; is a run on the bus there?") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def hear(self, key_expression: str) -> None:
        """Hear what is put there from now on; ``*`` and ``**`` stand for one part of a key and for many.

        Raises
        ------
        ConfigError
            If that is no key expression.
        """
        if key_expression not in self._declared:
            try:
                subscriber = self._session.declare_subscriber(key_expression, self._take_in)
            except zenoh.ZError as error:
                problem = str(error).partition(" at ")[0]
                raise ConfigError("KEY", f"{key_expression!r} is no key expression: {problem}") from None
            self._declared[key_expression] = subscriber

    def hear_presence(self, team: str = "*") -> None:
        """Hear of everybody who is there, comes or goes."""
        watched = presence_key(team, "*", "*")
        if watched not in self._declared:
            liveliness = self._session.liveliness()
            self._declared[watched] = liveliness.declare_subscriber(watched, self._inbox.put, history=True)

    def _take_in(self, sample: zenoh.Sample) -> None:
        if self._inbox.qsize() < _HEARD_MAX:
            self._inbox.put(sample)
        else:
            self.dropped += 1

    def take(self, timeout_s: float) -> Heard | None:
        """Take what was heard next, waiting so many wall seconds at most; None if there was nothing."""
        try:
            sample = self._inbox.get(timeout=timeout_s) if timeout_s > 0.0 else self._inbox.get_nowait()
        except queue.Empty:
            return None
        name, put = str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT
        if is_presence(name):
            return Heard(name, b"", put)
        return Heard(name, sample.payload.to_bytes(), None) if put else None

    def close(self) -> None:
        """Leave the bus."""
        with suppress(zenoh.ZError):
            self._session.close()  # type: ignore[no-untyped-call]


def serve(bus: ZenohBus, node: Node, config: ClockConfig) -> None:
    """Drive one node on its bus until it is done.

    Parameters
    ----------
    bus : ZenohBus
        Its place on the bus.
    node : Node
        The participant.
    config : ClockConfig
        Start timeout and chaos delay.

    Raises
    ------
    BusError
        If the mission has not started after twice the time that the simulator waits for everybody.
    """
    patience_s = 2.0 * config.start_timeout_s
    start_by = clock.monotonic_s() + patience_s
    while not node.done:
        if bus.idle and node.in_idle_time():
            continue
        wait_s = node.wall_s_to_deadline()
        if not node.started:
            left_s = start_by - clock.monotonic_s()
            if left_s < 0.0:
                raise BusError(f"the mission has not started for {patience_s:g} s; is the simulator still there?")
            wait_s = left_s if wait_s is None else min(wait_s, left_s)
        envelope = bus.take(wait_s)
        if config.chaos_delay_s:
            clock.sleep_s(random.uniform(0.0, config.chaos_delay_s))  # noqa: S311 - no result depends on it
        if envelope is not None:
            node.handle(*envelope)
        else:
            node.on_deadline()
