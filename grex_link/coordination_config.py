"""The scenario's ``[team.reference]`` and ``[team.talk]``: the shared reference, and when a craft speaks."""

from typing import Annotated

from msgspec import Meta

from grex_link.config_base import Config, Positive, Probability


class ReferenceConfig(Config, frozen=True):
    """The reference that all craft share, for the controller ``shared_reference``; times are seconds of the plan."""

    gain_per_s: Positive = 0.15
    """How fast a craft makes up what it is behind or ahead of the reference."""
    deadband_s: Positive = 1.0
    """A craft that is less behind than this asks nobody to wait."""
    yield_gain_per_s: Positive = 0.2
    """How fast the reference falls back to a craft that asks for it."""
    yield_min: Probability = 0.3
    """Slowest that the reference runs, as a share of the plan."""
    silence_s: Positive = 900.0
    """A mate that has not been heard for so long, seconds, is no longer waited for."""


class PeriodicTalk(Config, frozen=True, tag="periodic"):
    """Every craft speaks in every own slot."""


class EventTalk(Config, frozen=True, tag="event"):
    """A craft speaks in an own slot if the mates need it, or after a long silence."""

    threshold_m: Positive = 0.5
    """It speaks if what the mates believe of its place on its path is wrong by more."""
    repeats: Annotated[int, Meta(ge=0, le=20)] = 0
    """In so many own slots after that it speaks again, in case it has been lost."""
    heartbeat_slots: Annotated[int, Meta(ge=1, le=1000)] = 9
    """It speaks at least in every so many-th own slot."""


TalkConfig = PeriodicTalk | EventTalk
