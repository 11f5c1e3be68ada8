"""A bare Zenoh barrier: as many processes as a run, which do nothing but wait for each other; the measure for lockstep.

``python -m grex_sim.barrier SCENARIO PLACE`` is one participant; `measure` is the hub.
"""

import subprocess
import sys
from pathlib import Path

from grex_link import clock
from grex_link.bus import Session
from grex_link.config import Scenario
from grex_link.scenario import load

_TICK = "grex/barrier/tick"
_PAYLOAD = bytes(64)
_START_S = 60.0


def measure(scenario_file: Path, scenario: Scenario, overrides: list[str], participants: int, barriers: int) -> float:
    """Measure how many barriers a second a hub and a number of processes get through.

    Parameters
    ----------
    scenario_file, scenario, overrides : Path, Scenario, list of str
        Where they meet.
    participants : int
        Processes beside the hub.
    barriers : int
        How many barriers to go through.

    Returns
    -------
    float
        Barriers a second.
    """
    with Session(scenario, router=True) as hub:
        hub.subscribe("grex/barrier/done/*")
        hub.appear("grex/barrier/up/hub", "grex/barrier/up/*")
        publish = hub.publisher(_TICK)
        arguments = [part for value in overrides for part in ("--set", value)]
        command = [sys.executable, "-m", "grex_sim.barrier", str(scenario_file), *arguments]
        started = [subprocess.Popen([*command, str(place)]) for place in range(participants)]  # noqa: S603
        try:
            for _ in range(participants + 1):  # the hub sees its own token, too
                if hub.receive(_START_S) is None:
                    raise TimeoutError("the processes of the barrier did not appear")
            start = clock.monotonic_s()
            for _ in range(barriers):
                publish(_PAYLOAD)
                for _ in range(participants):
                    hub.receive(_START_S)
            rate = barriers / (clock.monotonic_s() - start)
            publish(b"")
            for process in started:
                process.wait(10.0)
        finally:
            for process in started:
                process.kill()
    return rate


def _participate(scenario: Scenario, place: str) -> None:
    with Session(scenario, router=False) as session:
        session.subscribe(_TICK)
        session.appear(f"grex/barrier/up/{place}", "grex/barrier/nobody")
        publish = session.publisher(f"grex/barrier/done/{place}")
        while (sample := session.receive(_START_S)) is not None and sample.payload.to_bytes():
            publish(_PAYLOAD)


if __name__ == "__main__":
    _participate(load(sys.argv[1], sys.argv[3:-1:2]), sys.argv[-1])
