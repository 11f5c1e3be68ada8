"""How an autopilot comes up: what it does and does not say yet."""

from grex_sim.autopilot.family import BootTimes

_CONSOLE = (
    "Init autopilot V4.6",
    "Free RAM: 131071",
    "load_all took 1830us",
    "Barometer 1 calibration complete",
    "GPS 1: detecting",
    "\x00\xff\x1b[2J ins: calibrating gyros",
)


class Boot:
    """Phases of one start.

    Parameters
    ----------
    times : BootTimes
        Seconds at which a real one gets there.
    at_s : float
        When it got power.
    ready_s : float or None
        When its estimator shall be ready instead; every other time shrinks or stretches with it.
    """

    def __init__(self, times: BootTimes, at_s: float, ready_s: float | None = None) -> None:
        self.times = times
        self.at_s = at_s
        self.scale = 1.0 if ready_s is None else ready_s / times.ready_s

    def age_s(self, now_s: float) -> float:
        """Seconds since power-on: the time base of everything it says."""
        return now_s - self.at_s

    def past(self, phase_s: float, now_s: float) -> bool:
        """Whether a phase of the table has come."""
        return self.age_s(now_s) >= phase_s * self.scale

    def when(self, phase_s: float) -> float:
        """Time at which a phase of the table comes."""
        return self.at_s + phase_s * self.scale

    def talks(self, now_s: float) -> bool:
        """Whether heartbeats have begun."""
        return self.past(self.times.heartbeat_s, now_s)

    def settled(self, now_s: float) -> bool:
        """Whether modes that are accepted stay."""
        return self.past(self.times.settled_s, now_s)

    def console(self) -> list[tuple[float, bytes]]:
        """Text of the boot console, which comes over the link, and when."""
        count = self.times.console_lines
        step = self.times.heartbeat_s * 0.9 / max(count, 1)
        return [(self.when(n * step), f"{_CONSOLE[n % len(_CONSOLE)]}\r\n".encode("latin-1")) for n in range(count)]

    def why_not_armed(self, now_s: float) -> str:
        """Reason that arming fails, which changes while it comes up."""
        reasons = (
            (self.times.clock_s, "Arm: AHRS: EKF3 not started"),
            ((self.times.clock_s + self.times.arm_s) / 2.0, "Arm: GPS 1: Bad fix"),
            (self.times.arm_s, "Arm: Compass not healthy"),
            ((self.times.arm_s + self.times.ready_s) / 2.0, "Arm: AHRS: waiting for home"),
        )
        return next((text for until, text in reasons if not self.past(until, now_s)), "Arm: Need Position Estimate")
