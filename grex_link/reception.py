"""What becomes of a packet that a receiver has locked to: the error figures of a modem, ready for many look-ups."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence

from grex_link.profile import BitErrors, ErrorTable, ModemProfile, Protocol, Threshold

#: Above this nothing changes any more, and powers of ten stay finite.
_LOUD_DB = 300.0


class Reception:
    """The error figures of a modem.

    Parameters
    ----------
    profile : ModemProfile
        Its tables and formulas.
    """

    __slots__ = ("_pieces", "_range", "_rate", "_survival")

    def __init__(self, profile: ModemProfile) -> None:
        self._rate, self._pieces = _figures(profile.reception)
        table, interference = profile.range_pdr, profile.interference_pdr
        self._range = None if table is None else Curve(table.range_m, table.pdr)
        self._survival = None if interference is None else Curve(interference.sir_db, interference.pdr)

    def packet_error_rate(self, sinr_db: float, size_bytes: int) -> float:
        """Probability that noise and interference spoil a packet: all its frames, or all its bits, must be whole.

        Parameters
        ----------
        sinr_db : float
            Lowest ratio of signal to interference and noise during the packet.
        size_bytes : int
            Length of the payload.

        Returns
        -------
        float
            From 0 to 1, never more for a stronger signal, never less for a longer payload.
        """
        rate, pieces = self._rate(sinr_db), self._pieces(size_bytes)
        return rate if pieces == 1 or rate >= 1.0 else -math.expm1(pieces * math.log1p(-rate))

    def range_delivery(self, range_m: float) -> float:
        """Share of packets that arrive over a range: held before the table's first point, 0 beyond its last.

        Parameters
        ----------
        range_m : float
            Metres.
        """
        if self._range is None:
            return 1.0
        return self._range(range_m) if range_m <= self._range.last else 0.0

    def interference_delivery(self, sir_db: float) -> float:
        """Share of packets that survive a ratio of signal to interference alone: held beyond the table's ends.

        Parameters
        ----------
        sir_db : float
            Infinite without interference.
        """
        return 1.0 if self._survival is None or sir_db == math.inf else self._survival(sir_db)


class Curve:
    """A table, linear between its points and held beyond them.

    Parameters
    ----------
    places, values : sequence of float
        The points; places increase.

    Attributes
    ----------
    last : float
        Place of the last point.
    """

    __slots__ = ("_places", "_values", "last")

    def __init__(self, places: Sequence[float], values: Sequence[float]) -> None:
        self._places, self._values = list(places), list(values)
        self.last = self._places[-1]

    def __call__(self, place: float) -> float:
        """Look up the value at a place."""
        places, values = self._places, self._values
        above = bisect_right(places, place)
        if above == 0 or above == len(places):
            return values[above and -1]
        start, end = values[above - 1], values[above]
        share = (place - places[above - 1]) / (places[above] - places[above - 1])
        # The rounding of neither may lead beyond the points.
        return min(max(start + share * (end - start), min(start, end)), max(start, end))


def _figures(
    reception: Threshold | ErrorTable | BitErrors | Protocol | None,
) -> tuple[Callable[[float], float], Callable[[int], int]]:
    """Error rate of a piece over SINR, and into how many pieces a payload goes."""
    if isinstance(reception, BitErrors):
        return _bit_error_rate(reception), lambda size_bytes: 8 * size_bytes
    if isinstance(reception, ErrorTable):
        frame = reception.frame_bytes
        pieces = _one if frame is None else lambda size_bytes: max(1, -(-size_bytes // frame))
        return Curve(reception.sinr_db, reception.per), pieces
    # In the protocol model whatever is not drowned is heard, and a modem without acoustics is never asked.
    least_db = reception.sinr_db if isinstance(reception, Threshold) else 0.0
    return lambda sinr_db: 0.0 if sinr_db >= least_db else 1.0, _one


def _one(size_bytes: int) -> int:
    del size_bytes
    return 1


def _bit_error_rate(reception: BitErrors) -> Callable[[float], float]:
    """BER of a modulation without coding in white noise (Proakis, Digital Communications, 4th ed., ch. 5)."""
    formula = _BIT_ERROR_RATES[reception.modulation]
    return lambda sinr_db: formula(10.0 ** (min(sinr_db + reception.gain_db, _LOUD_DB) / 10.0))


#: Over the ratio of signal to noise, as a power.
_BIT_ERROR_RATES: dict[str, Callable[[float], float]] = {
    "bpsk": lambda s: 0.5 * math.erfc(math.sqrt(s)),
    "dpsk": lambda s: 0.5 * math.exp(-s),
    "fsk": lambda s: 0.5 * math.exp(-0.5 * s),
}
