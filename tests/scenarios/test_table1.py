"""The paper's mission and its Table I.

::

    2 ─────────────────────────────────────────╮
         1 (25 m apart, ahead by 6 m, too fast) │ ╮ ╮   eight legs of 400 m
    3 ────────────────────────────────────╮    │ │ │   joined by half circles
                                          ╰─── ╯ ╯ ╯   about one centre
"""

import pytest
from missions import fly

from grex_sim.table1 import PAPER


@pytest.fixture(scope="module")
def table() -> dict[str, float]:
    return {case: fly(f"paper-{case}").fd for case in PAPER}


@pytest.mark.parametrize("case", PAPER)
def test_formation_deviation_is_the_papers(table, case):
    """Every case is within 2 % of the paper's figure."""
    assert table[case] == pytest.approx(PAPER[case], rel=0.02)


def test_order_of_the_cases(table):
    """Perfect knowledge beats two levels, two levels beat one, and no control is far worse than all."""
    assert table["b"] < table["d"] < table["c"]
    assert table["c"] * 20 < table["a"]


@pytest.mark.parametrize(("case", "ratio"), [("c", 1.0824), ("d", 1.0726)])
def test_cost_of_estimation_is_the_papers(table, case, ratio):
    """What the estimators lose against perfect knowledge is within 0.01 of the paper's ratio."""
    assert table[case] / table["b"] == pytest.approx(ratio, abs=0.01)
