"""Reads a scenario file, applies overrides, and turns every fault into one line that names its path."""

import hashlib
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from grex_link.config import Scenario, SimFrontseat
from grex_link.errors import ConfigError
from grex_link.fleet import spell_out
from grex_link.link_check import check_link
from grex_link.task_check import check_tasks
from grex_link.topics import is_reserved

_UNKNOWN = re.compile(r"Object contains unknown field `(.+?)`", re.DOTALL)
_MISSING = re.compile(r"Object missing required field `(.+?)`")
_KEY = "key` in `"
_AT = re.compile(r"^(?P<problem>.*?)(?: - at `(?P<path>.*?)`)?$", re.DOTALL)


def load(path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path : str or Path
        The TOML file.
    overrides : sequence of str
        ``path=value`` each, for instance ``link.loss=0.3``; the value is TOML, or a bare word taken as a string.

    Returns
    -------
    Scenario
        Decoded and checked for everything that needs no geometry.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise ConfigError(str(path), f"cannot read the scenario file: {reason}") from None
    return loads(text, overrides, name=str(path))


def loads(text: str, overrides: Sequence[str] = (), name: str = "scenario") -> Scenario:
    """Read a scenario from text; see `load`."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(name, f"not valid TOML: {error}") from None
    for override in overrides:
        _apply(document, override)
    return decode(document)


def decode(document: dict[str, Any]) -> Scenario:
    """Turn a document of plain tables into a checked scenario."""
    document = spell_out(document)
    link = document.get("link")
    mac = link.get("mac") if isinstance(link, dict) else None
    if isinstance(mac, dict):
        mac.setdefault("type", "tdma")  # so that `--set link.mac.cycle_s=60` is enough
    team = document.get("team")
    talk = team.get("talk") if isinstance(team, dict) else None
    if isinstance(talk, dict):
        talk.setdefault("type", "periodic")
    try:
        scenario = msgspec.convert(document, Scenario)
    except msgspec.ValidationError as error:
        raise _located(document, str(error)) from None
    _check_names(scenario)
    return scenario


def fingerprint(scenario: Scenario) -> str:
    """Short hash of all that must be the same for every participant of a run."""
    return hashlib.sha256(msgspec.json.encode(scenario)).hexdigest()[:12]


def _apply(document: dict[str, Any], override: str) -> None:
    path, equals, value = override.partition("=")
    keys = path.strip().removeprefix("$.").split(".")
    if not equals or not all(keys) or "\n" in override:
        raise ConfigError(_one_line(override), "an override has the form path=value, for instance link.loss=0.3")
    table = document
    for depth, part in enumerate(keys[:-1]):
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise ConfigError("$." + ".".join(keys[: depth + 1]), f"is a value, so {override!r} cannot go below it")
    try:
        table[keys[-1]] = tomllib.loads(f"value = {value.strip()}")["value"]
    except tomllib.TOMLDecodeError:
        table[keys[-1]] = value.strip()


def _located(document: dict[str, Any], error: str) -> ConfigError:
    """Name the path of msgspec's complaint, with the keys of dictionaries that it prints as ``[...]``."""
    match = _AT.match(error)
    problem, path = (match["problem"], match["path"] or "$") if match else (error, "$")
    if path.startswith(_KEY):
        path = path.removeprefix(_KEY) + "[...]"
    # Once for each key msgspec left out.
    for _ in range(path.count("[...]")):
        path = _with_key(document, path, error)
    for pattern, text in ((_UNKNOWN, "unknown key"), (_MISSING, "is missing")):
        if found := pattern.search(problem):
            return ConfigError(f"{path}.{_one_line(found[1])}", text)
    return ConfigError(path, _plain(problem))


def _one_line(key: str) -> str:
    return key.encode("unicode_escape").decode()


def _plain(problem: str) -> str:
    if "matching regex '^[a-z]" in problem:
        return "must be a lower-case name of letters, digits and _, beginning with a letter, 32 at most"
    if "matching regex '^(tcp|" in problem:
        return "must be an endpoint such as tcp/127.0.0.1:7447 or unixsock-stream//tmp/grex.sock"
    if "matching regex '^[A-Za-z_]" in problem:
        return "must be a known name or your_package.module:YourClass"
    return problem[0].lower() + problem[1:]


def _with_key(document: dict[str, Any], path: str, complaint: str) -> str:
    """Replace the first ``[...]`` of a path by the key whose entry alone gives the same complaint."""
    keys = path.partition("[...]")[0].removeprefix("$").strip(".").split(".")
    for entry, reduced in _one_entry_each(document, keys):
        try:
            msgspec.convert(reduced, Scenario)
        except msgspec.ValidationError as error:
            if str(error) == complaint:
                return path.replace("[...]", f".{_one_line(entry)}", 1)
    return path.replace("[...]", "", 1)


def _one_entry_each(document: dict[str, Any], keys: list[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    table: Any = document
    for part in keys:
        table = table.get(part, {}) if isinstance(table, dict) else {}
    for entry, value in table.items() if isinstance(table, dict) else ():
        reduced: Any = {entry: value}
        for depth in range(len(keys) - 1, -1, -1):
            outer: Any = document
            for part in keys[:depth]:
                outer = outer[part]
            reduced = {**outer, keys[depth]: reduced}
        yield entry, reduced


def _check_names(scenario: Scenario) -> None:
    """Check what one table says about another."""
    for craft in scenario.craft:
        if is_reserved(craft):
            raise ConfigError(
                f"$.craft.{craft}", "this name is taken by another participant on the bus; choose another"
            )
    _check_bases(scenario)
    check_link(scenario)
    check_tasks(scenario)
    _check_limits(scenario)


def _check_bases(scenario: Scenario) -> None:
    if scenario.bases.keys() == scenario.craft.keys():
        raise ConfigError("$.craft", "there are only bases; at least one craft must move")
    for base, config in scenario.bases.items():
        if config.watch not in scenario.formation:
            known = ", ".join(scenario.formation)
            raise ConfigError(f"$.craft.{base}.base.watch", f"no craft that moves: {config.watch!r}; there are {known}")
        for table in ("inertial", "frontseat"):
            if getattr(scenario.craft[base], table) not in {None, SimFrontseat()}:
                raise ConfigError(f"$.craft.{base}.{table}", "a base stays where it is; leave it out")


def _check_limits(scenario: Scenario) -> None:
    team = scenario.team
    if team.speed_min_mps > team.speed_max_mps:
        raise ConfigError("$.team.speed_min_mps", f"{team.speed_min_mps} is above speed_max_mps {team.speed_max_mps}")
    for name, craft_config in scenario.craft.items():
        for loop in ("roll", "pitch", "surge"):
            limits = getattr(craft_config.vehicle, loop)
            if limits.min > limits.max:
                raise ConfigError(f"$.craft.{name}.vehicle.{loop}.min", f"{limits.min} is above max {limits.max}")
