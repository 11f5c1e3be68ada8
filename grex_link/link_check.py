"""What one part of a scenario's ``[link]`` says about another: names, times, chances."""

from itertools import pairwise

from grex_link.config import Scenario
from grex_link.errors import ConfigError


def check_link(scenario: Scenario) -> None:
    """Check what needs neither the mission nor the modem.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    _check_times_and_names(scenario)
    _check_overlaps(scenario)
    _check_burst(scenario)
    _check_layers(scenario)


def _check_times_and_names(scenario: Scenario) -> None:
    link = scenario.link
    for number, outage in enumerate(link.outages):
        _check_craft(scenario, outage.craft, f"$.link.outages[{number}].craft")
        _check_end(outage.start_s, outage.end_s, f"$.link.outages[{number}].end_s")
    for number, jammer in enumerate(link.jammers):
        _check_end(jammer.start_s, jammer.end_s, f"$.link.jammers[{number}].end_s")
    for number, land in enumerate(link.land):
        for side, craft in enumerate(land.between):
            _check_craft(scenario, craft, f"$.link.land[{number}].between[{side}]")
        if land.between[0] == land.between[1]:
            raise ConfigError(f"$.link.land[{number}].between", f"{craft} needs no link to itself; name two craft")


def _check_craft(scenario: Scenario, craft: str, path: str) -> None:
    if craft not in scenario.craft:
        raise ConfigError(path, f"unknown craft {craft!r}; there are {', '.join(scenario.craft)}")


def _check_end(start_s: float, end_s: float, path: str) -> None:
    if end_s <= start_s:
        raise ConfigError(path, f"{end_s:g} s is not after start_s = {start_s:g} s")


def _check_overlaps(scenario: Scenario) -> None:
    """Refuse outages of one craft that overlap: it would not be clear when it is on again."""
    outages = sorted(enumerate(scenario.link.outages), key=lambda entry: (entry[1].craft, entry[1].start_s))
    for (_, before), (number, after) in pairwise(outages):
        if before.craft == after.craft and after.start_s < before.end_s:
            raise ConfigError(
                f"$.link.outages[{number}].start_s",
                f"{after.start_s:g} s lies in another outage of {after.craft}, which ends at {before.end_s:g} s",
            )


def _check_burst(scenario: Scenario) -> None:
    burst = scenario.link.burst
    if burst is not None and not burst.loss_good <= burst.loss <= burst.loss_bad:
        raise ConfigError(
            "$.link.burst.loss",
            f"{burst.loss:g} is no mean of loss_good {burst.loss_good:g} and loss_bad {burst.loss_bad:g}; "
            "it must lie between them",
        )


def _check_layers(scenario: Scenario) -> None:
    for number, (upper, lower) in enumerate(pairwise(scenario.link.water.layers), start=1):
        if lower[0] <= upper[0]:
            raise ConfigError(
                f"$.link.water.layers[{number}]", f"{lower[0]:g} m is not below {upper[0]:g} m: from above to below"
            )
