"""The health table: who is alive, who is lost, who says too little."""

import pytest
from missions import SCENARIOS

from grex_link.scenario import load
from grex_sim.view.health import Health

EVERYBODY = ["auv1", "auv2", "link"]


@pytest.fixture
def scenario():
    return load(SCENARIOS / "paper-d.toml", ["clock.pace=live", "clock.tick_s=0.1"])


def states(health, scenario, wall_s=0.0):
    return {row["who"]: row["state"] for row in health.table(scenario, EVERYBODY, wall_s, {})}


def test_who_goes_before_the_end_is_lost_and_afterwards_has_ended(scenario) -> None:
    """Missing, alive, lost, ended: as it comes and goes; the end of the run does not heal who was lost before."""
    health = Health()
    health.on_presence("auv1", alive=True)
    health.on_presence("auv2", alive=True)
    assert states(health, scenario) == {"sim": "missing", "auv1": "alive", "auv2": "alive", "link": "missing"}
    health.on_presence("auv2", alive=False)
    health.over = True
    health.on_presence("auv1", alive=False)
    health.on_presence("auv2", alive=False)
    assert states(health, scenario) == {"sim": "missing", "auv1": "ended", "auv2": "lost", "link": "missing"}


def test_the_one_at_fault_is_lost_even_if_the_goodbye_comes_first(scenario) -> None:
    """Goodbye and departure come in any order: who broke off the run is lost, the others have ended."""
    health = Health()
    for who in EVERYBODY:
        health.on_presence(who, alive=True)
    health.over = True
    health.on_fault("auv2")
    for who in EVERYBODY:
        health.on_presence(who, alive=False)
    assert states(health, scenario) == {"sim": "missing", "auv1": "ended", "auv2": "lost", "link": "ended"}


def test_without_the_bus_nobody_is_in_sight(scenario) -> None:
    """When the simulator is killed, and the bus with it, the others are out of sight, not dead."""
    health = Health()
    for who in ["sim", *EVERYBODY]:
        health.on_presence(who, alive=True)
    health.on_presence("sim", alive=False)
    health.everybody_gone()
    assert states(health, scenario) == {"sim": "lost", "auv1": "unseen", "auv2": "unseen", "link": "unseen"}


def test_rates_are_beside_those_wanted(scenario) -> None:
    """Messages a second over the last five, by who says them, beside the rate of the table of topics."""
    health = Health()
    for tick in range(100):
        health.heard("setpoint", "auv1", 0.1 * tick)
        if tick % 2:
            health.heard("setpoint", "auv2", 0.1 * tick)
        health.rates(0.1 * tick)
    rows = {row["who"]: row for row in health.table(scenario, EVERYBODY, 9.9, {"auv1": {"sent": 7}})}
    assert rows["auv1"]["rates"]["setpoint"] == [pytest.approx(10.0, rel=0.1), 10.0]
    assert rows["auv2"]["rates"]["setpoint"] == [pytest.approx(5.0, rel=0.1), 10.0]
    assert rows["auv1"]["notes"] == {"sent": 7}
    assert rows["auv2"]["silent_s"] == pytest.approx(0.0, abs=0.11)
    assert rows["link"]["rates"] == {}


def test_in_lockstep_no_rate_is_wanted() -> None:
    """In lockstep ticks come as fast as they can: no rate is too low."""
    health = Health()
    health.heard("state", "auv1", 0.0)
    health.rates(0.0)
    rows = health.table(load(SCENARIOS / "paper-d.toml"), EVERYBODY, 2.0, {})
    assert rows[1]["rates"]["state"][1] is None
