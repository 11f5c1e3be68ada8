"""What a craft says it has heard, and what a mate makes of that."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.team.acknowledgement import Acknowledgements, SentMessages
from grex_agent.team.interface import Report
from grex_link import wire

TEAM = ["auv1", "auv2", "auv3"]
CYCLE_S = 30.0


def state(source, t_s, flags=wire.NAVIGATION_VALID, form="full"):
    """What a craft says at a time."""
    return wire.TeamState(source, t_s, 0.0, 0.0, 0.0, 1.0, 0.0, 0, 0.5, 0.1, flags, form)


def on_air(told):
    """The same as it is read."""
    return wire.unpack(wire.pack(told), told.t_s)


def answer(of_mate, t_s):
    """What auv2 says at a time, of what it has heard."""
    return Report("auv2", on_air(state(1, t_s, wire.NAVIGATION_VALID | of_mate.flags(t_s))))


@given(
    size=st.integers(2, 7),
    ages=st.lists(st.one_of(st.none(), st.floats(0.0, 500.0)), min_size=7, max_size=7),
    now_s=st.floats(500.0, 3000.0),
)
def test_every_mate_reads_its_own_age(size, ages, now_s):
    """In teams of two to seven each mate reads how many cycles old its newest message is, up to what fits."""
    team = [f"auv{n}" for n in range(size)]
    speaker = Acknowledgements("auv0", team, CYCLE_S)
    now_s = round(now_s / wire.TIME_STEP_S) * wire.TIME_STEP_S
    heard_s = {}
    for mate, age in zip(team[1:], ages, strict=False):
        if age is not None:
            heard_s[mate] = round((now_s - age) / wire.TIME_STEP_S) * wire.TIME_STEP_S
            speaker.hear(mate, heard_s[mate])
    told = on_air(state(0, now_s, wire.NAVIGATION_VALID | speaker.flags(now_s)))
    assert told.flags & wire.NAVIGATION_VALID
    assert not told.flags & wire.ON_TASK
    for mate in team[1:]:
        reader = Acknowledgements(mate, team, CYCLE_S)
        assert reader.oldest == (1 << 6 // (size - 1)) - 1
        expected = reader.oldest if mate not in heard_s else reader.age(heard_s[mate], now_s)
        assert reader.read(Report("auv0", told)) == min(expected, reader.oldest)


def test_no_room_in_a_team_of_eight():
    """Where there is no bit for each mate, nothing is told."""
    eight = Acknowledgements("auv0", [f"auv{n}" for n in range(8)], CYCLE_S)
    eight.hear("auv3", 10.0)
    assert not eight.told
    assert eight.flags(20.0) == 0


@pytest.fixture
def sent():
    """Own messages of 0, 30 and 60 s, each 10 s on the air."""
    messages = SentMessages(Acknowledgements("auv1", TEAM, CYCLE_S), 300.0)
    for t_s in (0.0, 30.0, 60.0):
        messages.leave(state(0, t_s), t_s + 10.0)
    return messages


def test_the_newest_that_was_heard_is_no_news(sent):
    """Who has the last message has what it was taken to have."""
    mate = Acknowledgements("auv2", TEAM, CYCLE_S)
    mate.hear("auv1", 60.0)
    assert sent.learn(answer(mate, 70.0)) == []


def test_what_is_newer_than_the_newest_was_missed(sent):
    """Who has the first message only lacks the two later ones; that is news once, and of that mate alone."""
    mate, other = (Acknowledgements(craft, TEAM, CYCLE_S) for craft in TEAM[1:])
    mate.hear("auv1", 0.0)
    other.hear("auv1", 60.0)
    assert [(news.message.t_s, news.heard) for news in sent.learn(answer(mate, 70.0))] == [(30.0, False), (60.0, False)]
    assert sent.learn(answer(mate, 75.0)) == []
    assert sent.learn(Report("auv3", on_air(state(2, 80.0, 1 | other.flags(80.0))))) == []


def test_nothing_heard_yet(sent):
    """Who has heard nothing lacks all that is newer than the oldest age that can be told."""
    assert [news.message.t_s for news in sent.learn(answer(Acknowledgements("auv2", TEAM, CYCLE_S), 70.0))] == [
        0.0,
        30.0,
        60.0,
    ]


def test_what_was_on_its_way_is_not_missed(sent):
    """A message that left after the mate spoke says nothing; one that came in after it spoke is had after all."""
    mate = Acknowledgements("auv2", TEAM, CYCLE_S)
    mate.hear("auv1", 30.0)
    assert sent.learn(answer(mate, 65.0)) == []
    assert [news.heard for news in sent.learn(answer(mate, 70.0))] == [False]
    mate.hear("auv1", 60.0)
    assert [(news.message.t_s, news.heard) for news in sent.learn(answer(mate, 80.0))] == [(60.0, True)]
    # An answer of before that comes late changes nothing: what the mate has it has.
    late = Acknowledgements("auv2", TEAM, CYCLE_S)
    late.hear("auv1", 30.0)
    assert sent.learn(answer(late, 72.0)) == []


def test_a_form_without_flags_says_nothing(sent):
    """A short state is no word about what was heard."""
    assert sent.learn(Report("auv2", state(1, 70.0, 1 | 0b111 << 2, "short"))) == []


def test_old_messages_are_forgotten():
    """What is older than can be worked in is no news."""
    messages = SentMessages(Acknowledgements("auv1", ["auv1", "auv2"], CYCLE_S), 40.0)
    messages.leave(state(0, 0.0), 10.0)
    messages.leave(state(0, 60.0), 70.0)
    report = Report("auv2", on_air(state(1, 80.0, 1 | Acknowledgements("auv2", ["auv1", "auv2"], CYCLE_S).flags(80.0))))
    assert [news.message.t_s for news in messages.learn(report)] == [60.0]
