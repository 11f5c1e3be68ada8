"""Events in pictures of plans and runs: where they are, and the survey that is to be done there."""

import math
from typing import Any

import numpy as np

from grex_link.config import Scenario


def mark_events(axes: Any, scenario: Scenario) -> None:
    """Mark where events are, and the survey that is to be done there."""
    for number, event in enumerate(scenario.events):
        north, east, _ = event.at_ned_m
        around = np.linspace(0.0, 2.0 * math.pi, 61 if event.shape == "circle" else 5) + math.pi / 4.0
        reach = event.radius_m * (1.0 if event.shape == "circle" else math.sqrt(2.0))
        label = "" if number else "event, and the survey of it"
        axes.plot(east, north, "*", color="#D55E00", markeredgecolor="black", markersize=15, zorder=6, label=label)
        axes.plot(east + reach * np.sin(around), north + reach * np.cos(around), color="black", linewidth=0.8, zorder=5)
        axes.annotate(
            f"{event.at_s:g} s", (east, north), (9, 6), textcoords="offset points", fontsize="small", zorder=6
        )
