"""A scenario file that cannot work ends in one line that names the path of the fault."""

import copy

import msgspec
import pytest

from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.scenario import decode, fingerprint, load, loads

LOOP = "lag_s = 1.0, rate_max = 1.0"

#: What somebody writes, and the path that the one line must name.
BAD_VALUES = [
    ("nonsense = 1", "$.nonsense"),
    ("link.nonsense = 1", "$.link.nonsense"),
    ("team.kalman.nonsense = 1", "$.team.kalman.nonsense"),
    ("craft.auv2.nonsense = 1", "$.craft.auv2.nonsense"),
    ("craft.auv3.vehicle.nonsense = 1", "$.craft.auv3.vehicle.nonsense"),
    ('craft.auv2.frontseat = {type = "sim", url = "x"}', "$.craft.auv2.frontseat.url"),
    ("title = 3", "$.title"),
    ("title = 2008-09-03", "$.title"),
    ("link.loss = true", "$.link.loss"),
    ("link.loss = '0.3'", "$.link.loss"),
    ("clock = 3", "$.clock"),
    ("craft = 3", "$.craft"),
    ("craft.auv2 = 3", "$.craft.auv2"),
    ("craft = {}", "$.craft"),
    ("link.loss = 1.5", "$.link.loss"),
    ("link.seed = -1", "$.link.seed"),
    ("seed = 9223372036854775808", "$.seed"),
    ("score.xte = 2.0", "$.score.xte"),
    ("clock.tick_s = 0.001", "$.clock.tick_s"),
    ("mission.legs = 0", "$.mission.legs"),
    ("mission.legs = 2.5", "$.mission.legs"),
    ("mission.formation_m.auv2 = [0.0, 0.0]", "$.mission.formation_m.auv2"),
    ("craft.auv2.vehicle.speed_error_relative = -1.0", "$.craft.auv2.vehicle.speed_error_relative"),
    ("mission.first_turn = left", "$.mission.first_turn"),
    ("clock.pace = fast", "$.clock.pace"),
    ("clock.pace = 0", "$.clock.pace"),
    ("clock.pace = true", "$.clock.pace"),
    ("link.loss = nan", "$.link.loss"),
    ("duration_s = nan", "$.duration_s"),
    ("duration_s = inf", "$.duration_s"),
    ("clock.pace = nan", "$.clock.pace"),
    ("clock.pace = inf", "$.clock.pace"),
    ("sea.current_ned_mps = [0.0, -inf, 0.0]", "$.sea.current_ned_mps[1]"),
    ("mission.formation_m.auv3 = [0.0, nan, 0.0]", "$.mission.formation_m.auv3[1]"),
    ("craft.auv1.navigation.white_m = inf", "$.craft.auv1.navigation.white_m"),
    (f"craft.auv1.vehicle.surge = {{{LOOP}, min = nan, max = 1.0}}", "$.craft.auv1.vehicle.surge.min"),
    (f"craft.auv1.vehicle.surge = {{{LOOP}, max = 1.0}}", "$.craft.auv1.vehicle.surge.min"),
    (f"craft.auv2.vehicle.roll = {{{LOOP}, min = 2.0, max = 1.0}}", "$.craft.auv2.vehicle.roll.min"),
    ("team.speed_min_mps = 3.5", "$.team.speed_min_mps"),
    ("team.name = 'My Team'", "$.team.name"),
    ("team.estimator = 'not a path'", "$.team.estimator"),
    ("team.controller = 'module:'", "$.team.controller"),
    ("bus.endpoints = ['udp/127.0.0.1:7447']", "$.bus.endpoints[0]"),
    ("bus.endpoints = ['tcp/127.0.0.1:7447', '127.0.0.1']", "$.bus.endpoints[1]"),
    ("bus.endpoints = 'tcp/127.0.0.1:7447'", "$.bus.endpoints"),
    ("mission.type = spiral", "$.mission.type"),
    ("mission = {formation_m = {}}", "$.mission.type"),
    ("mission = {type = 'lawnmower'}", "$.mission.formation_m"),
    ("mission.formation_m.auv9 = [0.0, 0.0, 0.0]", "$.mission.formation_m.auv9"),
    ("craft.auv4 = {}", "$.mission.formation_m.auv4"),
    ("craft.sim = {}", "$.craft.sim"),
    ("link.mac = {type = 'tdma', slots = [{craft = 'auv1', start_s = 0.0}]}", "$.link.mac.slots[0].length_s"),
    (
        "link.mac = {type = 'tdma', slots = [{craft = 'AUV1', start_s = 0.0, length_s = 10.0}]}",
        "$.link.mac.slots[0].craft",
    ),
]

