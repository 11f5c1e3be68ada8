"""What users write on the command line, checked; every fault is one line that says what to write."""

import math
from pathlib import Path

from grex_link.errors import ConfigError
from grex_sim.autopilot.place import Place

_KEY_BYTES = 32


class Checked:
    """Numbers within their limits.

    Raises
    ------
    ConfigError
        If one is not.
    """

    def __init__(self, *, sysid: int, speedup: float, ready_s: float | None, noise_m: float) -> None:
        self.sysid = int(_within("--sysid", sysid, 1, 255))
        self.speedup = _within("--speedup", speedup, 0.1, 100.0)
        self.ready_s = None if ready_s is None else _within("--ready", ready_s, 0.1, 600.0)
        self.noise_m = _within("--noise", noise_m, 0.0, 1000.0)


def read_start(text: str) -> tuple[Place, float]:
    """Read ``LAT,LON[,HEADING]``, degrees; returns the place and the heading in radians."""
    numbers = _numbers("--start", text, (2, 3), "LAT,LON[,HEADING] in degrees")
    place = Place(_within("--start", numbers[0], -85.0, 85.0), _within("--start", numbers[1], -180.0, 180.0))
    return place, math.radians(numbers[2]) if len(numbers) > 2 else 0.0


def read_vector(option: str, text: str) -> tuple[float, float]:
    """Read ``NORTH,EAST``, m/s."""
    north, east = _numbers(option, text, (2,), "NORTH,EAST in m/s")
    return north, east


def read_parameters(texts: tuple[str, ...]) -> dict[str, float]:
    """Read every ``NAME=VALUE``."""
    values = {}
    for text in texts:
        name, _, value = text.partition("=")
        values[name.strip().upper()] = _numbers("--param", value, (1,), f"NAME=VALUE, not {text!r}")[0]
    return values


def read_key(path: Path | None) -> bytes | None:
    """Read a signing key: 64 hexadecimal digits."""
    if path is None:
        return None
    try:
        key = bytes.fromhex(path.read_text(encoding="ascii").strip())
    except OSError as error:
        raise ConfigError("--signing-key-file", f"cannot read {path}: {error.strerror}") from None
    except ValueError:
        key = b""
    if len(key) != _KEY_BYTES:
        raise ConfigError("--signing-key-file", f"{path} must hold {2 * _KEY_BYTES} hexadecimal digits, nothing else")
    return key


def _numbers(option: str, text: str, counts: tuple[int, ...], form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(math.isfinite(number) for number in numbers):
        raise ConfigError(option, f"write {form}")
    return numbers


def _within(option: str, value: float, least: float, most: float) -> float:
    if not least <= value <= most:
        raise ConfigError(option, f"must be from {least:g} to {most:g}, not {value:g}")
    return value
