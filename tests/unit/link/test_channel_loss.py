"""Losses without physics: even ones, and bursts that are there whether anybody sends or not."""

import math
from itertools import pairwise

import pytest

from grex_link.channel_loss import BurstChannel, ChannelLoss, bad_share
from grex_link.link_config import BurstConfig, LinkConfig
from grex_link.units import NS

STEPS = 60_000


def states(config: BurstConfig, seed: int = 1, source: str = "a", destination: str = "b") -> list[float]:
    channel = BurstChannel(config, seed, source, destination)
    return [channel.loss(round((step + 0.5) * config.step_s * NS)) for step in range(STEPS)]


def test_share_of_bad_time() -> None:
    """π_B = (P - e_G)/(e_B - e_G), and 0 where both states are the same."""
    assert bad_share(BurstConfig(0.3, 5.0, loss_good=0.1, loss_bad=0.9)) == pytest.approx(0.25)
    assert bad_share(BurstConfig(0.3, 5.0)) == pytest.approx(0.3)
    assert bad_share(BurstConfig(0.3, 5.0, loss_good=0.3, loss_bad=0.3)) == 0.0


@pytest.mark.parametrize("length", [2.0, 8.0])
def test_lengths_of_good_and_bad_times(length: float) -> None:
    """Bad times last L on average, good ones L·(1 - π)/π, both geometric: the standard deviation is that of it."""
    bad = [loss == 1.0 for loss in states(BurstConfig(0.25, length))]
    turns = [step for step, (before, now) in enumerate(pairwise(bad), start=1) if before != now]
    lengths = [(bad[start], end - start) for start, end in pairwise(turns)]
    for state, mean in ((True, length), (False, 3.0 * length)):
        some = [steps for which, steps in lengths if which == state]
        deviation = math.sqrt(mean * (mean - 1.0))
        assert abs(sum(some) / len(some) - mean) < 4.0 * deviation / math.sqrt(len(some))
        spread = math.sqrt(sum((steps - mean) ** 2 for steps in some) / len(some))
        # The fourth moment of a geometric distribution is at most nine times its variance squared, and a little.
        assert abs(spread / deviation - 1.0) < 4.0 * math.sqrt(9.0 / 4.0 / len(some))


def test_bad_times_do_not_depend_on_traffic() -> None:
    """The same times are bad, whether a link is asked every step or now and then."""
    config = BurstConfig(0.4, 6.0, step_s=0.5)
    often = states(config)
    seldom = BurstChannel(config, 1, "a", "b")
    for step in range(0, STEPS, 37):
        assert seldom.loss(round((step + 0.5) * 0.5 * NS)) == often[step]


def test_links_have_bad_times_of_their_own() -> None:
    """There and back, and with another seed, the bad times are others: they agree as often as chance has it."""
    config = BurstConfig(0.5, 4.0)
    here = states(config)
    for other in (states(config, source="b", destination="a"), states(config, seed=2), states(config, destination="c")):
        share = sum(mine == its for mine, its in zip(here, other, strict=True)) / STEPS
        # Correlated over some 4 steps: one in eight of the steps counts as independent.
        assert abs(share - 0.5) < 4.0 * math.sqrt(0.25 / (STEPS / 8))


@pytest.mark.parametrize(("loss", "length_s"), [(0.0, 5.0), (1.0, 5.0)])
def test_always_and_never(loss: float, length_s: float) -> None:
    """A mean loss of 0 or 1 has no turns."""
    assert set(states(BurstConfig(loss, length_s))) == {loss}


def test_the_mean_loss_holds() -> None:
    """Where bursts so short cannot add up to so much loss, the loss is what was asked for."""
    for loss, length_s in ((0.9, 2.0), (0.6, 0.1)):
        share = sum(states(BurstConfig(loss, length_s))) / STEPS
        assert share == pytest.approx(loss, abs=0.01)


def test_reasons() -> None:
    """An even loss is ``lost_noise``, one in a bad time ``lost_burst``, and neither is none."""
    assert ChannelLoss(LinkConfig(loss=1.0), 1).reason("a", "b", 0, 0) == "lost_noise"
    always = LinkConfig(burst=BurstConfig(1.0, 5.0))
    assert ChannelLoss(always, 1).reason("a", "b", 0, 0) == "lost_burst"
    assert ChannelLoss(LinkConfig(), 1).reason("a", "b", 0, 0) == ""


def test_loss_within_a_state() -> None:
    """In either state the share of packets that is lost is that state's."""
    config = BurstConfig(0.3, 20.0, loss_good=0.1, loss_bad=0.7)
    channel, loss = BurstChannel(config, 1, "a", "b"), ChannelLoss(LinkConfig(burst=config), 1)
    counts = {0.1: [0, 0], 0.7: [0, 0]}
    for number in range(40_000):
        t_ns = number * NS
        lost = loss.reason("a", "b", t_ns, number) == "lost_burst"
        counts[channel.loss(t_ns)][lost] += 1
    for share, (whole, lost) in counts.items():
        assert abs(lost / (whole + lost) - share) < 4.0 * math.sqrt(share * (1.0 - share) / (whole + lost))


def test_draws_are_of_the_packet() -> None:
    """What becomes of a packet depends on itself alone, not on what was asked before."""
    fresh, used = ChannelLoss(LinkConfig(loss=0.5), 1), ChannelLoss(LinkConfig(loss=0.5), 1)
    for number in range(100):
        used.reason("a", "b", number, number)
    for number in range(200):
        assert fresh.reason("a", "b", 0, number) == used.reason("a", "b", 0, number)