BAD_OVERRIDES = [
    ("link.loss", "link.loss"),
    ("=0.3", "=0.3"),
    ("link..loss=0.3", "link..loss=0.3"),
    ("link.loss.deep=0.3", "$.link.loss"),
    ("title.deep.deeper=0.3", "$.title"),
]

BAD_NAMES = ["AUV1", "1auv", "auv-1", "a" * 33]

TRACKS = """
[mission]
type = "tracks"
[mission.craft.auv1]
start_ned_m = [0, 0, 0]
tracks = [{type = "line", to_ned_m = [100, 0, 0], speed_mps = 1}]
[mission.craft.auv2]
start_ned_m = [0, 50, 0]
tracks = [{type = "line", to_ned_m = [100, 50, 0], speed_mps = 1}, {type = "arc", centre_ne_m = [100, 90], turn_deg = 90, speed_mps = 1}]
[craft.auv1]
[craft.auv2]
"""  # noqa: E501

BAD_TRACKS = [
    ("turn_deg = 90", "turn_deg = 360", "$.mission.craft.auv2.tracks[1].turn_deg"),
    ("[100, 50, 0]", "[100, 50, 'deep']", "$.mission.craft.auv2.tracks[0].to_ned_m[2]"),
    ('type = "arc"', 'type = "helix"', "$.mission.craft.auv2.tracks[1].type"),
    ("turn_deg = 90", "turn_deg = 90, radius_m = 9", "$.mission.craft.auv2.tracks[1].radius_m"),
    ("[craft.auv2]", "", "$.mission.craft.auv2"),
    ("[craft.auv2]", "[craft.auv2]\n[craft.auv3]", "$.mission.craft.auv3"),
]


def fault(text: str, *overrides: str) -> ConfigError:
    with pytest.raises(ConfigError) as caught:
        loads(text, overrides)
    assert str(caught.value) == f"{caught.value.path}: {caught.value.problem}"
    assert caught.value.problem
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2
    return caught.value


@pytest.mark.parametrize(("override", "path"), BAD_VALUES, ids=[value for value, _ in BAD_VALUES])
def test_bad_value(text: str, override: str, path: str) -> None:
    """A value that cannot work is named by its path, with the names of craft in it."""
    key, _, value = override.partition(" = ")
    assert fault(text, f"{key}={value}").path == path


@pytest.mark.parametrize(("override", "path"), BAD_OVERRIDES)
def test_bad_override(text: str, override: str, path: str) -> None:
    """An override that has no path, no value or no table to go into is refused by name."""
    assert fault(text, override).path == path


@pytest.mark.parametrize(("old", "new", "path"), BAD_TRACKS)
def test_bad_track(old: str, new: str, path: str) -> None:
    """A fault in one craft's list of tracks is named with the craft and the number of the track."""
    assert old in TRACKS
    assert fault(TRACKS.replace(old, new)).path == path


def test_several_faults(text: str) -> None:
    """Of several faults one is named, with its own craft's name and not another's."""
    faults = ["mission.formation_m.auv2=[0.0, 0.0]", "mission.formation_m.auv3=3", "craft.auv1.nonsense=1"]
    assert fault(text, *faults).path == "$.mission.formation_m.auv2"
    assert fault(text, *faults[1:]).path == "$.mission.formation_m.auv3"


@pytest.mark.parametrize("name", ["sim", "link", "up", "truth"])
def test_reserved_name(text: str, name: str) -> None:
    """A craft cannot take the place of another participant on the bus."""
    text = text.replace("[craft.auv2]", f"[craft.{name}]").replace("auv2 =", f"{name} =")
    assert fault(text).path == f"$.craft.{name}"


@pytest.mark.parametrize("name", BAD_NAMES)
def test_bad_craft_name(text: str, name: str) -> None:
    """A craft whose name cannot be part of a key is named by its path."""
    assert fault(text.replace("[craft.auv2]", f'[craft."{name}"]')).path == f"$.craft.{name}"


def test_name_with_newline(text: str) -> None:
    """A name ends where it seems to end: no newline hides behind it."""
    text = text.replace("[craft.auv2]", '[craft."auv2\\n"]').replace("auv2 =", '"auv2\\n" =')
    assert fault(text).path.startswith("$.")


@pytest.mark.parametrize("override", ['team.name="grex\\n"', 'team.estimator="none\\n"', 'link.profile="grex2008\\n"'])
def test_word_with_newline(text: str, override: str) -> None:
    """A word that becomes part of a key, a file name or an import has no newline at its end."""
    assert fault(text, override).path == "$." + override.partition("=")[0]


