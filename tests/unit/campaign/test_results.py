"""What comes of a campaign: rows, the Parquet file, the table, the picture, intervals."""

import math

import msgspec
import numpy as np
import pyarrow.parquet as pq
import pytest
from missions import SCENARIOS, fly

from grex_link.scenario import load
from grex_sim.campaign.definition import make_cells, make_jobs, parse_vary
from grex_sim.campaign.engine import Outcome
from grex_sim.campaign.flight import Figures
from grex_sim.campaign.flight import fly as fly_job
from grex_sim.campaign.picture import draw
from grex_sim.campaign.results import cell_results, rows, write_rows
from grex_sim.campaign.text import as_table, failures, rate
from grex_sim.intervals import mean_of, mean_of_series
from grex_sim.parquet import column_type

CELLS = make_cells(
    lambda values: load(SCENARIOS / "paper-d.toml", values), parse_vary(["link.loss=0,1", "team.estimator=none,ideal"])
)


def outcomes(fd_of_cell):
    """Three seeds a cell, whose FD are one below, at, and one above a value; the last run of the last cell failed."""
    figures = dict.fromkeys(Figures.__struct_fields__, 0) | {
        "digest": "d",
        "delivered": 3,
        "lost": 1,
        "age_mean_s": None,
    }
    found = {
        f"{cell}:{seed}": Outcome(
            f"{cell}:{seed}", {**figures, "fd": fd + seed - 1.0, "duration_s": 60.0, "wall_s": 0.5}
        )
        for cell, fd in enumerate(fd_of_cell)
        for seed in range(3)
    }
    return {**found, "3:2": Outcome("3:2", None, "its worker was killed")}


@pytest.fixture
def found():
    """Rows of twelve runs in four cells."""
    return rows(CELLS, 3, outcomes([10.0, 20.0, 30.0, 40.0]))


def test_every_run_is_a_row_with_its_values(found, tmp_path):
    """The file has a row a run, typed columns, and what has failed with its reason and without figures."""
    write_rows(tmp_path / "runs.parquet", found, CELLS)
    table = pq.read_table(tmp_path / "runs.parquet")
    read = table.to_pylist()
    assert [row["seed"] for row in read] == [1, 2, 3] * 4
    assert [row["link.loss"] for row in read[::3]] == [0, 0, 1, 1]
    assert str(table.schema.field("link.loss").type) == "int64"
    assert (read[-1]["failed"], read[-1]["fd"], read[-1]["fault"]) == (True, None, "its worker was killed")
    assert list(tmp_path.iterdir()) == [tmp_path / "runs.parquet"]


def test_a_cell_has_mean_and_interval_of_its_runs(found):
    """Three values one apart have t = 4.303 times 1/√3 as half an interval; what failed is counted and left out."""
    results = cell_results(CELLS, found)
    first, last = results[0].estimates["fd"], results[-1].estimates["fd"]
    assert (first.mean, first.half) == pytest.approx((10.0, 4.302653 / math.sqrt(3)))
    assert (last.mean, last.n, results[-1].failed) == (pytest.approx(39.5), 2, 1)
    assert results[0].estimates["received"].mean == 0.75
    assert results[0].estimates["age_mean_s"].n == 0


def test_the_text_names_cells_rate_and_failures(found):
    """The table has a line a cell; the rate is in missions a minute; failures are named."""
    lines = as_table(cell_results(CELLS, found))
    assert [line.split()[:4] for line in lines[2:]] == [
        ["0", "none", "3", "0"], ["0", "ideal", "3", "0"], ["1", "none", "3", "0"], ["1", "ideal", "2", "1"]
    ]  # fmt: skip
    assert rate(found, 12, 30.0, "2 processes") == (
        "12 missions of 60 s in 30.0 s on 2 processes: 24 missions a minute; one by itself at 120 x real time"
    )
    assert failures(found) == ["WARNING: cell 3, seed 3 failed: its worker was killed"]
    assert failures([{**found[-1]}] * 7)[-1] == "WARNING: and 2 more failed"


@pytest.mark.parametrize("options", [[], ["link.loss=0,1"], ["team.estimator=none,ideal,hold_last,$x"]])
def test_every_campaign_is_a_picture(tmp_path, options):
    """Nothing that varies, numbers, and words are drawn, with values that are missing."""
    cells = [msgspec.structs.replace(CELLS[0], values={})]
    if options:
        ((name, values),) = parse_vary(options).items()
        cells = [msgspec.structs.replace(CELLS[0], values={name: value}) for value in values]
    results = cell_results(cells, rows(cells, 3, outcomes([1.0] * len(cells))))
    draw(tmp_path / "c.png", "costs $x_$", results)
    assert (tmp_path / "c.png").stat().st_size > 10_000


def test_a_job_is_flown_as_a_run_is():
    """Figures of a job are those of the same scenario flown by itself."""
    (cell,) = make_cells(lambda values: load(SCENARIOS / "paper-d.toml", ["duration_s=60", *values]), {})
    figures = fly_job(make_jobs([cell], 2)[1])
    summary = fly("paper-d", "duration_s=60", "seed=2")
    assert (figures["digest"], figures["fd"], figures["seed"]) == (summary.digest, summary.fd, 2)
    assert figures["age_mean_s"] == pytest.approx(
        np.mean([p.age_mean_s for p in summary.paths.values() if p.delivered])
    )


def test_intervals_cover_the_truth_as_often_as_they_say():
    """Of two thousand intervals of five normal values each, 95 % hold the mean, to within two points."""
    values = np.random.default_rng(7).normal(3.0, 2.0, (2000, 5))
    hits = [abs(found.mean - 3.0) <= found.half for found in map(mean_of, values)]
    assert 0.93 < np.mean(hits) < 0.97


def test_an_interval_of_a_series_knows_that_values_follow_from_each_other():
    """Of a slow random process the interval is many times wider than if its values were independent."""
    noise = np.random.default_rng(1).normal(size=4000)
    slow = np.convolve(noise, np.ones(100) / 100, mode="valid")
    assert mean_of_series(slow).half > 4.0 * mean_of(slow.tolist()).half
    assert mean_of_series(np.array([1.0, math.nan, 3.0])).mean == 2.0


def test_a_column_has_the_type_that_holds_all():
    """Whole and broken numbers are numbers; whatever is mixed is text."""
    assert [column_type(each) for each in ([1, 2], [1, 0.5], [True, 1], ["a", 1])] == [int, float, str, str]
