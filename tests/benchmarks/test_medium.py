"""What the acoustic medium costs: a team of fifty that talks without pause, against an event loop that does nothing."""

import heapq
import random
import time

import pytest
from slot_water import team_scenario

from grex_link.acoustic_medium import AcousticMedium
from grex_link.link_config import LinkConfig
from grex_link.messages import Pose, Transmit, Truth
from grex_link.process import collect_rarely
from grex_link.profile import load_profile
from grex_link.units import NS

pytestmark = pytest.mark.benchmark

NODES, SECONDS = 50, 30
AREA_M = 1000.0


def schedule() -> list[tuple[int, int, int]]:
    """One message a node a second, at random times: (time ns, node, number)."""
    draw = random.Random(1)
    return sorted(
        (round((second + draw.random()) * NS), node, second) for second in range(SECONDS) for node in range(NODES)
    )


def truths() -> list[Truth]:
    """Everybody goes north at 1 m/s."""
    draw = random.Random(2)
    places = [(draw.uniform(0, AREA_M), draw.uniform(0, AREA_M), draw.uniform(0, 50)) for _ in range(NODES)]
    return [
        Truth(tick, tick * NS, [
            Pose(f"auv{node}", north + tick, east, down, 0.0, 0.0, 0.0, 1.0)
            for node, (north, east, down) in enumerate(places)
        ])
        for tick in range(SECONDS)
    ]  # fmt: skip


def run_medium() -> tuple[float, int]:
    """Run the medium tick by tick as the emulator does; return CPU seconds and log lines."""
    team = [f"auv{node}" for node in range(NODES)]
    medium = AcousticMedium(team_scenario(team, LinkConfig(profile="s2c_im")), load_profile("s2c_im"))
    pending, poses, lines, position = schedule(), truths(), 0, 0
    start = time.process_time()
    for truth in poses:
        medium.place(truth)
        until_ns = truth.t_ns + NS
        while position < len(pending) and pending[position][0] < until_ns:
            t_ns, node, number = pending[position]
            medium.request(team[node], Transmit(number, t_ns, bytes(15)), t_ns)
            position += 1
        medium.advance(until_ns)
        medium.events(until_ns)
        lines += len(medium.log(until_ns))
    return time.process_time() - start, lines


def run_empty_loop() -> float:
    """Push and pop the same events – each arrival's start and end – and do nothing with them; return CPU seconds."""
    airtime_ns = load_profile("s2c_im").airtime_ns(15)
    draw = random.Random(3)
    delays = [[draw.randrange(NS) for _ in range(NODES - 1)] for _ in range(NODES)]
    queue: list[tuple[int, int, int, int]] = []
    start = time.process_time()
    for t_ns, node, number in schedule():
        while queue and queue[0][0] < t_ns:
            heapq.heappop(queue)
        for delay_ns in delays[node]:
            heapq.heappush(queue, (t_ns + delay_ns, 1, node, number))
            heapq.heappush(queue, (t_ns + delay_ns + airtime_ns, 0, node, number))
    while queue:
        heapq.heappop(queue)
    return time.process_time() - start


def test_fifty_nodes() -> None:
    """Fifty nodes, one message a node a second, are worked through more than 100 times faster than real time."""
    collect_rarely()  # as every process of GREX does
    medium_s, empty_s = [], []
    for _ in range(3):
        seconds, lines = run_medium()
        assert lines > 0.99 * (NODES - 1) * NODES * (SECONDS - 1)
        medium_s.append(seconds)
        empty_s.append(run_empty_loop())
    cost = min(medium_s) / min(empty_s)
    speed = SECONDS / min(medium_s)
    assert speed > 100.0, f"{speed:.0f} x real time, {cost:.1f} times the cost of an empty event loop"
    assert cost < 6.0
