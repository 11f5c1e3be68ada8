"""The past of a run for the strip charts: evenly thinned, never longer than it can be drawn."""

from collections.abc import Sequence

Row = Sequence[float | None]


class History:
    """Columns over mission time that are thinned when they become too long.

    Every second point goes when there is no room left, and from then on only every second one comes in.

    Parameters
    ----------
    points : int
        Most points held.
    """

    def __init__(self, points: int = 1200) -> None:
        self._points = points
        self._rows: list[tuple[float, Row]] = []
        self._apart_s = 0.0

    def add(self, time_s: float, row: Row) -> bool:
        """Take a row if it is later than the last by as much as the points are apart; whether it was taken."""
        if self._rows and time_s < self._rows[-1][0] + self._apart_s:
            return False
        if self._rows and time_s == self._rows[-1][0]:
            return False
        self._rows.append((time_s, row))
        if len(self._rows) >= self._points:
            self._rows = self._rows[::2]
            span_s = self._rows[-1][0] - self._rows[0][0]
            self._apart_s = 0.999 * span_s / (len(self._rows) - 1)
        return True

    def columns(self) -> list[list[float | None]]:
        """Return mission times and one list for each column."""
        times: list[float | None] = [time_s for time_s, _ in self._rows]
        return [times, *map(list, zip(*(row for _, row in self._rows), strict=True))]
