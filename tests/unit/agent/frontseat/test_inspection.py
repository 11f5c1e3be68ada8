"""What a probe finds in each family of simulated autopilots, with right and with wrong parameters."""

import pytest
from mavlink_duet import Duet

from grex_agent.frontseat.parameters import ParameterReader
from grex_link.config import DatumConfig

GOOD = {
    "rover": {"FS_GCS_ENABLE": 1},
    "sub": {"FS_GCS_ENABLE": 4},
    "px4": {},
}


@pytest.mark.parametrize("family", GOOD)
def test_nothing_to_say(family: str):
    """An autopilot that knows where it is and whose failsafes are right misses nothing and needs no advice."""
    duet = Duet(family, inspect=True, parameters=GOOD[family]).run(9.0)
    assert (duet.missing, duet.advice) == ([], [])
    assert duet.inspection.origin is not None
    assert duet.inspection.done


@pytest.mark.parametrize(
    ("family", "frame"),
    [("rover", "boat (FRAME_CLASS 2)"), ("sub", "vectored (FRAME_CONFIG 1)"), ("px4", "SYS_AUTOSTART 50000")],
)
def test_the_frame(family: str, frame: str):
    """It tells what kind of craft the autopilot takes itself to be on; integers of a PX4 are read as their bytes."""
    duet = Duet(family, inspect=True).run(4.0)
    assert duet.inspection.frame == frame


WRONG = [
    ("rover", "FS_GCS_ENABLE", 0, "nothing happens when our heartbeats stop; set it to 1"),
    ("rover", "FS_ACTION", 0, "set it to 2, HOLD"),
    ("rover", "FS_EKF_ACTION", 2, "does not stop when it has lost its position; set it to 1"),
    ("rover", "FS_GCS_TIMEOUT", 60, "set it to 5"),
    ("rover", "SYSID_MYGCS", 252, "ours come from 255; set it to 255, or frontseat.own_system to 252"),
    ("rover", "ARMING_CHECK", 0, "all checks before arming are off; set it to 1"),
    ("sub", "FS_GCS_ENABLE", 2, "it disarms in mid-water when our heartbeats stop; set it to 4"),
    ("sub", "FS_GCS_ENABLE", 0, "nothing happens when our heartbeats stop; set it to 4"),
    ("sub", "SYSID_MYGCS", 1, "set it to 255"),
    ("px4", "COM_OF_LOSS_T", 20, "when set-points stop; set it to 1"),
    ("px4", "COM_OBL_RC_ACT", 2, "set it to 5, hold"),
    ("px4", "NAV_DLL_ACT", 2, "have a ground station on another link, or set it to 0"),
]


@pytest.mark.parametrize(("family", "name", "value", "what_to_do"), WRONG)
def test_a_wrong_parameter(family: str, name: str, value: float, what_to_do: str):
    """Each parameter that would not stop the craft, or not let it arm, is one line with its value and what to do."""
    duet = Duet(family, inspect=True, parameters=GOOD[family] | {name: value}).run(9.0)
    (line,) = duet.advice
    assert line.startswith(f"{name} is {value:g}: ")
    assert what_to_do in line
    assert duet.missing == []


@pytest.mark.parametrize(("name", "value"), [("MAV_GCS_SYSID", 252), ("ARMING_SKIPCHK", 1)])
def test_the_names_of_a_newer_firmware(name: str, value: float):
    """ArduPilot 4.7 calls some of them otherwise, and is read all the same."""
    good = GOOD["rover"] | {"ARMING_SKIPCHK": 0}
    duet = Duet("rover", inspect=True, firmware="4.7", parameters=good | {name: value}).run(9.0)
    assert [line.split(" is ")[0] for line in duet.advice] == [name]


@pytest.mark.parametrize("family", GOOD)
def test_no_position_yet(family: str):
    """Without a position that is missing, with the reason and what to do; outstanding checks are said in its words."""
    duet = Duet(family, inspect=True, ready_s=42.0, parameters=GOOD[family]).run(9.0 if family != "px4" else 35.0)
    assert any(line.startswith("a valid position: ") and "; " in line for line in duet.missing)
    (line,) = [line for line in duet.advice if "checks before arming are outstanding" in line]
    assert ("PreArm: " in line) == (family != "px4")


def test_no_satellites():
    """A GPS without a fix is named, with what to do about it."""
    duet = Duet("rover", inspect=True, parameters=GOOD["rover"] | {"SIM_GPS_DISABLE": 1}).run(9.0)
    assert any("free view of the sky" in line for line in duet.missing)


def test_far_from_the_datum():
    """With a datum that is not the mission's, that is what is missing, and nothing about satellites or estimators."""
    duet = Duet("rover", inspect=True, parameters=GOOD["rover"], datum=DatumConfig(0.0, 0.0)).run(9.0)
    (line,) = duet.missing
    assert line.startswith("a craft near the datum: the autopilot is ")
    assert line.endswith(" km from the datum; set [datum] to where the mission is")


def test_who_is_not_allowed_to_ask():
    """An autopilot that hears its ground station only: the missing messages come with that as a reason."""
    duet = Duet("rover", inspect=True, parameters={"SYSID_ENFORCE": 1, "SYSID_MYGCS": 7}).run(9.0)
    assert any(line.startswith("message LOCAL_POSITION_NED") and "SYSID_ENFORCE" in line for line in duet.missing)
    assert any("answers no parameter" in line for line in duet.advice)


def test_a_slow_stream():
    """A message that comes at less than half of what was asked for is advice, with both rates."""
    duet = Duet("rover", inspect=True, parameters=GOOD["rover"]).run(6.0)
    # Another station wants it slower.
    duet.pilot.brain.streams[0].ask("ATTITUDE", 1e6, duet.now)
    duet.run(5.0)
    assert any(line.startswith("ATTITUDE comes ") and "instead of 5" in line for line in duet.advice)


def test_it_touches_nothing():
    """Looking changes neither mode nor arming, and writes no parameter."""
    duet = Duet("rover", inspect=True, parameters=GOOD["rover"]).run(9.0)
    assert not {"PARAM_SET", "SET_POSITION_TARGET_LOCAL_NED", "SET_MODE"} & set(duet.sent)
    assert (duet.pilot.brain.modes.mode.name, duet.pilot.brain.modes.armed) == ("MANUAL", False)


def test_an_unknown_parameter_is_given_up():
    """A parameter that nobody answers for is asked for three times, and then no more."""
    reader = ParameterReader(["NONE", "NEITHER"], (1, 1), bytewise=False)
    asked = [len(reader.due(0.1 * k)) for k in range(40)]
    assert sum(asked) == 6
    assert reader.done
    assert reader.values == {}
