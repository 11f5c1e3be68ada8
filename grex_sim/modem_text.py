"""Modem profiles as a text for a person: what ``grex modems`` prints."""

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

import msgspec

from grex_link.errors import ConfigError
from grex_link.profile import ModemProfile, Ranging, load_profile, profile_names
from grex_sim.modem_figures import BASES, Figures, Use, base_of, figures

_WIDTH = 110
_NOTHING = "–"
_UNITS = {"_s": "s", "_m": "m", "_hz": "Hz", "_db": "dB", "_bytes": "bytes", "_bits": "bits", "_byte_s": "s a byte"}
_LEGEND = {
    "guard": "for this range, and the clock error and jitter of a scenario without changes",
    "cycle C": "of TDMA, one slot a craft",
    "age": "mean age of what a mate knows: latency + airtime + sound's way + C·(1/p - 1/2), p the share heard",
    "assumed": "what the row rests on and nobody has published: longest payload n, airtime T, latency L, band B, "
    "source level SL, error figures PER; grex modems NAME says more",
}


def modems_text(names: Sequence[str], use: Use) -> str:
    """Lay out a table of modems.

    Parameters
    ----------
    names : sequence of str
        Profiles that come with GREX, or paths of files.
    use : Use
        Payload, range and team.
    """
    modems = [figures(name, load_profile(name), use) for name in names]
    rows = [_row(modem) for modem in modems]
    headings = ("modem", "payload", "airtime", "SNR", "heard", "guard", "slot", "cycle", "age", "ranging", "assumed")
    units = ("", "at most", "s", "dB", "%", "s", "s", "s", "s", "", "")
    widths = [max(map(len, column)) for column in zip(headings, units, *rows, strict=True)]
    lines = [f"{len(rows)} modems, for {_use(use)}", ""]
    for row in (headings, units, *rows):
        cells = (cell.ljust(wide) if place in {0, 9, 10} else cell.rjust(wide)
                 for place, (cell, wide) in enumerate(zip(row, widths, strict=True)))  # fmt: skip
        lines.append(("  " + "  ".join(cells)).rstrip())
    notes = [*_LEGEND.items(), *_without_age(modems)]
    return "\n".join([*lines, "", *(line for label, text in notes for line in _entry(label, text, 9))])


def modem_text(name: str, use: Use) -> str:
    """Say all about one modem: its figures in a use, its profile with what is assumed, its sources."""
    profile = load_profile(name)
    return "\n".join([
        f"{name}: {profile.title}", "", *_uses(figures(name, profile, use), use),
        "", "Profile", *profile_lines(profile),
        "", "Sources", *(line for source in profile.sources for line in _wrapped("  ", source)),
    ])  # fmt: skip


def as_json(names: Sequence[str], use: Use) -> str:
    """One JSON array of `Figures`."""
    return msgspec.json.encode([figures(name, load_profile(name), use) for name in names]).decode()


def modem_as_json(name: str, use: Use) -> str:
    """One JSON object: the `Figures` of a modem and its whole profile."""
    profile = load_profile(name)
    return msgspec.json.encode({"figures": figures(name, profile, use), "profile": profile}).decode()


def show(name: str | None, use: Use, *, json: bool) -> str:
    """Give what ``grex modems`` prints.

    Raises
    ------
    ConfigError
        For a modem that does not exist, or a use that makes no sense.
    """
    limits = (
        ("payload", use.payload_bytes, 0, 65_535),
        ("range", use.range_m, 0, 100_000),
        ("craft", use.craft, 1, 200),
    )
    for option, value, least, most in limits:
        if not least <= value <= most:  # so that not-a-number is refused, too
            raise ConfigError(f"--{option}", f"{value:g} is not within {least} … {most}")
    if name is None:
        return (as_json if json else modems_text)(profile_names(), use)
    try:
        return (modem_as_json if json else modem_text)(name, use)
    except ConfigError as error:
        raise ConfigError("NAME", error.problem) from None


