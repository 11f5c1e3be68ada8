"""Shorthand of a scenario file for many craft: ``[fleet]`` and ``[mission.formation]``, spelled out before all else.

What is run, recorded and hashed has a table and a place for each craft; nothing behind this file knows of a fleet.
"""

import math
import re
from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta

from grex_link.config_base import Config, NonNegative, Positive
from grex_link.errors import ConfigError

#: Ahead, starboard, below the reference point, metres.
Place = tuple[float, float, float]
_NUMBER = "{n}"
_Table = TypeVar("_Table")


class FleetConfig(Config, frozen=True):
    """Some craft that are alike."""

    count: Annotated[int, Meta(ge=1, le=200)]
    name: Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]*\{n\}[a-z0-9_]*\Z", max_length=31)] = "auv{n}"
    """Name of each; ``{n}`` is its number, from 1."""
    craft: dict[str, Any] = msgspec.field(default_factory=dict)
    """What each of them has: a table like ``[craft.NAME]``. What that says of one of them goes first."""


class FormationConfig(Config, frozen=True):
    """Places for all craft, in the order of the team, which is that of the formation polygon."""

    type: Literal["abreast", "astern", "v", "polygon"]
    """``abreast``: a line from port to starboard about the reference point; ``astern``: a line that begins at it;
    ``v``: from the end of the port wing over the tip, the reference point, to the end of the starboard wing;
    ``polygon``: regular, about the reference point, the first craft ahead and the others clockwise."""
    spacing_m: Positive
    """Distance between neighbours."""
    angle_deg: Annotated[float, Meta(ge=10.0, le=170.0)] = 90.0
    """Between the wings of a V."""
    below_m: NonNegative = 0.0
    """Depth of all below the reference point."""


def spell_out(document: dict[str, Any]) -> dict[str, Any]:
    """Put a table for each craft of the fleet, and a place for each craft of the formation.

    Parameters
    ----------
    document : dict
        A scenario as plain tables; it is not changed.

    Returns
    -------
    dict
        The same without ``fleet`` and ``mission.formation``. Craft of the fleet come first, by number.

    Raises
    ------
    ConfigError
        If the shorthand itself is at fault, or says again what is spelled out.
    """
    document = dict(document)
    fleet = document.pop("fleet", None)
    if fleet is not None:
        document["craft"] = _craft(_converted(fleet, FleetConfig, "$.fleet"), document.get("craft", {}))
    mission = document.get("mission")
    if isinstance(mission, dict) and "formation" in mission:
        document["mission"] = _with_places(dict(mission), document.get("craft"))
    return document


def places(formation: FormationConfig, count: int) -> list[Place]:
    """Places of so many craft in a formation, in order: ahead, starboard, below the reference point, metres."""
    make = {"abreast": _abreast, "astern": _astern, "v": _v, "polygon": _polygon}[formation.type]
    return [(ahead, starboard, formation.below_m) for ahead, starboard in make(formation, count)]


# -- inside -------------------------------------------------------------------------------------------------------


def _converted(table: Any, kind: type[_Table], path: str) -> _Table:
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        problem, _, at = str(error).partition(" - at `$")
        if "matching regex" in problem:
            problem = "must be a lower-case name with {n} in it, for instance auv{n}"
        raise ConfigError(path + at.removesuffix("`"), problem[0].lower() + problem[1:]) from None


def _craft(fleet: FleetConfig, own: Any) -> dict[str, Any]:
    if not isinstance(own, dict):
        raise ConfigError("$.craft", "expected a table for each craft")
    names = [fleet.name.replace(_NUMBER, str(number)) for number in range(1, fleet.count + 1)]
    pattern = re.compile(re.escape(fleet.name).replace(re.escape(_NUMBER), r"[1-9]\d*") + r"\Z")
    for name in own:
        if pattern.match(name) and name not in names:
            raise ConfigError(f"$.craft.{name}", f"is beyond the fleet, which goes to {names[-1]}; raise $.fleet.count")
    alike = {name: _merged(fleet.craft, own.get(name, {})) for name in names}
    return alike | {name: table for name, table in own.items() if name not in alike}


def _merged(general: Any, special: Any) -> Any:
    """Lay a table over another one, and the tables in it; one of another type replaces what was there."""
    if not (isinstance(general, dict) and isinstance(special, dict)) or special.get("type") not in {
        None,
        general.get("type"),
    }:
        return special
    both = {key: _merged(general[key], special[key]) for key in general.keys() & special.keys()}
    return {**general, **special, **both}


def _with_places(mission: dict[str, Any], craft: Any) -> dict[str, Any]:
    formation = _converted(mission.pop("formation"), FormationConfig, "$.mission.formation")
    if mission.get("type") != "lawnmower":
        raise ConfigError("$.mission.formation", "only a lawnmower has a formation")
    if "formation_m" in mission:
        raise ConfigError("$.mission.formation_m", "there is also $.mission.formation; one of the two says it all")
    team = list(craft) if isinstance(craft, dict) else []
    mission["formation_m"] = dict(zip(team, places(formation, len(team)), strict=True))
    return mission


def _abreast(formation: FormationConfig, count: int) -> list[tuple[float, float]]:
    return [(0.0, formation.spacing_m * (place - (count - 1) / 2.0)) for place in range(count)]


def _astern(formation: FormationConfig, count: int) -> list[tuple[float, float]]:
    return [(-formation.spacing_m * place, 0.0) for place in range(count)]


def _v(formation: FormationConfig, count: int) -> list[tuple[float, float]]:
    half = math.radians(formation.angle_deg) / 2.0
    back, aside = formation.spacing_m * math.cos(half), formation.spacing_m * math.sin(half)
    tip = (count - 1) // 2
    return [(-back * abs(place - tip), aside * (place - tip)) for place in range(count)]


def _polygon(formation: FormationConfig, count: int) -> list[tuple[float, float]]:
    if count < 2:
        return [(0.0, 0.0)] * count
    radius = formation.spacing_m / (2.0 * math.sin(math.pi / count))
    angles = [2.0 * math.pi * place / count for place in range(count)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]
