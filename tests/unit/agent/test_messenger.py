"""When a craft speaks, in the water and over land, and the ledger of that."""

import msgspec
import pytest

from grex_agent.core import AgentCore
from grex_link import wire
from grex_link.messages import Fix, ModemEvent, PortLedger, Received, Transmit, TxEvent
from grex_link.profile import load_profile
from grex_link.scenario import decode

NS = 1_000_000_000


class Recall:
    """A user's estimator that remembers what it is told."""

    def __init__(self, context):
        self.sent, self.heard = [], []

    def step(self, now_s, own, sent, heard):
        self.sent += sent
        self.heard += heard
        return []


def aboard(size=3, craft="auv1", **link):
    """An agent of a team in line abreast, 25 m apart, and what its estimator is told."""
    formation = {f"auv{place}": [0.0, 25.0 * (place - 1), 0.0] for place in range(1, size + 1)}
    document = {
        "mission": {"type": "lawnmower", "formation_m": formation, "legs": 1},
        "craft": {name: {} for name in formation},
        "team": {"estimator": f"{__name__}:Recall"},
        "link": link,
    }
    core = AgentCore(decode(document), craft)
    return core, core._estimator


def play(core, ticks, start=0):
    """Let a core step; all that it puts, as (topic, message)."""
    put = []
    for tick in range(start, start + ticks):
        core.on_fix(Fix(tick, tick * NS, float(tick), 0.0, 0.0, 0.0, 1.0, 0.1))
        put += core.step(tick, tick * NS)
    return put


def requests(put):
    """The requests to the modem among what was put."""
    return [message for topic, message in put if topic == "modem_tx"]


# -- the water ----------------------------------------------------------------------------------------------------


def test_the_state_is_as_fresh_as_the_step():
    """In a step with several slots every one carries the state of that step, not of an earlier one."""
    core, _ = aboard(profile="s2c_im")
    asked = requests(play(core, 50))
    assert len(asked) > 25
    for request in asked:
        state = wire.unpack(request.payload, request.t_ns / NS)
        assert 0.0 <= request.t_ns / NS - state.t_s < 1.0
        assert state.north_m == pytest.approx(state.t_s, abs=0.07)


@pytest.mark.parametrize(("profile", "size", "length"), [("s2c_im", 3, 15), ("waterlinked_m64", 2, 8), ("janus", 3, 5)])
def test_the_form_is_that_of_the_modem(profile, size, length):
    """What goes on the air has the length of the fullest form that the modem carries."""
    asked = requests(play(aboard(size, profile=profile)[0], 20))
    assert {len(request.payload) for request in asked} == {length}


def test_a_pair_without_broadcast_tells_its_mate():
    """On a modem for a pair the state is addressed to the mate; elsewhere to all."""
    assert {request.destination for request in requests(play(aboard(2, profile="waterlinked_m64")[0], 20))} == {"auv2"}
    assert {request.destination for request in requests(play(aboard(2, profile="s2c_im")[0], 20))} == {""}


def test_the_state_goes_once_a_slot():
    """Room for three messages a slot makes slots longer; the state goes once in each, the rest is for what waits."""
    one, three = ({"type": "tdma", "messages_per_slot": number} for number in (1, 3))
    often, seldom = (requests(play(aboard(profile="s2c_im", mac=mac)[0], 40)) for mac in (one, three))
    airtime_ns = load_profile("s2c_im").airtime_ns(15)
    cycles = [asked[1].t_ns - asked[0].t_ns for asked in (often, seldom)]
    assert cycles[1] - cycles[0] == pytest.approx(3 * 2 * airtime_ns, abs=5e6)
    assert [request.t_ns for request in seldom] == [cycles[1] * number for number in range(len(seldom))]


