"""Files of the user's own that a scenario names: modem profiles and plug-ins. A run depends on what is in them."""

from collections.abc import Iterator, Sequence
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from grex_link.config import Scenario
from grex_link.profile import own_profile


def own_files(scenarios: Sequence[Scenario]) -> dict[str, str]:
    """Return the hash of each such file, by the name the scenarios have for it."""
    return {name: sha256(path.read_bytes()).hexdigest() for each in scenarios for name, path in _named(each)}


def _named(scenario: Scenario) -> Iterator[tuple[str, Path]]:
    profile = own_profile(scenario.link.profile)
    if profile is not None:
        yield scenario.link.profile, profile
    for name in (scenario.team.estimator, scenario.team.controller):
        module, colon, _ = name.partition(":")
        found = find_spec(module) if colon else None
        if found is not None and found.origin is not None:
            yield module, Path(found.origin)
