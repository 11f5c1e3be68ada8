"""``grex view``: the live page of a run on the bus, or of a recorded one."""

from pathlib import Path
from typing import Annotated

import tyro

from grex_link.errors import ConfigError
from grex_sim.bus_options import DEFAULT_CONNECT, Connect

_PORT_MAX = 65_535


def view(
    run: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[RUN]")] = None,
    connect: Connect = DEFAULT_CONNECT,
    port: Annotated[int, tyro.conf.arg(metavar="PORT")] = 8080,
    foxglove: bool = False,  # noqa: FBT001, FBT002 - a flag
) -> None:
    """Show a run in the browser: tracks, beliefs, messages in the water, deviation, health. It only ever looks.

    Parameters
    ----------
    run
        Folder or run.mcap of a recorded run; left out: the run that is on the bus, now or later.
    port
        Of the page on this machine; 0 takes any that is free.
    foxglove
        Serve map and scene for Foxglove's WebSocket connection on that port, instead of a page.
    """
    if not 0 <= port <= _PORT_MAX:
        raise ConfigError("--port", f"{port} is no port; they go to {_PORT_MAX}, and 0 takes any that is free")
    if foxglove:
        _serve_foxglove(run, connect, port)
        return
    try:
        from grex_sim.view import server
    except ModuleNotFoundError as error:
        raise _without("view", error) from None
    from grex_sim.view.live import Live
    from grex_sim.view.recorded_page import RecordedPage

    app = server.LiveServer(Live((connect,))).app() if run is None else server.recorded_app(RecordedPage(run))
    with server.listen_on(port) as taken:
        print(f"http://127.0.0.1:{taken.getsockname()[1]}/", flush=True)  # noqa: T201
        server.serve(app, taken)


def _serve_foxglove(run: Path | None, connect: str, port: int) -> None:
    try:
        from grex_sim.view import foxglove_server as server
    except ModuleNotFoundError as error:
        raise _without("foxglove", error) from None
    if run is None:
        server.serve_live(connect, port)
    else:
        server.serve_recorded(run, port)


def _without(extra: str, error: ModuleNotFoundError) -> ConfigError:
    return ConfigError("grex view", f"needs the extra '{extra}' ({error.name} is missing): pip install 'grex[{extra}]'")
