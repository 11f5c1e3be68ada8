"""Pictures of runs and plans: what is on them, and where there is nothing to draw."""

import math
import subprocess
import sys
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Annotation

from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError
from grex_link.scenario import loads
from grex_sim import report

HEAD = """
[mission]
type = "lawnmower"
legs = {legs}
leg_length_m = 100.0
turn_radius_m = 40.0
heading_deg = {heading}
"""
TRIANGLE = {"auv1": (10.0, 0.0), "auv2": (-6.0, -25.0), "auv3": (-6.0, 25.0)}


def lawnmower(formation=TRIANGLE, *, title="A mission", heading=0.0, legs=3):
    """Plan a lawnmower for craft at (ahead, starboard)."""
    places = "".join(f"{craft} = [{ahead}, {starboard}, 0.0]\n" for craft, (ahead, starboard) in formation.items())
    craft = "".join(f"[craft.{name}]\n" for name in formation)
    text = f'title = "{title}"\n{HEAD.format(heading=heading, legs=legs)}[mission.formation_m]\n{places}{craft}'
    scenario = loads(text)
    return scenario, plan_mission(scenario)


def ring(count):
    """Place craft on a circle of 20 m."""
    angles = [math.tau * place / count for place in range(count)]
    return {f"craft_number_{place}": (20.0 * math.cos(a), 20.0 * math.sin(a)) for place, a in enumerate(angles)}


def as_planned(plan, steps):
    """Take all craft along their plans together; positions of shape (steps, craft, 2)."""
    tracks = len(next(iter(plan.craft.values())).tracks)
    progress = np.linspace(0.001, tracks - 0.001, steps)
    return np.array([[craft.point(at) for craft in plan.craft.values()] for at in progress])


def write_series(folder, plan, positions, parts=(0.5, 0.25, 0.125)):
    """Write a series.csv as the simulator does, with the same parts of fd in every step."""
    names = ["t_s", "fd", "fd_distance", "fd_angle", "fd_xte"]
    names += [f"{craft}_{axis}_m" for craft in plan.craft for axis in ("north", "east")]
    times = np.arange(1.0, len(positions) + 1.0)
    fd = np.tile([sum(parts), *parts], (len(positions), 1))
    table = np.column_stack([times, fd, positions.reshape(len(positions), -1)])
    np.savetxt(folder / "series.csv", table, delimiter=",", header=",".join(names), comments="")


@pytest.fixture
def figures(monkeypatch):
    """Every figure that is saved, laid out, instead of its file."""
    kept = []

    def keep(figure, path):
        figure.canvas.draw()
        kept.append(figure)
        return path

    monkeypatch.setattr(report, "_save", keep)
    return kept


def panel(figure, words):
    """Find a panel by its title."""
    return next(axes for axes in figure.axes if words in axes.get_title())


def pixels_of(picture, colour):
    """Count the pixels of about a colour."""
    return int((np.abs(picture[..., :3] - to_rgb(colour)).max(axis=-1) < 0.02).sum())


def test_a_run_becomes_a_picture_with_every_craft_on_it(tmp_path):
    """The picture is written where it says, has its full size, and shows the colours of all craft and parts of fd."""
    scenario, plan = lawnmower()
    write_series(tmp_path, plan, as_planned(plan, 300))
    path = report.draw(tmp_path, scenario, plan)
    assert path == tmp_path / "run.png"
    picture = imread(path)
    assert picture.shape[:2] == (1155, 1540)
    for colour in ("#0072B2", "#D55E00", "#009E73", *(shade for *_, shade in report._PARTS)):
        assert pixels_of(picture, colour) > 300


@pytest.mark.parametrize("count", [1, 3])
def test_a_run_of_one_tick_is_drawn(tmp_path, count):
    """A run that broke off after its first tick is drawn without a warning."""
    scenario, plan = lawnmower(dict(list(TRIANGLE.items())[:count]))
    write_series(tmp_path, plan, as_planned(plan, 2)[:1])
    assert report.draw(tmp_path, scenario, plan).stat().st_size > 10_000


@pytest.mark.parametrize("text", [None, "t_s,fd,fd_distance,fd_angle,fd_xte\n"])
def test_without_a_tick_there_is_no_picture(tmp_path, text):
    """A run that broke off before the first tick has no series, or one without steps: None, and no file."""
    if text is not None:
        (tmp_path / "series.csv").write_text(text, encoding="utf-8")
    assert report.draw(tmp_path, *lawnmower()) is None
    assert not (tmp_path / "run.png").exists()


