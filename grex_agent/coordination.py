"""Coordination: the speed that keeps the team at one degree of execution (paper, eqs. 2 and 3)."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from grex_agent.plugin import build_plugin
from grex_link.config import TeamConfig
from grex_link.errors import ConfigError


class SpeedController(Protocol):
    """A coordination law; one instance serves a craft and its models of the mates."""

    def speed(self, planned_mps: float, own: float, mates: Sequence[float]) -> float:
        """Order a speed.

        Parameters
        ----------
        planned_mps : float
            Planned speed v' of the present track.
        own : float
            Own progress: track number plus Θ.
        mates : sequence of float
            Progress of the mates, as far as known.

        Returns
        -------
        float
            Speed over ground, m/s.
        """


@runtime_checkable
class TeamSpeeds(Protocol):
    """A law that needs only the sum of the mates' progress: models of many mates are then driven at once."""

    def speeds(
        self,
        planned_mps: npt.NDArray[np.float64],
        own: npt.NDArray[np.float64],
        mates_sum: npt.NDArray[np.float64],
        mates: int,
    ) -> npt.NDArray[np.float64]:
        """Order the speeds of many craft; the same as `SpeedController.speed` for each.

        Parameters
        ----------
        planned_mps, own, mates_sum : ndarray of float, shape (n,)
            Planned speed, progress, and sum of the progress of its mates, of each craft.
        mates : int
            How many mates each has.
        """


class ThetaP:
    """v_m = v'_m + K Σ (Θ_i − Θ_m), limited to [v_min, v_max] (GREX 2008, eq. 2).

    Θ is the cumulative one: the fractional Θ would jump from 1 to 0 where a craft changes its track.

    Parameters
    ----------
    config : TeamConfig
        Gain and limits.
    """

    def __init__(self, config: TeamConfig) -> None:
        self._gain = config.gain_mps
        self._min = config.speed_min_mps
        self._max = config.speed_max_mps

    def speed(self, planned_mps: float, own: float, mates: Sequence[float]) -> float:
        """Order a speed; see `SpeedController`."""
        wanted = planned_mps + self._gain * quality(own, mates)
        least, most = self._min, self._max
        # Comparisons, not min() and max(): this runs for every mate at every step.
        return least if wanted < least else most if wanted > most else wanted  # noqa: FURB136

    def speeds(
        self,
        planned_mps: npt.NDArray[np.float64],
        own: npt.NDArray[np.float64],
        mates_sum: npt.NDArray[np.float64],
        mates: int,
    ) -> npt.NDArray[np.float64]:
        """Order many speeds; see `TeamSpeeds`."""
        wanted = planned_mps + self._gain * (mates_sum - mates * own)
        return np.minimum(np.maximum(wanted, self._min), self._max)


def quality(own: float, mates: Sequence[float]) -> float:
    """Quality criterion Q_m = Σ (Θ_i − Θ_m), to be brought to zero for every craft (GREX 2008, eq. 3)."""
    return sum(mates) - len(mates) * own


#: Laws that remove the own speed error, which the own filter estimates.
UNBIASED = frozenset({"theta_p_unbiased", "shared_reference"})


def load_controller(config: TeamConfig) -> SpeedController:
    """Build the controller a scenario names.

    ``theta_p_unbiased`` is the same law: what is removed is removed from what the craft's frontseat is told, not from
    what the law orders, and so the mates' models of it hold.
    """
    law = "grex_agent.coordination:ThetaP"
    # The shared reference is no speed controller, and not asked for here; it is named for who misspells it.
    known = {"theta_p": law, "theta_p_unbiased": law, "shared_reference": ""}
    controller: SpeedController = build_plugin("$.team.controller", config.controller, known, config, "speed")
    return controller


def check_unbiased(config: TeamConfig) -> None:
    """Refuse a law that removes the own speed error where nothing estimates it.

    Raises
    ------
    ConfigError
        If there is no own filter.
    """
    if config.controller in UNBIASED and config.own_filter is None:
        raise ConfigError(
            "$.team.own_filter",
            f"is missing: {config.controller!r} removes the own speed error, and this estimates it; add "
            "[team.own_filter]",
        )