# -- layout -------------------------------------------------------------------------------------------------------


def _use(use: Use) -> str:
    return f"messages of {use.payload_bytes} bytes among {use.craft} craft within {use.range_m:g} m"


def _row(modem: Figures) -> tuple[str, ...]:
    symbols = {base_of(field) for field in modem.assumed}
    whole = modem.payload_max_bits == 8 * modem.payload_max_bytes
    return (
        modem.name,
        f"{modem.payload_max_bytes} B" if whole else f"{modem.payload_max_bits} bit",
        _number(modem.airtime_s, 3),
        _number(modem.snr_db, 0),
        f"{100.0 * modem.delivery:.0f}",
        _number(modem.guard_s, 3),
        _number(modem.slot_s, 3),
        _number(modem.cycle_s, 2),
        _number(modem.age_s, 2),
        " ".join(modem.ranging) or "none",
        " ".join(symbol for symbol in BASES if symbol in symbols),
    )


def _without_age(modems: Sequence[Figures]) -> Iterator[tuple[str, str]]:
    """Say which modems have no age, and why."""
    reasons: dict[str, list[str]] = {}
    for modem in modems:
        if modem.age_s is None:
            reasons.setdefault(_reason(modem), []).append(modem.name)
    text = "; ".join(f"{', '.join(names)}: {reason}" for reason, names in reasons.items())
    if text:
        yield "no age", text


def _reason(modem: Figures) -> str:
    return ", ".join(modem.lacks) or "not heard at this range"


def _uses(modem: Figures, use: Use) -> Iterator[str]:
    yield f"For {_use(use)}"
    rows = [
        ("airtime T", modem.airtime_s, 3, "s"),
        ("signal to noise", modem.snr_db, 1, "dB"),
        ("heard p", 100.0 * modem.delivery, 1, "%"),
        ("guard", modem.guard_s, 3, "s"),
        ("slot", modem.slot_s, 3, "s"),
        ("cycle C", modem.cycle_s, 2, "s"),
        ("mean age", modem.age_s, 2, "s"),
    ]
    for label, value, digits, unit in rows:
        yield from _entry(label, _NOTHING if value is None else f"{_number(value, digits)} {unit}")
    if modem.age_s is None:
        yield from _entry("no age", _reason(modem))


def profile_lines(profile: ModemProfile) -> Iterator[str]:
    """Give one line a field, with dotted names for those of tables, and mark what is assumed."""
    table = msgspec.to_builtins(profile)
    if profile.ranging == Ranging():
        table["ranging"] = "none"
    for field, value in _flat("", table):
        if field not in {"title", "sources", "assumed"}:
            unit = next((text for end, text in reversed(_UNITS.items()) if field.endswith(end)), "")
            text = _plain(value) if value is None or not unit else f"{_plain(value)} {unit}"
            mark = "   assumed" if field in profile.assumed or field.partition(".")[0] in profile.assumed else ""
            yield from _entry(field, text + mark)


def _flat(path: str, table: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    for field, value in table.items():
        if isinstance(value, dict):
            yield from _flat(f"{path}{field}.", value)
        else:
            yield path + field, value


def _entry(label: str, text: str, width: int = 28) -> list[str]:
    return _wrapped(f"  {label:<{width}}  ", text)


def _wrapped(label: str, text: str) -> list[str]:
    """Lay out a label and its text, wrapped under itself."""
    return textwrap.wrap(text, _WIDTH, initial_indent=label, subsequent_indent=" " * len(label), break_on_hyphens=False)


def _number(value: float | None, digits: int) -> str:
    return _NOTHING if value is None else f"{value:.{digits}f}"


def _plain(value: Any) -> str:
    if value is None:
        return _NOTHING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    return ", ".join(map(_plain, value)) if isinstance(value, list | tuple) else str(value)
