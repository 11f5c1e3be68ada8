"""The console, from its arguments to what it prints and its exit status."""

import json
import re
import sys
import tomllib
import typing
from importlib.resources import files

import pytest
from missions import SCENARIOS

from grex_link.config import Scenario, SerialModem
from grex_link.config_base import Config
from grex_link.link_config import PureAloha, SlottedAloha
from grex_link.scenario import decode, loads
from grex_sim import cli

PAPER = str(SCENARIOS / "paper-d.toml")
SLOTS = "link.mac={type='tdma',slots=[{craft='auv1',start_s=0,length_s=10},{craft='auv2',start_s=%s,length_s=%s}]}"


@pytest.fixture
def grex(monkeypatch, capsys, tmp_path):
    """Run the console in this process: (exit status, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["grex", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return run


@pytest.mark.parametrize(
    ("override", "path"),
    [
        ("nonsense=1", "$.nonsense"),
        ("link.los=0.1", "$.link.los"),
        ("craft.auv2.vehicle.surge.lag=1", "$.craft.auv2.vehicle.surge"),
        ("craft.auv2.navigation.white=1", "$.craft.auv2.navigation.white"),
        ("link.loss='much'", "$.link.loss"),
        ("link.loss=1.1", "$.link.loss"),
        ("link.loss=nan", "$.link.loss"),
        ("mission.legs=0", "$.mission.legs"),
        ("mission.legs=2.5", "$.mission.legs"),
        ("mission.speed_mps=inf", "$.mission.speed_mps"),
        ("mission.type='spiral'", "$.mission.type"),
        ("mission.formation_m.auv2=[0,0]", "$.mission.formation_m.auv2"),
        ("mission.formation_m.auv9=[0,0,0]", "$.mission.formation_m.auv9"),
        ("craft.auv9={}", "$.mission.formation_m.auv9"),
        ("craft.AUV={}", "$.craft.AUV"),
        ("craft.link={}", "$.craft.link"),
        ("mission.turn_radius_m=20", "$.mission.turn_radius_m"),
        ("mission.turn_radius_m=26", "$.mission.formation_m.auv2"),
        ("team.speed_min_mps=5", "$.team.speed_min_mps"),
        ("team.estimator=clairvoyant", "$.team.estimator"),
        ("team.controller=json:JSONDecoder2", "$.team.controller"),
        ("clock.pace=quick", "$.clock.pace"),
        ("bus.endpoints=['127.0.0.1']", "$.bus.endpoints[0]"),
        ("link.profile=shouting", "$.link.profile"),
        (SLOTS % (10, 9), "$.link.mac.slots[1].length_s"),
        (SLOTS % (5, 10), "$.link.mac.slots[1].start_s"),
        (SLOTS.replace("auv2", "auv9") % (10, 10), "$.link.mac.slots[1].craft"),
        ("link.mac={type='tdma',cycle_s=29}", "$.link.mac.cycle_s"),
        ("duration_s=-1", "$.duration_s"),
        ("craft.auv1.vehicle.surge={lag_s=1,min=2,max=1,rate_max=1}", "$.craft.auv1.vehicle.surge.min"),
    ],
)
def test_a_bad_scenario_is_one_line_with_its_path(grex, override, path):
    """Whatever is wrong, the exit status is 2 and one line names where it is; nothing is run for it."""
    status, out, err = grex("run", PAPER, "--set", override)
    assert (status, out) == (2, "")
    assert err.startswith(f"grex: {path}")
    assert err.count("\n") == 1


@pytest.mark.parametrize("command", ["run", "check", "sim", "link"])
def test_a_file_that_is_not_there(grex, command):
    """Every command names the scenario file it cannot read."""
    assert grex(command, "none.toml")[::2] == (
        2,
        "grex: none.toml: cannot read the scenario file: No such file or directory\n",
    )


def test_an_unknown_craft(grex):
    """An agent of a craft that is not in the scenario is refused with those there are."""
    status, _, err = grex("agent", PAPER, "--craft", "auv7")
    assert (status, err) == (2, "grex: --craft: unknown craft 'auv7'; there are auv1, auv2, auv3\n")


def test_run_prints_one_json_object(grex, tmp_path):
    """With --json there is one object on standard output, and nothing on standard error when that is no terminal."""
    status, out, err = grex("run", PAPER, "--in-process", "--set", "duration_s=50", "--seed", "3", "--json")
    assert (status, err) == (0, "")
    summary = json.loads(out)
    assert summary["seed"] == 3
    assert summary["ticks"] == 50
    assert (tmp_path / summary["out"] / "run.png").exists()


def test_run_prints_a_summary(grex):
    """Without --json a person reads FD, speed, messages and digest."""
    status, out, _ = grex("run", PAPER, "--in-process", "--set", "duration_s=50", "--out", "here")
    assert status == 0
    assert all(
        word in out for word in ("formation deviation FD", "x real time", "messages sent", "digest", "files in here")
    )


def test_a_pace_that_is_not_held_is_said(grex):
    """Faster than the machine can, the run says so instead of degrading silently."""
    status, out, _ = grex(
        "run", PAPER, "--in-process", "--pace", "1000", "--set", "duration_s=300", "--set", "clock.tick_s=0.02"
    )
    assert status == 0
    assert "WARNING: the pace was not held" in out


def test_an_output_folder_that_cannot_be_made(grex, tmp_path):
    """A file in the way of the output folder is named."""
    (tmp_path / "taken").write_text("")
    status, _, err = grex("run", PAPER, "--in-process", "--out", "taken")
    assert (status, err) == (2, "grex: --out: cannot make the folder taken: File exists\n")


def test_check_prints_the_plan_and_draws_it(grex, tmp_path):
    """`grex check` says what will happen and draws the tracks."""
    status, out, _ = grex("check", PAPER, "--out", "plan.png")
    assert status == 0
    assert "4629" in out
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")


def test_example_is_a_sound_scenario(grex):
    """What `grex example` prints can be run as it is."""
    status, out, _ = grex("example")
    assert status == 0
    assert loads(out).craft


def tables_of(kind):
    """Return all tables of the scenario below a type, itself included."""
    found = {kind} if isinstance(kind, type) and issubclass(kind, Config) else set()
    inner = typing.get_type_hints(kind, include_extras=False).values() if found else typing.get_args(kind)
    return found.union(*map(tables_of, inner))


def test_example_shows_every_field():
    """Every field of every table of a scenario stands in the example, set or behind ``#:``."""
    example = (files("grex_sim") / "example.toml").read_text(encoding="utf-8")
    keys = re.findall(r"(?:^|[{,]|#:) *(\w+) *=", example, re.MULTILINE)
    headers = re.findall(r"\[([a-z]\w*(?:\.\w+)*)\]", example)
    shown = {*keys, *(part for header in headers for part in header.split("."))}
    fields = {name for table in tables_of(Scenario) for name in table.__struct_fields__}
    assert len(fields) > 130
    assert fields <= shown, sorted(fields - shown)


