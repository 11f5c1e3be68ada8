"""A scenario of three craft, an outlet that keeps what is put, and log lines that go where pytest can read them."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
import structlog

from grex_link.config import Scenario
from grex_link.messages import Message, Pose, Truth
from grex_link.scenario import loads

TEXT = """
title = "three craft"

[mission]
type = "lawnmower"

[mission.formation_m]
auv1 = [0.0, 0.0, 0.0]
auv2 = [-6.0, -25.0, 0.0]
auv3 = [-6.0, 25.0, 0.0]

[craft.auv1]

[craft.auv2]

[craft.auv3]
"""


class Puts:
    """Where a node puts its messages: a list."""

    def __init__(self) -> None:
        self.all: list[tuple[str, str, Any]] = []

    def put(self, topic: str, craft: str, message: Message) -> None:
        self.all.append((topic, craft, message))

    def of(self, topic: str, craft: str = "") -> list[Any]:
        return [message for put, to, message in self.all if (put, to) == (topic, craft)]


@pytest.fixture
def text() -> str:
    return TEXT


@pytest.fixture
def make() -> Callable[..., Scenario]:
    return lambda *overrides: loads(TEXT, overrides)


@pytest.fixture
def outlet() -> Puts:
    return Puts()


@pytest.fixture
def truth_at() -> Callable[[int], Truth]:
    """Truth at a tick of one second."""

    def build(tick: int) -> Truth:
        poses = [Pose(f"auv{place}", 100.0 * place, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0) for place in (1, 2, 3)]
        return Truth(tick, tick * 1_000_000_000, poses)

    return build


@pytest.fixture
def fresh_log() -> Iterator[None]:
    """Let structlog find this test's standard error."""
    structlog.reset_defaults()
    yield
    structlog.reset_defaults()
