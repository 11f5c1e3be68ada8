"""The report: one HTML file with everything in it. It asks nothing of any server, and runs no script.

Whatever comes from a scenario or a recording is escaped; pictures are PNG within the page.
"""

import base64
import html
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from grex_link.errors import ConfigError
from grex_sim import report_pictures as pictures
from grex_sim import report_tables as tables
from grex_sim.canvas import png
from grex_sim.link_stats_text import as_text
from grex_sim.report_data import RunData, labels, read_run

if TYPE_CHECKING:
    from grex_sim.canvas import Figure

REPORT_FILE = "report.html"

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; background: #fff; margin: 0 auto; max-width: 1240px;
       padding: 1rem; }
h1 { font-size: 1.6rem; } h2 { margin-top: 2.2rem; border-bottom: 1px solid #d0d7de; font-size: 1.3rem; }
h3 { font-size: 1.05rem; }
img { max-width: 100%; height: auto; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .6rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid #e3e7eb; text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 2px solid #8c99a6; }
pre { background: #f5f7f9; padding: .8rem; overflow-x: auto; font-size: .85rem; }
.warning { border-left: 4px solid #d55e00; padding: .3rem .8rem; background: #fff4ec; }
nav a { margin-right: 1rem; }
"""


def write_report(runs: Sequence[Path], out: Path) -> list[str]:
    """Write the report of one or several runs.

    Parameters
    ----------
    runs : sequence of Path
        Their folders, or their recordings.
    out : Path
        The HTML file.

    Returns
    -------
    list of str
        What should be known of the recordings: those that were cut off.

    Raises
    ------
    ConfigError
        If a run cannot be read, or the file cannot be written.
    """
    data = [read_run(run, label) for run, label in zip(runs, labels(runs), strict=True)]
    page = "".join(_page(data))
    try:
        out.write_text(page, encoding="utf-8")
    except OSError as error:
        raise ConfigError("--out", f"cannot write the report {out}: {error.strerror}") from None
    return [run.remark for run in data if run.remark]


def _page(runs: Sequence[RunData]) -> Iterator[str]:
    title = runs[0].scenario.title or runs[0].label if len(runs) == 1 else f"{len(runs)} runs side by side"
    yield '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield '<link rel="icon" href="data:,">'
    yield f"<title>GREX: {_text(title)}</title><style>{_STYLE}</style></head><body><h1>{_text(title)}</h1>"
    for run in runs:
        yield from _warnings(run)
    yield "<h2>Figures</h2>"
    yield "<p>FD is the mean of fd(k), eqs. (4) and (5); after ± half of its 95 % interval, from the means of 20 "
    yield "pieces of the run. Differences are taken tick by tick.</p>"
    yield _table(tables.merits(runs))
    yield _table(tables.facts(runs))
    if len(runs) > 1:
        yield "<h3>What the scenarios do not have in common</h3>"
        yield _table(tables.differing(runs))
    yield "<h2>Formation deviation (Fig. 11)</h2>"
    yield _picture(pictures.deviations(runs), "fd(k) and its parts over mission time")
    yield "<h2>Latency and age of information</h2>"
    yield _picture(pictures.link_histograms(runs), "Histograms of latency and of age of information")
    for place, run in enumerate(runs):
        yield from _run(run, place)
    yield "</body></html>\n"


def _warnings(run: RunData) -> Iterator[str]:
    remarks = [run.remark] if run.remark else []
    if run.summary is not None:
        remarks += [] if run.summary.complete else [f"the run broke off: {run.summary.fault}"]
        remarks += [
            f"{craft} reported {word} in {steps} steps"
            for craft, words in run.summary.unhealthy_steps.items()
            for word, steps in words.items()
        ]
    remarks += [f"the ledger does not add up: {fault}" for fault in run.stats.faults]
    yield from (f'<p class="warning">{_text(run.label)}: {_text(remark)}</p>' for remark in remarks)


def _run(run: RunData, place: int) -> Iterator[str]:
    yield f'<h2 id="run{place}">{_text(run.label)}</h2>'
    yield "<h3>Tracks, formation deviation (Fig. 11) and relative positions (Fig. 12)</h3>"
    yield _picture(pictures.overview(run), f"Tracks, fd(k) and relative positions of {run.label}")
    yield "<h3>Coordination</h3>"
    yield _picture(pictures.coordination(run), f"Sum of Θ differences, cross-track error and speed of {run.label}")
    yield "<h3>Beliefs about the mates: error and consistency</h3>"
    figure = pictures.consistency(run)
    if figure is None:
        yield "<p>No craft believed anything about another.</p>"
    else:
        yield _picture(figure, f"Errors of beliefs, and their NEES with its 95 % band, of {run.label}")
        yield _table(tables.beliefs(run))
    yield "<h3>Ledger of the link</h3>"
    yield _table(tables.links(run))
    yield f"<p>{_text(tables.left_out(run))}</p>"
    yield f"<details><summary>All of grex link stats</summary><pre>{_text(as_text(run.stats))}</pre></details>"
    scenario = msgspec.json.format(msgspec.json.encode(run.scenario), indent=2).decode()
    yield f"<details><summary>The scenario, resolved</summary><pre>{_text(scenario)}</pre></details>"


def _table(rows: tables.Rows) -> str:
    head, *body = rows
    lines = "".join(f"<tr>{_cells(row, 'td')}</tr>" for row in body)
    return f'<div class="wide"><table><thead><tr>{_cells(head, "th")}</tr></thead><tbody>{lines}</tbody></table></div>'


def _cells(row: Sequence[str], kind: str) -> str:
    return "".join(f"<{kind}>{_text(cell)}</{kind}>" for cell in row)


def _picture(figure: "Figure", words: str) -> str:
    data = base64.b64encode(png(figure)).decode()
    return f'<p><img alt="{_text(words)}" src="data:image/png;base64,{data}"></p>'


def _text(words: str) -> str:
    return html.escape(words, quote=True)
