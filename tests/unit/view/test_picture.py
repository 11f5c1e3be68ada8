"""What there is to see of a run: places, deviation, messages in the water, the past."""

import itertools
import json
import math

import msgspec
import pytest
from missions import SCENARIOS

from grex_agent.mission import plan_mission
from grex_link.messages import AgentState, Fix, LinkEvent, MateBelief, Pose, Truth
from grex_link.scenario import load
from grex_sim.view.formation import Formation
from grex_sim.view.history import History
from grex_sim.view.picture import Picture
from grex_sim.view.sounds import Sounds

TEAM = ["auv1", "auv2", "auv3"]
PLACES = {"auv1": (0.0, 0.0), "auv2": (-6.0, -25.0)}


@pytest.fixture
def scenario():
    return load(SCENARIOS / "paper-d.toml")


def truth(tick, *places):
    poses = [Pose(name, north, east, 0.0, 0.0, 0.0, 0.0, 1.0) for name, (north, east) in zip(TEAM, places, strict=True)]
    return Truth(tick, tick * 10**9, poses)


def start(tick=0, north_m=0.0):
    return truth(tick, (north_m, 0.0), (north_m - 6.0, -25.0), (north_m - 6.0, 25.0))


def state(tick, track=0, mates=()):
    return AgentState(tick, tick * 10**9, track, 0.25, 0.5, 1.0, 1.1, 0.0, list(mates), [], 0)


def test_deviation_is_that_of_the_score(recorded, scenario) -> None:
    """Tick by tick from the start, fd(k) and its parts are those of the run's own series."""
    rows = [[float(value) for value in row.split(",")] for row in (recorded / "series.csv").read_text().split()[1:]]
    formation = Formation(plan_mission(scenario), scenario.score)
    for row in rows:
        places = [(row[5], row[6]), (row[7], row[8]), (row[9], row[10])]
        assert formation.deviation(places) == pytest.approx(row[1:5], abs=1e-6)


def test_who_comes_later_judges_by_the_tracks_of_the_craft(scenario) -> None:
    """On the third leg, a picture that was not there before knows the formation as soon as it knows the tracks."""
    plan = plan_mission(scenario)
    places = [plan.craft[name].point(4.5) for name in TEAM]
    picture = Picture(scenario)
    picture.take("", truth(2000, *places))
    assert all(math.isnan(value) for value in picture.frame()["fd"])
    for name in TEAM:
        picture.take(name, state(2000, track=4))
    assert picture.frame()["fd"] == pytest.approx((0.0,) * 4, abs=1e-6)


def test_a_frame_has_truth_own_fix_and_beliefs(scenario) -> None:
    """Each craft is in a frame with its true place, its own fix, and what it believes of its mates."""
    picture = Picture(scenario)
    picture.take("", start(12, 12.0))
    picture.take("auv1", Fix(12, 12 * 10**9, 12.5, 0.25, 0.0, 0.0, 1.0, 0.1))
    picture.take("auv1", state(12, mates=[MateBelief("auv2", 6.5, -25.0, 0.02, 0.75, 9.0)]))
    craft = picture.frame()["craft"]["auv1"]
    assert craft["true"] == [12.0, 0.0, 0.0, 0.0, 1.0]
    assert craft["own"] == [12.5, 0.25, 0.1]
    assert craft["mates"] == {"auv2": [6.5, -25.0, 0.02, 0.75, 9.0]}
    assert craft["xte"] == 0.5


def test_the_past_has_a_name_for_every_column(scenario) -> None:
    """Deviation, Θ, cross-track error, ages and places are in the history, each under its name."""
    picture = Picture(scenario)
    picture.take("", start())
    picture.take("auv1", state(0, mates=[MateBelief("auv2", 0.0, 0.0, 0.0, 0.0, 9.0)]))
    picture.frame()
    past = picture.past()
    assert len(past["columns"]) == len(past["names"]) + 1
    values = dict(zip(past["names"], [column[-1] for column in past["columns"][1:]], strict=True))
    assert values["fd"] == pytest.approx(0.0, abs=1e-6)
    assert values["xte/auv1"] == 0.5
    assert values["age/auv1/auv2"] == 9.0
    assert math.isnan(values["age/auv1/auv3"])
    assert values["east/auv3"] == 25.0


def test_what_is_no_number_is_null(scenario) -> None:
    """NaN and infinity anywhere become null, and the page gets JSON that every browser reads."""
    picture = Picture(scenario)
    picture.take("", truth(0, (math.nan, 0.0), (-6.0, math.inf), (-6.0, 25.0)))
    picture.take("auv1", state(0, mates=[MateBelief("auv2", math.nan, 0.0, math.inf, math.nan, 9.0)]))
    frame = json.loads(msgspec.json.encode(picture.frame()), parse_constant=pytest.fail)
    assert frame["fd"] == [None] * 4
    assert frame["craft"]["auv1"]["true"][0] is None
    assert frame["craft"]["auv2"]["true"][1] is None
    assert frame["craft"]["auv1"]["mates"]["auv2"] == [None, 0.0, None, None, 9.0]
    assert frame["craft"]["auv3"]["true"][1] == 25.0


def event(t_s, kind, destination="", reason="", seq=0):
    return LinkEvent(round(t_s * 1e9), kind, "auv1", seq, destination, 15, reason, lasting_ns=10 * 10**9)


def test_a_message_is_shown_from_its_start_to_a_while_after_its_end() -> None:
    """It is there from its start, at the place it began; with each outcome and its cause; then it is gone."""
    sounds = Sounds(lasting_s=4.0)
    sounds.on_event(event(10.0, "started"), PLACES)
    assert sounds.shown(9.9) == []
    assert sounds.shown(15.0)[0]["ends"] == {}
    sounds.on_event(event(20.0, "delivered", "auv2"), PLACES)
    sounds.on_event(event(20.0, "lost", "auv3", "lost_burst"), PLACES)
    (sound,) = sounds.shown(23.0)
    assert sound["place"] == (0.0, 0.0)
    assert sound["ends"] == {"auv2": (20.0, "delivered", ""), "auv3": (20.0, "lost", "lost_burst")}
    assert sounds.shown(24.5) == []
    assert sounds.counts["lost"] == 1


def test_messages_without_end_take_no_room_for_ever() -> None:
    """However many messages never have an outcome, a few hundred are held, and old ones are forgotten."""
    sounds = Sounds()
    for seq in range(5000):
        sounds.on_event(event(0.001 * seq, "started", seq=seq), PLACES)
    assert len(sounds.shown(5.0)) == 400
    assert sounds.shown(1000.0) == []


def test_history_is_bounded_and_even() -> None:
    """A history of any length has room for a part of it only: from first to last, evenly apart."""
    history = History(points=100)
    for second in range(10_000):
        history.add(float(second), [2.0 * second])
    times, values = history.columns()
    assert 50 <= len(times) < 100
    assert times[0] == 0.0
    assert times[-1] > 9700.0
    apart = [later - earlier for earlier, later in itertools.pairwise(times)]
    assert max(apart) <= 2.0 * min(apart)
    assert values == [2.0 * time for time in times]
