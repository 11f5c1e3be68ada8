"""Units of time: seconds inside, integer nanoseconds of mission time on the wire. No clock in here."""

NS = 1_000_000_000


def tick_ns(tick_s: float) -> int:
    """Length of a tick in nanoseconds."""
    return round(tick_s * NS)
