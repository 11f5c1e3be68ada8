"""The families of autopilots: what differs between them, one small module each. A new one is one file and one line."""

from grex_agent.frontseat.dialect import Mavlink, mavlink
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


def describe(heartbeat: Mavlink) -> str:
    """Say what an autopilot says of itself, for a person."""
    names = []
    for enum, value in (("MAV_AUTOPILOT", heartbeat.autopilot), ("MAV_TYPE", heartbeat.type)):
        entry = mavlink.enums[enum].get(value)
        names.append(entry.name.removeprefix(enum + "_").lower().replace("_", " ") if entry else f"number {value}")
    return ", ".join(names)
