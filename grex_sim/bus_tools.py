"""``grex topics``, ``grex echo`` and ``grex hz``: what is on the bus now, for a person at a terminal."""

import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import msgspec

from grex_link import clock
from grex_link.bus import Heard, Listener
from grex_link.errors import BusError
from grex_link.process import say
from grex_link.topics import TOPICS, place_of, who_of
from grex_sim.layout import table
from grex_sim.rates import Intervals

#: Wall seconds between two tables of ``grex hz``, and after which silence is worth a line.
_TELL_S = 1.0
_SILENCE_S = 3.0
_WAIT_S = 0.1


def list_topics(connect: str, seconds: float, *, as_json: bool) -> str:
    """Listen for some wall seconds and say who and what is there.

    Raises
    ------
    BusError
        If nobody is on the bus there.
    """
    intervals: dict[str, Intervals] = {}
    there: dict[str, set[str]] = {}
    with Listener((connect,)) as listener:
        listener.hear("grex/**")
        listener.hear_presence()
        for heard in _heard_for(listener, seconds):
            if heard.alive is None:
                intervals.setdefault(heard.key, Intervals()).add(clock.monotonic_s())
            else:
                team, who = who_of(heard.key)
                (there.setdefault(team, set()).add if heard.alive else there.setdefault(team, set()).discard)(who)
    if not intervals and not any(there.values()):
        raise BusError(f"somebody answers at {connect}, but no GREX run is there")
    rows = [_about(name, intervals[name]) for name in sorted(intervals)]
    if as_json:
        participants = {team: sorted(who) for team, who in sorted(there.items())}
        return msgspec.json.encode({"participants": participants, "topics": rows}).decode()
    lines = [f"team {team}: {', '.join(sorted(who)) or 'nobody'}" for team, who in sorted(there.items())]
    cells = [[row["key"], row["type"], row["writer"], _figure(row["hz"]), str(row["messages"])] for row in rows]
    return "\n".join([*lines, *table(("key", "type", "writer", "rate 1/s", "messages"), cells, left=3)])


def _heard_for(listener: Listener, seconds: float) -> Iterator[Heard]:
    end_s = clock.monotonic_s() + seconds
    while (left_s := end_s - clock.monotonic_s()) > 0.0:
        if heard := listener.take(min(left_s, _WAIT_S)):
            yield heard


def _about(name: str, intervals: Intervals) -> dict[str, Any]:
    place = place_of(name)
    return {
        "key": name,
        "type": _type_name(place.topic.type) if place else "unknown",
        "writer": " or ".join(place.topic.writers) if place else "",
        "hz": intervals.rate.hz,
        "messages": intervals.rate.messages,
    }


def _type_name(kind: Any) -> str:
    return getattr(kind, "__name__", None) or " or ".join(part.__name__ for part in kind.__args__)


def echo_messages(key: str, connect: str) -> None:
    """Print what is put on a key, a JSON object a line, until Ctrl-C or until the run is over."""
    bad: Counter[str] = Counter()
    decoders: dict[str, msgspec.msgpack.Decoder[Any]] = {}
    with Listener((connect,)) as listener, _telling_dropped(listener), suppress(KeyboardInterrupt):
        for heard in _heard_until_over(listener, key):
            place = place_of(heard.key)
            kind = place.topic.name if place else ""
            if kind not in decoders:
                decoders[kind] = msgspec.msgpack.Decoder(TOPICS[kind].type if kind else Any)
            try:
                line = msgspec.json.encode({"key": heard.key, "message": decoders[kind].decode(heard.payload)})
            except (
                msgspec.DecodeError,
                msgspec.ValidationError,
                UnicodeDecodeError,
                RecursionError,
                TypeError,
            ) as error:
                bad[heard.key] += 1
                if bad[heard.key] == 1:
                    say(f"grex: {heard.key}: a message of {len(heard.payload)} bytes does not decode: {error}")
                continue
            sys.stdout.write(line.decode() + "\n")
            sys.stdout.flush()
    for name, count in sorted(bad.items()):
        say(f"grex: {name}: {count} messages did not decode")


def measure_rates(key: str, connect: str) -> None:
    """Print how often messages come, every second anew, until Ctrl-C or until the run is over."""
    intervals: dict[str, Intervals] = {}
    told_s = clock.monotonic_s()
    with Listener((connect,)) as listener, _telling_dropped(listener), suppress(KeyboardInterrupt):
        for heard in _heard_until_over(listener, key, tick=True):
            now_s = clock.monotonic_s()
            if heard.key:
                intervals.setdefault(heard.key, Intervals()).add(now_s)
            if now_s - told_s >= _TELL_S and intervals:
                told_s = now_s
                print(_rates(intervals), flush=True)  # noqa: T201
    if intervals:
        print(_rates(intervals), flush=True)  # noqa: T201


def _rates(intervals: dict[str, Intervals]) -> str:
    headings = ("key", "messages", "mean 1/s", "min s", "max s", "std s")
    rows = []
    for name, entry in sorted(intervals.items()):
        rate = entry.rate
        figures = [_figure(value) for value in (rate.hz, rate.min_s, rate.max_s, rate.std_s)]
        rows.append([name, str(rate.messages), *figures])
    return "\n".join(table(headings, rows, left=1)) + "\n"


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


@contextmanager
def _telling_dropped(listener: Listener) -> Iterator[None]:
    """Say at the end what was left out."""
    yield
    if listener.dropped:
        say(f"grex: {listener.dropped} messages came too fast and were left out")


def _heard_until_over(listener: Listener, key: str, *, tick: bool = False) -> Iterator[Heard]:
    """Yield messages of a key expression until the simulator leaves; between them now and then an empty one."""
    listener.hear(key)
    listener.hear_presence()
    silent_since_s: float | None = clock.monotonic_s()
    while True:
        heard = listener.take(_WAIT_S)
        if heard is None:
            if tick:
                yield Heard("", b"", None)
            if silent_since_s is not None and clock.monotonic_s() - silent_since_s > _SILENCE_S:
                silent_since_s = None
                say(f"grex: nothing on {key} so far; `grex topics` says what there is")
        elif heard.alive is None:
            silent_since_s = None
            yield heard
        elif not heard.alive and who_of(heard.key)[1] == "sim":
            say("grex: the run is over")
            return
