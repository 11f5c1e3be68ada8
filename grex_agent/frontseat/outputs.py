"""What the core of a frontseat gives out besides MAVLink messages: words for a person, and where the craft is."""

from dataclasses import dataclass
from typing import Literal

from grex_agent.frontseat.dialect import Mavlink


@dataclass(frozen=True, slots=True)
class Note:
    """One line for the log.

    Attributes
    ----------
    text : str
        What has happened, and what to do.
    level : str
        ``warn`` for what a user should look into.
    """

    text: str
    level: Literal["info", "warn"] = "info"


@dataclass(frozen=True, slots=True)
class Estimate:
    """Where the craft is, in the mission frame.

    Attributes
    ----------
    north_m, east_m, down_m : float
        Metres about the datum; what was known last when it is not valid.
    heading_rad : float
        Direction of the bow, [-π, π).
    speed_mps : float
        Over ground.
    sigma_m : float
        Standard deviation of each horizontal axis.
    valid : bool
        Whether an agent may use it.
    reason : str
        Why not.
    """

    north_m: float = 0.0
    east_m: float = 0.0
    down_m: float = 0.0
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    sigma_m: float = 0.0
    valid: bool = False
    reason: str = ""


Output = Mavlink | Note


def warn(text: str) -> Note:
    """Return a line that a user should look into."""
    return Note(text, "warn")
