"""The paper's estimators: one filter a mate (case c), and what the mates believe about oneself (case d)."""

import pytest

from grex_agent.coordination import load_controller
from grex_agent.mission import plan_mission
from grex_agent.team.interface import Own, Report, TeamContext, load_estimator
from grex_link.scenario import decode
from grex_link.wire import TeamState

TEAM = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -25.0, 0.0], "auv3": [-6.0, 25.0, 0.0]}
RATES = {"auv1": 0.00255, "auv2": 0.0025, "auv3": 0.00245}


def estimator(level, craft, formation=TEAM):
    """Build an estimator aboard a craft."""
    scenario = decode(
        {
            "mission": {"type": "lawnmower", "formation_m": formation},
            "craft": {name: {} for name in formation},
            "team": {"estimator": level, "gain_mps": 8.0},
        }
    )
    return load_estimator(TeamContext(craft, plan_mission(scenario), scenario, load_controller(scenario.team)))


def own(progress):
    """Oneself at a progress on the first leg; the estimators look at nothing else."""
    return Own(400.0 * progress, 0.0, progress)


def said(craft, t_s):
    """What a craft says at a time: where it is on its first leg."""
    ahead, starboard, _ = TEAM[craft]
    progress = RATES[craft] * t_s
    place = list(TEAM).index(craft)
    return TeamState(place, t_s, 400.0 * progress + ahead, starboard, 0.0, 1.0, 0.0, 0, progress, 0.1)


