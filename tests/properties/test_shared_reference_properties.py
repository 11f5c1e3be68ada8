"""The shared reference over missions, whatever is lost and whoever is slow: Θ never back, limits, no craft special."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grex_agent.core import AgentCore
from grex_agent.mission import plan_mission
from grex_link.messages import ModemEvent, Received, Transmit, TxEvent
from grex_link.scenario import decode
from grex_sim.sea import Sea

NS = 1_000_000_000
FORMATION = {"a": (0.0, 0.0, 0.0), "b": (-6.0, -20.0, 0.0), "c": (-6.0, 20.0, 0.0)}
#: Each craft's slot in a cycle of 12 s, whatever its place in the team; a message takes 4 s.
SLOTS = {"a": 0, "b": 4, "c": 8}
STEPS = 120


def scenario(order="abc", craft=None, talk="event", turn="starboard"):
    """A team of three on a short lawnmower with the shared reference."""
    return decode(
        {
            "mission": {
                "type": "lawnmower",
                "formation_m": {name: FORMATION[name] for name in order},
                "legs": 3,
                "leg_length_m": 40.0,
                "turn_radius_m": 40.0,
                "first_turn": turn,
            },
            "craft": {name: (craft or {}).get(name, {}) for name in order},
            "team": {
                "controller": "shared_reference",
                "estimator": "none",
                "own_filter": {},
                "talk": {"type": talk},
            },
            "link": {
                "mac": {
                    "type": "slotted_aloha",
                    "probability": 1.0,
                    "slot_s": 12.0,
                }
            },
        }
    )


def sail(config, heard, steps=STEPS):
    """Let a team sail; `heard(source, receiver, number)` says what arrives. Returns a log of what everybody did."""
    order = list(config.craft)
    water = Sea(config, plan_mission(config))
    agents = {name: AgentCore(config, name) for name in order}
    seqs = dict.fromkeys(order, 0)
    due, log = [], {name: [] for name in order}
    for tick in range(steps):
        for arrival in sorted(entry for entry in due if entry[0] == tick):
            _, receiver, event = arrival[0], arrival[2], arrival[3]
            agents[receiver].on_modem(ModemEvent(seqs[receiver], tick * NS, event))
            seqs[receiver] += 1
        setpoints = {}
        for (name, core), fix in zip(agents.items(), water.fixes([0] * len(order)), strict=True):
            core.on_fix(fix)
            put = list(core.step(tick, tick * NS))
            setpoints[name] = dict(put)["setpoint"]
            law = core._estimator
            log[name].append((law.reference, setpoints[name], dict(put)["state"], law.hold_s, put))
            for request in (message for _, message in put if isinstance(message, Transmit)):
                arrives = tick + 4 + SLOTS[name]
                due.append((arrives, (name, name), name, TxEvent(request.seq, "SENT")))
                due += [
                    (arrives, (mate, name), mate, Received(name, request.payload))
                    for mate in order
                    if mate != name and heard(name, mate, request.seq)
                ]
        water.advance(setpoints)
    return log, water.truth


slow = st.fixed_dictionaries(
    {
        "vehicle": st.fixed_dictionaries(
            {
                "speed_error_relative": st.floats(-0.2, 0.2),
                "speed_limits": st.lists(
                    st.builds(
                        lambda start, lasts, most: {"start_s": start, "end_s": start + lasts, "max_mps": most},
                        st.floats(0.0, 100.0),
                        st.floats(1.0, 80.0),
                        st.floats(0.0, 1.0),
                    ),
                    max_size=1,
                ),
            }
        )
    }
)
fleet = st.fixed_dictionaries(dict.fromkeys("abc", slow))
losses = st.integers(0, 2**32 - 1)


def lossy(seed):
    """Return a channel that loses about half, by a fixed pattern."""
    return lambda source, mate, number: hash((seed, ord(source), ord(mate), number)) % 2 == 0


@settings(max_examples=6, deadline=None)
@given(fleet, losses, st.sampled_from(["event", "periodic"]), st.sampled_from(["starboard", "port"]))
def test_whatever_happens(craft, seed, talk, turn):
    """Θ of the reference never runs back nor ahead of the plan, every order is within the limits, nothing is NaN."""
    log, truth = sail(scenario(craft=craft, talk=talk, turn=turn), lossy(seed))
    for steps in log.values():
        references = [reference for reference, *_ in steps]
        holds = [hold_s for *_, hold_s, _ in steps]
        assert all(later >= earlier for earlier, later in pairwise(references))
        assert all(0.0 <= later - earlier <= 0.7 + 1e-9 for earlier, later in pairwise(holds))
        for _, setpoint, state, _, _ in steps:
            assert 0.3 <= setpoint.speed_mps <= 3.0
            assert math.isfinite(setpoint.course_rad)
            numbers = [state.theta, state.xte_m, state.quality, state.ordered_mps]
            for mate in state.mates:
                numbers += [mate.north_m, mate.east_m, mate.progress, mate.sigma_m, mate.age_s]
            assert all(map(math.isfinite, numbers))
            assert state.bad_frames == 0
    assert all(math.isfinite(pose.north_m + pose.east_m) for pose in truth.poses)


@settings(max_examples=3, deadline=None)
@given(st.permutations("abc"), fleet, losses)
def test_no_craft_is_special(order, craft, seed):
    """Naming the craft in another order moves each of them in the same way."""
    (_, one), (_, other) = (sail(scenario(team, craft), lossy(seed)) for team in ("abc", "".join(order)))
    places = {pose.craft: (pose.north_m, pose.east_m, pose.surge_mps) for pose in one.poses}
    for pose in other.poses:
        assert (pose.north_m, pose.east_m, pose.surge_mps) == pytest.approx(places[pose.craft], abs=1e-9)


@settings(max_examples=3, deadline=None)
@given(fleet)
def test_in_silence_everybody_follows_the_clock(craft):
    """If nothing arrives nobody waits for anybody, not even the slow one for itself."""
    log, _ = sail(scenario(craft=craft), lambda *_: False)
    assert all(hold_s == 0.0 for steps in log.values() for *_, hold_s, _ in steps)


@settings(max_examples=4, deadline=None)
@given(fleet)
def test_copies_agree_when_all_is_heard(craft):
    """Some time after the last change, with nothing lost, all copies have held as long, to two steps of the message."""
    quiet = {name: {"vehicle": {**each["vehicle"], "speed_limits": [
        limit for limit in each["vehicle"]["speed_limits"] if limit["end_s"] < 80.0
    ]}} for name, each in craft.items()}  # fmt: skip
    log, _ = sail(scenario(craft=quiet, talk="periodic"), lambda *_: True, 200)
    holds = [steps[-1][3] for steps in log.values()]
    assert max(holds) - min(holds) <= 0.11
