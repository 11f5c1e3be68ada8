"""A run for Foxglove's own connection ("Foxglove WebSocket"): map, frames, scene; from the bus or a recording."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import foxglove
from foxglove.websocket import ServerListener

from grex_agent.mission import plan_mission
from grex_link import clock
from grex_link.config import Scenario
from grex_link.errors import BusError, ConfigError
from grex_link.messages import Truth
from grex_link.recording import Recording
from grex_link.units import NS
from grex_sim.foxglove_scene import Encoded, FoxgloveScene
from grex_sim.view.live import Live

_LOOK_S = 0.05
#: Mission seconds between two moments of a live run.
_APART_S = 0.1


class _Newcomers(ServerListener):
    """Remembers that somebody has begun to look."""

    def __init__(self) -> None:
        self.there = False

    def on_subscribe(self, *_: object) -> None:
        """Take note of a subscription."""
        self.there = True


class _Outlet:
    """Channels of the server, each with the schema of what goes through it."""

    def __init__(self, context: foxglove.Context, newcomers: _Newcomers) -> None:
        self._context = context
        self._newcomers = newcomers
        self._channels: dict[str, foxglove.Channel] = {}

    def show(self, scene: FoxgloveScene, truth: Truth) -> None:
        """Send what there is to see at true poses; the plan, too, if somebody is new."""
        if self._newcomers.there:
            self._newcomers.there = False
            scene.begin_again()
        for encoded in scene.at(truth):
            self._channel(encoded).log(encoded.data, log_time=encoded.t_ns)

    def _channel(self, encoded: Encoded) -> foxglove.Channel:
        if encoded.topic not in self._channels:
            schema = foxglove.Schema(name=encoded.schema, encoding="protobuf", data=encoded.descriptors)
            self._channels[encoded.topic] = foxglove.Channel(
                encoded.topic, schema=schema, message_encoding="protobuf", context=self._context
            )
        return self._channels[encoded.topic]


@contextmanager
def _serving(port: int) -> Iterator[_Outlet]:
    context, newcomers = foxglove.Context(), _Newcomers()
    try:
        server = foxglove.start_server(
            name="grex", host="127.0.0.1", port=port, context=context, server_listener=newcomers
        )
    except (RuntimeError, OSError) as error:
        raise ConfigError("--port", f"cannot listen on port {port}: {error}; take another one, or 0 for any") from None
    print(f"ws://127.0.0.1:{server.port}", flush=True)  # noqa: T201
    try:
        with suppress(KeyboardInterrupt):
            yield _Outlet(context, newcomers)
    finally:
        server.stop()


def serve_live(connect: str, port: int) -> None:
    """Serve the run on the bus, now or later, until Ctrl-C."""
    live = Live((connect,))
    scene, run = None, -1
    with _serving(port) as outlet:
        while True:
            if not live.connected:
                with suppress(BusError):
                    live.connect()
            live.listen(clock.monotonic_s())
            if live.picture is not None and live.truth is not None:
                if run != live.run or scene is None:
                    run, scene = live.run, _scene(live.picture.scenario)
                outlet.show(scene, live.truth)
            clock.sleep_s(_LOOK_S)


def serve_recorded(run: Path, port: int) -> None:
    """Play a recording in real time, again and again, until Ctrl-C.

    Raises
    ------
    ConfigError
        If it is no recording of a run.
    """
    recording = Recording(run)
    with _serving(port) as outlet:
        while True:
            started_s, scene = clock.monotonic_s(), _scene(recording.scenario)
            for entry in recording.entries({"truth"}):
                clock.sleep_s(max(0.0, entry.t_ns / NS - (clock.monotonic_s() - started_s)))
                if isinstance(entry.message, Truth):
                    outlet.show(scene, entry.message)
            clock.sleep_s(_LOOK_S)


def _scene(scenario: Scenario) -> FoxgloveScene:
    return FoxgloveScene(scenario, plan_mission(scenario), _APART_S)
