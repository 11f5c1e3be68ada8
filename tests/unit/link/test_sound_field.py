"""The state machine of a receiver (acoustic-link §3), event by event, with literal times and levels."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from grex_link.propagation import Paths
from grex_link.sound_field import SEND, Sound, SoundField, power, ratio_db, sinr_db

NOISE_DB, LOUD_DB, WEAK_DB = 60.0, 100.0, 75.0
ACQUISITION_DB = 10.0


class Fate(NamedTuple):
    """What the listener was told."""

    t_ns: int
    what: str
    node: int
    reason: str
    sinr_db: float


class Field:
    """Four nodes; what they send reaches each of the others after 10 ns, or after the given delays."""

    def __init__(self, acquisition_db: float = ACQUISITION_DB) -> None:
        self.field = SoundField(4, power(NOISE_DB), acquisition_db, self)
        self.fates: list[Fate] = []

    def missed(self, t_ns: int, sound: Sound, index: int, reason: str, others: int) -> None:
        self._note(t_ns, sound, index, reason, others)

    def decide(self, t_ns: int, sound: Sound, index: int, others: int) -> None:
        self._note(t_ns, sound, index, "decided", others)

    def _note(self, t_ns: int, sound: Sound, index: int, reason: str, others: int) -> None:
        fate = Fate(t_ns, sound.content, sound.receivers[index], reason, round(sinr_db(sound, index, others), 6))
        self.fates.append(fate)

    def send(
        self, node: int, t_ns: int, what: str, *, level_db: float = LOUD_DB, airtime_ns: int = 100,
        turnaround_ns: int = 0, delays_ns: tuple[int, ...] = (10, 10, 10), audible: list[bool] | None = None,
    ) -> None:  # fmt: skip
        receivers = [other for other in range(4) if other != node]
        gaps = np.diff(delays_ns).tolist()
        paths = Paths(receivers, list(delays_ns), gaps, np.ones(3), np.full(3, level_db))
        sound = Sound((node, 0, 0, 0), t_ns, airtime_ns, paths, audible, what)
        self.field.at(t_ns, SEND, sound.key, lambda _: self.field.send(node, sound, turnaround_ns))

    def at(self, receiver: int) -> list[tuple[int, str, str]]:
        """Work through everything; return (ns, what, fate) at one receiver."""
        self.field.advance(10**9)
        return [(fate.t_ns, fate.what, fate.reason) for fate in self.fates if fate.node == receiver]

    def sinr(self, receiver: int) -> list[float]:
        self.field.advance(10**9)
        return [fate.sinr_db for fate in self.fates if fate.node == receiver]


def together(*levels_db: float) -> float:
    return 10.0 * math.log10(sum(10.0 ** (level_db / 10.0) for level_db in levels_db))


def test_a_sound_alone() -> None:
    """One sound is decided at its end at each of the others, with level over noise as its SINR."""
    field = Field()
    field.send(0, 1000, "x", delays_ns=(10, 20, 500))
    field.field.advance(10**9)
    assert field.fates == [
        Fate(1110, "x", 1, "decided", 40.0), Fate(1120, "x", 2, "decided", 40.0), Fate(1600, "x", 3, "decided", 40.0)
    ]  # fmt: skip


@pytest.mark.parametrize(("level_db", "reason"), [(69.99, "missed_snr"), (70.01, "decided")])
def test_acquisition(level_db: float, reason: str) -> None:
    """A receiver locks above the acquisition threshold, and not below."""
    field = Field()
    field.send(0, 0, "x", level_db=level_db)
    assert [fate for *_, fate in field.at(1)] == [reason]


def test_exactly_at_the_threshold() -> None:
    """A SINR that is exactly the threshold is not above it."""
    field = Field(acquisition_db=0.0)
    field.send(0, 0, "x", level_db=NOISE_DB)
    assert [fate for *_, fate in field.at(1)] == ["missed_snr"]


def test_acquisition_with_interference() -> None:
    """A sound that begins while another is there, to which nobody locked, is weighed against it, too."""
    field = Field()
    field.send(0, 0, "weak", level_db=69.0)
    field.send(1, 50, "loud", level_db=together(69.0, NOISE_DB) + 10.1)
    field.send(2, 300, "weak again", level_db=69.0)
    field.send(0, 350, "not loud enough", level_db=together(69.0, NOISE_DB) + 9.9)
    assert [fate for *_, fate in field.at(3)] == ["missed_snr", "decided", "missed_snr", "missed_snr"]


def test_the_newcomer_is_never_locked() -> None:
    """A locked receiver stays locked, however loud the newcomer, which interferes; its SINR is that of its start."""
    field = Field()
    field.send(0, 0, "first", level_db=WEAK_DB)
    field.send(1, 50, "second", level_db=120.0)
    assert field.at(2) == [(60, "second", "missed_busy"), (110, "first", "decided")]
    assert field.sinr(2) == pytest.approx([120.0 - together(WEAK_DB, NOISE_DB), WEAK_DB - together(120.0, NOISE_DB)])


def test_the_lowest_sinr_counts() -> None:
    """Of all that comes and goes during a packet the worst moment counts: the sum of what is there at once."""
    field = Field()
    field.send(0, 0, "packet", airtime_ns=1000)
    field.send(1, 100, "one", level_db=80.0, airtime_ns=100)
    field.send(2, 300, "two", level_db=80.0, airtime_ns=100)
    field.send(1, 350, "three", level_db=80.0, airtime_ns=100)
    field.send(2, 600, "four", level_db=82.0, airtime_ns=100)
    assert field.at(3)[-1] == (1010, "packet", "decided")
    assert field.sinr(3)[-1] == pytest.approx(100.0 - together(80.0, 80.0, NOISE_DB), abs=1e-5)


def test_one_ends_as_the_other_begins() -> None:
    """At equal times arrivals end before others begin: neither disturbs the other."""
    field = Field()
    field.send(0, 0, "first")
    field.send(1, 100, "second")
    assert field.at(2) == [(110, "first", "decided"), (210, "second", "decided")]
    assert field.sinr(2) == [40.0, 40.0]


def test_two_that_begin_together() -> None:
    """Of two that begin together (source, number) decides which is locked to; both suffer."""
    field = Field()
    field.send(1, 0, "second")
    field.send(0, 0, "first")
    assert field.at(2) == [(10, "second", "missed_busy"), (110, "first", "decided")]
    assert field.sinr(2)[1] == pytest.approx(100.0 - together(100.0, NOISE_DB), abs=1e-5)


def test_own_transmission_ends_a_lock() -> None:
    """A receiver that sends loses what it is locked to, at once; what is left of it is still noise afterwards."""
    field = Field()
    field.send(0, 0, "lost", airtime_ns=200)
    field.send(1, 50, "own", airtime_ns=50)
    field.send(2, 110, "next", level_db=105.0)
    assert field.at(1) == [(50, "lost", "aborted_own_tx"), (120, "next", "missed_snr")]


def test_deaf_while_it_sends() -> None:
    """What begins during a transmission or the turnaround after it is missed to its end, and interferes later."""
    field = Field()
    field.send(0, 0, "own", turnaround_ns=30)
    field.send(1, 119, "too early", level_db=80.0)
    field.send(2, 121, "heard")
    assert field.at(0) == [(129, "too early", "missed_halfduplex"), (231, "heard", "decided")]
    assert field.sinr(0)[1] == pytest.approx(100.0 - together(80.0, NOISE_DB), abs=1e-5)


def test_own_transmission_at_the_same_time() -> None:
    """At equal times arrivals end, arrivals begin, transmissions begin: heard to the end, or locked and cut off."""
    field = Field()
    field.send(0, 0, "heard")
    field.send(1, 110, "own", airtime_ns=100)
    field.send(0, 200, "heard as the own one ends")
    assert field.at(1) == [(110, "heard", "decided"), (310, "heard as the own one ends", "decided")]
    field = Field()
    field.send(0, 0, "cut off")
    field.send(1, 10, "own")
    assert field.at(1) == [(10, "cut off", "aborted_own_tx")]


def test_out_of_range() -> None:
    """Beyond the modem's reach nothing is locked to, but heard as noise, by those that are locked, too."""
    field = Field()
    field.send(0, 0, "far", audible=[True, False, True])
    field.send(1, 50, "near", level_db=105.0)
    field.send(3, 300, "locked", level_db=100.0)
    field.send(0, 350, "far again", level_db=95.0, audible=[True, False, True])
    assert [(what, fate) for _, what, fate in field.at(2)] == [
        ("far", "out_of_range"), ("near", "missed_snr"), ("far again", "out_of_range"), ("locked", "decided")
    ]  # fmt: skip
    assert field.sinr(2)[-1] == pytest.approx(100.0 - together(95.0, NOISE_DB), abs=1e-5)