def test_the_figure_of_merit_is_that_of_all_steps(tmp_path, figures, monkeypatch):
    """FD and the means of its parts count every step, although a picture shows only some of them."""
    monkeypatch.setattr(report, "_SAMPLES_MAX", 10)
    scenario, plan = lawnmower()
    write_series(tmp_path, plan, as_planned(plan, 40))
    lines = (tmp_path / "series.csv").read_text(encoding="utf-8").splitlines()
    lines[-1] = ",".join(["40", "40.875", "40.5", *lines[-1].split(",")[3:]])
    (tmp_path / "series.csv").write_text("\n".join(lines), encoding="utf-8")
    report.draw(tmp_path, scenario, plan)
    axes = panel(figures[0], "Formation deviation")
    assert "FD = 1.8750" in axes.get_title()
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["distance (mean 1.5000 m)", "angle (mean 0.2500 rad)", "cross-track (mean 0.1250 m)", "fd(k)"]
    assert len(axes.lines[0].get_xdata()) == 10


@pytest.mark.parametrize(
    ("count", "heading", "legs"), [(1, 0.0, 2), (1, 0.0, 12), (2, 90.0, 12), (7, 30.0, 3), (30, 0.0, 12), (30, 90.0, 3)]
)
def test_nothing_overlaps_and_nothing_is_cut_off(tmp_path, figures, count, heading, legs):
    """Panels, titles and legend keep apart and stay inside the picture, whatever the team, the shape and the title."""
    title = "costs $x_$ or $6, " * 20
    scenario, plan = lawnmower(ring(count), title=title, heading=heading, legs=legs)
    write_series(tmp_path, plan, as_planned(plan, 50))
    report.draw(tmp_path, scenario, plan)
    report.draw_plan(tmp_path / "plan.png", scenario, plan)
    for figure in figures:
        parts = [*figure.axes, *figure.legends, figure._suptitle]
        boxes = [part.get_tightbbox(figure.canvas.get_renderer()) for part in parts]
        for box in boxes:
            assert box.x0 >= 0.0
            assert box.y0 >= 0.0
            assert box.x1 <= figure.bbox.x1
            assert box.y1 <= figure.bbox.y1
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_every_axis_has_its_unit_and_the_legend_every_craft(tmp_path, figures):
    """Every axis names quantity and unit; the legend names every craft with its number once."""
    scenario, plan = lawnmower(ring(10))
    write_series(tmp_path, plan, as_planned(plan, 50))
    report.draw(tmp_path, scenario, plan)
    labels = {axes.get_xlabel() for axes in figures[0].axes} | {axes.get_ylabel() for axes in figures[0].axes}
    tracks, relative = {"east (m)", "north (m)"}, {"starboard (m)", "ahead (m)"}
    assert labels == {*tracks, *relative, "mission time (s)", "fd(k), sum of its parts (m and rad)"}
    named = [text.get_text() for text in figures[0].legends[0].get_texts()]
    craft = [f"{place + 1}: craft_number_{place}" for place in range(10)]
    assert sorted(named) == sorted([*craft, "planned track", "formation", "start", "desired place"])


def test_a_long_legend_says_how_many_it_leaves_out(figures, tmp_path):
    """A team of fifty does not push its tracks off the picture: the legend names forty and counts the rest."""
    report.draw_plan(tmp_path / "plan.png", *lawnmower(ring(50)))
    named = [text.get_text() for text in figures[0].legends[0].get_texts()]
    assert sum("craft_number" in name for name in named) == 40
    assert named[-1] == "and 10 more"


def test_lines_of_thirty_five_craft_differ():
    """No two of the first thirty-five craft have the same colour and the same dashes."""
    assert len({(report._colour(place), report._dash(place)) for place in range(35)}) == 35


def test_one_craft_has_no_panel_of_relative_positions(tmp_path, figures):
    """A team of one has nobody to be relative to."""
    scenario, plan = lawnmower({"solo": (0.0, 0.0)})
    write_series(tmp_path, plan, as_planned(plan, 20))
    report.draw(tmp_path, scenario, plan)
    assert len(figures[0].axes) == 2


@pytest.mark.parametrize("heading", [0.0, 135.0])
def test_a_formation_that_turns_as_a_rigid_body_stands_still(heading):
    """On lines and arcs, whichever way it heads, a perfect lawnmower is one point for each mate: its place."""
    _, plan = lawnmower(heading=heading)
    desired, real = report.relative_positions(as_planned(plan, 500), plan)
    np.testing.assert_allclose(desired - [[-16.0, -25.0], [-16.0, 25.0]], 0.0, atol=1e-6)
    np.testing.assert_allclose(real, desired, atol=1e-6)


