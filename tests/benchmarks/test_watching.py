"""Watching costs the watched nothing, and the watcher little. Ratios, on an idle machine."""

import json
import os
import statistics
import subprocess
import time
from contextlib import nullcontext
from pathlib import Path

import psutil
import pytest
from launching import SCENARIO, grex, running
from playwright.sync_api import sync_playwright
from watching import viewing

from grex_sim.launch import free_port

#: Wall seconds of the live run that is watched: `GREX_WATCH_S=1800` for the half hour of the issue.
LASTING_S = float(os.environ.get("GREX_WATCH_S", "60"))
TEN = {f"auv{number}": [-6.0 * abs(number - 5), 12.0 * (number - 5), 0.0] for number in range(10)}
pytestmark = [pytest.mark.benchmark, pytest.mark.timeout(LASTING_S + 900)]


def lockstep(out: Path, *, watched: bool) -> dict:
    """Fly case d in lockstep, and say what came of it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = ("--set", f'bus.endpoints=["{endpoint}"]', "--json", "--out", str(out))
    with viewing("--connect", endpoint) if watched else nullcontext():
        time.sleep(1.0)
        return json.loads(subprocess.run(grex("run", str(SCENARIO), *options), capture_output=True, check=True).stdout)


def test_watching_does_not_change_or_slow_a_lockstep_run(tmp_path):
    """With and without a viewer the digest is the same, and the speed within ten per cent.

    That is the median of the ratios of pairs, the one or the other first in turns: single runs differ by a quarter.
    """
    speeds = {False: [], True: []}
    digests = set()
    for number in range(10):
        for watched in (number % 2 == 0, number % 2 == 1):
            summary = lockstep(tmp_path, watched=watched)
            speeds[watched].append(summary["ticks_per_s"])
            digests.add(summary["digest"])
    (tmp_path.parent / "speeds.txt").write_text(f"{speeds}\n")
    assert len(digests) == 1
    ratios = [watched / alone for watched, alone in zip(speeds[True], speeds[False], strict=True)]
    assert statistics.median(ratios) > 0.9, ratios


def test_ten_craft_at_ten_hertz(tmp_path):
    """A page of ten craft at 10 Hz: 20 frames a second, a heap that does not grow, a server below a tenth of a core."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    scenario = tmp_path / "ten.toml"
    craft = "\n".join(f"[craft.{name}]" for name in TEN)
    formation = "\n".join(f"{name} = {place}" for name, place in TEN.items())
    scenario.write_text(
        f'[clock]\ntick_s = 0.1\npace = "live"\n[mission]\ntype = "lawnmower"\n[mission.formation_m]\n{formation}\n'
        f'[link]\nprofile = "s2c_im"\nloss = 0.3\n{craft}\n'
    )
    options = ("--set", f"duration_s={LASTING_S + 60:g}", "--set", f'bus.endpoints=["{endpoint}"]')
    with (
        viewing("--connect", endpoint) as address,
        running("run", str(scenario), *options, "--out", str(tmp_path / "out")),
        sync_playwright() as driver,
    ):
        server = next(p for p in psutil.Process().children() if "view" in p.cmdline())
        flags = ["--no-sandbox", "--enable-precise-memory-info", "--js-flags=--expose-gc"]
        browser = driver.chromium.launch(executable_path="/usr/bin/chromium", args=flags)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(address)
        page.wait_for_selector("#health .state[data-state=alive]", timeout=60_000)
        heaps, rates = [], []
        started, cpu = time.monotonic(), sum(server.cpu_times()[:2])
        while (passed_s := time.monotonic() - started) < LASTING_S:
            drawn, at = page.evaluate("[grexPage.drawn, performance.now()]")
            page.wait_for_timeout(min(5000, LASTING_S * 100))
            later, then = page.evaluate("[grexPage.drawn, performance.now()]")
            rates.append(1000.0 * (later - drawn) / (then - at))
            page.evaluate("gc()")
            heaps.append(page.evaluate("performance.memory.usedJSHeapSize") / 1e6)
        share = (sum(server.cpu_times()[:2]) - cpu) / passed_s
        rss = server.memory_info().rss / 1e6
        browser.close()
    half = len(heaps) // 2
    found = f"frames/s {[round(rate) for rate in rates]}, server {share:.1%} of a core and {rss:.0f} MB, heap MB "
    found += " ".join(f"{heap:.1f}" for heap in heaps)
    (tmp_path.parent / "watching.txt").write_text(found + "\n")
    assert statistics.median(rates) >= 20.0, found
    assert share < 0.10, found
    assert max(heaps[half:]) < 1.5 * max(heaps[:half]) + 2.0, found
