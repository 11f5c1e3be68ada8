"""The options of grex view."""

import socket

import pytest
from missions import fly

from grex_link.errors import ConfigError
from grex_sim.view.command import view


@pytest.mark.parametrize("foxglove", [False, True])
def test_a_port_that_is_none_or_taken_is_one_line(tmp_path, foxglove):
    """What is no port number, and a port that somebody else has, are told with what to do."""
    fly("paper-d", "duration_s=20", out=tmp_path)
    for number in (-1, 65_536):
        with pytest.raises(ConfigError, match=rf"^--port: {number} is no port; they go to 65535, and 0 takes any"):
            view(tmp_path, port=number, foxglove=foxglove)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        taken = other.getsockname()[1]
        with pytest.raises(ConfigError, match=rf"^--port: cannot listen on port {taken}: .*; take another one, or 0"):
            view(tmp_path, port=taken, foxglove=foxglove)
