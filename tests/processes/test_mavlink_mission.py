"""Case d of the paper, scaled, as real processes: through MAVLink, mixed, and on the plain simulation at the same pace.

auv1 makes 5 % more speed than it is told to, whoever moves it: what the team does about that is the figure of merit.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from mavlink_teams import Flown, fly_team

from grex_agent.manoeuvre import ManoeuvreProcessor

#: Minutes of wall time: `pytest -m slow tests/processes`.
pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

SCALED = ("mission.legs=2", "mission.leg_length_m=40")
HOW = {"pace": 6.0, "speed_error": 0.05}


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> dict[str, Flown]:
    """One mission three times; the two that need least of the machine at once."""
    folder = {name: tmp_path_factory.mktemp(name) for name in ("mavlink", "mixed", "plain")}
    with ThreadPoolExecutor() as pool:
        mixed = pool.submit(fly_team, "mixed", folder["mixed"], *SCALED, **HOW)
        plain = pool.submit(fly_team, "mavlink", folder["plain"], *SCALED, plain=True, **HOW)
        runs = {"mixed": mixed.result(), "plain": plain.result()}
    return runs | {"mavlink": fly_team("mavlink", folder["mavlink"], *SCALED, **HOW)}


def along(run: Flown, craft: str) -> np.ndarray:
    """Cross-track error (m), and 1 on lines, 0 on arcs, of every valid fix."""
    plan = run.plan.craft[craft]
    follower = ManoeuvreProcessor(plan)
    rows = []
    for fix in run.fixes[craft]:
        if fix.valid:
            xte_m = follower.follow(fix.north_m, fix.east_m).xte_m
            track = plan.tracks[min(int(follower.progress), len(plan.tracks) - 1)]
            rows.append((xte_m, track.curvature == 0.0))
    return np.array(rows)


@pytest.mark.parametrize("team", ["mavlink", "mixed"])
def test_the_figure_of_merit_is_that_of_the_simulation(flown, team: str):
    """The formation is kept through MAVLink as on the plain simulation: FD differs by less than 10 %."""
    plain = flown["plain"].summary["fd"]
    assert plain > 0.5, "there is something to coordinate"
    assert flown[team].summary["fd"] == pytest.approx(plain, rel=0.1)


@pytest.mark.parametrize("team", ["mavlink", "mixed"])
def test_it_flies_to_the_end(flown, team: str):
    """All ticks are flown, all craft hear each other, and nearly every fix is valid."""
    run = flown[team]
    assert run.summary["complete"]
    assert run.summary["delivered"] > 20
    assert set(run.fixes) == {"auv1", "auv2", "auv3"}
    for fixes in run.fixes.values():
        assert sum(fix.valid for fix in fixes) >= 0.9 * run.summary["ticks"]


@pytest.mark.parametrize(
    ("team", "craft"), [("mavlink", "auv1"), ("mavlink", "auv2"), ("mavlink", "auv3"), ("mixed", "auv1")]
)
def test_it_keeps_its_tracks(flown, team: str, craft: str):
    """A craft on MAVLink stays within 3 m of its lines, and within 3 m of its arcs, too."""
    xte_m, line = along(flown[team], craft).T
    assert line.sum() > 30
    assert (1.0 - line).sum() > 100
    assert np.abs(xte_m).max() < 3.0
    # Most of the way it is much nearer: an adapter whose fixes are late by seconds is a metre and a half off on arcs.
    assert np.median(np.abs(xte_m)) < 0.5


@pytest.mark.parametrize(("team", "count"), [("mavlink", 3), ("mixed", 1)])
def test_everybody_is_handed_back(flown, team: str, count: int):
    """At the end every craft is with its autopilot, in a mode that holds."""
    assert len(flown[team].words) == count
    for words in flown[team].words.values():
        assert "the craft is with its autopilot, in HOLD, armed" in words