def test_example_shows_the_defaults():
    """What the example sets is the default, but for what has none or is about its own mission."""
    example = tomllib.loads((files("grex_sim") / "example.toml").read_text(encoding="utf-8"))
    needed = {key: example[key] for key in ("title", "mission")} | {"craft": {craft: {} for craft in example["craft"]}}
    assert decode(example) == decode(needed)


def test_what_the_example_offers_is_accepted():
    """What stands behind ``#:`` in the tables of the link and of a craft is accepted as it is."""
    example = (files("grex_sim") / "example.toml").read_text(encoding="utf-8")
    before, _, link = example.partition("[link] ")
    aloha = re.search(r"(?:#: .*\n)*#: type = \"slotted_aloha\"(?:\n#: .*)+", link)
    offered = (
        link.replace(aloha[0], "")
        .replace("slots = []", "")
        .replace("speed_limits = []", "")
        .replace("#: known", "# known")
    )
    offered = offered.replace('frontseat = { type = "sim" }', "")
    offered = re.sub(r"^modem = .*emulated.*$", "", offered, flags=re.MULTILINE)
    scenario = loads(before + "[link] " + re.sub(r"^#: ?", "", offered, flags=re.MULTILINE))
    taken = scenario.link
    assert (taken.seed, taken.mac.guard_s, len(taken.mac.slots), taken.shadowing.sigma_db) == (7, 0.4, 3, 4.0)
    assert (taken.burst.loss, len(taken.jammers), len(taken.outages), len(taken.land)) == (0.2, 1, 1, 1)
    assert isinstance(scenario.craft["auv1"].modem, SerialModem)
    assert scenario.craft["auv1"].self_noise.level_db == 100.0
    vehicle = scenario.craft["auv1"].vehicle
    assert (vehicle.speed_wander.sigma_relative, len(vehicle.speed_limits)) == (0.03, 1)
    kinds = aloha[0].replace("#: ", "").split("[link.mac]")[1:]
    macs = [loads(f"{before}[link.mac]{kind}\n[craft.auv1]\n[craft.auv2]\n[craft.auv3]\n").link.mac for kind in kinds]
    assert [type(mac) for mac in macs] == [SlottedAloha, PureAloha]


def test_help_names_every_command(grex):
    """`grex --help` lists what there is."""
    status, out, _ = grex("--help")
    assert status == 0
    assert all(command in out for command in cli.COMMANDS)
