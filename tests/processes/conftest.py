"""Fixtures for tests with real processes."""

import psutil
import pytest


@pytest.fixture
def gone():
    """A function that says whether processes are gone, waiting a moment for the kernel to reap them."""

    def check(processes) -> bool:
        _, alive = psutil.wait_procs(list(processes), timeout=3.0)
        return not alive

    return check
