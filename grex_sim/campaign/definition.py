"""What a campaign is, as data: cells times seeds are its jobs. Pure; nothing is run here."""

import itertools
import tomllib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import msgspec

from grex_link.config import Scenario
from grex_link.errors import ConfigError

_OPTION = "--vary"
_OPENING, _CLOSING, _QUOTES = "[{", "]}", "\"'"


class Job(msgspec.Struct, frozen=True):
    """One run."""

    key: str
    """Names it within its campaign, for ever."""
    scenario: Scenario
    """With the seed of this run."""


class Cell(msgspec.Struct, frozen=True):
    """One combination of values, flown with every seed."""

    values: dict[str, Any]
    """For each path that varies, the value it has here; a number, a truth value or text."""
    scenario: Scenario


class Definition(msgspec.Struct, frozen=True):
    """What makes two campaigns the same."""

    scenario: Scenario
    """Before anything is varied."""
    vary: dict[str, list[str]]
    """For each path its values, as they were typed."""
    seeds: int
    """Every cell is flown with the scenario's seed and those that follow it, so many in all."""
    version: str
    """Of GREX."""
    own_files: dict[str, str] = {}
    """Hashes of the user's own modem profiles and plug-ins; see `grex_sim.campaign.own_files`."""


def parse_vary(options: Sequence[str]) -> dict[str, list[str]]:
    """Read ``path=value,value,…`` options; commas within brackets, braces and quotes belong to a value.

    Raises
    ------
    ConfigError
        If an option has no path or no values, or says the same twice.
    """
    vary: dict[str, list[str]] = {}
    for option in options:
        path, equals, text = option.partition("=")
        path = path.strip().removeprefix("$.")
        values = [value.strip() for value in _split(text)]
        if not (path and equals and all(values)):
            raise ConfigError(_OPTION, f"{option!r} does not have the form path=value,value: link.loss=0,0.1,0.3")
        if path == "seed":
            raise ConfigError(_OPTION, "the seed varies by itself: say how many with --seeds")
        if path in vary or len(set(values)) < len(values):
            raise ConfigError(_OPTION, f"{option!r} says the same twice")
        vary[path] = values
    return vary


def make_cells(decode: Callable[[Sequence[str]], Scenario], vary: dict[str, list[str]]) -> list[Cell]:
    """Decode the scenario of every combination of values.

    Parameters
    ----------
    decode : callable
        Gives the scenario with overrides ``path=value``.
    vary : dict
        See `parse_vary`.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    cells = []
    for values in itertools.product(*vary.values()):
        pairs = dict(zip(vary, values, strict=True))
        scenario = decode([f"{path}={value}" for path, value in pairs.items()])
        cells.append(Cell({path: plain_value(value) for path, value in pairs.items()}, scenario))
    return cells


def make_jobs(cells: Sequence[Cell], seeds: int) -> list[Job]:
    """Cross cells and seeds, seed by seed, so that a campaign that is cut off has something of every cell."""
    return [
        Job(job_key(number, seed), msgspec.structs.replace(cell.scenario, seed=cell.scenario.seed + seed))
        for seed in range(seeds)
        for number, cell in enumerate(cells)
    ]


def job_key(cell: int, seed: int) -> str:
    """Name the run of a cell with its so-manieth seed."""
    return f"{cell}:{seed}"


def plain_value(text: str) -> Any:
    """Read a value as TOML; a bare word, and whatever is no single number, is text."""
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
    return value if isinstance(value, bool | int | float | str) else text


def difference(recorded: Definition, wanted: Definition) -> str:
    """Say in a few words in what two definitions differ; empty if they are the same."""
    parts = []
    if recorded.seeds != wanted.seeds:
        parts.append(f"{recorded.seeds} seeds instead of {wanted.seeds}")
    if recorded.vary != wanted.vary:
        parts.append(f"varies {_said(recorded.vary)} instead of {_said(wanted.vary)}")
    if recorded.scenario != wanted.scenario:
        parts.append("another scenario")
    if recorded.version != wanted.version:
        parts.append(f"GREX {recorded.version} instead of {wanted.version}")
    names = sorted(recorded.own_files.keys() | wanted.own_files.keys())
    changed = [name for name in names if recorded.own_files.get(name) != wanted.own_files.get(name)]
    if changed and not parts:
        parts.append(f"what is in {', '.join(changed)} has changed since")
    return ", ".join(parts)


def _said(vary: dict[str, list[str]]) -> str:
    return " ".join(f"{path}={','.join(values)}" for path, values in vary.items()) or "nothing"


def _split(text: str) -> Iterator[str]:
    """Split at commas that stand neither in brackets or braces nor in quotes."""
    depth, quote, start = 0, "", 0
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in _QUOTES:
            quote = letter
        elif letter in _OPENING:
            depth += 1
        elif letter in _CLOSING:
            depth -= 1
        elif letter == "," and not depth:
            yield text[start:place]
            start = place + 1
    yield text[start:]
