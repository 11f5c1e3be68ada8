"""The parameter files of deploy/ on the simulated autopilots."""

import re
import struct
from pathlib import Path

import pytest
from autopilots import Bench

DEPLOY = Path(__file__).parents[4] / "deploy"


def values(path: Path) -> dict[str, float]:
    """Names and values of a file in ArduPilot's or PX4's form."""
    rows = [line for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    if path.suffix == ".param":
        return {name: float(value) for name, value in (row.split(",") for row in rows)}
    fields = [row.split("\t") for row in rows]
    assert all(len(row) == 5 for row in fields)
    return {row[2]: float(row[3]) for row in fields}


def alternative(path: Path, first: str) -> dict[str, float]:
    """Names and values of the commented lines from one on."""
    rows = re.findall(r"^# ([A-Z0-9_]+),(\d+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    names = [name for name, _ in rows]
    return {name: float(value) for name, value in rows[names.index(first) :]}


def test_the_subs_lines_on_vision_are_enough():
    """A Sub with the file and its lines on vision has a position as soon as vision tells one; every name is known."""
    path = DEPLOY / "ardupilot" / "sub.param"
    lines = alternative(path, "VISO_TYPE")
    assert {"VISO_TYPE", "EK3_SRC1_POSXY", "EK3_SRC1_VELXY", "EK3_SRC1_YAW"} <= set(lines)
    bench = Bench("sub", ready_s=4.0, parameters=values(path) | lines).run(1.0)
    bench.send("SET_GPS_GLOBAL_ORIGIN", target_system=1, latitude=543_700_000, longitude=101_600_000, altitude=0)
    bench.run(9.0, 0.2, lambda: bench.send("VISION_POSITION_ESTIMATE", usec=0, x=3.0, y=-2.0))
    assert bench.pilot.brain.estimator.aiding


@pytest.mark.parametrize(
    ("file", "wanted"),
    [
        ("ardupilot/rover.param", {"FS_THR_ENABLE": 1}),
        ("ardupilot/sub.param", {"FS_PILOT_INPUT": 1}),
        ("px4/px4.params", {"NAV_RCL_ACT": 1, "COM_RCL_EXCEPT": 0}),
    ],
)
def test_the_loss_of_a_pilots_hand_is_decided(file, wanted):
    """Each file says what the loss of remote control or joystick does, and none of them disarms or drives home."""
    assert {name: values(DEPLOY / file)[name] for name in wanted} == wanted


@pytest.mark.parametrize("file", ["ardupilot/rover.param", "ardupilot/sub.param", "px4/px4.params"])
def test_every_parameter_is_known_and_stored(file):
    """Each parameter of a file is taken by its autopilot and stored as it stands there."""
    family = Path(file).stem
    bench = Bench(family).run(3.0)
    wanted = values(DEPLOY / file)
    assert len(wanted) >= 5
    for name, value in wanted.items():
        real = family != "px4" or name in {"COM_OF_LOSS_T", "RO_SPEED_LIM"}
        sent = value if real else struct.unpack("<f", struct.pack("<i", int(value)))[0]
        assert bench.set_parameter(name, sent) is not None, name
        assert bench.pilot.brain.parameters.get(name) == pytest.approx(value)


def test_the_rovers_file_makes_it_hold():
    """A Rover with the file holds when heartbeats stop, and makes no more than 2.5 m/s."""
    bench = Bench(parameters=values(DEPLOY / "ardupilot" / "rover.param")).guided()
    bench.heartbeat()
    bench.drive(5.5, 4.0, 0.0)
    assert bench.speed == pytest.approx(2.5, abs=0.05)
    bench.drive(3.0, 4.0, 0.0)
    assert (bench.shown, bench.armed) == (4, True)


def test_the_subs_file_brings_it_up():
    """A Sub with the file surfaces when heartbeats stop, instead of disarming under water."""
    bench = Bench("sub", parameters=values(DEPLOY / "ardupilot" / "sub.param")).guided()
    bench.heartbeat()
    bench.drive(5.0, 0.4, 0.0, 0.5)
    assert bench.truth.down_m > 1.5
    bench.drive(15.0, 0.4, 0.0, 0.5)
    assert (bench.shown, bench.armed) == (9, True)
    assert bench.truth.down_m < 0.1


def test_a_sub_that_cannot_surface_disarms():
    """With FS_GCS_ENABLE 4 and no position a Sub disarms instead."""
    bench = Bench("sub", ready_s=None, parameters={"FS_GCS_ENABLE": 4}).run(2.0)
    bench.mode("ALT_HOLD")
    bench.command(400, 1)
    bench.heartbeat()
    bench.run(bench.now + 7.0)
    assert not bench.pilot.brain.modes.armed