def run_team(level, until_s=100, lost=()):
    """Run everybody's estimator: one speaks every 10 s, 10 s late; `lost` are (sender, time, receiver)."""
    team = {craft: estimator(level, craft) for craft in TEAM}
    beliefs = {}
    for now in range(1, until_s + 1):
        sent = dict.fromkeys(TEAM, ())
        heard = dict.fromkeys(TEAM, ())
        if now >= 10 and now % 10 == 0:
            sender, state = list(TEAM)[now // 10 % 3], None
            state = said(sender, now - 10.0)
            sent[sender] = [state]
            for craft in TEAM:
                if craft != sender and (sender, now, craft) not in lost:
                    heard[craft] = [Report(sender, state)]
        for craft, aboard in team.items():
            beliefs[craft] = {
                belief.craft: belief
                for belief in aboard.step(float(now), own(RATES[craft] * now), sent[craft], heard[craft])
            }
    return beliefs


@pytest.mark.parametrize("level", ["first_level", "second_level"])
def test_believes_in_every_mate(level):
    """There is one belief a mate, in the order of the team, from the start on; before any message its age is -1."""
    beliefs = estimator(level, "auv2").step(1.0, own(0.0025), [], [])
    assert [belief.craft for belief in beliefs] == ["auv1", "auv3"]
    for belief, starboard in zip(beliefs, (0.0, 25.0), strict=True):
        assert belief.progress == pytest.approx(0.0025)
        assert belief.east_m == pytest.approx(starboard)
        assert belief.age_s == -1.0
        assert belief.sigma_m == pytest.approx((0.01 + 0.0025 + 0.0004) ** 0.5)


@pytest.mark.parametrize("level", ["first_level", "second_level"])
def test_hears(level):
    """What a mate says counts at the time it speaks of: the belief moves, is surer, and has that age."""
    deaf, hearing = estimator(level, "auv2"), estimator(level, "auv2")
    fast = TeamState(0, 20.0, 23.0, 0.0, 0.0, 1.0, 0.0, 0, 23.0 / 400.0, 0.1)
    for now in range(1, 31):
        unheard = deaf.step(float(now), own(0.0025 * now), [], [])
        heard = hearing.step(float(now), own(0.0025 * now), [], [Report("auv1", fast)] if now == 30 else [])
    assert heard[0].age_s == 10.0
    assert heard[0].north_m > unheard[0].north_m + 1.0
    assert heard[0].sigma_m < unheard[0].sigma_m
    assert heard[1].age_s == -1.0


@pytest.mark.parametrize("level", ["first_level", "second_level"])
def test_mates_drive_each_others_models(level):
    """A mate that falls back makes the others be believed to wait for it."""
    deaf, hearing = estimator(level, "auv2"), estimator(level, "auv2")
    slow = TeamState(0, 10.0, 4.0, 0.0, 0.0, 1.0, 0.0, 0, 4.0 / 400.0, 0.1)
    for now in range(1, 21):
        unheard = deaf.step(float(now), own(0.0025 * now), [], [])
        heard = hearing.step(float(now), own(0.0025 * now), [], [Report("auv1", slow)] if now == 11 else [])
    assert heard[1].craft == "auv3"
    assert heard[1].north_m < unheard[1].north_m - 0.1


def test_first_level_takes_the_own_present_progress():
    """Case c: the mates' models are driven by the own progress now; own messages play no part."""
    still, moving, telling = (estimator("first_level", "auv2") for _ in range(3))
    for now in range(1, 41):
        wait = still.step(float(now), own(0.0), [], [])
        go = moving.step(float(now), own(0.0025 * now), [], [])
        tell = telling.step(float(now), own(0.0025 * now), [said("auv2", now - 1.0)], [])
    assert wait[0].progress < go[0].progress - 0.01
    assert tell == go


def test_second_level_takes_what_the_mates_believe():
    """Case d: the own progress plays no part until it has been told; then the mates' models take it up."""
    still, moving, telling = (estimator("second_level", "auv2") for _ in range(3))
    behind = TeamState(1, 10.0, 4.0 - 6.0, -25.0, 0.0, 1.0, 0.0, 0, 0.01, 0.1)
    for now in range(1, 41):
        wait = still.step(float(now), own(0.0), [], [])
        go = moving.step(float(now), own(0.0025 * now), [], [])
        tell = telling.step(float(now), own(0.0), [behind] if now == 20 else [], [])
        if now < 20:
            assert tell == go
    assert wait == go
    assert tell[0].progress < go[0].progress - 0.001


def test_without_loss_all_believe_the_same():
    """Case d without loss: what a craft holds its mates to believe is what they do, so all share one belief."""
    beliefs = run_team("second_level")
    for craft, (one, other) in {
        "auv1": ("auv2", "auv3"),
        "auv2": ("auv1", "auv3"),
        "auv3": ("auv1", "auv2"),
    }.items():
        first, second = beliefs[one][craft], beliefs[other][craft]
        assert first.progress == pytest.approx(second.progress, abs=1e-9)
        assert (first.north_m, first.east_m) == pytest.approx((second.north_m, second.east_m), abs=1e-9)
        assert (first.sigma_m, first.age_s) == pytest.approx((second.sigma_m, second.age_s), abs=1e-9)


def test_with_loss_beliefs_part():
    """A message that only one mate has heard makes the two believe different things."""
    beliefs = run_team("second_level", lost=[("auv1", 90, "auv3")])
    assert beliefs["auv2"]["auv1"].age_s == 20.0
    assert beliefs["auv3"]["auv1"].age_s == 50.0
    assert abs(beliefs["auv2"]["auv1"].progress - beliefs["auv3"]["auv1"].progress) > 1e-6


@pytest.mark.parametrize("level", ["first_level", "second_level"])
@pytest.mark.parametrize("step_s", [1.0, 0.9])
def test_work_in_advance_changes_nothing(level, step_s):
    """An estimator that is told when the next step is expected believes the same, if that step comes sooner, too."""
    eager, patient = estimator(level, "auv2"), estimator(level, "auv2")
    for step in range(1, 61):
        now = step * step_s
        told = [said("auv2", now - 10.0)] if step % 30 == 11 else []
        heard = [Report("auv1", said("auv1", now - 10.3))] if step % 30 == 21 else []
        believed = [aboard.step(now, own(0.002 * now), told, heard) for aboard in (eager, patient)]
        eager.prepare(now + 1.0)
        for one, other in zip(*believed, strict=True):
            assert (one.craft, one.age_s) == (other.craft, other.age_s)
            assert (one.north_m, one.progress, one.sigma_m) == pytest.approx(
                (other.north_m, other.progress, other.sigma_m), abs=1e-9
            )


@pytest.mark.parametrize("level", ["first_level", "second_level"])
def test_alone(level):
    """A team of one believes nothing."""
    assert estimator(level, "auv1", {"auv1": [0.0, 0.0, 0.0]}).step(12.0, own(0.03), [], []) == []