def test_switched_off_and_on() -> None:
    """A modem that goes off loses its lock and hears nothing; what began meanwhile it does not lock to later."""
    field = Field()
    field.send(0, 0, "locked")
    field.field.at(50, SEND, (9, 0, 0, 0), lambda t_ns: field.field.switch(1, t_ns, off=True))
    field.send(2, 80, "began while off")
    field.field.at(120, SEND, (9, 1, 0, 0), lambda t_ns: field.field.switch(1, t_ns, off=False))
    field.send(3, 200, "after")
    assert [(what, fate) for _, what, fate in field.at(1)] == [
        ("locked", "aborted_off"), ("began while off", "missed_off"), ("after", "decided")
    ]  # fmt: skip


def test_noise_that_changes() -> None:
    """Noise that rises during a packet lowers its SINR, and falls back; what has ended is no part of it."""
    field = Field()
    field.send(1, 0, "over", level_db=120.0, airtime_ns=20)
    field.send(0, 100, "packet", airtime_ns=500)
    for t_ns, noise_db in ((200, 80.0), (300, 50.0)):
        field.field.advance(t_ns)
        field.field.set_noise(2, power(noise_db), t_ns)
    field.send(0, 1000, "later")
    assert field.sinr(2)[1:] == pytest.approx([20.0, 50.0], abs=1e-5)


def test_the_books_close() -> None:
    """After ten thousand sounds of all levels nothing is left of them: the noise is what it was, to the last bit."""
    field = Field()
    for number in range(10_000):
        field.send(number % 4, 37 * number, str(number), level_db=-150.0 + 0.0371 * number, airtime_ns=100)
    field.send(0, 10**7, "last")
    assert field.sinr(1)[-1] == 40.0
    assert len(field.fates) == 3 * 10_001


@pytest.mark.parametrize("level_db", [-400.0, -190.0, 0.0, 250.0])
def test_powers(level_db: float) -> None:
    """SINRs are exact for levels of which nothing is left, and ratios know both of their ends."""
    field = Field(acquisition_db=-100.0)
    field.send(0, 0, "x", level_db=level_db)
    assert field.sinr(1) == pytest.approx([level_db - NOISE_DB], abs=1e-6)
    assert ratio_db(0, 5) == -math.inf
    assert ratio_db(5, 0) == math.inf
    assert ratio_db(power(30.0), power(10.0)) == pytest.approx(20.0)
