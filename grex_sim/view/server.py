"""The web server of the page: static files, a recording in pieces, a socket for a live run. It only ever answers."""

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as AsgiMessage
from starlette.websockets import WebSocket, WebSocketDisconnect

from grex_link import clock
from grex_link.errors import BusError, ConfigError
from grex_sim.view.guard import ANSWER_HEADERS, refusal
from grex_sim.view.live import Live
from grex_sim.view.mailbox import Mailbox, Patience
from grex_sim.view.recorded_page import RecordedPage

_PAGE = Path(__file__).parent / "page"
_FRAME_S = 0.1
#: Without news, a frame all the same: ages in the health table go on.
_IDLE_S = 1.0
_RETRY_S = 1.0
_SOCKETS_MAX = 16
_SEND_S = 10.0
_SAID_MAX_BYTES = 1024
_TRY_AGAIN, _TOO_MUCH = 1013, 1008


class _Guarded:
    """Lets in who may come, and adds the headers that keep the browser from anything but this page."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refused = refusal(scope["headers"], scope.get("method", "GET"))
        if refused is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": _TOO_MUCH, "reason": refused[1]})
        else:
            await PlainTextResponse(refused[1] + "\n", refused[0])(scope, receive, _with_headers(send))


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: AsgiMessage) -> None:
        if message["type"] == "http.response.start":
            message = {**message, "headers": [*message["headers"], *ANSWER_HEADERS]}
        await send(message)

    return send_with_headers


def _json(content: bytes) -> Response:
    return Response(content, media_type="application/json")


# -- a recording --------------------------------------------------------------------------------------------------


def recorded_app(recorded: RecordedPage) -> ASGIApp:
    """Serve a recorded run; all playing is the page's own."""
    scene, past = msgspec.json.encode(recorded.scene), msgspec.json.encode(recorded.past)

    async def piece(request: Request) -> Response:
        number = request.path_params["number"]
        if number >= len(recorded.pieces):
            return PlainTextResponse("there is no such piece\n", 404)
        return _json(recorded.pieces[number])

    return _app(
        Route("/scene.json", _constant(scene)),
        Route("/past.json", _constant(past)),
        Route("/frames/{number:int}.json", piece),
    )


def _constant(content: bytes) -> Any:
    async def answer(request: Request) -> Response:
        del request
        return _json(content)

    return answer


# -- a live run ---------------------------------------------------------------------------------------------------


class LiveServer:
    """Looks at a live run ten times a second and shows it to every page.

    Parameters
    ----------
    live : Live
        The run.
    """

    def __init__(self, live: Live) -> None:
        self._live = live
        self._mailboxes: set[Mailbox] = set()

    def app(self) -> ASGIApp:
        """Return the application."""
        scene = msgspec.json.encode({"mode": "live", "endpoints": self._live.endpoints})
        return _app(
            Route("/scene.json", _constant(scene)),
            WebSocketRoute("/live", self._socket),
            lifespan=self._lifespan,
        )

    @contextlib.asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        del app
        watch = asyncio.create_task(self._watch())
        try:
            yield
        finally:
            watch.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await watch
            self._live.close()

    async def _watch(self) -> None:
        while not self._live.connected:
            try:
                await asyncio.to_thread(self._live.connect)
            except BusError:
                await asyncio.sleep(_RETRY_S)
        shown_at = 0.0
        while True:
            now = clock.monotonic_s()
            news = self._live.listen(now)
            if news or now - shown_at >= _IDLE_S:
                shown_at = now
                letter = msgspec.json.encode(self._live.frame(now))
                for mailbox in self._mailboxes:
                    mailbox.put(letter)
            await asyncio.sleep(_FRAME_S)

    async def _socket(self, websocket: WebSocket) -> None:
        if len(self._mailboxes) >= _SOCKETS_MAX:
            await websocket.close(_TRY_AGAIN, "too many pages are open")
            return
        await websocket.accept()
        mailbox = Mailbox()
        self._mailboxes.add(mailbox)
        tasks = {asyncio.create_task(self._show(websocket, mailbox)), asyncio.create_task(_ignore(websocket))}
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._mailboxes.discard(mailbox)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _show(self, websocket: WebSocket, mailbox: Mailbox) -> None:
        """Send what there is to see; whoever takes nothing for too long is left."""
        told = -1
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
            while True:
                letter = await mailbox.take()
                picture = self._live.picture
                if picture is not None and told != self._live.run:
                    told = self._live.run
                    scene = {"scene": picture.scene, "past": picture.past(), "run": told}
                    await _send(websocket, msgspec.json.encode(scene))
                await _send(websocket, letter)


async def _send(websocket: WebSocket, content: bytes) -> None:
    await asyncio.wait_for(websocket.send_text(content.decode()), _SEND_S)


async def _ignore(websocket: WebSocket) -> None:
    """Listen to nothing the page says, and to a page that says much no longer."""
    patience = Patience()
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while (await websocket.receive())["type"] != "websocket.disconnect":
            if not patience.bears(clock.monotonic_s()):
                await websocket.close(_TOO_MUCH, "this page only reads")
                return


# -- both ---------------------------------------------------------------------------------------------------------


def _app(*routes: Any, lifespan: Any = None) -> ASGIApp:
    pages = Mount("/", StaticFiles(directory=_PAGE, html=True))
    return _Guarded(Starlette(routes=[*routes, pages], lifespan=lifespan))


def listen_on(port: int) -> socket.socket:
    """Take a port on this machine, 0 for any that is free.

    Raises
    ------
    ConfigError
        If it is in use.
    """
    taken = socket.socket()
    taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        taken.bind(("127.0.0.1", port))
        taken.listen()
    except OSError as error:
        taken.close()
        problem = f"cannot listen on port {port}: {error.strerror}; take another one, or 0 for any"
        raise ConfigError("--port", problem) from None
    return taken


def serve(app: ASGIApp, taken: socket.socket) -> None:
    """Serve until Ctrl-C or SIGTERM."""
    config = uvicorn.Config(
        app,
        log_level="critical",
        access_log=False,
        ws="websockets-sansio",
        ws_max_size=_SAID_MAX_BYTES,
        timeout_graceful_shutdown=1,
        server_header=False,
    )
    with contextlib.suppress(KeyboardInterrupt):
        uvicorn.Server(config).run(sockets=[taken])
