"""What a craft says it is missing, and what a mate makes of that."""

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
    ages=st.lists(st.lists(st.integers(0, 10_000), max_size=8), min_size=6, max_size=6),
    now=st.integers(10_000, 60_000),
)
def test_every_mate_reads_what_is_missing_of_it(size, ages, now):
    """In teams of two to seven each mate reads for each of the latest intervals whether its message is missing."""
    team = [f"auv{n}" for n in range(size)]
    speaker = Acknowledgements("auv0", team, CYCLE_S)
    now_s = now * wire.TIME_STEP_S
    for mate, of_mate in zip(team[1:], ages, strict=False):
        for age in sorted(of_mate, reverse=True):
            speaker.hear(mate, (now - age) * wire.TIME_STEP_S)
    told = Report("auv0", on_air(state(0, now_s, wire.NAVIGATION_VALID | speaker.flags(now_s))))
    assert told.state.flags & wire.NAVIGATION_VALID
    assert not told.state.flags & wire.ON_TASK
    for mate, of_mate in zip(team[1:], ages, strict=False):
        reader = Acknowledgements(mate, team, CYCLE_S)
        assert reader.intervals == 6 // (size - 1)
        heard = {reader.age((now - age) * wire.TIME_STEP_S, now_s) for age in of_mate}
        for interval in range(reader.intervals):
            assert reader.missing(told, now_s - (interval + 0.5) * CYCLE_S) is (interval not in heard)
        assert reader.missing(told, now_s - (reader.intervals + 0.5) * CYCLE_S) is None


def test_no_room_in_a_team_of_eight():
    """Where there is no bit for each mate, nothing is told."""
    eight = Acknowledgements("auv0", [f"auv{n}" for n in range(8)], CYCLE_S)
    eight.hear("auv3", 10.0)
    assert not eight.intervals
    assert eight.flags(20.0) == 0


def test_alone():
    """Who has no mate tells nothing."""
    assert not Acknowledgements("auv1", ["auv1"], CYCLE_S).intervals


@pytest.fixture
def sent():
    """Own messages of 0, 30 and 60 s, each 10 s on the air."""
    messages = SentMessages(Acknowledgements("auv1", TEAM, CYCLE_S), 300.0)
    for t_s in (0.0, 30.0, 60.0):
        messages.leave(state(0, t_s), t_s + 10.0)
    return messages


def mate_that_heard(*times_s, craft="auv2"):
    """A mate that has heard the own messages of some times."""
    mate = Acknowledgements(craft, TEAM, CYCLE_S)
    for t_s in times_s:
        mate.hear("auv1", t_s)
    return mate


def found(news):
    """What there is of news: of which messages, and whether heard."""
    return [(each.message.t_s, each.heard) for each in news]


def test_what_was_heard_is_no_news(sent):
    """Who has all messages has what it was taken to have."""
    assert sent.learn(answer(mate_that_heard(0.0, 30.0, 60.0), 70.0)) == []


def test_what_is_missing_is_news_once(sent):
    """Each message that is missing is named once, whatever of later ones has been heard, and of that mate alone."""
    assert found(sent.learn(answer(mate_that_heard(30.0), 70.0))) == [(0.0, False), (60.0, False)]
    assert sent.learn(answer(mate_that_heard(30.0), 75.0)) == []
    others = mate_that_heard(0.0, 30.0, 60.0, craft="auv3")
    assert sent.learn(Report("auv3", on_air(state(2, 80.0, 1 | others.flags(80.0))))) == []


def test_nothing_heard_yet(sent):
    """Who has heard nothing lacks all the messages for which there is a bit: three in a team of three."""
    sent.leave(state(0, 90.0), 100.0)
    assert found(sent.learn(answer(mate_that_heard(), 110.0))) == [(30.0, False), (60.0, False), (90.0, False)]


def test_what_was_on_its_way_is_not_missed(sent):
    """A message that left after the mate spoke is not missed; one that came in after it spoke is had after all."""
    mate = mate_that_heard(0.0, 30.0)
    assert sent.learn(answer(mate, 65.0)) == []
    assert found(sent.learn(answer(mate, 70.0))) == [(60.0, False)]
    mate.hear("auv1", 60.0)
    assert found(sent.learn(answer(mate, 80.0))) == [(60.0, True)]
    # An answer of before that comes late changes nothing: what the mate has it has.
    assert sent.learn(answer(mate_that_heard(0.0, 30.0), 72.0)) == []


def test_a_form_without_flags_says_nothing(sent):
    """A short state is no word about what was heard."""
    assert sent.learn(Report("auv2", state(1, 70.0, 1 | 0b111 << 2, "short"))) == []


def test_old_messages_are_forgotten():
    """What is older than can be worked in is no news."""
    messages = SentMessages(Acknowledgements("auv1", ["auv1", "auv2"], CYCLE_S), 40.0)
    messages.leave(state(0, 0.0), 10.0)
    messages.leave(state(0, 60.0), 70.0)
    nothing = Acknowledgements("auv2", ["auv1", "auv2"], CYCLE_S).flags(80.0)
    assert found(messages.learn(Report("auv2", on_air(state(1, 80.0, 1 | nothing))))) == [(60.0, False)]
