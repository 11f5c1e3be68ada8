"""The tables about ranges: what is done with them, navigation that needs them, and bases that watch by them."""

from typing import Annotated, Literal

from msgspec import Meta

from grex_link.config_base import Config, Finite, Name, NonNegative, Positive


class RangingConfig(Config, frozen=True):
    """Ranges that correct the position of craft whose navigation drifts, and that a base watches a craft with."""

    mode: Literal["off", "one_way", "two_way"] = "off"
    """``one_way``: of every message heard; needs clocks that agree to well below a millisecond. ``two_way``: the modem
    asks the other one to answer, which takes room in the own slot."""
    every: Annotated[int, Meta(ge=1, le=1000)] = 1
    """Two-way: after so many own messages one range is asked for."""
    sigma_m: Positive = 0.3
    """Noise of a range, with what the speed of sound is off, metres."""
    gate: Positive = 9.0
    """A range is an outlier if the square of its surprise is more than so many times its variance (χ², 1 degree of
    freedom: 9 rejects 0.3 % of good ones)."""
    memory_s: Annotated[float, Meta(ge=1.0, le=600.0)] = 60.0
    """How late a range may come and still be worked in at its time, seconds."""


class InertialConfig(Config, frozen=True):
    """What a craft knows of its own inertial navigation: its fixes have an error that stays, and that drifts.

    A craft without this has an absolute one (GPS), whose errors are noise.
    """

    offset_sigma_m: NonNegative = 0.5
    """Standard deviation of the error at the start, each axis, metres."""
    drift_sigma_mps: NonNegative = 0.01
    """Standard deviation of its rate, each axis, m/s."""
    drift_noise_mps: NonNegative = 1e-5
    """Change of that rate over a second: a random walk, m/s."""
    noise_m: Positive = 0.05
    """Noise of a fix from one to the next, metres."""


class BaseConfig(Config, frozen=True):
    """A modem at a known place, such as on a buoy or the sea bed: no part of the formation, it watches one craft."""

    place_ned_m: tuple[Finite, Finite, Finite]
    watch: Name
    """The craft it estimates, from its messages and from ranges."""
    told_time_s: Positive = 600.0
    """Time constant of the error of the positions that craft tells, seconds."""
    acceleration_noise_mps: NonNegative = 0.02
    """What the craft's velocity changes by over a second, besides its plan, m/s."""
