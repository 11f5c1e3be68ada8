"""A list of transmissions through the medium alone: ``grex medium SCHEDULE.csv --config LINK.toml --out OUTCOMES.csv``.

Every packet is `ok` if a receiver locked to it and its lowest SINR stayed at or above the survival threshold, `error`
if it fell below, `missed` if the receiver never locked or transmitted itself; nothing is drawn at random.
"""

import csv
import tomllib
from collections.abc import Iterable, Sequence
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta

from grex_link.acoustics import Water
from grex_link.config_base import Config, Finite, Positive
from grex_link.errors import ConfigError
from grex_link.link_config import FixedNoise, WaterConfig, WenzNoise
from grex_link.propagation import Paths, Propagation
from grex_link.sound_field import SEND, Sound, SoundField, power, sinr_db
from grex_link.units import NS

COLUMNS = (
    "time_s", "source", "receiver", "outcome", "reason", "range_m", "delay_s", "level_db", "sinr_db", "per",
)  # fmt: skip
SCHEDULE_COLUMNS = ("time_s", "source", "payload_bytes")
_LONGEST_S = Decimal(10**9)


class MediumConfig(Config, frozen=True):
    """The water, and when a receiver locks and survives."""

    acquisition_sinr_db: Annotated[float, Meta(ge=-100.0, le=200.0)]
    survival_sinr_db: Annotated[float, Meta(ge=-100.0, le=200.0)]
    sound_speed_mps: Positive = 1500.0
    absorption: Literal["thorp", "ainslie_mccolm"] = "ainslie_mccolm"
    spreading: Annotated[float, Meta(ge=0.0, le=4.0)] = 1.5
    noise: WenzNoise | FixedNoise = WenzNoise()
    temperature_c: Finite = 10.0
    salinity_ppt: Annotated[float, Meta(ge=0.0, le=45.0)] = 35.0
    ph: Annotated[float, Meta(ge=5.0, le=9.0)] = 8.0


class ModemConfig(Config, frozen=True):
    """Everybody's modem."""

    frequency_hz: Positive
    bandwidth_hz: Positive
    source_level_db: Annotated[float, Meta(ge=-100.0, le=300.0)]
    """dB re 1 µPa at 1 m."""
    bit_rate_bps: Positive


class NodeConfig(Config, frozen=True):
    """One node, which does not move."""

    id: str | int
    position_ned_m: tuple[Finite, Finite, Finite]


class ReplayConfig(Config, frozen=True):
    """A whole ``LINK.toml``."""

    medium: MediumConfig
    modem: ModemConfig
    node: Annotated[tuple[NodeConfig, ...], Meta(min_length=2, max_length=1000)]


class Transmission(NamedTuple):
    """One row of the schedule."""

    time_s: str
    """As it was given."""
    start_ns: int
    source: int
    payload_bytes: int


class Outcome(NamedTuple):
    """One row of the result, see `COLUMNS`."""

    outcome: str
    reason: str
    sinr_db: float
    per: float


