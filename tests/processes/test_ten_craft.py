"""Ten craft as processes."""

import json
import subprocess
from pathlib import Path

import pytest
from launching import grex

FIFTY = Path(__file__).parents[2] / "deploy" / "scenarios" / "fifty.toml"
FEWER = (
    "--set",
    "fleet.count=10",
    "--set",
    "craft={}",
    "--set",
    "duration_s=60",
    "--set",
    "team.separation_min_m=11.9",
)


@pytest.mark.slow
def test_ten_craft_as_processes_are_ten_craft_in_one(tmp_path):
    """Twelve processes give the digest of one, with estimators, guard and a fleet spelled out in each of them."""
    digests = set()
    for name, where in (("one", ["--in-process"]), ("many", [])):
        command = grex("run", str(FIFTY), *FEWER, *where, "--json", "--out", str(tmp_path / name))
        ran = subprocess.run(command, check=True, capture_output=True, text=True, timeout=110)
        digests.add(json.loads(ran.stdout)["digest"])
    assert len(digests) == 1
