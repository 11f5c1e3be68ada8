"""Behaviour 11: parameters coerce, integers travel in two ways, and unknown names get silence."""

import struct

import pytest
from autopilots import Bench

from grex_link.errors import ConfigError


def read(bench, name: str, index: int = -1):
    since = bench.now
    bench.send("PARAM_REQUEST_READ", target_system=1, param_id=name, param_index=index)
    said = bench.run(since + 0.1).said("PARAM_VALUE", since)
    return said[-1] if said else None


@pytest.mark.parametrize("family", ["rover", "sub", "px4"])
def test_unknown_names_get_silence(family):
    """Reading or writing a parameter there is not is never answered."""
    bench = Bench(family).run(3.0)
    assert read(bench, "GPS_TYPE") is None
    assert bench.set_parameter("GPS_TYPE", 14) is None
    assert read(bench, "", 30000) is None


def test_integers_are_cut_off():
    """3.3 into an INT16 is echoed as 3.0; 300 into an INT8 as 127."""
    bench = Bench().run(3.0)
    assert bench.set_parameter("SYSID_MYGCS", 3.3)["param_value"] == 3.0
    assert bench.set_parameter("FS_ACTION", 300.0)["param_value"] == 127.0
    assert bench.set_parameter("FS_ACTION", float("nan")) is None


def test_px4_takes_the_bytes():
    """12.0 written to an integer of a PX4 stores 1094713344; the bytes of 12 store 12."""
    bench = Bench("px4").run(3.0)
    bench.set_parameter("NAV_DLL_ACT", 12.0)
    assert bench.pilot.brain.parameters.get("NAV_DLL_ACT") == 1094713344
    echo = bench.set_parameter("NAV_DLL_ACT", struct.unpack("<f", struct.pack("<i", 12))[0])
    assert bench.pilot.brain.parameters.get("NAV_DLL_ACT") == 12
    assert struct.unpack("<i", struct.pack("<f", echo["param_value"]))[0] == 12
    assert bench.set_parameter("RO_SPEED_LIM", 2.5)["param_value"] == 2.5


def test_all_are_listed_within_a_second():
    """PARAM_REQUEST_LIST brings every one once, in order, with the count, at some 1300 a second."""
    bench = Bench().run(3.0)
    bench.send("PARAM_REQUEST_LIST", target_system=1)
    values = bench.run(4.0).said("PARAM_VALUE")
    count = values[0]["param_count"]
    assert count > 80
    assert [value["param_index"] for value in values] == list(range(count))
    assert {value["param_count"] for value in values} == {count}


def test_reading_by_name_and_by_index():
    """Read by name the index of the answer is 65535; read by index it is the index."""
    bench = Bench().run(3.0)
    by_name = read(bench, "WP_SPEED")
    assert (by_name["param_index"], by_name["param_value"]) == (65535, 5.0)
    assert read(bench, "", 3)["param_index"] == 3


def test_newer_versions_have_other_names():
    """In 4.7 SYSID_THISMAV is MAV_SYSID, and the failsafe reads the new name of SYSID_MYGCS."""
    bench = Bench(firmware="4.7", parameters={"FS_GCS_ENABLE": 1, "MAV_GCS_SYSID": 9}).guided()
    assert read(bench, "SYSID_THISMAV") is None
    assert read(bench, "MAV_SYSID")["param_value"] == 1.0
    bench.heartbeat(9)
    bench.drive(10.0, 1.0, 0.0)
    assert bench.shown == 4


def test_a_parameter_of_the_command_line_must_exist():
    """A parameter that nobody knows is refused before anything starts."""
    with pytest.raises(ConfigError, match="rover has no parameter NONSENSE"):
        Bench(parameters={"NONSENSE": 1.0})
