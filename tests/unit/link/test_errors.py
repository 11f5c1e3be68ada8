"""Every foreseen failure has one line and an exit status."""

import pytest

from grex_link.errors import BusError, ConfigError, FaultError, GrexError, WireError


@pytest.mark.parametrize(
    ("error", "line", "status"),
    [
        (ConfigError("$.link.loss", "expected <= 1.0"), "$.link.loss: expected <= 1.0", 2),
        (FaultError("agent auv2", "left the bus", 12.04), "agent auv2 left the bus at mission time 12.0 s", 1),
        (FaultError("link", "exited", None), "link exited before the first tick", 1),
        (BusError("missing: auv2"), "missing: auv2", 1),
        (WireError("track 256"), "track 256", 1),
    ],
)
def test_line_and_status(error: GrexError, line: str, status: int) -> None:
    """A bad scenario exits with 2, a run that failed with 1, and the line says who, what and when."""
    assert isinstance(error, GrexError)
    assert (str(error), error.exit_status) == (line, status)
