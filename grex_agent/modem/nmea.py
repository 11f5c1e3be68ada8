"""Sentences of NMEA 0183 as modems speak it: framing, checksums, and a count of everything that is wrong.

A sentence is ``$`` talker and type, fields between commas, ``*`` and the exclusive or of all characters between as two
hexadecimal digits, carriage return and line feed. Modems print sentences far longer than NMEA's 82 characters.
"""

import re
from collections import Counter

import msgspec

#: The longest sentence of the Micro-Modem (WHOI libumutil, UMMAXMSSZ); one that is longer is no sentence.
LONGEST = 5664

_SENTENCE = re.compile(rb"\$([A-Z]{2}[A-Z0-9]{3})((?:,[ -)+-~]*)?)\*([0-9A-Fa-f]{2}) *\Z")
_PRINTABLE = bytes(range(0x20, 0x7F))


class Sentence(msgspec.Struct, frozen=True):
    """A sentence whose checksum is right.

    Attributes
    ----------
    kind : str
        Talker and type, for instance ``CARXD``.
    fields : tuple of str
        What stands between the commas, without talker and checksum.
    """

    kind: str
    fields: tuple[str, ...]


def checksum(body: bytes) -> int:
    """Exclusive or of all bytes between ``$`` and ``*``."""
    value = 0
    for byte in body:
        value ^= byte
    return value


def encode(kind: str, *fields: object) -> bytes:
    """Write a sentence with its checksum.

    Parameters
    ----------
    kind : str
        Talker and type.
    fields : object
        Printed with `str`.

    Returns
    -------
    bytes
        With ``$``, checksum, carriage return and line feed.
    """
    body = ",".join([kind, *map(str, fields)]).encode("ascii")
    return b"$%s*%02X\r\n" % (body, checksum(body))


class SentenceReader:
    """Finds the sentences in what a serial line brings, in whatever pieces it comes; never raises, never grows.

    Attributes
    ----------
    faults : Counter
        What was wrong, by kind: ``bad_checksum``, ``no_checksum``, ``malformed``, ``non_ascii``, ``overlong``,
        ``cut_off`` (another sentence began in the middle of one) and ``stray_bytes`` outside of sentences.
    """

    def __init__(self) -> None:
        self.faults: Counter[str] = Counter()
        self._begun = bytearray()
        self._skipping = False

    def feed(self, data: bytes) -> list[Sentence]:
        """Take some bytes.

        Returns
        -------
        list of Sentence
            Those that have become complete, in order.
        """
        sentences = []
        for line, end in _pieces(data):
            self._take(line)
            if end and (sentence := self._finish()) is not None:
                sentences.append(sentence)
        return sentences

    def reset(self) -> None:
        """Forget a sentence that has begun: the line was cut."""
        if self._begun:
            self.faults["cut_off"] += 1
        self._begun.clear()
        self._skipping = False

    def _take(self, piece: bytes) -> None:
        """Add a piece of a line; a dollar sign begins a sentence, whatever was before."""
        inside, *beginnings = piece.split(b"$")
        self._add(inside)
        for beginning in beginnings:
            if self._begun:
                self.faults["cut_off"] += 1
            self._begun[:] = b"$"
            self._skipping = False
            self._add(beginning)

    def _add(self, piece: bytes) -> None:
        if self._begun:
            self._begun += piece
            if len(self._begun) > LONGEST:
                self.faults["overlong"] += 1
                self._begun.clear()
                self._skipping = True
        elif piece and not self._skipping:
            self.faults["stray_bytes"] += len(piece)

    def _finish(self) -> Sentence | None:
        line = bytes(self._begun)
        self._begun.clear()
        self._skipping = False
        if not line:
            return None
        match = _SENTENCE.match(line)
        if match is None:
            self.faults[_fault(line)] += 1
            return None
        if checksum(line[1 : match.end(2)]) != int(match[3], 16):
            self.faults["bad_checksum"] += 1
            return None
        return Sentence(match[1].decode("ascii"), tuple(match[2].decode("ascii").split(",")[1:]))


def _fault(line: bytes) -> str:
    if line.translate(None, _PRINTABLE):
        return "non_ascii"
    return "malformed" if b"*" in line else "no_checksum"


def _pieces(data: bytes) -> list[tuple[bytes, bool]]:
    """Cut at the ends of lines; with each piece, whether an end follows it."""
    parts = data.replace(b"\n", b"\r").split(b"\r")
    return [(part, place < len(parts) - 1) for place, part in enumerate(parts)]