def test_the_tiny_form_reaches_the_estimator_with_a_place():
    """Own messages that have left, and those of mates, come to the estimator with the place the plan gives them."""
    core, estimator = aboard(profile="janus")
    (request, *_) = requests(play(core, 1))
    core.on_modem(ModemEvent(0, 2 * NS, TxEvent(request.seq, "SENT")))
    mate = wire.pack(wire.TeamState(1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0, 0.1, 0.1), "tiny")
    core.on_modem(ModemEvent(1, 2 * NS, Received("auv2", mate)))
    play(core, 1, start=3)
    (sent,), ((craft, heard),) = estimator.sent, estimator.heard
    assert (sent.north_m, sent.east_m) == pytest.approx((0.0, 0.0), abs=0.1)
    assert (craft, heard.north_m, heard.east_m) == ("auv2", pytest.approx(40.0, abs=0.1), pytest.approx(25.0))


# -- land ---------------------------------------------------------------------------------------------------------

PAIR = [{"between": ["auv1", "auv2"], "every_s": 4.0}]
ALL = [*PAIR, {"between": ["auv3", "auv1"], "every_s": 2.5}]


def test_over_land_as_often_as_it_is_given():
    """A craft with a land link tells its state over it as often as given, in full, besides its slots."""
    core, _ = aboard(land=PAIR, profile="janus")
    put = requests(play(core, 21))
    land = [request for request in put if request.by_land]
    assert [request.t_ns for request in land] == [4 * NS * number for number in range(6)]
    assert {len(request.payload) for request in land} == {15}
    assert [request.seq for request in put] == list(range(len(put)))
    assert any(not request.by_land for request in put)


def test_the_most_frequent_link_decides():
    """What is said over land goes over all links of a craft: the one that wants it most often decides."""
    land = [request.t_ns for request in requests(play(aboard(land=ALL)[0], 11)) if request.by_land]
    assert land == [round(2.5 * NS * number) for number in range(5)]


def test_without_a_link_nothing_goes_over_land():
    """A craft that has no land link uses none."""
    assert not any(request.by_land for request in requests(play(aboard(craft="auv3", land=PAIR)[0], 60)))


@pytest.mark.parametrize(("land", "known"), [(PAIR, False), (ALL, True)])
def test_what_all_mates_have_is_what_counts_as_said(land, known):
    """What went over land counts as told to the mates only if all of them are linked."""
    core, estimator = aboard(land=land)
    over_land = [request for request in requests(play(core, 3)) if request.by_land]
    for number, request in enumerate(over_land):
        core.on_modem(ModemEvent(number, 3 * NS, TxEvent(request.seq, "SENT")))
    play(core, 1, start=3)
    assert len(estimator.sent) == (len(over_land) if known else 0)


def test_no_fix_no_word():
    """Without a fix nothing is said over land either."""
    core, _ = aboard(land=ALL)
    assert requests(core.step(0, 0)) == []


# -- the ledger ---------------------------------------------------------------------------------------------------


def test_the_setpoint_counts_every_request():
    """The count in the setpoint covers water and land, and what has been put before it."""
    core, _ = aboard(land=ALL, profile="s2c_im")
    put = 0
    for topic, message in play(core, 30):
        put += isinstance(message, Transmit)
        if topic == "setpoint":
            assert message.transmissions == put
    assert put > 30


def test_the_ledger_comes_as_often_as_given():
    """Every so many seconds of the craft's time the port's ledger is put, and its identity holds."""
    core, _ = aboard(ledger_s=7.0, profile="s2c_im")
    ledgers = [message for topic, message in play(core, 30) if topic == "port"]
    assert [ledger.t_ns for ledger in ledgers] == [7 * NS, 14 * NS, 21 * NS, 28 * NS]
    last = core.ledger(99 * NS)
    assert isinstance(last, PortLedger)
    for ledger in (*ledgers, last):
        ended = sum(ledger.refused.values()) + ledger.superseded + ledger.expired + ledger.queued + ledger.started
        assert ledger.requested == ended
        assert ledger.slots_owned == ledger.slots_used + ledger.slots_skipped
    assert last.slots_used > 15


def test_slots_without_a_fix_are_skipped():
    """A slot that opens while there is no good fix is counted as skipped."""
    core, _ = aboard(profile="s2c_im")
    for tick in range(20):
        assert requests(core.step(tick, tick * NS)) == []
    ledger = core.ledger(20 * NS)
    assert ledger.slots_skipped == ledger.slots_owned > 10
    assert msgspec.structs.asdict(ledger)["started"] == 0
