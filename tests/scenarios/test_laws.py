r"""The laws of acoustic-link §6, measured through the real medium with at least 20 000 packets each.

Three craft stand in a triangle::

            c
           / \        every side the same: equal levels, so that two packets that overlap spoil each other
          /   \
         a --- b

A measured share must be within 4·sqrt(P(1 - P)/n) of what the law says.
"""

import math
from itertools import pairwise

import pytest
from acoustic_water import AcousticWater, fates, plain, triangle

from grex_link.link_config import BurstConfig, LinkConfig
from grex_link.mac import PureAlohaMac, SlottedAlohaMac
from grex_link.messages import LinkEvent
from grex_link.units import NS

TEAM = ("a", "b", "c")
NEXT = {"a": "b", "b": "c", "c": "a"}
PACKETS = 20_000
#: So close that delays (0.1 ms) are nothing beside the second that a packet takes.
CLOSE = triangle(0.15)


def assert_share(right: int, of: int, law: float) -> None:
    assert of >= PACKETS
    assert abs(right / of - law) <= 4.0 * math.sqrt(law * (1.0 - law) / of), f"{right / of:.4f}, not {law:.4f} ({of})"


def started(log: list[LinkEvent]) -> list[LinkEvent]:
    return [line for line in log if line.kind == "started"]


# -- Aloha -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", [0.1, 0.3, 1.0])
def test_pure_aloha(load: float) -> None:
    """Of three half-duplex nodes with Poisson requests, [e^(-λT)/(1 + λT)]² of the packets arrive at a receiver.

    A request that finds its own modem transmitting is not sent: each node is a renewal process of a packet T and a
    pause of mean 1/λ. The other two nodes must both be silent when a packet begins (1/(1 + λT) each) and remain so
    (e^(-λT) each). One receiver is counted for each packet, because the two share the third node's silence.
    """
    rate = load / 3.0  # λ for T = 1 s
    duration_s = 1.02 * PACKETS * (1.0 + rate) / (3.0 * rate)
    water = AcousticWater(CLOSE)
    mac = PureAlohaMac(rate, 64, seed=4)
    for craft in TEAM:
        for opening_ns in mac.openings(craft, 0, round(duration_s * NS)):
            water.send(craft, opening_ns / NS)
    log = water.run()
    whole = {which for which, reason in fates(log).items() if not reason}
    sent = started(log)
    heard = sum((line.source, line.seq, NEXT[line.source]) in whole for line in sent)
    law = (math.exp(-rate) / (1.0 + rate)) ** 2
    assert_share(heard, len(sent), law)
    # The same as throughput: 0.216 for G = 1, and not 0.135 as for infinitely many nodes.
    throughput = heard / duration_s
    assert throughput == pytest.approx(load / (1.0 + rate) * law, rel=0.06)


