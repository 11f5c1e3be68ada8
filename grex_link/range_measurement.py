"""What a modem measures of distances: travel times with clocks, noise, steps and outliers in them."""

from collections.abc import Sequence

from grex_link.craft_clock import CraftClock
from grex_link.link_config import RangingErrors
from grex_link.packet import Draws, Packet
from grex_link.profile import ModemProfile
from grex_link.units import NS


class RangeMeasurement:
    """Turns true travel times into measured ones.

    Parameters
    ----------
    profile : ModemProfile
        Noise, steps and ambiguity of the modem.
    errors : RangingErrors
        Outliers.
    nominal_mps : float
        Speed of sound that modems reckon with.
    draws : Draws
        Noise.
    """

    def __init__(self, profile: ModemProfile, errors: RangingErrors, nominal_mps: float, draws: Draws) -> None:
        self._profile = profile
        self._ranging = profile.ranging
        self._errors = errors
        self._nominal_mps = nominal_mps
        self._draws = draws

    def two_way_m(self, ping: Packet, elapsed_ns: int) -> float:
        """Range from the time between the start of a ping and the end of its answer, metres.

        Airtimes, decoding and the other modem's time to answer are known and taken off.
        """
        profile = self._profile
        known_ns = 2 * profile.ping_airtime_ns + round((self._ranging.reply_s + 2.0 * profile.decode_latency_s) * NS)
        range_m = 0.5 * (elapsed_ns - known_ns) / NS * self._nominal_mps
        return max(0.0, self._measured(range_m, "two_way", ping, None))

    def one_way_s(
        self, packet: Packet, node: int, left_ns: int, delay_ns: int, clocks: Sequence[CraftClock]
    ) -> float | None:
        """Arrival by the receiver's clock minus departure by the sender's, seconds; None if the modem cannot."""
        ranging = self._ranging
        if not ranging.one_way:
            return None
        error_ns = clocks[node].error_ns(left_ns + delay_ns) - packet.clock_error_ns
        travel_s = self._measured((delay_ns + error_ns) / NS * self._nominal_mps, "one_way", packet, node)
        travel_s /= self._nominal_mps
        return travel_s % ranging.ambiguity_s if ranging.ambiguity_s else travel_s

    def _measured(self, range_m: float, purpose: str, packet: Packet, node: int | None) -> float:
        draws, errors, ranging = self._draws, self._errors, self._ranging
        if ranging.sigma_m:
            range_m += ranging.sigma_m * draws.normal(purpose + "_noise", packet, node)[0]
        if draws.happens(errors.outlier_probability, purpose + "_outlier", packet, node):
            range_m += errors.outlier_m * draws.uniform(purpose + "_extra", packet, node)
        return round(range_m / ranging.step_m) * ranging.step_m if ranging.step_m else range_m
