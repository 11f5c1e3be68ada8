"""Missions other than the paper's, one figure each."""

import csv

import pytest
from missions import fly, fly_text

LINE_ABREAST = """
# auv1 ────►
# auv2 ────►   {gap} m apart, 1 m/s
# auv3 ────►
duration_s = {duration}
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 2000.0
[mission.formation_m]
auv1 = [0.0, 0.0, 0.0]
auv2 = [0.0, {gap}, 0.0]
auv3 = [0.0, 60.0, 0.0]
[craft.auv1]
[craft.auv2]
[craft.auv3]
"""


def series(folder) -> list[dict[str, float]]:
    with (folder / "series.csv").open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def test_an_undisturbed_team_is_perfect_on_a_line():
    """With nothing wrong there is nothing to deviate."""
    assert fly_text(LINE_ABREAST.format(gap=30, duration=600)).fd < 0.02


def test_a_known_current_is_compensated():
    """
    A current the craft know costs next to nothing.

        current ↑ 0.3 m/s
        auv ──────────►
    """
    current = ("sea.current_ned_mps=[0.3, -0.1, 0.0]",)
    assert fly_text(LINE_ABREAST.format(gap=30, duration=600), *current).fd < 0.05


def test_an_unknown_current_costs_cross_track():
    """A current the craft do not know sets them off their track until the P controller balances it."""
    current = ("sea.current_ned_mps=[0.0, 0.15, 0.0]", "sea.known_current_ned_mps=[0.0, 0.0, 0.0]")
    # 0.15 m/s across at 1 m/s is an angle of 0.15 rad, which k_x = 0.05 rad/m orders at 3 m.
    assert fly_text(LINE_ABREAST.format(gap=30, duration=1200), *current).fd_xte == pytest.approx(3.0, rel=0.15)


def test_a_current_too_strong_is_said():
    """A craft that cannot make good its course is named with the number of steps, and the run goes on."""
    summary = fly_text(LINE_ABREAST.format(gap=30, duration=60), "sea.current_ned_mps=[-3.5, 0.0, 0.0]")
    assert summary.complete
    assert summary.adrift_steps == {"auv1": 60, "auv2": 60, "auv3": 60}


def test_losses_make_it_worse_but_not_bad():
    """Half of the datagrams lost costs FD less than a tenth."""
    lossless, lossy = fly("paper-d"), fly("paper-d", "link.loss=0.5")
    assert lossy.lost == pytest.approx(lossy.delivered, rel=0.15)
    assert lossless.fd < lossy.fd < 1.1 * lossless.fd


def test_hold_at_the_end(tmp_path):
    """
    A team that is told to hold stays within a few metres of the end of its last track.

        ───────────► ⊗ ⊗ ⊗
    """
    text = LINE_ABREAST.format(gap=30, duration=400).replace("2000.0", '200.0\nat_end = "hold"')
    fly_text(text, out=tmp_path)
    last = series(tmp_path)[-1]
    assert all(abs(last[f"{craft}_north_m"] - 200.0) < 5.0 for craft in ("auv1", "auv2", "auv3"))


def test_a_drifting_craft_drifts_apart():
    """Inertial drift of one craft is an error nobody can see: it shows in the true formation, one metre a 1000 s."""
    drift = ("craft.auv3.navigation.drift_ned_mps=[0.0, 0.001, 0.0]",)
    assert fly_text(LINE_ABREAST.format(gap=30, duration=1000), *drift).fd_xte == pytest.approx(1.0 / 2 / 3, rel=0.1)


def test_explicit_tracks_in_three_dimensions(tmp_path):
    """The explicit-track example of deploy/scenarios runs and keeps its formation."""
    summary = fly("tracks", out=tmp_path)
    assert summary.complete
    assert summary.fd < 3.5


@pytest.mark.parametrize("craft", [1, 2, 10])
def test_any_number_of_craft(craft):
    """One craft alone, a pair and ten craft fly the lawnmower in one program."""
    from grex_sim.bench import scenario_text

    summary = fly_text(scenario_text(craft, 400))
    assert summary.complete
    assert summary.messages_sent == 40
    assert summary.delivered == 39 * (craft - 1)


def test_a_fix_that_is_not_trusted_holds_the_craft():
    """An agent without a valid fix holds; the run says how often that was so."""
    summary = fly_text(LINE_ABREAST.format(gap=30, duration=60), "craft.auv2.navigation.offset_ned_m=[1e4, 0.0, 0.0]")
    # 10 km off is outside of what a team state can say: it is not sent, and that is a state of health.
    assert summary.unhealthy_steps == {"auv2": {"outside_frame": 2}}
    assert summary.refused == 0