@pytest.mark.parametrize("load", [0.5, 1.0, 2.0])
def test_finite_slotted_aloha(load: float) -> None:
    """Of N = 3 nodes that speak with q = 1 - e^(-G/N) in a slot, N·q·(1 - q)² of the slots succeed."""
    probability = 1.0 - math.exp(-load / 3.0)
    slots = PACKETS
    slot_ns = round(1.1 * NS)
    water = AcousticWater(CLOSE)
    mac = SlottedAlohaMac(probability, slot_ns, 64, seed=4)
    for craft in TEAM:
        for opening_ns in mac.openings(craft, 0, slots * slot_ns):
            water.send(craft, opening_ns / NS)
    log = water.run()
    outcomes = fates(log)
    good = {line.t_ns // slot_ns for line in log if line.kind == "delivered"}
    assert_share(len(good), slots, 3.0 * probability * (1.0 - probability) ** 2)
    # In a slot of one speaker both others hear it; in any other slot nobody hears anybody.
    assert sum(not reason for reason in outcomes.values()) == 2 * len(good)


# -- TDMA ------------------------------------------------------------------------------------------------------------


def tdma(delay_s: float, guard_s: float) -> list[str]:
    """Let three nodes at saturation take turns, and return the fates of all packets at all receivers."""
    water = AcousticWater(triangle(1500.0 * delay_s))
    for number in range(PACKETS):
        water.send(TEAM[number % 3], number * (1.0 + guard_s))
    return list(fates(water.run()).values())


@pytest.mark.parametrize(("delay_s", "guard_s"), [(0.3, 0.5), (1.0, 1.0)])
def test_tdma_with_a_guard_that_is_long_enough(delay_s: float, guard_s: float) -> None:
    """As long as the guard is not shorter than the delay, everything arrives."""
    reasons = tdma(delay_s, guard_s)
    assert len(reasons) == 2 * PACKETS
    assert not any(reasons)


def test_tdma_with_a_guard_that_is_too_short() -> None:
    """With a guard of 0.5 s and a delay of 1.0 s exactly half arrives: the next speaker deafens itself every time.

    The last packet alone has no next speaker, and is heard by both.
    """
    reasons = tdma(1.0, 0.5)
    assert reasons.count("") == PACKETS + 1
    assert reasons.count("aborted_own_tx") == PACKETS - 1


# -- age of information ----------------------------------------------------------------------------------------------

CYCLE_S = 30.0
AIRTIME_S = 10.0


def receptions(loss: float, packets: int) -> list[tuple[float, float]]:
    """Return (time of validity, time of delivery) of what a craft hears of another 500 m away in the paper's cycle."""
    places = {"a": (0.0, 0.0, 0.0), "b": (500.0, 0.0, 0.0)}
    water = AcousticWater(places, plain(airtime_fixed_s=AIRTIME_S), LinkConfig(loss=loss))
    for number in range(packets):
        water.send("a", number * CYCLE_S)
    return [(line.seq * CYCLE_S, line.t_ns / NS) for line in water.run() if line.kind == "delivered"]


def mean_age_s(heard: list[tuple[float, float]]) -> float:
    """Integrate the age exactly: it grows with time from each delivery to the next."""
    area = 0.0
    for (valid_s, from_s), (_, to_s) in pairwise(heard):
        area += 0.5 * ((to_s - valid_s) ** 2 - (from_s - valid_s) ** 2)
    return area / (heard[-1][1] - heard[0][1])


def test_age_of_information_without_loss() -> None:
    """In the paper's cycle at 500 m the mean age is T + τ + C/2 = 25.3 s."""
    heard = receptions(0.0, 200)
    assert mean_age_s(heard) == pytest.approx(AIRTIME_S + 500.0 / 1500.0 + CYCLE_S / 2.0, abs=1e-6)


def test_age_of_information_with_loss() -> None:
    """With p = 0.8 the mean age is T + τ + C(1/p - 1/2) = 32.8 s, within four standard errors."""
    heard = receptions(0.2, PACKETS)
    law = AIRTIME_S + 500.0 / 1500.0 + CYCLE_S * (1.0 / 0.8 - 0.5)
    assert_share(len(heard), PACKETS, 0.8)
    # The mean age is T + τ + ΣY²/(2ΣY) over the intervals Y between deliveries; its error is that of a ratio.
    intervals = [later - earlier for (_, earlier), (_, later) in pairwise(heard)]
    ratio = sum(y * y for y in intervals) / sum(intervals)
    spread = math.sqrt(sum((y * y - ratio * y) ** 2 for y in intervals)) / (2.0 * sum(intervals))
    assert spread < 0.2
    assert abs(mean_age_s(heard) - law) < 4.0 * spread


# -- losses ----------------------------------------------------------------------------------------------------------

PAIR = {"a": (0.0, 0.0, 0.0), "b": (75.0, 0.0, 0.0)}


@pytest.mark.parametrize("loss", [0.0, 0.3, 0.6, 1.0])
def test_even_loss(loss: float) -> None:
    """The share of packets lost evenly is the one asked for."""
    water = AcousticWater(PAIR, link=LinkConfig(loss=loss))
    for number in range(PACKETS):
        water.send("a", 1.5 * number)
    reasons = list(fates(water.run()).values())
    assert set(reasons) <= {"", "lost_noise"}
    assert_share(reasons.count("lost_noise"), len(reasons), loss)


@pytest.mark.parametrize(("loss", "length_s"), [(0.1, 4.0), (0.3, 10.0), (0.6, 1.0), (0.95, 5.0)])
def test_burst_loss(loss: float, length_s: float) -> None:
    """The share of packets lost in bursts is the one asked for; they are sent so seldom that each is on its own.

    Where so much loss cannot come in bursts so short, the loss holds and the bursts are longer.
    """
    apart_s = 12.0 * length_s
    water = AcousticWater(PAIR, link=LinkConfig(burst=BurstConfig(loss=loss, mean_length_s=length_s)))
    for number in range(PACKETS):
        water.send("a", apart_s * number)
    reasons = list(fates(water.run()).values())
    assert set(reasons) <= {"", "lost_burst"}
    assert_share(reasons.count("lost_burst"), len(reasons), loss)


def test_a_link_that_is_always_bad() -> None:
    """A burst loss of 1 loses everything, however short its bursts."""
    water = AcousticWater(PAIR, link=LinkConfig(burst=BurstConfig(loss=1.0, mean_length_s=5.0)))
    for number in range(1000):
        water.send("a", 1.5 * number)
    assert set(fates(water.run()).values()) == {"lost_burst"}


def test_mean_burst_length() -> None:
    """A link that is asked every step is lost for the mean length of a burst at a time."""
    water = AcousticWater(PAIR, plain(airtime_fixed_s=0.5), LinkConfig(burst=BurstConfig(loss=0.3, mean_length_s=6.0)))
    for number in range(3 * PACKETS):
        water.send("a", float(number))
    log = water.run()
    lost = [line.kind == "lost" for line in log if line.kind != "started"]
    assert len(lost) == 3 * PACKETS
    bursts = sum(now and not before for before, now in pairwise([False, *lost]))
    # Lengths are geometric with leaving probability 1/6 a step: variance (1 - 1/6)·36.
    assert abs(sum(lost) / bursts - 6.0) < 4.0 * math.sqrt(30.0 / bursts)
