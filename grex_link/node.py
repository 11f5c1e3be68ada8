"""What a participant is to the bus: something that takes messages and puts messages, and never blocks.

A node acts when it *knows* that it has all its inputs; it assumes nothing about the order of messages from different
writers. The same node therefore gives the same result on Zenoh between processes and in memory inside one.
"""

from typing import Any, Protocol

from grex_link.messages import Message


class Outlet(Protocol):
    """Where a node puts its messages."""

    def put(self, topic: str, craft: str, message: Message) -> None:
        """Write a message to a topic."""


class Node(Protocol):
    """One participant: an agent, the link, or the simulator.

    Attributes
    ----------
    done : bool
        True once it wants no more messages.
    """

    done: bool

    @property
    def started(self) -> bool:
        """Whether the mission has started."""

    def handle(self, topic: str, craft: str, message: Any) -> None:
        """Take one message; presence changes come as topic ``presence``."""

    def wall_s_to_deadline(self) -> float | None:
        """Wall seconds until `on_deadline` wants to be called if no message comes before; None for never."""

    def on_deadline(self) -> None:
        """Do what is due because time has passed."""

    def in_idle_time(self) -> bool:
        """Do a little of the work that can wait, while no message does; False if there is none."""
