"""``grex topics|echo|hz`` on the command line; what they need is imported when they run."""

from typing import Annotated

import tyro

from grex_link.console import AsJson

DEFAULT_CONNECT = "tcp/127.0.0.1:7447"

Connect = Annotated[
    str, tyro.conf.arg(metavar="ENDPOINT", help="Where the run's simulator listens: its bus.endpoints.")
]
Key = Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="KEY")]


def topics(
    connect: Connect = DEFAULT_CONNECT,
    seconds: Annotated[float, tyro.conf.arg(metavar="S")] = 2.0,
    as_json: AsJson = False,  # noqa: FBT002 - a flag
) -> None:
    """List what is alive on the bus of a run: key, type, writer, rate.

    Parameters
    ----------
    connect
        Where to listen.
    seconds
        How long to listen.
    as_json
        Print one JSON object instead of a table.
    """
    from grex_sim.bus_tools import list_topics

    print(list_topics(connect, seconds, as_json=as_json))  # noqa: T201


def echo(key: Key, connect: Connect = DEFAULT_CONNECT) -> None:
    """Print the messages of a key as lines of JSON, until Ctrl-C or the end of the run.

    Parameters
    ----------
    key
        A key or an expression: grex/grex/auv1/fix, 'grex/*/*/state', 'grex/**'.
    connect
        Where to listen.
    """
    from grex_sim.bus_tools import echo_messages

    echo_messages(key, connect)


def hz(key: Key, connect: Connect = DEFAULT_CONNECT) -> None:
    """Measure how often the messages of a key come: mean rate, shortest and longest interval, deviation.

    Parameters
    ----------
    key
        A key or an expression: grex/grex/auv1/fix, 'grex/*/*/state', 'grex/**'.
    connect
        Where to listen.
    """
    from grex_sim.bus_tools import measure_rates

    measure_rates(key, connect)
