"""Between a run that goes on and a browser that may be slow: room for one frame, in which the newest wins."""

import asyncio


class Mailbox:
    """Holds the newest letter until it is taken."""

    def __init__(self) -> None:
        self._letter: bytes | None = None
        self._there = asyncio.Event()

    def put(self, letter: bytes) -> None:
        """Put a letter in; one that is still there is thrown away."""
        self._letter = letter
        self._there.set()

    async def take(self) -> bytes:
        """Wait for a letter."""
        await self._there.wait()
        self._there.clear()
        letter, self._letter = self._letter, None
        return letter or b""


class Patience:
    """How much a browser may say to a server that does not listen.

    Parameters
    ----------
    messages : int
        So many within `over_s`, seconds, and the socket is closed.
    """

    def __init__(self, messages: int = 20, over_s: float = 10.0) -> None:
        self._most = messages
        self._over_s = over_s
        self._count = 0
        self._since_s = 0.0

    def bears(self, now_s: float) -> bool:
        """Count one more message; whether it may go on like this."""
        if now_s - self._since_s > self._over_s:
            self._count, self._since_s = 0, now_s
        self._count += 1
        return self._count <= self._most
