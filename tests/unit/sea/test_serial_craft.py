"""A craft with a modem of its own among craft in the emulated water."""

import pytest

from grex_link.clock import unix_ns
from grex_link.emulator import Emulator
from grex_link.errors import BusError, ConfigError, FaultError
from grex_link.messages import Clock, Presence, Received, Transmit
from grex_link.scenario import fingerprint, loads
from grex_link.units import NS
from grex_sim.live import LiveHub
from grex_sim.logbook import Logbook
from grex_sim.run import check_scenario, simulate_in_process

SCENARIO = """
duration_s = 100
[clock]
pace = "live"
[link]
profile = "umodem_fsk0"
[mission]
type = "lawnmower"
[mission.formation_m]
auv1 = [0, 0, 0]
auv2 = [0, 30, 0]
auv3 = [30, 0, 0]
[craft.auv1]
modem = { type = "serial", port = "/dev/ttyS0" }
[craft.auv2]
[craft.auv3]
"""


class Outlet:
    def __init__(self) -> None:
        self.put_there: list = []

    def put(self, topic: str, craft: str, message) -> None:
        self.put_there.append((topic, craft, message))


def test_its_sound_is_not_in_the_emulated_water():
    """What it requests is not transmitted there, and what others say does not reach it there."""
    outlet = Outlet()
    link = Emulator(loads(SCENARIO), outlet)
    link.handle("clock", "", Clock("start", unix_ns() - 200 * NS))
    link.handle("modem_tx", "auv1", Transmit(0, 0, b"by its own modem"))
    link.handle("modem_tx", "auv2", Transmit(0, 0, b"in the water"))
    link.on_deadline()
    events = [(craft, message.event) for topic, craft, message in outlet.put_there if topic == "modem_rx"]
    assert {craft for craft, _ in events} == {"auv2", "auv3"}
    assert [event.payload for _, event in events if isinstance(event, Received)] == [b"in the water"]


@pytest.fixture
def hub():
    """The simulator, waiting for everybody."""
    scenario = loads(SCENARIO)
    made = LiveHub(scenario, check_scenario(scenario), Outlet(), Logbook(), lambda _: None)
    for who in ("auv1", "auv2", "auv3", "link"):
        made.handle("presence", "", Presence(who, alive=True, scenario=fingerprint(scenario)))
    return made


def test_the_mission_waits_for_its_driver(hub):
    """Without the driver the mission does not start; with it, it does, and the driver is told the time."""
    assert not hub.started
    hub.handle("presence", "", Presence("modem_auv1", alive=True, scenario=fingerprint(loads(SCENARIO))))
    assert hub.started
    told = {craft for topic, craft, _ in hub._outlet.put_there if topic == "clock"}
    assert told == {"auv1", "auv2", "auv3", "modem_auv1", "link"}


def test_a_driver_of_another_scenario_is_named(hub):
    """A driver that runs another scenario is refused by name."""
    with pytest.raises(BusError, match=r"^modem auv1 runs another scenario"):
        hub.handle("presence", "", Presence("modem_auv1", alive=True, scenario="other"))


def test_a_driver_that_is_gone_is_named(hub):
    """When the driver leaves the bus the run is over, and says whose it was."""
    for alive in (True, False):
        presence = Presence("modem_auv1", alive=alive, scenario=fingerprint(loads(SCENARIO)))
        if alive:
            hub.handle("presence", "", presence)
        else:
            with pytest.raises(FaultError, match=r"^modem auv1 left the bus \(killed, stopped or cut off\)"):
                hub.handle("presence", "", presence)


def test_not_in_one_process():
    """A run in one process has no place for a driver and says so."""
    with pytest.raises(ConfigError, match=r"^\$\.craft\.auv1\.modem\.type: a serial modem needs its own process"):
        simulate_in_process(loads(SCENARIO), None, lambda _: None)


def test_no_craft_has_the_name_of_a_driver():
    """Names that begin like a driver's are not for craft."""
    with pytest.raises(ConfigError, match=r"^\$\.craft\.modem_auv2: this name is taken"):
        loads(SCENARIO.replace("auv2", "modem_auv2"))
