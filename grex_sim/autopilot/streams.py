"""Which message goes out how often on one link: defaults, asked intervals, limits. A reboot forgets what was asked."""

import math

from grex_sim.autopilot.message import Result

#: The groups of REQUEST_DATA_STREAM, which is old and still what MAVProxy asks for.
GROUPS: dict[int, tuple[str, ...]] = {
    1: ("RAW_IMU", "SCALED_PRESSURE"),
    2: ("SYS_STATUS", "POWER_STATUS", "MEMINFO", "MISSION_CURRENT", "GPS_RAW_INT", "NAV_CONTROLLER_OUTPUT"),
    3: ("SERVO_OUTPUT_RAW", "RC_CHANNELS"),
    6: ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    10: ("ATTITUDE", "SIMSTATE"),
    11: ("VFR_HUD",),
    12: ("SYSTEM_TIME", "EKF_STATUS_REPORT", "BATTERY_STATUS"),
}
_ALL = 0


class Streams:
    """Intervals of one link.

    Parameters
    ----------
    defaults : dict
        Messages sent without being asked, Hz.
    rate_max_hz : float or None
        What is asked for faster is denied.
    start_s : float
        When the first messages go out.
    """

    def __init__(self, defaults: dict[str, float], rate_max_hz: float | None, start_s: float) -> None:
        self._defaults = defaults
        self._rate_max_hz = rate_max_hz
        self._interval = {name: 1.0 / rate for name, rate in defaults.items()}
        # Spread, as a scheduler does, so that they do not all come in one burst.
        self._next = {
            name: start_s + gap * n / max(len(defaults), 1) for n, (name, gap) in enumerate(self._interval.items())
        }

    def ask(self, name: str, interval_us: float, now_s: float) -> Result:
        """Obey SET_MESSAGE_INTERVAL: -1 stops it, 0 is the default again."""
        if not math.isfinite(interval_us):
            return Result.DENIED
        if interval_us < 0:
            self._stop(name)
            return Result.ACCEPTED
        if interval_us == 0:
            rate = self._defaults.get(name, 0.0)
            self._stop(name) if rate == 0.0 else self._start(name, 1.0 / rate, now_s)
            return Result.ACCEPTED
        if self._rate_max_hz is not None and 1e6 / interval_us > self._rate_max_hz * 1.001:
            return Result.DENIED
        self._start(name, interval_us / 1e6, now_s)
        return Result.ACCEPTED

    def ask_group(self, group: int, rate_hz: float, *, start: bool, now_s: float) -> None:
        """Obey REQUEST_DATA_STREAM."""
        names = [name for names in GROUPS.values() for name in names] if group == _ALL else GROUPS.get(group, ())
        for name in names:
            wanted = min(rate_hz, self._rate_max_hz or rate_hz)
            self._start(name, 1.0 / wanted, now_s) if start and wanted > 0.0 else self._stop(name)

    def interval_us(self, name: str) -> int:
        """Interval of a message, microseconds; -1 if it is not sent."""
        return round(self._interval[name] * 1e6) if name in self._interval else -1

    def due(self, now_s: float) -> list[str]:
        """Take the names that are due; who was away does not get all that it missed."""
        names = [name for name, at_s in self._next.items() if at_s <= now_s]
        for name in names:
            gap = self._interval[name]
            self._next[name] = max(self._next[name] + gap, now_s + gap * 0.5)
        return names

    def _start(self, name: str, interval_s: float, now_s: float) -> None:
        self._interval[name] = interval_s
        self._next[name] = now_s + interval_s

    def _stop(self, name: str) -> None:
        self._interval.pop(name, None)
        self._next.pop(name, None)
