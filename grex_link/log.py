"""Logging: structlog to standard error, bound with who speaks; loaded when there is something to say."""

from typing import Any

_who = "grex"


def speak_as(who: str) -> None:
    """Name the participant that this process is in every line."""
    global _who  # noqa: PLW0603 - one process is one participant
    _who = who


def warn(event: str, **fields: Any) -> None:
    """Log something that a user should look into."""
    _logger().warning(event, **fields)


def info(event: str, **fields: Any) -> None:
    """Log something worth knowing afterwards."""
    _logger().info(event, **fields)


def _logger() -> Any:
    import sys

    import structlog

    if not structlog.is_configured():
        structlog.configure(
            processors=[
                structlog.processors.add_log_level,
                structlog.processors.TimeStamper(fmt="iso"),
                structlog.processors.LogfmtRenderer(key_order=["timestamp", "level", "who", "event"]),
            ],
            logger_factory=structlog.PrintLoggerFactory(sys.stderr),
        )
    return structlog.get_logger(who=_who)
