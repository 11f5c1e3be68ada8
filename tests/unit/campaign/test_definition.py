"""What a campaign is: its options, its cells, its jobs."""

from importlib.resources import files

import pytest
from missions import SCENARIOS

from grex_link.errors import ConfigError
from grex_link.scenario import load
from grex_sim.campaign.definition import Definition, difference, make_cells, make_jobs, parse_vary, plain_value
from grex_sim.campaign.own_files import own_files

PAPER = SCENARIOS / "paper-d.toml"


def cells_of(*options):
    return make_cells(lambda values: load(PAPER, values), parse_vary(options))


def test_commas_within_brackets_and_quotes_belong_to_the_value():
    """A value may be a table, a list or text with commas in it."""
    vary = parse_vary(["link.burst={loss=0.2,mean_length_s=60},{loss=0.5,mean_length_s=60}", "title='a,b',\"c,d\",e"])
    assert vary["link.burst"] == ["{loss=0.2,mean_length_s=60}", "{loss=0.5,mean_length_s=60}"]
    assert vary["title"] == ["'a,b'", '"c,d"', "e"]


@pytest.mark.parametrize(
    "options", [["link.loss"], ["=1"], ["link.loss="], ["link.loss=0,,1"], ["seed=1,2"], ["link.loss=0,0"],
                ["link.loss=0", "$.link.loss=1"]]
)  # fmt: skip
def test_a_bad_option_is_refused(options):
    """Whatever has no path, no value, or says the same twice is a fault of --vary."""
    with pytest.raises(ConfigError, match=r"^--vary: "):
        parse_vary(options)


def test_a_bad_path_or_value_is_named_as_in_the_scenario():
    """The path of the fault is that of the scenario."""
    with pytest.raises(ConfigError, match=r"^\$\.link\.loss: "):
        cells_of("link.loss=0,2")
    with pytest.raises(ConfigError, match=r"^\$\.link\.los: unknown key"):
        cells_of("link.los=0")


def test_cells_are_all_combinations_and_have_their_values():
    """Two paths of three and two values are six scenarios, each with its own."""
    cells = cells_of("link.loss=0,0.1,0.3", "team.estimator=none,along_track")
    found = [(cell.scenario.link.loss, cell.scenario.team.estimator) for cell in cells]
    assert found == [(loss, name) for loss in (0.0, 0.1, 0.3) for name in ("none", "along_track")]
    assert cells[3].values == {"link.loss": 0.1, "team.estimator": "along_track"}


def test_every_cell_is_flown_with_the_same_seeds():
    """Seeds follow the scenario's, the same in all cells; no two jobs share a key."""
    jobs = make_jobs(cells_of("link.loss=0,1"), 3)
    seeds = {loss: [job.scenario.seed for job in jobs if job.scenario.link.loss == loss] for loss in (0.0, 1.0)}
    assert seeds == {0.0: [1, 2, 3], 1.0: [1, 2, 3]}
    assert len({job.key for job in jobs}) == 6
    assert [job.scenario.link.loss for job in jobs[:2]] == [0.0, 1.0]


def test_without_anything_that_varies_there_is_one_cell():
    """A campaign may be one scenario with many seeds."""
    assert [cell.values for cell in cells_of()] == [{}]


@pytest.mark.parametrize(
    ("text", "value"), [("0.1", 0.1), ("3", 3), ("true", True), ("'x'", "x"), ("word", "word"), ("{a=1}", "{a=1}")]
)
def test_values_are_read_as_toml_where_they_are_simple(text, value):
    """Numbers are numbers, bare words are text, and tables stay as they were typed."""
    assert plain_value(text) == value
    assert type(plain_value(text)) is type(value)


def test_what_differs_between_two_campaigns_is_named():
    """Seeds, values, scenario and version are compared; nothing is said of the same."""
    one = Definition(load(PAPER), {"link.loss": ["0"]}, 5, "1")
    assert difference(one, one) == ""
    other = Definition(load(PAPER, ["link.loss=0.5"]), {"link.loss": ["1"]}, 6, "2")
    said = difference(one, other)
    for part in ("5 seeds instead of 6", "link.loss=0 instead of link.loss=1", "another scenario", "GREX 1"):
        assert part in said


def test_files_of_ones_own_belong_to_the_campaign(tmp_path, monkeypatch):
    """A modem profile or a plug-in that has been edited since makes another campaign, and is named."""
    profile, plugin = tmp_path / "my.toml", tmp_path / "my_estimator.py"
    profile.write_text((files("grex_link") / "modems" / "grex2008.toml").read_text())
    plugin.write_text("class Mine: ...\n")
    monkeypatch.syspath_prepend(tmp_path)
    scenario = load(PAPER, [f"link.profile='{profile}'", "team.estimator=my_estimator:Mine"])

    def definition():
        return Definition(scenario, {}, 1, "1", own_files([scenario, scenario]))

    before = definition()
    assert difference(before, definition()) == ""
    plugin.write_text("class Mine: changed = True\n")
    assert difference(before, definition()) == "what is in my_estimator has changed since"
    profile.write_text(profile.read_text() + "\n# a word\n")
    assert difference(before, definition()) == f"what is in {profile}, my_estimator has changed since"
    assert own_files([load(PAPER)]) == {}
