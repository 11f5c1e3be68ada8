"""Whose fault it is that ranges surprise: literal surprises in sigmas, against a limit of 3."""

from grex_agent.range_gate import Gate

GOOD, BAD = 1.0, 4.0


def judged(*ranges, every_s=10.0):
    """What a gate says of ranges (mate, surprise), one every so often."""
    gate = Gate(9.0)
    return [gate.judge(mate, number * every_s, sigmas) for number, (mate, sigmas) in enumerate(ranges)]


def test_of_one_mate_several_outliers_in_a_row_are_none():
    """Four surprising ranges are left out, the fifth in a row is not: the position is wrong. A good one begins anew."""
    verdicts = judged(*(("boat", sigmas) for sigmas in (BAD, BAD, -2.9, BAD, BAD, BAD, BAD, BAD, BAD)))
    assert verdicts == ["outlier", "outlier", "good", *["outlier"] * 4, "wrong", "outlier"]


def test_a_bad_mate_is_left_out_for_good():
    """One mate is always out, the other one fits but for an outlier in ten: the position is never to blame."""
    verdicts = judged(*((("boat", BAD), ("ship", BAD if turn % 10 == 9 else GOOD))[turn % 2] for turn in range(1000)))
    assert set(verdicts) == {"good", "outlier"}
    assert verdicts[::2] == ["outlier"] * 500


def test_a_bad_mate_is_left_out_however_seldom_the_good_one_is_asked():
    """Five ranges to the bad mate between two to the good one that fit do not make the own position wrong."""
    assert "wrong" not in judged(*[("ship", GOOD), *[("boat", BAD)] * 9] * 5)


def test_a_mate_that_always_surprises_the_same_way_does_not_fit():
    """Ranges that are always two sigmas too long pass five times and no more; if in turns too short, always."""
    long = judged(*[("ship", GOOD), ("boat", 2.0)] * 12)
    assert long[1::2] == [*["good"] * 5, *["outlier"] * 7]
    assert set(long[::2]) == {"good"}
    assert set(judged(*[("ship", GOOD), ("boat", 2.0), ("ship", GOOD), ("boat", -2.0)] * 12)) == {"good"}


def test_the_only_mate_may_surprise_the_same_way():
    """Who ranges to one mate alone follows it: it is the own position that leans."""
    assert set(judged(*[("boat", 2.0)] * 30)) == {"good"}


def test_a_bad_mate_that_happens_to_fit_is_not_trusted():
    """After six outliers six ranges have to fit before the sixth is used; then it is a mate like any other."""
    ranges = [*[("boat", BAD)] * 6, *[("boat", GOOD)] * 6, ("boat", BAD), ("boat", GOOD)]
    verdicts = judged(*(each for boat in ranges for each in (("ship", GOOD), boat)))
    assert verdicts[1::2] == [*["outlier"] * 11, "good", "outlier", "good"]


def test_who_is_always_out_does_not_put_the_position_right():
    """The bad mate is out twenty times, then the good one five times: the good one is believed, the bad one not."""
    start = [("ship", GOOD), *[("boat", BAD)] * 20]
    verdicts = judged(*start, *[("ship", BAD), ("boat", BAD)] * 5, ("ship", GOOD), ("boat", GOOD))
    assert verdicts[21:] == [*["outlier"] * 8, "wrong", "outlier", "good", "outlier"]


def test_all_disagree():
    """Both are out, in turn: when each has been five times it is the own position, and counting begins anew."""
    verdicts = judged(("boat", GOOD), ("ship", GOOD), *[("boat", BAD), ("ship", BAD)] * 6)
    assert verdicts[2:] == [*["outlier"] * 9, "wrong", "outlier", "outlier"]


def test_the_loudest_alone_is_not_enough():
    """However often one mate is out, a single outlier of the other one does not make it right."""
    assert "wrong" not in judged(*[("boat", BAD)] * 3, ("ship", GOOD), *[("boat", BAD)] * 9, ("ship", BAD))


def test_of_many_each_once():
    """Of six mates that all disagree each has to say so once: no longer wait than with few."""
    team = "abcdef"
    verdicts = judged(*((mate, GOOD) for mate in team), *((mate, BAD) for mate in team))
    assert verdicts[6:] == [*["outlier"] * 5, "wrong"]


def test_who_is_gone_has_no_say():
    """A mate that fitted once, and has not been ranged to for more than five minutes, says nothing any more."""
    calls = [("ship", GOOD), *[("boat", BAD)] * 8]
    assert judged(*calls, every_s=60.0) == ["good", *["outlier"] * 5, "wrong", "outlier", "outlier"]
    assert "wrong" not in judged(*calls, every_s=30.0)
