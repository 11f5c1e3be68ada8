"""Lockstep by dataflow: no order of messages can change a result.

::

    hub ──Fix──► agents ──Setpoint, Transmit──► hub, link      every arrow may be late,
     ▲                                            │            and any message may overtake any other
     └────────────── LinkReport, ModemEvents ─────┘
"""

import random

import pytest
from missions import SCENARIOS, fly

import grex_sim.run
from grex_link.memory_bus import MemoryBus
from grex_link.scenario import load

SHORT = ("duration_s=300", "link.loss=0.2", "craft.auv3.navigation.white_m=0.5")


class ShufflingBus(MemoryBus):
    """Hands out the messages that are under way in any order at all, even those of one writer."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self._random = random.Random(seed)

    def put(self, topic, craft, message) -> None:
        super().put(topic, craft, message)
        place = self._random.randrange(len(self._queue)) if self._queue else 0
        self._queue.rotate(place)


@pytest.mark.parametrize("seed", range(8))
def test_any_order_of_messages_gives_the_same_digest(monkeypatch, seed):
    """Messages that overtake each other at random do not change the run by a bit."""
    straight = fly("paper-d", *SHORT)
    monkeypatch.setattr(grex_sim.run, "MemoryBus", lambda: ShufflingBus(seed))
    shuffled = fly("paper-d", *SHORT)
    assert shuffled.complete
    assert shuffled.digest == straight.digest


def test_the_digest_sees_a_difference():
    """Another seed of the losses, or another gain, gives another digest."""
    digests = {fly("paper-d", *SHORT, *more).digest for more in ([], ["link.seed=7"], ["team.gain_mps=0.81"])}
    assert len(digests) == 3


def test_craft_are_independent_of_each_others_noise():
    """Noise on one craft's navigation leaves the draws of another craft as they were (draws are keyed, not in turn)."""
    alone = load(SCENARIOS / "paper-a.toml", ["duration_s=50", "craft.auv3.navigation.white_m=0.5"])
    both = load(
        SCENARIOS / "paper-a.toml",
        ["duration_s=50", "craft.auv2.navigation.white_m=0.5", "craft.auv3.navigation.white_m=0.5"],
    )
    fixes = [recorded_fixes(scenario, "auv3") for scenario in (alone, both)]
    assert fixes[0] == fixes[1]


def recorded_fixes(scenario, craft: str) -> list:
    """Run a scenario and return what one agent was told of its position."""
    heard = []

    class ListeningBus(MemoryBus):
        def put(self, topic, to, message) -> None:
            if (topic, to) == ("fix", craft):
                heard.append(message)
            super().put(topic, to, message)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grex_sim.run, "MemoryBus", ListeningBus)
        grex_sim.run.simulate_in_process(scenario, None, lambda _: None)
    return heard
