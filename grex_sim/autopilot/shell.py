"""The process around the core: links, one loop, and the wall clock times the speedup."""

import select
from collections.abc import Callable

from grex_link import clock
from grex_sim.autopilot.codec import Codec
from grex_sim.autopilot.core import Autopilot
from grex_sim.autopilot.craft import STEP_S
from grex_sim.autopilot.links import Link
from grex_sim.autopilot.message import Message

#: A process that was stopped does not run after the time it missed: its autopilot stood still.
_STRIDE_MAX_S = 0.5
_WAIT_MIN_S = 0.001


class Pace:
    """Autopilot time from wall time: so many times as fast, and a little wrong.

    Parameters
    ----------
    speedup : float
        Autopilot seconds per wall second.
    ppm : float
        How much its clock is fast, parts in a million.
    wall_s : float
        Wall time of its time zero.
    """

    def __init__(self, speedup: float, ppm: float, wall_s: float) -> None:
        self._rate = speedup * (1.0 + ppm * 1e-6)
        self._wall_s = wall_s
        self._now_s = 0.0

    def advance(self, wall_s: float) -> float:
        """Autopilot time at a wall time."""
        stride = min(max(wall_s - self._wall_s, 0.0), _STRIDE_MAX_S)
        self._wall_s = wall_s
        self._now_s += stride * self._rate
        return self._now_s

    def wait_s(self) -> float:
        """Wall seconds for which nothing happens by itself."""
        return max(_WAIT_MIN_S, STEP_S / self._rate)


class Shell:
    """One autopilot on its links.

    Parameters
    ----------
    pilot : Autopilot
        The core.
    links : list of Link
        In the order of the core's numbers.
    codecs : list of Codec
        One a link.
    pace : Pace
        Its time.
    tell : callable
        Where lines for people go.
    """

    def __init__(
        self, pilot: Autopilot, links: list[Link], codecs: list[Codec], pace: Pace, tell: Callable[[str], None]
    ) -> None:
        self._pilot, self._links, self._codecs, self._pace, self._tell = pilot, links, codecs, pace, tell

    def run(self) -> None:
        """Run until it is interrupted."""
        try:
            while True:
                self.turn()
        finally:
            for link in self._links:
                link.close()

    def turn(self) -> None:
        """Wait a moment, hear, think and say."""
        files = [file for link in self._links for file in link.files()]
        select.select(files, [], [], self._pace.wait_s())
        wall_s = clock.monotonic_s()
        now_s = self._pace.advance(wall_s)
        for number, (link, codec) in enumerate(zip(self._links, self._codecs, strict=True)):
            for sender, data in link.receive(wall_s):
                for message in codec.read(data, sender, datagram=link.datagrams):
                    self._pilot.heard(message, number, now_s)
        for out in self._pilot.step(now_s):
            for number in range(len(self._links)) if out.link is None else (out.link,):
                data = self._codecs[number].pack(out.message) if isinstance(out.message, Message) else out.message
                self._links[number].send(data)
            if isinstance(out.message, Message) and out.message.name == "STATUSTEXT":
                self._tell(f"{now_s:8.2f} s  says: {out.message['text']}")
        for line in self._pilot.log:
            self._tell(line)
        self._pilot.log.clear()
