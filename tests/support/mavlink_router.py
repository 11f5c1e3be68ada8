"""A router as MAVLink users run one: one UDP port, and everybody hears what anybody else says."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def router() -> Iterator[int]:
    """Run a router on a free port, and give that."""
    with socket.socket(type=socket.SOCK_DGRAM) as hub:
        hub.bind(("127.0.0.1", 0))
        hub.settimeout(0.1)
        over = threading.Event()
        thread = threading.Thread(target=_route, args=(hub, over))
        thread.start()
        try:
            yield hub.getsockname()[1]
        finally:
            over.set()
            thread.join()


def _route(hub: socket.socket, over: threading.Event) -> None:
    known: dict[tuple[str, int], None] = {}
    while not over.is_set():
        try:
            data, sender = hub.recvfrom(65535)
        except TimeoutError:
            continue
        except ConnectionError:
            # Somebody has gone; his datagram is lost.
            continue
        known[sender] = None
        for peer in known:
            if peer != sender:
                hub.sendto(data, peer)
