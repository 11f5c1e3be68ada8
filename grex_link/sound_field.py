"""Sounds on their way through the water and what each receiver makes of them: the core of the acoustic medium.

A transmission is a wavefront that passes the receivers in the order of their delays; it stands in the queue of events
once, with the receiver that it reaches next. Its end is an event only where somebody has locked to it.

The state machine of a receiver (acoustic-link §3):

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
from collections.abc import Callable
from itertools import count
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from grex_link.propagation import Paths

#: Kinds of events, in their order at equal times.
END, START, SEND, OTHER = range(4)
#: (source, number of the request, 0 for an own transmission or 1 for an answer, place of the asker)
Key = tuple[int, int, int, int]

_SCALE_BITS = 64
_RATIO_BITS = 80


def power(level_db: float) -> int:
    """Power of a level in dB, in units of 2⁻⁶⁴ µPa²."""
    return int(10.0 ** (level_db / 10.0) * 2.0**_SCALE_BITS)


def powers(level_db: NDArray[np.float64]) -> list[int]:
    """Powers of several levels, see `power`."""
    return list(map(int, (10.0 ** (level_db / 10.0) * 2.0**_SCALE_BITS).tolist()))


class Sound:
    """One transmission on its way.

    Parameters
    ----------
    key : Key
        Who, and which.
    start_ns, airtime_ns : int
        When it left, and how long it lasts.
    paths : Paths
        To everybody else, in the order of their delays.
    audible : list of bool or None
        Who of them could hear it at all; None for everybody.
    content : object
        What the owner of the field wants to know of it.
    """

    __slots__ = (
        "airtime_ns", "audible", "content", "cut", "delay_ns", "gap_ns", "key", "last", "level_db", "power", "range_m",
        "receivers", "start_ns",
    )  # fmt: skip

    def __init__(
        self,
        key: Key,
        start_ns: int,
        airtime_ns: int,
        paths: Paths,
        audible: list[bool] | None,
        content: Any,
    ) -> None:
        self.key = key
        self.start_ns = start_ns
        self.airtime_ns = airtime_ns
        self.receivers, self.delay_ns, self.gap_ns, self.range_m, self.level_db = paths
        self.last = len(self.receivers) - 1
        self.power = powers(paths.level_db)
        self.audible = audible
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
    acquisition_db : float
        SINR above which a receiver locks.
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

    def __init__(self, size: int, noise: int, acquisition_db: float, listener: Listener) -> None:
        self.now_ns = 0
        self.sending_until_ns = [0] * size
        self.deaf_until_ns = [0] * size
        self.off = [False] * size
        self._acquisition = round(10.0 ** (acquisition_db / 10.0) * 2.0**_RATIO_BITS)
        self._listener = listener
        self._noise = [noise] * size
        self._total = [noise] * size  # noise and all arrivals
        self._peak = [0] * size  # greatest total while locked
        # (end, power) of what arrives; taken off the total when next that matters
        self._ends: list[list[tuple[int, int]]] = [[] for _ in range(size)]
        self._locked: list[Sound | None] = [None] * size
        self._locked_index = [0] * size
        self._serial = count()
        # (time, kind, (key, serial), receiver's index, what): the serial number tells apart what nothing else does
        self._queue: list[tuple[int, int, tuple[Key, int], int, Any]] = []

    def at(self, t_ns: int, kind: int, key: Key, action: Callable[[int], None]) -> None:
        """Have something done at a time that is not before `now_ns`."""
        heapq.heappush(self._queue, (t_ns, kind, (key, next(self._serial)), 0, action))

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
            which = sound.key, next(self._serial)
            heapq.heappush(self._queue, (first_ns, START, which, 0, sound))

    def cut(self, sound: Sound, t_ns: int) -> None:
        """Cut a transmission short; where it is already heard it ends a delay later."""
        planned_ns, sound.airtime_ns, sound.cut = sound.airtime_ns, t_ns - sound.start_ns, True
        for index, node in enumerate(sound.receivers):
            arrival_ns = sound.start_ns + sound.delay_ns[index]
            entry = (arrival_ns + planned_ns, sound.power[index])
            if entry in self._ends[node]:
                self._ends[node].remove(entry)
                self._ends[node].append((t_ns + sound.delay_ns[index], sound.power[index]))
                heapq.heapify(self._ends[node])
            if self._locked[node] is sound:
                which = sound.key, next(self._serial)
                heapq.heappush(self._queue, (t_ns + sound.delay_ns[index], END, which, index, sound))

    def switch(self, node: int, t_ns: int, *, off: bool) -> None:
        """Switch a node's modem off or on."""
        self.off[node] = off
        if off:
            if self._locked[node] is not None:
                self._drop_lock(node, t_ns, "aborted_off")
            self.sending_until_ns[node] = self.deaf_until_ns[node] = t_ns

    def set_noise(self, node: int, noise: int, t_ns: int) -> None:
        """Change the noise at a node; a locked packet suffers from it, too."""
        ends = self._ends[node]
        while ends and ends[0][0] <= t_ns:
            self._total[node] -= heapq.heappop(ends)[1]
        self._total[node] += noise - self._noise[node]
        self._noise[node] = noise
        self._peak[node] = max(self._peak[node], self._total[node])

    def noise(self, node: int) -> int:
        """Power of the noise at a node."""
        return self._noise[node]

    def advance(self, until_ns: int) -> None:
        """Work through all events before a time."""
        queue, arrive = self._queue, self._arrive
        replace, pop = heapq.heapreplace, heapq.heappop
        while queue and queue[0][0] < until_ns:
            t_ns, kind, which, index, what = queue[0]
            if kind == START:
                if index < what.last:
                    replace(queue, (t_ns + what.gap_ns[index], START, which, index + 1, what))
                else:
                    pop(queue)
                arrive(t_ns, which, index, what)
            elif kind == END:
                pop(queue)
                self._end(t_ns, index, what)
            else:
                pop(queue)
                what(t_ns)
        self.now_ns = max(self.now_ns, until_ns)

    def _arrive(self, t_ns: int, which: tuple[Key, int], index: int, sound: Sound) -> None:
        """Let a sound begin at a receiver."""
        node = sound.receivers[index]
        strength = sound.power[index]
        ends, others = self._ends[node], self._total[node]
        while ends and ends[0][0] <= t_ns:
            others -= heapq.heappop(ends)[1]
        self._total[node] = everything = others + strength
        end_ns = t_ns + sound.airtime_ns
        heapq.heappush(ends, (end_ns, strength))
        busy = self._locked[node] is not None
        if busy and everything > self._peak[node]:
            self._peak[node] = everything
        if sound.audible is not None and not sound.audible[index]:
            reason = "out_of_range"
        elif busy:
            reason = "missed_busy"
        elif self.off[node]:
            reason = "missed_off"
        elif t_ns < self.deaf_until_ns[node]:
            reason = "missed_halfduplex"
        elif strength << _RATIO_BITS > others * self._acquisition:
            self._locked[node] = sound
            self._locked_index[node] = index
            self._peak[node] = everything
            heapq.heappush(self._queue, (end_ns, END, which, index, sound))
            return
        else:
            reason = "missed_snr"
        self._listener.missed(t_ns, sound, index, reason, others)

    def _end(self, t_ns: int, index: int, sound: Sound) -> None:
        """Let a sound end that a receiver has locked to, unless the lock was lost."""
        node = sound.receivers[index]
        if self._locked[node] is sound:
            self._locked[node] = None
            self._listener.decide(t_ns, sound, index, self._peak[node] - sound.power[index])

    def _drop_lock(self, node: int, t_ns: int, reason: str) -> None:
        sound = self._locked[node]
        self._locked[node] = None
        if sound is not None:
            index = self._locked_index[node]
            self._listener.missed(t_ns, sound, index, reason, self._peak[node] - sound.power[index])


def sinr_db(sound: Sound, index: int, others: int) -> float:
    """SINR of a sound at one of its receivers, dB; finite even where nothing audible is left of it."""
    if not others:
        return math.inf
    return float(sound.level_db[index]) - 10.0 * (math.log10(others) - _SCALE_BITS * math.log10(2.0))


def ratio_db(strength: int, others: int) -> float:
    """Ratio of two powers, dB."""
    if not strength:
        return -math.inf
    return 10.0 * math.log10(strength / others) if others else math.inf