def test_key_with_newline(text: str) -> None:
    """Even an unknown key that has a newline in it is complained about in one line."""
    assert fault('"two\\nlines" = 1\n' + text)


@pytest.mark.parametrize("part", ["[mission", "x = ", "x = 1\nx = 2", "[craft.auv1]"])
def test_bad_toml(text: str, part: str) -> None:
    """Text that is no TOML is refused under the name of the file."""
    assert fault(text + part + "\n").path == "scenario"


def test_missing_tables(text: str) -> None:
    """Without a mission or without craft there is no scenario."""
    assert fault("[craft.auv1]").path == "$.mission"
    assert fault(text.partition("[craft")[0]).path == "$.craft"


def test_missing_file(tmp_path) -> None:
    """A file that is not there is named, with the reason."""
    with pytest.raises(ConfigError, match="No such file or directory") as caught:
        load(tmp_path / "none.toml")
    assert caught.value.path == str(tmp_path / "none.toml")


def test_file_of_other_bytes(tmp_path) -> None:
    """A file that is not UTF-8 is named, with the reason."""
    file = tmp_path / "latin.toml"
    file.write_bytes('title = "Länge"'.encode("latin-1"))
    with pytest.raises(ConfigError, match="not UTF-8") as caught:
        load(file)
    assert caught.value.path == str(file)


def test_bad_toml_in_file(tmp_path) -> None:
    """A file that is no TOML is named."""
    file = tmp_path / "bad.toml"
    file.write_text("= 3")
    with pytest.raises(ConfigError, match="line 1") as caught:
        load(file)
    assert caught.value.path == str(file)


def test_file_and_text_agree(tmp_path, text: str) -> None:
    """A scenario is the same from a file as from its text."""
    file = tmp_path / "good.toml"
    file.write_text(text)
    assert load(file, ["link.loss=0.3"]) == loads(text, ["link.loss=0.3"])


def test_heading_limits_are_ignored(text: str) -> None:
    """The heading wraps, so its limits may be anything."""
    heading = f"craft.auv1.vehicle.heading={{{LOOP}, min=2.0, max=1.0}}"
    assert loads(text, [heading]).craft["auv1"].vehicle.heading.min == 2.0


def test_override_types(text: str) -> None:
    """An override's value is TOML; what is no TOML is a word."""
    overrides = [
        "link.loss=0.25",
        "mission.legs = 3",
        "team.estimator=none",
        'title="with spaces"',
        "$.mission.at_end=hold",
        "sea.current_ned_mps=[0.1, 0, -0.2]",
        "clock.pace=4",
        "bus.endpoints=['tcp/127.0.0.1:7500']",
    ]
    scenario = loads(text, overrides)
    assert (scenario.link.loss, scenario.mission.legs, scenario.team.estimator) == (0.25, 3, "none")
    assert (scenario.title, scenario.mission.at_end, scenario.clock.pace) == ("with spaces", "hold", 4)
    assert scenario.sea.current_ned_mps == (0.1, 0.0, -0.2)
    assert scenario.bus.endpoints == ("tcp/127.0.0.1:7500",)


def test_override_word_with_spaces(text: str) -> None:
    """A title needs no quotes on the command line, and may hold an equals sign."""
    assert loads(text, ["title=loss = 0.3"]).title == "loss = 0.3"


def test_override_creates_tables(text: str) -> None:
    """An override makes the tables on its way, and leaves their other values alone."""
    scenario = loads(text, ["craft.auv2.vehicle.speed_error_relative=0.1", "team.kalman.memory_s=60"])
    assert scenario.craft["auv2"].vehicle.speed_error_relative == 0.1
    assert scenario.craft["auv1"].vehicle.speed_error_relative == 0.0
    assert scenario.team.kalman.memory_s == 60.0
    assert scenario.team.kalman.fix_sigma_m == loads(text).team.kalman.fix_sigma_m


def test_last_override_wins(text: str) -> None:
    """Overrides are applied in their order, over what the file says."""
    assert loads("seed = 3\n" + text, ["seed=5", "seed=7"]).seed == 7


def test_order_of_craft_is_kept(text: str) -> None:
    """The team keeps the order of the file, which is that of the formation polygon."""
    text = text.replace("[craft.auv1]\n", "") + "[craft.auv1]\n"
    assert list(loads(text).craft) == ["auv2", "auv3", "auv1"]


def leaves(value, path=()):
    if isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else enumerate(value)
        for key, below in entries:
            yield from leaves(below, (*path, key))
    else:
        yield path, value


