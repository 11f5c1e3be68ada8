"""Messages out of a stream of bytes in which there may be garbage, even garbage that looks like a beginning."""

from collections.abc import Callable, Iterator
from typing import TypeVar

_V1, _V2 = 0xFE, 0xFD
_V1_EXTRA, _V2_EXTRA, _SIGNATURE = 8, 12, 13
_SIGNED = 0x01

Whole = TypeVar("Whole")


class Framer:
    """Cuts the bytes of one sender; what does not check is given up byte by byte, so that nothing good is lost in it.

    Attributes
    ----------
    dropped : int
        Bytes that belonged to no message.
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.dropped = 0

    def cut(self, data: bytes, check: Callable[[bytes], Whole | None]) -> Iterator[Whole]:
        """Add bytes and return what `check` makes of every whole frame; it returns None for a false one."""
        self._buffer += data
        while self._buffer:
            length = self._length()
            if length is None:
                return
            frame = bytes(self._buffer[:length])
            whole = check(frame) if length > 1 else None
            if whole is None:
                self.dropped += 1
                del self._buffer[0]
            else:
                del self._buffer[:length]
                yield whole

    def end(self) -> None:
        """Forget what is not whole: a datagram holds whole messages only."""
        self.dropped += len(self._buffer)
        self._buffer.clear()

    def _length(self) -> int | None:
        """Length of the frame that seems to begin here; 1 if none does, None while too little has come."""
        buffer = self._buffer
        if buffer[0] not in {_V1, _V2}:
            return 1
        if len(buffer) < 3:
            return None
        if buffer[0] == _V2 and buffer[2] & ~_SIGNED:
            return 1
        length = buffer[1] + _V1_EXTRA if buffer[0] == _V1 else buffer[1] + _V2_EXTRA + _SIGNATURE * buffer[2]
        return length if len(buffer) >= length else None
