"""Runs with craft on MAVLink: simulated autopilots as processes of their own, on free ports."""

import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from launching import running
from recordings import recorded_messages

from grex_agent.frontseat.geodesy import to_degrees
from grex_link.config import DatumConfig
from grex_link.messages import Fix

DATUM = DatumConfig(54.37, 10.16)
HEAD = """
duration_s = {duration_s}
datum = {{ latitude_deg = 54.37, longitude_deg = 10.16 }}
[clock]
pace = {pace}
[mission]
type = "lawnmower"
leg_length_m = 2000.0
turn_radius_m = 200.0
legs = 1
[mission.formation_m]
"""


def free_port() -> int:
    with socket.socket(type=socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def autopilot(
    url: str, log: Path, *arguments: str, start: tuple[float, float] = (0.0, 0.0), heading_deg: float = 0.0
) -> Iterator[None]:
    """Run a simulated autopilot that starts so many metres north and east of the datum."""
    latitude, longitude = to_degrees(DATUM, *start)
    place = f"{latitude:.7f},{longitude:.7f},{heading_deg:g}"
    command = [sys.executable, "-m", "grex_sim.autopilot", "--url", url, "--start", place]
    with log.open("w") as out:
        process = subprocess.Popen([*command, *arguments], stdout=out, stderr=subprocess.STDOUT)
        try:
            yield
        finally:
            process.terminate()
            process.wait(10.0)


class OneBoat:
    """A team of one craft on MAVLink over UDP."""

    def __init__(self, folder: Path, duration_s: float, *, pace: float = 4.0, more: str = "arm = true") -> None:
        self.port = free_port()
        self.pace = pace
        self.out = folder / "run"
        self.scenario = folder / "boat.toml"
        self.log = folder / "autopilot.log"
        url = f"udpin:127.0.0.1:{self.port}"
        text = HEAD.format(duration_s=duration_s, pace=pace) + "auv1 = [0, 0, 0]\n[craft.auv1.frontseat]\n"
        self.scenario.write_text(text + f'type = "mavlink"\nurl = "{url}"\n{more}\n')

    def autopilot(self, *arguments: str, log: str = "autopilot.log"):
        """Return its autopilot, which is soon ready."""
        where = f"udpout:127.0.0.1:{self.port}"
        defaults = ("--ready", "4", "--speedup", f"{self.pace:g}")
        return autopilot(where, self.log.with_name(log), *defaults, *arguments)

    def grex(self, *arguments: str):
        return running("run", str(self.scenario), "--json", "--out", str(self.out), *arguments)

    def fly(self, *arguments: str, timeout: float = 90.0) -> tuple[int, str, str]:
        with self.grex(*arguments) as launcher:
            out, err = launcher.communicate(timeout=timeout)
        return launcher.returncode, out, err

    @property
    def words(self) -> list[str]:
        """What the adapter has said."""
        text = (self.out / "frontseat-auv1.log").read_text()
        return re.findall(r'event="?(.*?)"?$', text, re.MULTILINE)

    def wait_for_words(self, words: str, timeout: float = 60.0) -> None:
        """Wait for a line that a pattern is found in."""
        deadline = time.monotonic() + timeout
        while not any(re.search(words, line) for line in self.words_so_far()):
            assert time.monotonic() < deadline, (words, self.words_so_far())
            time.sleep(0.05)

    def autopilot_time(self, words: str) -> float:
        """Autopilot seconds at which its log has a line with these words."""
        (line, *_) = [line for line in self.log.read_text().splitlines() if words in line]
        return float(line.split(" s ")[0])

    def words_so_far(self) -> list[str]:
        return self.words if (self.out / "frontseat-auv1.log").exists() else []

    def fixes(self, craft: str = "auv1") -> list[Fix]:
        return fixes(self.out, craft)


def fixes(out: Path, craft: str) -> list[Fix]:
    """Return the fixes of a craft that were recorded."""
    return recorded_messages(out, "fix", craft)
