"""The acoustic medium between processes: whatever they are delayed, the same packets have the same fates."""

import json
import subprocess

import pytest
from launching import SCENARIO, grex

#: Everything at once that can make a packet's fate depend on when and where.
ROUGH = (
    "duration_s=100",
    "link.profile=ahoi",
    "link.burst={loss=0.3,mean_length_s=20}",
    "link.shadowing={sigma_db=4}",
    "link.land=[{between=['auv1','auv2']}]",
    "link.outages=[{craft='auv3',start_s=40,end_s=50}]",
    "craft.auv2.clock={offset_s=0.02,drift_ppm=20}",
)


def fly(folder, *options: str) -> dict:
    settings = [part for value in ROUGH for part in ("--set", value)]
    command = grex("run", str(SCENARIO), *settings, *options, "--json", "--out", str(folder))
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=100).stdout)


@pytest.fixture(scope="module")
def in_one_process(tmp_path_factory) -> dict:
    return fly(tmp_path_factory.mktemp("one"), "--in-process")


def test_delayed_processes_give_the_same_log(in_one_process, tmp_path) -> None:
    """With every message delayed at random, the digest of truth, link log and setpoints is that of one process."""
    delayed = fly(tmp_path, "--set", "clock.chaos_delay_s=0.003")
    assert delayed["digest"] == in_one_process["digest"]
    assert delayed["paths"] == in_one_process["paths"]


def test_the_fates_are_many(in_one_process) -> None:
    """The run compared has losses of several kinds, and its books balance."""
    reasons = {reason for path in in_one_process["paths"].values() for reason in path["lost"]}
    assert {"lost_noise", "lost_burst", "missed_off"} <= reasons
    assert in_one_process["ledger_faults"] == []
