"""With losses both ways and tries enough, an order is done exactly once; with too few, never more than once."""

from hypothesis import given
from hypothesis import strategies as st
from task_bench import NS, Line

from grex_link import draws
from grex_link.tasks import Hold

SEEDS = st.integers(0, 2**32)


@given(SEEDS, st.floats(0.0, 0.7), st.integers(1, 3))
def test_exactly_once(seed, loss, orders):
    """With up to 70 % lost each way and 120 tries, every order is started once, echoed, and its end is told."""
    line = Line(lambda who, number: draws.uniform(seed, who, number) < loss, tries=120)
    for n in range(orders):
        line.posts["a"].order(line.now_s * NS, f"x{n}", "b", Hold(4.0 * (n + 1)))
        while line.words.count("started") <= n:
            line.step()
            assert line.now_s < 5000
        line.run(20)  # repeated orders and echoes that are on their way
    assert [arrival.name for arrival in line.arrived] == [f"a#{n}" for n in range(orders)]
    assert line.words.count("started") == line.words.count("echoed") == orders
    assert "failed" not in line.words


@given(SEEDS, st.floats(0.0, 1.0), st.integers(1, 5))
def test_never_twice_and_never_silent(seed, loss, tries):
    """Whatever is lost, an order is done at most once, and its sender ends with "started" or "failed"."""
    line = Line(lambda who, number: draws.uniform(seed, who, number) < loss, tries=tries)
    line.posts["a"].order(0, "x", "b", Hold(4.0))
    line.run(30 * tries)
    assert len(line.arrived) <= 1
    assert line.sent["a"] <= tries
    assert ("started" in line.words) != ("failed" in line.words)
    assert "started" not in line.words or len(line.arrived) == 1