def load_config(path: Path) -> ReplayConfig:
    """Read a ``LINK.toml``.

    Raises
    ------
    ConfigError
        With the path of the fault.
    """
    try:
        config = msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), ReplayConfig)
    except OSError as error:
        raise ConfigError(str(path), f"cannot read it: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise ConfigError(str(path), str(error)) from None
    names = [str(node.id) for node in config.node]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ConfigError(f"{path}: node", f"id {min(twice)!r} is given twice")
    return config


def load_schedule(path: Path, config: ReplayConfig) -> list[Transmission]:
    """Read a schedule: a CSV file whose first line names the columns ``time_s, source, payload_bytes``.

    Raises
    ------
    ConfigError
        With file and line of the fault.
    """
    places = {str(node.id): place for place, node in enumerate(config.node)}
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            missing = [name for name in SCHEDULE_COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                needed = ", ".join(SCHEDULE_COLUMNS)
                raise ConfigError(f"{path} line 1", f"column {missing[0]} is missing; needed are {needed}")
            return [_transmission(f"{path} line {reader.line_num}", row, places) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise ConfigError(str(path), f"cannot read it: {reason}") from None


def _transmission(where: str, row: dict[str, str | None], places: dict[str, int]) -> Transmission:
    text = {name: (row[name] or "").strip() for name in SCHEDULE_COLUMNS}
    try:
        time_s = Decimal(text["time_s"])
    except InvalidOperation:
        raise ConfigError(where, f"time_s {text['time_s']!r} is no number") from None
    if not (time_s.is_finite() and 0 <= time_s <= _LONGEST_S):
        raise ConfigError(where, f"time_s {text['time_s']} is not between 0 and {_LONGEST_S}")
    if text["source"] not in places:
        raise ConfigError(where, f"source {text['source']!r} is no node; there are {', '.join(places)}")
    if not text["payload_bytes"].isdecimal() or not 1 <= int(text["payload_bytes"]) <= 10**6:
        raise ConfigError(where, f"payload_bytes {text['payload_bytes']!r} is no whole number from 1 to 1000000")
    start_ns = int((time_s * NS).to_integral_value())
    return Transmission(text["time_s"], start_ns, places[text["source"]], int(text["payload_bytes"]))


class Replay:
    """Transmissions through the medium alone.

    Parameters
    ----------
    config : ReplayConfig
        Water, modem and nodes.
    schedule : sequence of Transmission
        In any order.
    """

    def __init__(self, config: ReplayConfig, schedule: Sequence[Transmission]) -> None:
        medium, modem = config.medium, config.modem
        self._config = config
        self._schedule = schedule
        self._survival_db = medium.survival_sinr_db
        water = WaterConfig(
            sound_speed=medium.sound_speed_mps,
            temperature_c=medium.temperature_c,
            salinity_ppt=medium.salinity_ppt,
            ph=medium.ph,
            absorption=medium.absorption,
            spreading=medium.spreading,
            noise=medium.noise,
        )
        self._water = Water(water, modem.frequency_hz, modem.bandwidth_hz)
        positions = [node.position_ned_m for node in config.node]
        self._propagation = Propagation(self._water, modem.source_level_db, positions)
        self._noise = power(self._water.noise_db)
        self._field = SoundField(len(config.node), self._noise, medium.acquisition_sinr_db, self)
        #: For each transmission and receiver.
        self._outcomes: dict[tuple[int, int], Outcome] = {}
        self._paths: list[Paths] = [self._propagation.paths(node, 0) for node in range(len(config.node))]

    def run(self) -> None:
        """Work through the whole schedule."""
        for number, row in enumerate(self._schedule):
            self._field.at(row.start_ns, SEND, (row.source, number, 0, 0), partial(self._send, number))
        while (next_ns := self._field.next_ns()) is not None:
            self._field.advance(next_ns + NS)

    def rows(self) -> Iterable[tuple[str, ...]]:
        """Return one row for each transmission, in the order of the schedule, and receiver; see `COLUMNS`."""
        names = [str(node.id) for node in self._config.node]
        for number, row in enumerate(self._schedule):
            paths = self._paths[row.source]
            by_node = {node: index for index, node in enumerate(paths.receivers)}
            for node, index in sorted(by_node.items()):
                outcome = self._outcomes[number, node]
                yield (
                    row.time_s, names[row.source], names[node], outcome.outcome, outcome.reason,
                    f"{paths.range_m[index]:.6f}", f"{paths.delay_ns[index] / NS:.9f}",
                    f"{paths.level_db[index]:z.6f}", f"{outcome.sinr_db:z.6f}", f"{outcome.per:g}",
                )  # fmt: skip

    def _send(self, number: int, t_ns: int) -> None:
        row = self._schedule[number]
        paths = self._paths[row.source]
        if t_ns < self._field.sending_until_ns[row.source]:
            for index, node in enumerate(paths.receivers):
                alone_db = paths.level_db[index] - self._water.noise_db
                self._outcomes[number, node] = Outcome("not_sent_busy", "busy", alone_db, 1.0)
            return
        airtime_ns = round(8.0 * row.payload_bytes / self._config.modem.bit_rate_bps * NS)
        sound = Sound((row.source, number, 0, 0), t_ns, airtime_ns, paths, None, number)
        self._field.send(row.source, sound, 0)

    def missed(self, t_ns: int, sound: Sound, index: int, reason: str, others: int) -> None:
        """See `Listener`."""
        del t_ns
        outcome = Outcome("missed", reason, sinr_db(sound, index, others), 1.0)
        self._outcomes[sound.content, sound.receivers[index]] = outcome

    def decide(self, t_ns: int, sound: Sound, index: int, others: int) -> None:
        """See `Listener`."""
        del t_ns
        lowest_db = sinr_db(sound, index, others)
        outcome = Outcome("ok", "", lowest_db, 0.0)
        if lowest_db < self._survival_db:
            alone = sinr_db(sound, index, self._noise) < self._survival_db
            outcome = Outcome("error", "lost_noise" if alone else "lost_collision", lowest_db, 1.0)
        self._outcomes[sound.content, sound.receivers[index]] = outcome


def replay(schedule: Path, config: Path, out: Path) -> dict[str, int]:
    """Read a schedule and a link, and write the outcomes.

    Returns
    -------
    dict of str to int
        How many there were of each outcome.

    Raises
    ------
    ConfigError
        If one of the files cannot be used, with the place of the fault.
    """
    link = load_config(config)
    play = Replay(link, load_schedule(schedule, link))
    play.run()
    counts = dict.fromkeys(("ok", "error", "missed", "not_sent_busy"), 0)
    try:
        with out.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            for row in play.rows():
                counts[row[3]] += 1
                writer.writerow(row)
    except OSError as error:
        raise ConfigError(str(out), f"cannot write it: {error.strerror}") from None
    return counts