def test_relative_positions_are_ahead_and_to_starboard_of_the_first():
    """On the leg back south, a mate that is 2 m too far north and 3 m too far west is astern and to starboard."""
    _, plan = lawnmower()
    positions = np.array([[craft.point(at) for craft in plan.craft.values()] for at in (0.5, 1.5, 2.5)])
    positions[2, 1] += [2.0, -3.0]
    desired, real = report.relative_positions(positions, plan)
    np.testing.assert_allclose((real - desired)[2], [[-2.0, 3.0], [0.0, 0.0]], atol=1e-9)


def test_how_far_craft_are_off_is_in_the_title(tmp_path, figures):
    """A mate that is 3 m off in all steps, and one that is not, are 2.12 m r.m.s. off, and 3 m at most."""
    scenario, plan = lawnmower()
    positions = as_planned(plan, 50)
    positions[:, 2, 0] += 3.0
    write_series(tmp_path, plan, positions)
    report.draw(tmp_path, scenario, plan)
    assert "2.12 m r.m.s. off the desired, 3 m at most" in panel(figures[0], "relative to auv1").get_title()


def test_the_plan_is_a_picture(tmp_path):
    """The plan is written as PNG by default, also without a suffix, and shows every craft."""
    report.draw_plan(tmp_path / "plan", *lawnmower())
    picture = imread(tmp_path / "plan", format="png")
    for colour in ("#0072B2", "#D55E00", "#009E73"):
        assert pixels_of(picture, colour) > 1000


def test_the_plan_shows_numbers_and_directions_of_its_tracks(tmp_path, figures):
    """Every track of a single craft has its number, in the middle, and an arrow that points the way it goes."""
    scenario, plan = lawnmower({"solo": (0.0, 0.0)})
    report.draw_plan(tmp_path / "plan.png", scenario, plan)
    arrows = [text for text in figures[0].axes[0].texts if isinstance(text, Annotation)]
    numbers = [text for text in figures[0].axes[0].texts if text not in arrows]
    assert [text.get_text() for text in numbers] == ["0", "1", "2", "3", "4"]
    assert numbers[2].get_position() == pytest.approx((80.0, 50.0))
    north = [arrow.xy[1] - arrow.xyann[1] for arrow in arrows]
    assert [math.copysign(1.0, way) for way in north] == [1.0, 1.0, -1.0, -1.0, 1.0]


def test_numbers_and_arrows_keep_apart(tmp_path, figures):
    """Where thirty craft leave no room for all numbers and arrows, those drawn do not cover each other."""
    report.draw_plan(tmp_path / "plan.png", *lawnmower(ring(30)))
    axes = figures[0].axes[0]
    places = [text.xy if isinstance(text, Annotation) else text.get_position() for text in axes.texts]
    nearest = min(math.dist(one, other) for one, other in combinations(places, 2))
    pixels = np.diff(axes.transData.transform([(0.0, 0.0), (nearest, 0.0)])[:, 0])[0]
    assert len(places) > 10
    assert pixels > 20.0


@pytest.mark.parametrize("name", ["no/such/folder.png", "plan.nonsense"])
def test_a_picture_that_cannot_be_written_is_one_line(tmp_path, name):
    """A missing folder or an unknown kind of picture is a fault of the command line, not a traceback."""
    with pytest.raises(ConfigError, match=r"^--out: cannot write the picture"):
        report.draw_plan(tmp_path / name, *lawnmower())


def test_a_fault_of_the_encoder_is_told(tmp_path, monkeypatch):
    """What fails without an error number, as encoders of pictures do, is told in its own words."""

    def fail(*_, **__):
        raise OSError("encoder error -2 when writing image file")

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(ConfigError, match=r"cannot write the picture .*: encoder error -2 when writing image file$"):
        report.draw_plan(tmp_path / "plan.png", *lawnmower())


def test_matplotlib_is_imported_only_to_draw():
    """Importing the module, and writing the plan as text, costs no import of matplotlib; pyplot is never imported."""
    program = (
        "import sys; from pathlib import Path; from grex_sim import report; from grex_link.scenario import loads\n"
        "from grex_agent.mission import plan_mission\n"
        "s = loads('[mission]\\ntype=\"lawnmower\"\\n[mission.formation_m]\\na=[0,0,0]\\n[craft.a]')\n"
        "p = plan_mission(s)\n"
        "report.plan_text(s, p); assert 'matplotlib' not in sys.modules\n"
        "report.draw_plan(Path('/dev/null'), s, p); assert 'matplotlib.figure' in sys.modules\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
