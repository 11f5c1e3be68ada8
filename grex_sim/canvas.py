"""What all pictures share: figures, colours, dashes, files. The only user of matplotlib, imported when one is drawn.

Colours are Okabe and Ito's, which the colour-blind can tell apart; where they run out, lines are broken in other ways.
"""

import math
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grex_link.errors import ConfigError
from grex_sim.score import Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes  # noqa: PLC0414 - for the others, too
    from matplotlib.figure import Figure as Figure  # noqa: PLC0414

_DOTS_PER_INCH = 110
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_DASHES = ("-", "--", ":", "-.", (0, (8, 2, 1, 2, 1, 2)))


def colour(place: int) -> str:
    """Colour of the craft or series at a place."""
    return _COLOURS[place % len(_COLOURS)]


def dash(place: int) -> Any:
    """How the line of the craft or series at a place is broken."""
    return _DASHES[place // len(_COLOURS) % len(_DASHES)]


def thin(series: Series, samples_max: int) -> Series:
    """Leave out steps that no picture could show."""
    return series[:: max(1, math.ceil(len(series) / samples_max))]


def new_figure(width_inch: float, height_inch: float) -> "Figure":
    """Make an empty figure that needs no display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure((width_inch, height_inch), dpi=_DOTS_PER_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: "Figure", path: Path) -> Path:
    """Write a figure; the suffix says of which kind, PNG without one.

    Raises
    ------
    ConfigError
        If the picture cannot be written.
    """
    try:
        figure.savefig(path, format=path.suffix[1:] or "png")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error  # an encoder's fault has no number
        raise ConfigError("--out", f"cannot write the picture {path}: {why}") from None
    return path


def png(figure: "Figure") -> bytes:
    """Return a figure as the bytes of a PNG file."""
    into = BytesIO()
    figure.savefig(into, format="png")
    return into.getvalue()
