"""Lets an agent's core step, tick by tick."""

from grex_link.messages import Fix
from grex_link.scenario import decode

NS = 1_000_000_000
TEAM = {"auv1": [0.0, 0.0, 0.0], "auv2": [-6.0, -25.0, 0.0], "auv3": [-6.0, 25.0, 0.0]}


def scenario(estimator="none", formation=TEAM, team=None, **tables):
    """The paper's team; auv1, auv2 and auv3 have the slots at 0, 10 and 20 s of a cycle of 30 s."""
    mission = {"type": "lawnmower", "formation_m": formation} | tables.pop("mission", {})
    return decode(
        {
            "mission": mission,
            "craft": {name: {} for name in formation},
            "team": {"estimator": estimator} | (team or {}),
            **tables,
        }
    )


def fix(tick, north_m=None, east_m=0.0, **fields):
    """A fix of a tick of one second; auv1 by its plan if no place is given."""
    north_m = float(tick) if north_m is None else north_m
    given = {"down_m": 0.0, "heading_rad": 0.0, "speed_mps": 1.0, "sigma_m": 0.1} | fields
    return Fix(tick, tick * NS, north_m, east_m, **given)


def step(core, tick, position=None):
    """Give a core a fix and let it step; returns (transmissions, state, setpoint)."""
    core.on_fix(position or fix(tick))
    return outputs(core, tick)


def outputs(core, tick, now_s=None):
    """Let a core step; returns (transmissions, state, setpoint)."""
    now_ns = tick * NS if now_s is None else round(now_s * NS)
    put = [(topic, message) for topic, message in core.step(tick, now_ns) if topic != "port"]
    transmissions = [message for topic, message in put if topic == "modem_tx"]
    rest = dict(put[len(transmissions) :])
    assert len(put) == len(transmissions) + 2, "transmissions first, then one state and one setpoint"
    return transmissions, rest["state"], rest["setpoint"]
