"""Sounds on their way through the water and what each receiver makes of them: the core of the acoustic medium.

A transmission is a wavefront that passes the receivers in the order of their delays; its start and its end each stand
in the queue of events once, with the receiver they reach next. The state machine of a receiver (acoustic-link §3):

===================  ==============================  ====================================  ========================
event                idle                            locked                                transmitting, turnaround
===================  ==============================  ====================================  ========================
arrival starts       lock if SINR > acquisition      newcomer is never locked, interferes  deaf to it, interferes
arrival ends         –                               if it is the locked one: decide       –
own transmission     transmit                        the locked packet is lost; transmit   refused
===================  ==============================  ====================================  ========================

At equal times arrivals end, then arrivals start, then transmissions start, then (source, sequence) decides.

Powers are integers, so that a sum of arrivals does not depend on the order in which they came and went.
"""

import heapq
import math
from collections.abc import Callable, Sequence
from itertools import count
from typing import Any, Protocol

#: Kinds of events, in their order at equal times.
END, START, SEND, OTHER = range(4)
#: (source, number of the request, 0 for an own transmission or 1 for an answer, place of the asker)
Key = tuple[int, int, int, int]

_SCALE_BITS = 64


def power(level_db: float) -> int:
    """Power of a level in dB, in units of 2⁻⁶⁴ µPa²."""
    return int(10.0 ** (level_db / 10.0) * 2.0**_SCALE_BITS)


class Sound:
    """One transmission on its way.

    Parameters
    ----------
    key : Key
        Who, and which.
    start_ns, airtime_ns : int
        When it left, and how long it lasts.
    receivers : sequence of int
        Everybody else, in the order of their delays.
    delay_ns, range_m, level_db : sequence of float
        For each of these receivers.
    reach_m : float
        Beyond this nobody can hear it.
    content : object
        What the owner of the field wants to know of it.
    """

    __slots__ = (
        "airtime_ns",
        "audible",
        "content",
        "cut",
        "delay_ns",
        "key",
        "level_db",
        "power",
        "range_m",
        "receivers",
        "start_ns",
    )

    def __init__(
        self,
        key: Key,
        start_ns: int,
        airtime_ns: int,
        receivers: Sequence[int],
        delay_ns: Sequence[int],
        range_m: Sequence[float],
        level_db: Sequence[float],
        reach_m: float,
        content: Any,
    ) -> None:
        self.key = key
        self.start_ns = start_ns
        self.airtime_ns = airtime_ns
        self.receivers = receivers
        self.delay_ns = delay_ns
        self.range_m = range_m
        self.level_db = level_db
        self.power = [power(level) for level in level_db]
        self.audible = [distance <= reach_m for distance in range_m]
        self.cut = False
        self.content = content


class Listener(Protocol):
    """Who owns a field and is told what becomes of every sound at every receiver."""

    def missed(self, t_ns: int, sound: Sound, index: int, reason: str, others: int) -> None:
        """Learn that a receiver did not lock, or lost its lock.

        Parameters
        ----------
        t_ns : int
            True time.
        sound : Sound
            Which one.
        index : int
            Which of its receivers.
        reason : str
            As in `LinkEvent`.
        others : int
            Power of noise and all other arrivals when it arrived; if the lock was lost, the greatest until then.
        """

    def decide(self, t_ns: int, sound: Sound, index: int, others: int) -> None:
        """Learn that a locked sound has ended.

        Parameters
        ----------
        t_ns, sound, index
            As in `missed`.
        others : int
            Greatest power of noise and all other arrivals while it lasted; the lowest SINR follows from it.
        """


