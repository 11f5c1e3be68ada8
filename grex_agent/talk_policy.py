"""Whether a craft speaks in an own slot: always, or only if the mates need it (team-navigation by events).

By events a craft compares its place with what the mates believe of it, which an estimator of the second level knows, or
the shared reference. "I sent it" is not "they have it": a message may be lost without the sender knowing. So it may
repeat itself, and after so many slots it speaks in any case.
"""

from typing import Protocol, runtime_checkable

from grex_link.coordination_config import EventTalk, TalkConfig
from grex_link.errors import ConfigError


@runtime_checkable
class Doubting(Protocol):
    """What knows what the mates believe of oneself.

    Attributes
    ----------
    doubt_m : float
        How far that is from the truth, metres along the own path.
    owes : bool
        Whether something is to be said in any case.
    """

    @property
    def doubt_m(self) -> float:
        """How far what the mates believe is from the truth."""

    @property
    def owes(self) -> bool:
        """Whether something is to be said in any case."""


class TalkPolicy(Protocol):
    """Decides, once in every own slot, whether to speak."""

    def speaks(self) -> bool:
        """Whether to speak in the slot that opens."""


class Periodic:
    """Speaks in every own slot."""

    def speaks(self) -> bool:
        """Whether to speak in the slot that opens."""
        return True


class ByEvents:
    """Speaks if the mates are wrong by more than a threshold, or after a long silence.

    Parameters
    ----------
    config : EventTalk
        Threshold, repetitions, longest silence.
    beliefs : Doubting
        What the mates believe.
    """

    def __init__(self, config: EventTalk, beliefs: Doubting) -> None:
        self._config = config
        self._beliefs = beliefs
        self._silent_slots = config.heartbeat_slots
        self._repeats = 0

    def speaks(self) -> bool:
        """Whether to speak in the slot that opens."""
        self._silent_slots += 1
        if self._beliefs.doubt_m > self._config.threshold_m:
            self._repeats = self._config.repeats
        elif self._repeats:
            self._repeats -= 1
        elif not self._beliefs.owes and self._silent_slots < self._config.heartbeat_slots:
            return False
        self._silent_slots = 0
        return True


def make_policy(config: TalkConfig, estimator: object) -> TalkPolicy:
    """Build the policy that a scenario asks for.

    Raises
    ------
    ConfigError
        If the estimator does not know what the mates believe.
    """
    if not isinstance(config, EventTalk):
        return Periodic()
    if not isinstance(estimator, Doubting):
        raise ConfigError(
            "$.team.talk",
            "'event' needs to know what the mates believe: take controller 'shared_reference', or an estimator of two "
            "levels: 'along_track', 'biased_planar', 'second_level'",
        )
    return ByEvents(config, estimator)
