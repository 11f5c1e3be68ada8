"""Every exception GREX raises on purpose, each with the one line a user needs.

Stale fixes, silent mates and lost messages are *states*, never exceptions.
"""


class GrexError(Exception):
    """Base of all errors that end a command with one clear line.

    Attributes
    ----------
    exit_status : int
        What the process exits with.
    """

    exit_status = 1


class ConfigError(GrexError):
    """A scenario, an override or a command line that cannot work.

    Parameters
    ----------
    path : str
        Where the fault is, in the notation ``$.link.loss``.
    problem : str
        What is wrong there, and what would be right.
    """

    exit_status = 2

    def __init__(self, path: str, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path
        self.problem = problem


class BusError(GrexError):
    """Not everybody is on the bus, or not with the same scenario."""


class RecordingError(GrexError):
    """A recording that cannot be written any more, as on a full disk."""


class WireError(GrexError):
    """A compact payload that cannot be packed or unpacked."""


class FaultError(GrexError):
    """A run that could not go on: who stopped it, and at what mission time.

    Parameters
    ----------
    who : str
        The participant at fault, for instance ``agent auv2``.
    problem : str
        What happened to it.
    time_s : float or None
        Mission time of the fault, seconds; None before the first tick.
    """

    def __init__(self, who: str, problem: str, time_s: float | None) -> None:
        when = "before the first tick" if time_s is None else f"at mission time {time_s:.1f} s"
        super().__init__(f"{who} {problem} {when}")
        self.who = who
        self.problem = problem
        self.time_s = time_s