class SoundField:
    """All sounds and all receivers.

    Parameters
    ----------
    size : int
        How many nodes there are.
    noise : int
        Power of the ambient noise.
    acquisition : float
        Ratio of powers above which a receiver locks.
    listener : Listener
        Who is told.

    Attributes
    ----------
    now_ns : int
        Everything before this has been worked through.
    sending_until_ns, deaf_until_ns : list of int
        For each node, the end of its own transmission, and of the turnaround after it.
    off : list of bool
        Whether its modem is off.
    """

    def __init__(self, size: int, noise: int, acquisition: float, listener: Listener) -> None:
        self.now_ns = 0
        self.sending_until_ns = [0] * size
        self.deaf_until_ns = [0] * size
        self.off = [False] * size
        self._acquisition = acquisition
        self._listener = listener
        self._noise = [noise] * size
        self._total = [noise] * size  # noise and all arrivals
        self._peak = [0] * size  # greatest total while locked
        self._locked: list[Sound | None] = [None] * size
        self._locked_index = [0] * size
        self._serial = count()
        # (time, kind, key, receiver's index, serial, what)
        self._queue: list[tuple[int, int, Key, int, int, Any]] = []

    def at(self, t_ns: int, kind: int, key: Key, action: Callable[[int], None]) -> None:
        """Have something done at a time that is not before `now_ns`."""
        heapq.heappush(self._queue, (t_ns, kind, key, 0, next(self._serial), action))

    def next_ns(self) -> int | None:
        """Time of the next event."""
        return self._queue[0][0] if self._queue else None

    def send(self, node: int, sound: Sound, turnaround_ns: int) -> None:
        """Let a node transmit; what it was locked to is lost."""
        if self._locked[node] is not None:
            self._drop_lock(node, sound.start_ns, "aborted_own_tx")
        end_ns = sound.start_ns + sound.airtime_ns
        self.sending_until_ns[node] = end_ns
        self.deaf_until_ns[node] = end_ns + turnaround_ns
        if sound.receivers:
            first_ns = sound.start_ns + sound.delay_ns[0]
            heapq.heappush(self._queue, (first_ns, START, sound.key, 0, next(self._serial), sound))
            heapq.heappush(self._queue, (first_ns + sound.airtime_ns, END, sound.key, 0, next(self._serial), sound))

    def switch(self, node: int, t_ns: int, *, off: bool) -> None:
        """Switch a node's modem off or on."""
        self.off[node] = off
        if off:
            if self._locked[node] is not None:
                self._drop_lock(node, t_ns, "aborted_off")
            self.sending_until_ns[node] = self.deaf_until_ns[node] = t_ns

    def set_noise(self, node: int, noise: int) -> None:
        """Change the noise at a node; a locked packet suffers from it, too."""
        self._total[node] += noise - self._noise[node]
        self._noise[node] = noise
        self._peak[node] = max(self._peak[node], self._total[node])

    def noise(self, node: int) -> int:
        """Power of the noise at a node."""
        return self._noise[node]

    def advance(self, until_ns: int) -> None:
        """Work through all events before a time."""
        queue, total, locked, peak, off = self._queue, self._total, self._locked, self._peak, self.off
        deaf_until_ns, missed, acquisition = self.deaf_until_ns, self._listener.missed, self._acquisition
        replace = heapq.heapreplace
        while queue and queue[0][0] < until_ns:
            t_ns, kind, key, index, serial, what = queue[0]
            if kind > START:
                heapq.heappop(queue)
                what(t_ns)
                continue
            following = index + 1
            if following < len(what.receivers):
                step_ns = what.delay_ns[following] - what.delay_ns[index]
                replace(queue, (t_ns + step_ns, kind, key, following, serial, what))
            else:
                heapq.heappop(queue)
            node = what.receivers[index]
            strength = what.power[index]
            if kind == END:
                if locked[node] is what:
                    locked[node] = None
                    self._listener.decide(t_ns, what, index, peak[node] - strength)
                total[node] -= strength
                continue
            others = total[node]
            total[node] = others + strength
            if locked[node] is not None:
                peak[node] = max(peak[node], others + strength)
                missed(t_ns, what, index, "missed_busy" if what.audible[index] else "out_of_range", others)
            elif not what.audible[index]:
                missed(t_ns, what, index, "out_of_range", others)
            elif off[node]:
                missed(t_ns, what, index, "missed_off", others)
            elif t_ns < deaf_until_ns[node]:
                missed(t_ns, what, index, "missed_halfduplex", others)
            elif strength > acquisition * others:
                locked[node] = what
                self._locked_index[node] = index
                peak[node] = others + strength
            else:
                missed(t_ns, what, index, "missed_snr", others)
        self.now_ns = max(self.now_ns, until_ns)

    def _drop_lock(self, node: int, t_ns: int, reason: str) -> None:
        sound = self._locked[node]
        self._locked[node] = None
        if sound is not None:
            index = self._locked_index[node]
            self._listener.missed(t_ns, sound, index, reason, self._peak[node] - sound.power[index])


def ratio_db(strength: int, others: int) -> float:
    """Ratio of two powers, dB."""
    if not strength:
        return -math.inf
    return 10.0 * math.log10(strength / others) if others else math.inf
