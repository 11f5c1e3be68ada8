"""A second opinion on ``grex medium``: the text of the specification as the plainest program that will do it.

It shares no code with `grex_link` and does not work like it. The product is a discrete-event core that keeps
sums up to date; this looks at one receiver at a time, holds every arrival there as an interval of time, and adds up
from scratch whatever overlaps. It is quadratic and proud of it.

Times are whole nanoseconds (acoustic-link §3), each given time, delay and airtime rounded once. Levels are
floats in dB re 1 µPa.

Where the text leaves a choice, this is what was read into it:

1. Equal times (§3: "arrival end, arrival start, tx start, then (source, sequence)"). The end of a transmission
   has no place in that list; a transmission fills [start, start + airtime), so that a source may send
   again, and hear again, at the very nanosecond it has finished.
2. Arrivals that start together are taken one after another by (source, sequence): the first does not yet see the
   second when it is acquired, and has it as interference at once afterwards. The second finds the receiver busy.
   Sources are in the order of the ``[[node]]`` tables, sequence is the order of the rows.
3. Acquisition is strict, ``SINR > acquisition`` (§3's table); survival is not: an error is a minimum that *fell
   below* (issue 3, item 7), so that a minimum of exactly the threshold is ``ok``.
4. A packet whose interference ends in the nanosecond it starts was never interfered with, and the other way round.
5. A receiver that starts to send in the nanosecond a packet starts to arrive locks and is cut off; in the nanosecond
   in which the packet ends, it has heard it all.
6. Of two rows of one source at one time the first in the file is sent and the second finds it busy.
7. What comes from a node in the same place arrives in the nanosecond it starts, but not before it does: after the
   other arrivals of that nanosecond, and after those transmissions that (source, sequence) puts first.
8. ``sinr_db`` is what the outcome was decided by: the lowest while the receiver was locked, and at the start of the
   arrival where it never was. The receiver's own transmission is no interference.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Water:
    """The constants of one replay, as in the TOML of issue 3."""

    sound_speed_mps: float
    spreading: float
    acquisition_sinr_db: float
    survival_sinr_db: float
    wind_mps: float
    shipping: float
    frequency_hz: float
    bandwidth_hz: float
    source_level_db: float
    bit_rate_bps: float
    nodes: dict[str, tuple[float, float, float]]


@dataclass(frozen=True)
class Verdict:
    """What became of one transmission at one receiver; levels of what was not sent are NaN."""

    outcome: str
    reason: str
    range_m: float
    delay_s: float
    level_db: float
    sinr_db: float


#: Moments in the order of their events: (ns, whether it is or follows a transmission's start, source, row).
Moment = tuple[int, bool, int, int]


@dataclass(frozen=True)
class Span:
    """One transmission where it is made or where it is heard: [start, end) in ns."""

    row: int
    moment: Moment
    start: int
    end: int
    level: float = math.nan

    def covers(self, moment: Moment) -> bool:
        """Whether it has begun by a moment, and has not ended."""
        return self.moment <= moment and moment[0] < self.end


def thorp(frequency_hz: float) -> float:
    """Return the absorption in dB/km (§2)."""
    square = (frequency_hz / 1000.0) ** 2
    return 0.11 * square / (1 + square) + 44 * square / (4100 + square) + 0.000275 * square + 0.003


def wenz(water: Water) -> float:
    """Return the noise in the band in dB re 1 µPa (§2)."""
    f = water.frequency_hz / 1000.0
    turbulence = 17 - 30 * math.log10(f)
    ships = 40 + 20 * (water.shipping - 0.5) + 26 * math.log10(f) - 60 * math.log10(f + 0.03)
    waves = 50 + 7.5 * math.sqrt(water.wind_mps) + 20 * math.log10(f) - 40 * math.log10(f + 0.4)
    thermal = -15 + 20 * math.log10(f)
    density = 10 * math.log10(sum(10 ** (part / 10) for part in (turbulence, ships, waves, thermal)))
    return density + 10 * math.log10(water.bandwidth_hz)


def received_level(water: Water, distance_m: float) -> float:
    """Return the level in dB re 1 µPa after `distance_m` of water (§2)."""
    spread = water.spreading * 10 * math.log10(max(distance_m, 1.0))
    return water.source_level_db - spread - thorp(water.frequency_hz) * distance_m / 1000.0


def nanoseconds(seconds: float) -> int:
    """Return the nearest whole nanosecond."""
    return round(seconds * 1e9)


def outcomes(water: Water, rows: list[tuple[float, str, int]]) -> dict[tuple[int, str], Verdict]:
    """Return the verdict for each (index of the row, receiver).

    Parameters
    ----------
    water : Water
        The constants and the nodes.
    rows : list of (float, str, int)
        ``time_s``, ``source``, ``payload_bytes``, in the order of the file.
    """
    on_air = _on_air(water, rows)
    verdicts: dict[tuple[int, str], Verdict] = {}
    for receiver in water.nodes:
        own = [span for span in on_air if rows[span.row][1] == receiver]
        fates = _listen(water, _heard(water, rows, on_air, receiver), own)
        for row, (_, source, _) in enumerate(rows):
            if source == receiver:
                continue
            distance = math.dist(water.nodes[source], water.nodes[receiver])
            outcome, reason, sinr = fates.get(row, ("not_sent_busy", "busy", math.nan))
            delay, level = distance / water.sound_speed_mps, received_level(water, distance)
            verdicts[row, receiver] = Verdict(outcome, reason, distance, delay, level, sinr)
    return verdicts


def _on_air(water: Water, rows: list[tuple[float, str, int]]) -> list[Span]:
    """Return every row whose source was free to send it."""
    places = {name: place for place, name in enumerate(water.nodes)}
    free: dict[str, int] = {}
    spans = []
    for row in sorted(range(len(rows)), key=lambda index: (nanoseconds(rows[index][0]), index)):
        time_s, source, payload = rows[row]
        start = nanoseconds(time_s)
        if start >= free.get(source, start):
            free[source] = start + nanoseconds(payload * 8 / water.bit_rate_bps)
            spans.append(Span(row, (start, True, places[source], row), start, free[source]))
    return spans


def _heard(water: Water, rows: list[tuple[float, str, int]], on_air: list[Span], receiver: str) -> list[Span]:
    """Return all that reaches `receiver`, in the order in which it begins."""
    sounds = []
    for span in on_air:
        source = rows[span.row][1]
        if source != receiver:
            distance = math.dist(water.nodes[source], water.nodes[receiver])
            delay = nanoseconds(distance / water.sound_speed_mps)
            moment = (span.start + delay, delay == 0, *span.moment[2:])
            level = received_level(water, distance)
            sounds.append(Span(span.row, moment, span.start + delay, span.end + delay, level))
    return sorted(sounds, key=lambda sound: sound.moment)


def _listen(water: Water, sounds: list[Span], own: list[Span]) -> dict[int, tuple[str, str, float]]:
    """Return row → (outcome, reason, SINR) for one receiver."""
    fates: dict[int, tuple[str, str, float]] = {}
    locked: Span | None = None
    released: Moment = (-1, False, 0, 0)  # when the last lock ended
    for sound in sounds:
        first = _sinr(water, sound, sounds, sound.moment)
        if any(span.covers(sound.moment) for span in own):
            fates[sound.row] = ("missed", "halfduplex", first)
        elif locked is not None and sound.moment < released:
            fates[sound.row] = ("missed", "busy", first)
        elif not first > water.acquisition_sinr_db:
            fates[sound.row] = ("missed", "acquisition", first)
        else:
            locked, full = sound, (sound.end, False, -1, 0)
            released = min([full, *(span.moment for span in own if sound.covers(span.moment))])
            lowest = _lowest(water, sound, sounds, released)
            if released != full:
                fates[sound.row] = ("missed", "own_tx", lowest)
            elif lowest < water.survival_sinr_db:
                fates[sound.row] = ("error", "sinr", lowest)
            else:
                fates[sound.row] = ("ok", "", lowest)
    return fates


def _lowest(water: Water, sound: Span, sounds: list[Span], released: Moment) -> float:
    """Return the lowest SINR until a lock ended; it can only fall when something begins."""
    moments = [other.moment for other in sounds if sound.moment <= other.moment < released]
    return min(_sinr(water, sound, sounds, moment) for moment in moments)


def _sinr(water: Water, sound: Span, sounds: list[Span], moment: Moment) -> float:
    """Return level over noise and all others at a moment in dB."""
    powers = [wenz(water), *(other.level for other in sounds if other is not sound and other.covers(moment))]
    return sound.level - 10 * math.log10(sum(10 ** (power / 10) for power in powers))
