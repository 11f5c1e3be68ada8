"""Serial links: a port that is there, or a pseudo-terminal of our own."""

import os
import pty
import termios
import tty
from contextlib import suppress
from pathlib import Path

_CHUNK = 65536


class Tty:
    """A serial port, or a pseudo-terminal of our own with a name for the other side."""

    datagrams = False

    def __init__(self, path: str, baud: int | None) -> None:
        self._name: Path | None = None
        self._slave: int | None = None
        if baud is None:
            self._file, self._slave = pty.openpty()
            device = os.ttyname(self._slave)
            tty.setraw(self._slave)
            self._link_to(device, path)
            self.where = f"serial port {device}" + (f" = {path}" if path else "")
        else:
            self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._file)
            _set_baud(self._file, baud)
            self.where = f"serial:{path}:{baud}"
        os.set_blocking(self._file, False)

    def files(self) -> list[int]:
        """File descriptors to wait for."""
        return [self._file]

    def receive(self, now_s: float) -> list[tuple[object, bytes]]:
        """Take what has come; a port that is gone gives nothing."""
        del now_s
        with suppress(OSError):
            data = os.read(self._file, _CHUNK)
            return [(self.where, data)] if data else []
        return []

    def send(self, data: bytes) -> None:
        """Send; what does not fit on the line is lost, as on a real one."""
        with suppress(OSError):
            os.write(self._file, data)

    def close(self) -> None:
        """Close it, and take its name away."""
        for file in (self._file, self._slave):
            if file is not None:
                os.close(file)
        if self._name is not None:
            self._name.unlink(missing_ok=True)

    def _link_to(self, device: str, path: str) -> None:
        if path:
            name = Path(path)
            if name.is_symlink():
                name.unlink()
            name.symlink_to(device)
            self._name = name


def _set_baud(file: int, baud: int) -> None:
    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise OSError(None, f"this system knows no {baud} baud")
    attributes = termios.tcgetattr(file)
    attributes[4] = attributes[5] = speed
    termios.tcsetattr(file, termios.TCSANOW, attributes)
