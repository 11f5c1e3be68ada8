"""What becomes of a packet between two modems: who can hear it, how it fades, and whether it comes out whole.

p_ok = channel · range table · (1 - PER(lowest SINR)), and more where a profile says so (acoustic-link §3, step 7).
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grex_link.channel_loss import ChannelLoss
from grex_link.packet import Draws, Packet
from grex_link.profile import ModemProfile, Protocol
from grex_link.propagation import Paths
from grex_link.reception import Reception
from grex_link.sound_field import Sound, ratio_db

#: In UnetStack's protocol model all levels are 0 dB; against this noise one is heard, and two are not.
_PROTOCOL_NOISE_DB = -10.0


class Hearing:
    """How the modems of a team hear each other.

    Parameters
    ----------
    profile : ModemProfile
        Everybody's modem.
    loss : ChannelLoss
        Losses that no physics explains.
    draws : Draws
        Chance.
    names : sequence of str
        The nodes.

    Attributes
    ----------
    reach_m : float
        Beyond this nothing is heard, by what the profile says itself.
    """

    def __init__(self, profile: ModemProfile, loss: ChannelLoss, draws: Draws, names: Sequence[str]) -> None:
        self._protocol = profile.reception if isinstance(profile.reception, Protocol) else None
        self._rician_k = None if self._protocol is not None else profile.rician_k
        self._lock_sinr_db = profile.lock_sinr_db
        self._reception = Reception(profile)
        self._loss = loss
        self._draws = draws
        self._names = names
        self.reach_m = _reach_m(profile)

    @property
    def lock_sinr_db(self) -> float:
        """SINR above which a receiver locks."""
        return 0.0 if self._protocol is not None else self._lock_sinr_db

    def noise_db(self, sea_db: float) -> float:
        """Level of the noise in the band, given that of the sea."""
        return sea_db if self._protocol is None else _PROTOCOL_NOISE_DB

    def paths(self, packet: Packet, paths: Paths) -> tuple[Paths, list[bool] | None]:
        """Let a packet fade on its paths; return them, and who could hear it at all (None for everybody)."""
        audible = None if self.reach_m == math.inf else (paths.range_m <= self.reach_m).tolist()
        if self._protocol is not None:
            levels = np.where(paths.range_m <= self._protocol.interference_m, 0.0, -np.inf)
            return paths._replace(level_db=levels), self._detected(self._protocol, packet, paths)
        if self._rician_k is not None:
            fading_db = self._fading_db(self._rician_k, packet, paths.receivers)
            paths = paths._replace(level_db=paths.level_db + fading_db)
        return paths, audible

    def loss_reason(self, sound: Sound, index: int, others: int, noise: int, t_ns: int) -> str:
        """Say why a packet is lost that a receiver was locked to; "" if it comes out whole.

        Parameters
        ----------
        sound : Sound
            Which one.
        index : int
            Which of its receivers.
        others : int
            Greatest power of noise and all other arrivals while it lasted.
        noise : int
            Power of the noise alone.
        t_ns : int
            True time of its end.
        """
        packet: Packet = sound.content
        node = sound.receivers[index]
        if self._protocol is not None:
            reason = self._by_protocol(self._protocol, sound, index, others)
        else:
            reason = self._by_figures(sound, index, others, noise)
        return reason or self._loss.reason(packet.name, self._names[node], t_ns, *self._draws.which(packet))

    def _by_protocol(self, protocol: Protocol, sound: Sound, index: int, others: int) -> str:
        node = sound.receivers[index]
        if sound.power[index] < others:
            return "lost_collision"
        garbled = sound.range_m[index] > protocol.communication_m
        chance = 1.0 - protocol.communication
        return "lost_noise" if garbled or self._draws.happens(chance, "communication", sound.content, node) else ""

    def _by_figures(self, sound: Sound, index: int, others: int, noise: int) -> str:
        packet: Packet = sound.content
        node, strength = sound.receivers[index], sound.power[index]
        happens, reception = self._draws.happens, self._reception
        per = reception.packet_error_rate(ratio_db(strength, others), packet.size)
        if happens(per, "error", packet, node):
            alone = reception.packet_error_rate(ratio_db(strength, noise), packet.size)
            return "lost_noise" if alone >= per else "lost_collision"
        if happens(1.0 - reception.range_delivery(float(sound.range_m[index])), "range", packet, node):
            return "lost_noise"
        if others > noise:
            survival = reception.interference_delivery(ratio_db(strength, others - noise))
            if happens(1.0 - survival, "interference", packet, node):
                return "lost_collision"
        return ""

    def _detected(self, protocol: Protocol, packet: Packet, paths: Paths) -> list[bool]:
        missed = 1.0 - protocol.detection
        return [
            distance_m <= self.reach_m and not self._draws.happens(missed, "detection", packet, node)
            for distance_m, node in zip(paths.range_m.tolist(), paths.receivers, strict=True)
        ]

    def _fading_db(self, k: float, packet: Packet, receivers: Sequence[int]) -> NDArray[np.float64]:
        """Draw Rician fading for every receiver of a packet; the mean power is 1."""
        steady, scatter = math.sqrt(k / (k + 1.0)), math.sqrt(0.5 / (k + 1.0))
        x, y = np.array([self._draws.normal("fading", packet, node) for node in receivers]).reshape(-1, 2).T
        gain: NDArray[np.float64] = (steady + scatter * x) ** 2 + (scatter * y) ** 2
        return 10.0 * np.log10(np.maximum(gain, 1e-12))


def _reach_m(profile: ModemProfile) -> float:
    reaches = [profile.range_max_m or math.inf]
    if isinstance(profile.reception, Protocol):
        reaches.append(profile.reception.detection_m)
    if profile.range_pdr is not None and profile.range_pdr.pdr[-1] == 0.0:
        reaches.append(profile.range_pdr.range_m[-1])
    return min(reaches)
