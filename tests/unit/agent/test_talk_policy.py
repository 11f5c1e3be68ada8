"""When a craft speaks: in every slot, or when the mates are wrong, after a change again, and after a long silence."""

import pytest

from grex_agent.talk_policy import ByEvents, make_policy
from grex_link.coordination_config import EventTalk, PeriodicTalk
from grex_link.errors import ConfigError


class Beliefs:
    """What the mates believe, set by hand."""

    doubt_m = 0.0
    owes = False


def slots(policy, number):
    """Whether it speaks in each of so many slots."""
    return [policy.speaks() for _ in range(number)]


def test_periodic_speaks_always():
    """The default is every slot, whatever the estimator knows."""
    assert slots(make_policy(PeriodicTalk(), object()), 5) == [True] * 5


def test_heartbeat():
    """With nothing to say a craft speaks in its first own slot, and then in every third if so told."""
    policy = ByEvents(EventTalk(heartbeat_slots=3), Beliefs())
    assert slots(policy, 7) == [True, False, False, True, False, False, True]


def test_speaks_while_the_mates_are_wrong():
    """Above the threshold it speaks, at it and below it does not; the heartbeat is counted from there."""
    beliefs = Beliefs()
    policy = ByEvents(EventTalk(threshold_m=0.5, heartbeat_slots=4), beliefs)
    assert policy.speaks()
    beliefs.doubt_m = 0.51
    assert slots(policy, 2) == [True, True]
    beliefs.doubt_m = 0.5
    assert slots(policy, 4) == [False, False, False, True]


def test_repeats_after_a_change():
    """After a change it speaks in so many slots more."""
    beliefs = Beliefs()
    policy = ByEvents(EventTalk(repeats=2, heartbeat_slots=100), beliefs)
    policy.speaks()
    beliefs.doubt_m = 1.0
    assert policy.speaks()
    beliefs.doubt_m = 0.0
    assert slots(policy, 4) == [True, True, False, False]


def test_what_is_owed_is_said():
    """An answer, or what not all know yet, is said whatever the threshold."""
    beliefs = Beliefs()
    policy = ByEvents(EventTalk(), beliefs)
    policy.speaks()
    assert not policy.speaks()
    beliefs.owes = True
    assert slots(policy, 3) == [True] * 3


def test_an_estimator_that_knows_nothing_of_the_mates_beliefs():
    """By events does not go with an estimator of one level, and one line says what does."""
    with pytest.raises(ConfigError, match=r"\$\.team\.talk: .*along_track"):
        make_policy(EventTalk(), object())
