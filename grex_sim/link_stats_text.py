"""The pages of ``grex link stats`` for a person: tables of links and craft, and histograms as bars."""

from collections.abc import Mapping, Sequence
from textwrap import wrap

from grex_link.ledger import EDGES_S
from grex_link.messages import PathLedger, PortLedger
from grex_sim.link_stats import NodeStats, RunStats, Spread

_WIDTH = 110
_BAR = 20
_NONE = "-"
_LATENCY_COLUMN = 52


def as_text(stats: RunStats) -> str:
    """Return the statistics as text of at most 110 columns, names of usual length provided.

    Parameters
    ----------
    stats : RunStats
        What was found.
    """
    state = "cut off; drawn up from the log" if stats.recomputed else "whole"
    lines = [f"{stats.run}: {stats.mission_s:g} s of mission, {state}; times in seconds"]
    if stats.links:
        lines += ["", *_links_table(stats)]
    lines += ["", *_water_table(stats.nodes)]
    if any(node.port for node in stats.nodes.values()):
        lines += ["", *_ports_table(stats.nodes)]
    lines += [line for craft, node in stats.nodes.items() for line in _details(craft, node)]
    for name, link in stats.links.items():
        lines += ["", *_losses(name, link.counts), *_histograms(link.counts)]
    lines += [""] if stats.faults else []
    lines += [f"WARNING: the ledger does not add up: {fault}" for fault in stats.faults]
    return "\n".join(lines)


def _links_table(stats: RunStats) -> list[str]:
    heads = ["link", "sent", "delivered", "", "overheard", "lost", "", "on way"]
    heads += ["latency mean", "p50", "p90", "age mean", "p50", "p90"]
    rows = [
        [name, *_counts([link.counts]), *_spread(link.latency), *_spread(link.age)]
        for name, link in stats.links.items()
    ]
    if len(rows) > 1:
        paths = [link.counts for link in stats.links.values()]
        rows.append(["all", *_counts(paths), *_spread(stats.latency), *_spread(stats.age)])
    return _table([heads, *rows])


def _counts(paths: Sequence[PathLedger]) -> list[str]:
    sent = sum(path.sent for path in paths)
    delivered = sum(path.delivered for path in paths)
    overheard = sum(path.overheard for path in paths)
    lost = sum(sum(path.lost.values()) for path in paths)
    on_the_way = sum(path.on_the_way for path in paths)
    outcomes = delivered + overheard + lost
    return [str(sent), str(delivered), _percent(delivered, outcomes), str(overheard), str(lost),
            _percent(lost, outcomes), str(on_the_way)]  # fmt: skip


def _spread(spread: Spread) -> list[str]:
    return [_seconds(value) for value in (spread.mean_s, spread.p50_s, spread.p90_s)]


def _water_table(nodes: Mapping[str, NodeStats]) -> list[str]:
    rows = [["craft", "sent", "airtime", "of mission", "bytes", "refused by modem", "by land", "sound, J"]]
    for craft, node in nodes.items():
        water, share = node.water, f"{100 * node.airtime_share:.1f} %"
        refused = sum(water.refused.values())
        counts = (water.bytes_sent, refused, water.by_land)
        energy = _NONE if node.sound_j is None else f"{node.sound_j:.3g}"
        rows.append([craft, str(water.started), _seconds(water.airtime_s), share, *map(str, counts), energy])
    return _table(rows)


def _ports_table(nodes: Mapping[str, NodeStats]) -> list[str]:
    heads = ["port of", "requested", "refused", "superseded", "expired", "queued", "started"]
    rows = [[*heads, "slots owned", "used", "skipped"]]
    for craft, node in nodes.items():
        port = node.port
        if port is None:
            continue
        refused = sum(port.refused.values())
        fates = (port.requested, refused, port.superseded, port.expired, port.queued, port.started)
        slots = (port.slots_owned, port.slots_used, port.slots_skipped)
        rows.append([craft, *map(str, fates), *map(str, slots)])
    return _table(rows)


def _details(craft: str, node: NodeStats) -> list[str]:
    """Say of a craft what does not happen to most: refusals, failures, answers, land links, fragments."""
    water, port = node.water, node.port
    parts = [f"{reason} refused by the modem {n}" for reason, n in water.refused.items()]
    parts += [f"{purpose} sent {n}" for purpose, n in water.purposes.items() if purpose != "data"]
    parts += [f"by land {water.by_land} in {water.land_requests} requests"] if water.by_land else []
    parts += [] if port is None else _port_details(port)
    return wrap(f"{craft}: {', '.join(parts)}", _WIDTH, subsequent_indent="  ") if parts else []


def _port_details(port: PortLedger) -> list[str]:
    parts = [f"{reason} refused by the port {n}" for reason, n in port.refused.items()]
    parts += [f"{reason} failed {n}" for reason, n in port.failed.items()]
    rare = {"reassembled": port.reassembled, "abandoned": port.abandoned, "bad frames": port.bad_frames}
    return parts + [f"{word} {n}" for word, n in rare.items() if n]


def _losses(name: str, path: PathLedger) -> list[str]:
    outcomes = path.delivered + path.overheard + sum(path.lost.values())
    if not outcomes:
        return [f"{name}: nothing came to an end"]
    by_number = sorted(path.lost.items(), key=lambda entry: -entry[1])
    lost = ", ".join(f"{reason} {n} ({_percent(n, outcomes)})" for reason, n in by_number) or "nothing lost"
    return wrap(f"{name}: {lost}", _WIDTH, subsequent_indent="  ")


def _histograms(path: PathLedger) -> list[str]:
    """Latency and age beside each other, in rows of the same bins, from the first that holds anything to the last."""
    latencies = [float(count) for count in path.latency_counts]
    used = [place for place, pair in enumerate(zip(latencies, path.age_seconds, strict=True)) if any(pair)]
    if not used:
        return []
    places = range(used[0], used[-1] + 1)
    left = [_bar(latencies, place, f"{latencies[place]:.0f}") for place in places]
    right = [_bar(path.age_seconds, place, f"{_seconds(path.age_seconds[place])} s") for place in places]
    lines = [f"  {'latency':16s}{'deliveries':{_LATENCY_COLUMN - 18}s}age of information, time"]
    lines += [
        f"  {_bin(place):16s}{count:{_LATENCY_COLUMN - 18}s}{seconds}".rstrip()
        for place, count, seconds in zip(places, left, right, strict=True)
    ]
    return lines


def _bin(place: int) -> str:
    if place == len(EDGES_S):
        return f"{EDGES_S[-1]:g} s and more"
    return f"{EDGES_S[place - 1] if place else 0.0:g} - {EDGES_S[place]:g} s"


def _bar(values: Sequence[float], place: int, figure: str) -> str:
    """Draw a bar as long as a bin is full in comparison with the fullest; whatever is there is seen."""
    if not values[place]:
        return ""
    return f"{'█' * max(1, round(_BAR * values[place] / max(values)))} {figure}"


def _seconds(value: float | None) -> str:
    if value is None:
        return _NONE
    return f"{value:.3f}" if value < 10.0 else f"{value:.1f}"


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.1f} %" if whole else _NONE


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Align columns: the first to the left, all others to the right."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        " ".join(
            cell.ljust(width) if not place else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