def changed(document, path, value):
    document = copy.deepcopy(document)
    table = document
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    try:
        return msgspec.convert(document, Scenario)
    except msgspec.ValidationError:
        return None


WORDS = ["other", "hold", "port", "lockstep", "live", "tracks", "auv2", "short", "thorp", "cable", "rover", "vision",
         "one_way", "go_on", "radio", "box"]  # fmt: skip


def test_fingerprint_changes_with_any_value(text: str) -> None:
    """No two scenarios that differ in any value have the same fingerprint."""
    slot = "link.mac={type='tdma',slots=[{craft='auv1', start_s=0.0, length_s=10.0}]}"
    more = [
        "duration_s=9",
        "link.seed=3",
        "link.mac.cycle_s=90",
        "link.burst={loss=0.1, mean_length_s=9.0}",
        "link.shadowing={sigma_db=3.0}",
        "link.jammers=[{position_ned_m=[0, 0, 0], source_level_db=150}]",
        "link.outages=[{craft='auv1', start_s=1, end_s=2}]",
        "link.land=[{between=['auv1', 'auv3'], kind='cable'}]",
        "craft.auv4={}",
        "standby.auv4={at_ned_m=[0, 50, 5]}",
        "events=[{at_s=60.0, at_ned_m=[9, 9, 9], seen_by='auv1'}]",
        "tasking.operator='auv1'",
        "craft.auv2.tasks=[{type='inspect', at_ned_m=[5, 6, 7]}, {type='hold', for_s=9.0}]",
        "link.water.layers=[[0, 1490], [30, 1480]]",
        "craft.auv1.self_noise={level_db=90}",
        "craft.auv1.vehicle.speed_wander={sigma_relative=0.03}",
        "craft.auv1.vehicle.speed_limits=[{start_s=1, end_s=2, max_mps=0.5}]",
        "team.own_filter={speed_sigma_mps=0.02}",
        "craft.auv3.modem={type='serial', port='/dev/ttyS0'}",
        "craft.auv3.inertial={offset_sigma_m=0.3}",
        "sea.known_current_ned_mps=[0, 0, 0]",
        "datum={latitude_deg=54.0, longitude_deg=10.0}",
        "craft.auv2.frontseat={type='mavlink', url='tcp:h:1', system=3, own_system=7, signing_key_file='key'}",
    ]
    scenario = loads(text, [slot, *more, "bus.endpoints=['tcp/h:1']"])
    document = msgspec.json.decode(msgspec.json.encode(scenario))
    seen = {fingerprint(scenario)}
    tried = 0
    for path, value in leaves(document):
        number = 1 if value is None else value
        others = [*WORDS, "tcp/h:2"] if isinstance(value, str) else [number + 1, number * 0.9, number + 0.5, not value]
        variants = [changed(document, path, other) for other in others if other != value]
        variant = next((variant for variant in variants if variant is not None), None)
        if variant is None:
            assert path[-1] in {"type", "model", "driver", "self_noise", "speed_wander", "inertial", "base"}, path
            continue
        tried += 1
        seen.add(fingerprint(variant))
    assert tried > 150
    assert len(seen) == tried + 1


def test_fingerprint_is_stable(text: str) -> None:
    """The fingerprint is of what a scenario says, not of how it is written."""
    same = ["link.loss=0", "clock.pace=lockstep", "mission.speed_mps=1", "craft.auv1={}"]
    assert fingerprint(loads(text)) == fingerprint(loads("# a comment\n" + text, same))
    assert len(fingerprint(loads(text))) == 12


def test_big_link_seed_has_a_fingerprint(text: str) -> None:
    """A scenario that is accepted has a fingerprint, however large its seeds."""
    assert fingerprint(loads(text, [f"link.seed={2**80}"])) != fingerprint(loads(text))


def test_decode_checks_names() -> None:
    """A document from elsewhere than a file is checked no less."""
    mission = {"type": "lawnmower", "formation_m": {"auv1": [0, 0, 0]}}
    assert list(decode({"mission": mission, "craft": {"auv1": {}}}).craft) == ["auv1"]
    with pytest.raises(ConfigError) as caught:
        decode({"mission": mission, "craft": {"auv1": {}, "auv2": {}}})
    assert caught.value.path == "$.mission.formation_m.auv2"


def test_bad_name_beside_a_good_one(text: str) -> None:
    """Of two entries of a table the one with the fault is named, even where others complain alike."""
    text = text.replace("[craft.auv3]", "[craft.AUV]").replace("auv3 =", "AUV =")
    assert fault(text).path == "$.mission.formation_m.AUV"
