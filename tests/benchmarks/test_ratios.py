"""Speed as ratios of one run, never as times: this is what the README's figures come from (opt in: -m benchmark)."""

import pytest

from grex_sim.bench import Row, measure

pytestmark = [pytest.mark.benchmark, pytest.mark.timeout(300)]


@pytest.fixture(scope="module")
def three_craft() -> Row:
    return measure(3, 2000, 5)


def test_lockstep_keeps_a_quarter_of_a_bare_barrier(three_craft):
    """Three agents, link and simulator do at least 0.25 of the barriers of five processes that do nothing."""
    assert three_craft.lockstep_to_bare_barrier >= 0.25


def test_one_process_is_faster_than_many(three_craft):
    """The same run in one process is at least 1.5 times as fast as between processes."""
    assert three_craft.in_process_to_processes >= 1.5
