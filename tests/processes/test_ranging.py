"""Ranging and a base between processes: the result is that of one process."""

import json
import subprocess

from launching import SCENARIO, grex


def fly(folder, *options: str) -> dict:
    """Run the base's scenario for a minute and a half."""
    command = grex("run", str(SCENARIO.with_name("base.toml")), "--set", "duration_s=90", *options, "--json", "--out", str(folder))  # fmt: skip  # noqa: E501
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, timeout=100).stdout)


def test_processes_find_what_one_process_finds(tmp_path) -> None:
    """With every message delayed at random, digest, positions believed and the base's own are those of one process."""
    alone = fly(tmp_path / "one", "--in-process")
    delayed = fly(tmp_path / "many", "--set", "clock.chaos_delay_s=0.001")
    assert delayed["digest"] == alone["digest"]
    assert delayed["navigation"] == alone["navigation"]
    assert delayed["navigation"]["base>auv2"]["steps"] > 80
