"""Hypothesis, for all tests: no deadline on a shared machine, few examples, and in CI always the same ones."""

import os

from hypothesis import settings

settings.register_profile("here", deadline=None, max_examples=50)
settings.register_profile("ci", settings.get_profile("here"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")


def pytest_addoption(parser):
    """Add the flag that flies the golden recordings of tests/replay anew."""
    parser.addoption("--refresh-golden", action="store_true", help="fly the recordings of tests/replay/golden anew")
