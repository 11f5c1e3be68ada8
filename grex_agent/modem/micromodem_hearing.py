"""What a Micro-Modem hears, put together: announcement, frames, complaints and statistics of each packet."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from grex_link.units import NS

#: After the last frame the statistics follow at once; without them the packet is handed over after this time.
SETTLE_NS = NS

_GOOD, _BAD_CRC, _TIMEOUT = 0, 1, 2
_MINIPACKETS = (2, 4)
#: Clock modes in which a pulse every second keeps the modem's clock.
_SYNCHRONISED = {"2", "3"}
_DIGITS = re.compile(r"[0-9]{1,9}\Z", re.ASCII)


@dataclass(frozen=True, slots=True)
class Heard:
    """A packet that has been heard; ``fault`` says why it could not be decoded.

    Attributes
    ----------
    source, destination : int
        Addresses.
    frames : list of bytes
        Its frames, all of them; empty if there is a fault.
    fault : str
        Empty if it is whole.
    level_db, snr_db : float or None
        Received level, dB re 1 µPa, and signal-to-noise ratio, as far as the modem says.
    past_second_s : float or None
        How far into a second of a synchronised clock it came.
    """

    source: int
    destination: int
    frames: list[bytes]
    fault: str = ""
    level_db: float | None = None
    snr_db: float | None = None
    past_second_s: float | None = None


@dataclass(slots=True)
class _Packet:
    source: int
    destination: int
    count: int | None
    until_ns: int
    frames: dict[int, bytes] = field(default_factory=dict)
    fault: str = ""

    @property
    def complete(self) -> bool:
        return self.count is not None and len(self.frames) >= self.count


@dataclass(frozen=True, slots=True)
class Statistics:
    """The part of ``$CACST`` that is used."""

    mode: int
    packet_type: int
    level_db: float | None
    snr_db: float | None
    past_second_s: float | None


def read_statistics(fields: tuple[str, ...]) -> Statistics | None:
    """Read ``$CACST``: without a version as the Micro-Modem 1 prints it, or with version 6 in front.

    Fields from the mode on: 0 mode, 1 time of arrival, 2 clock mode, 3 to 5 matched filter, 6 sound pressure level, …,
    16 packet type, …, 20 SNR at the input.

    Returns
    -------
    Statistics or None
        None if it is too short or not of numbers.
    """
    try:
        start = 0 if int(fields[0]) < 6 else 1
        mode, packet_type = int(fields[start]), int(fields[start + 16])
        level_db, snr_db = float(fields[start + 6]), float(fields[start + 20])
    except (ValueError, IndexError):
        return None
    # Only PSK has equalizer statistics; 0 and -1 stand for not measured.
    psk = packet_type in {3, 4}
    fraction = fields[start + 1].partition(".")[2]
    past_second_s = float("0." + fraction) if fields[start + 2] in _SYNCHRONISED and _DIGITS.match(fraction) else None
    return Statistics(
        mode, packet_type, _plausible(level_db), snr_db if psk and -50.0 < snr_db < 100.0 else None, past_second_s
    )


def _plausible(level_db: float) -> float | None:
    return level_db if 0.0 < level_db < 300.0 else None


class Hearing:
    """Assembles packets.

    Every method returns the packets that have become final. A packet is final with its statistics, when another one
    begins, or when nothing more of it has come for some time.

    Parameters
    ----------
    patience_ns : int
        How long after its announcement the frames of a packet may come.
    """

    def __init__(self, patience_ns: int) -> None:
        self._patience_ns = patience_ns
        self._packet: _Packet | None = None
        self._level_db: float | None = None

    @property
    def until_ns(self) -> int | None:
        """When the present packet is given up, or handed over as it is."""
        return None if self._packet is None else self._packet.until_ns

    def detected(self, level_db: float) -> None:
        """Take the level of a packet of which nothing else is known yet."""
        self._level_db = _plausible(level_db)

    def take_level(self) -> float | None:
        """Take the level of what was detected last; it belongs to one packet only."""
        level_db, self._level_db = self._level_db, None
        return level_db

    def announced(self, source: int, destination: int, count: int, now_ns: int) -> list[Heard]:
        """Take a cycle initialisation by somebody else."""
        final = self._finish()
        self._packet = _Packet(source, destination, max(1, count), now_ns + self._patience_ns)
        return final

    def frame(self, source: int, destination: int, number: int, data: bytes | None, now_ns: int) -> list[Heard]:
        """Take a frame, counted from 1; ``data`` is None if it made no sense."""
        final: list[Heard] = []
        packet = self._packet
        if packet is None or (packet.source, packet.destination) != (source, destination) or number in packet.frames:
            final = self._finish()
            packet = self._packet = _Packet(source, destination, None, 0)
        packet.frames[number] = data or b""
        if data is None:
            packet.fault = "corrupt"
        packet.until_ns = now_ns + (SETTLE_NS if packet.count is None or packet.complete else self._patience_ns)
        return final

    def complaint(self, fault: str, now_ns: int) -> list[Heard]:
        """Take the modem's word that it could not decode something."""
        if self._packet is None:
            self._packet = _Packet(-1, -1, None, 0)
        self._packet.fault = fault
        self._packet.until_ns = now_ns + SETTLE_NS
        return []

    def statistics(self, statistics: Statistics) -> list[Heard]:
        """Take the statistics of a packet; they come last."""
        packet = self._packet
        if statistics.mode == _GOOD:
            # The announcement at rate 0 is a packet of its own, with statistics of its own.
            if packet is None or statistics.packet_type in _MINIPACKETS or not (packet.frames or packet.fault):
                return []
            return self._finish(statistics)
        if packet is None:
            packet = self._packet = _Packet(-1, -1, None, 0)
        packet.fault = packet.fault or ("timeout" if statistics.mode == _TIMEOUT else "corrupt")
        return self._finish(statistics)

    def on_time(self, now_ns: int) -> list[Heard]:
        """Give up, or hand over, what has waited long enough."""
        return self._finish() if self._packet is not None and self._packet.until_ns <= now_ns else []

    def forget(self) -> None:
        """Forget the present packet: the modem has."""
        self._packet = self._level_db = None

    def _finish(self, statistics: Statistics | None = None) -> list[Heard]:
        return list(self._final(statistics))

    def _final(self, statistics: Statistics | None) -> Iterator[Heard]:
        packet, self._packet = self._packet, None
        if packet is None or not (packet.frames or packet.fault):
            return
        measured = statistics or Statistics(_GOOD, 0, self.take_level(), None, None)
        self._level_db = None
        wanted = range(1, (packet.count or max(packet.frames, default=0)) + 1)
        fault = packet.fault or ("" if all(number in packet.frames for number in wanted) else "incomplete")
        frames = [] if fault else [packet.frames[number] for number in wanted]
        yield Heard(packet.source, packet.destination, frames, fault, measured.level_db, measured.snr_db,
                    measured.past_second_s)  # fmt: skip
