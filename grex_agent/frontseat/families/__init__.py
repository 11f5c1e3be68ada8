"""The families of autopilots: what differs between them, one small module each. A new one is one file and one line."""

from grex_agent.frontseat.dialect import Mavlink
from grex_agent.frontseat.families import px4, rover, sub
from grex_agent.frontseat.families.table import Family

KNOWN: dict[str, Family] = {family.name: family for family in (rover.FAMILY, sub.FAMILY, px4.FAMILY)}


def family_of(heartbeat: Mavlink, wanted: str) -> Family | None:
    """Find the family of an autopilot.

    Parameters
    ----------
    heartbeat : HEARTBEAT
        What it says of itself.
    wanted : str
        Name of a family, or ``auto``.

    Returns
    -------
    Family or None
        None if ``auto`` knows none that suits.
    """
    if wanted != "auto":
        return KNOWN[wanted]
    return next((family for family in KNOWN.values() if family.suits(heartbeat)), None)
