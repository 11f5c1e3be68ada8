"""Losses that no physics explains: evenly spread, or in bursts (Gilbert–Elliott), the same for every medium."""

import math

from grex_link import draws
from grex_link.link_config import BurstConfig, LinkConfig
from grex_link.units import NS


class BurstChannel:
    """One directed link's turns of good and bad times, on a fixed grid of steps that no traffic can change.

    Each stay in a state is one draw: geometric with the chain's rates (acoustic-link §3: π_B = (P - e_G)/(e_B - e_G),
    p_BG = dt/L, p_GB = p_BG·π_B/(1 - π_B)).

    Parameters
    ----------
    config : BurstConfig
        Mean loss, mean length, step and the losses in either state.
    seed : int
        Seed of the link.
    source, destination : str
        The link.
    """

    def __init__(self, config: BurstConfig, seed: int, source: str, destination: str) -> None:
        self._config = config
        self._who = ("burst", source, destination)
        self._seed = seed
        self._share_bad = bad_share(config)
        good = 1.0 - self._share_bad
        self._leave_bad = min(1.0, config.step_s / config.mean_length_s)
        if self._leave_bad * self._share_bad < good:
            self._leave_good = self._leave_bad * self._share_bad / good
        else:
            # So much loss cannot come in bursts so short: the loss holds, and the bursts are longer.
            self._leave_good = 1.0
            self._leave_bad = max(0.0, good / self._share_bad)
        self._bad = draws.uniform(seed, *self._who, "start") < self._share_bad
        self._stays = 0
        self._until_step = self._stay()

    def loss(self, t_ns: int) -> float:
        """Probability of loss at a time; times do not decrease."""
        step = int(t_ns / NS / self._config.step_s)
        while step >= self._until_step:
            self._bad = not self._bad
            self._stays += 1
            self._until_step += self._stay()
        return self._config.loss_bad if self._bad else self._config.loss_good

    def _stay(self) -> float:
        """Draw how many steps the present state lasts."""
        leave = self._leave_bad if self._bad else self._leave_good
        if leave <= 0.0:
            return math.inf
        if leave >= 1.0:
            return 1.0
        u = draws.uniform(self._seed, *self._who, self._stays)
        return 1.0 + math.floor(math.log1p(-u) / math.log1p(-leave))


def bad_share(config: BurstConfig) -> float:
    """Share of time π_B that a link is in its bad state."""
    spread = config.loss_bad - config.loss_good
    return (config.loss - config.loss_good) / spread if spread > 0.0 else 0.0


class ChannelLoss:
    """Whether a packet is lost for no physical reason.

    Parameters
    ----------
    link : LinkConfig
        ``loss`` and ``burst``.
    seed : int
        Seed of the link.
    """

    def __init__(self, link: LinkConfig, seed: int) -> None:
        self._link = link
        self._seed = seed
        self._bursts: dict[tuple[str, str], BurstChannel] = {}

    def reason(self, source: str, destination: str, t_ns: int, *which: object) -> str:
        """Say why a packet is lost: ``lost_noise`` (evenly spread), ``lost_burst``, or "" if it is not.

        Parameters
        ----------
        source, destination : str
            The directed link.
        t_ns : int
            True mission time of the decision.
        *which
            What tells this packet from all others of this source.
        """
        loss = self._link.loss
        if loss and draws.uniform(self._seed, "loss", source, *which, destination) < loss:
            return "lost_noise"
        if self._link.burst is None:
            return ""
        burst = self._bursts.get((source, destination))
        if burst is None:
            burst = self._bursts[source, destination] = BurstChannel(self._link.burst, self._seed, source, destination)
        bad = burst.loss(t_ns)
        if bad and (bad >= 1.0 or draws.uniform(self._seed, "burst_loss", source, *which, destination) < bad):
            return "lost_burst"
        return ""
