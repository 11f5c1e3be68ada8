"""Many craft in a few lines: a fleet of like craft, and formations by name.

A scenario may say ``[fleet]`` instead of a table for each craft, and ``mission.formation`` instead of a place for each.
Both are written out before anything else looks at the scenario: what is checked, recorded and hashed names every craft.
"""

import copy
import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from grex_link.config_base import Config, Positive
from grex_link.errors import ConfigError

Place = tuple[float, float, float]


class FleetConfig(Config, frozen=True):
    """Craft that are alike; a table ``[craft.NAME]`` besides changes one of them, or adds one."""

    count: Annotated[int, Meta(ge=1, le=200)]
    """How many."""
    name: Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]*\{n\}[a-z0-9_]*\Z")] = "auv{n}"
    """What they are called; {n} is 1, 2, …"""
    craft: dict[str, Any] = {}  # noqa: RUF012 - msgspec copies it
    """What each of them is like: as a table ``[craft.NAME]``."""


class LineFormation(Config, frozen=True, tag="line"):
    """One beside the other from port to starboard, or one after the other."""

    spacing_m: Positive
    """Distance of neighbours."""
    direction: Literal["abreast", "astern"] = "abreast"

    def places(self, count: int) -> list[Place]:
        """Place each craft: ahead, starboard, below the reference point, metres."""
        if self.direction == "astern":
            return [(-self.spacing_m * number, 0.0, 0.0) for number in range(count)]
        return [(0.0, self.spacing_m * (number - (count - 1) / 2.0), 0.0) for number in range(count)]


class VFormation(Config, frozen=True, tag="v"):
    """Two wings that fall back from the craft in the middle, from the port tip to the starboard one."""

    spacing_m: Positive
    """Distance of neighbours."""
    opening_deg: Annotated[float, Meta(gt=0.0, lt=180.0)] = 90.0
    """Angle between the wings."""

    def places(self, count: int) -> list[Place]:
        """Place each craft: ahead, starboard, below the reference point, metres."""
        half = math.radians(self.opening_deg) / 2.0
        wings = [number - count // 2 for number in range(count)]
        ahead, starboard = self.spacing_m * math.cos(half), self.spacing_m * math.sin(half)
        return [(-ahead * abs(wing), starboard * wing, 0.0) for wing in wings]


class PolygonFormation(Config, frozen=True, tag="polygon"):
    """On a circle about the reference point, evenly, clockwise from the one that leads."""

    spacing_m: Positive
    """Distance of neighbours: the side of the polygon."""

    def places(self, count: int) -> list[Place]:
        """Place each craft: ahead, starboard, below the reference point, metres."""
        radius = self.spacing_m / (2.0 * math.sin(math.pi / count)) if count > 1 else 0.0
        angles = [2.0 * math.pi * number / count for number in range(count)]
        return [(radius * math.cos(angle), radius * math.sin(angle), 0.0) for angle in angles]


Formation = LineFormation | VFormation | PolygonFormation


def write_out(document: dict[str, Any]) -> dict[str, Any]:
    """Write out a fleet and a formation; a document without them is returned as it is.

    Raises
    ------
    ConfigError
        If they cannot be read, or say what is said already.
    """
    fleet, mission = document.get("fleet"), document.get("mission")
    if fleet is not None:
        document = {key: value for key, value in document.items() if key != "fleet"}
        document["craft"] = _craft(_read("$.fleet", fleet, FleetConfig), document.get("craft", {}))
    if isinstance(mission, dict) and "formation" in mission:
        if "formation_m" in mission:
            raise ConfigError("$.mission.formation", "there is formation_m too, which places the craft: leave one out")
        formation: Formation = _read("$.mission.formation", mission["formation"], Formation)
        written = {key: value for key, value in mission.items() if key != "formation"}
        craft = document.get("craft")
        written["formation_m"] = _places(formation, list(craft) if isinstance(craft, dict) else [])
        document = {**document, "mission": written}
    return document


def _craft(fleet: FleetConfig, single: Any) -> Any:
    if not isinstance(single, dict):
        return single
    names = [fleet.name.replace("{n}", str(number)) for number in range(1, fleet.count + 1)]
    like = {name: copy.deepcopy(fleet.craft) for name in names}
    for name, table in single.items():
        like[name] = _merged(like[name], table) if name in like else table
    return like


def _merged(below: Any, above: Any) -> Any:
    """Lay one table over another; anything but tables is replaced."""
    if not (isinstance(below, dict) and isinstance(above, dict)):
        return above
    return {**below, **{key: _merged(below.get(key), value) for key, value in above.items()}}


def _places(formation: Formation, craft: Sequence[str]) -> dict[str, list[float]]:
    # To the micrometre: so the places look in print like what was meant.
    places = formation.places(len(craft))
    return {name: [round(x, 6) + 0.0 for x in place] for name, place in zip(craft, places, strict=True)}


def _read(path: str, value: Any, kind: Any) -> Any:
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        problem, _, at = str(error).partition(" - at `")
        raise ConfigError(path + at.removeprefix("$").removesuffix("`"), problem[0].lower() + problem[1:]) from None
