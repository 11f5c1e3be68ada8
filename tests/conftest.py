"""For all tests: Hypothesis without deadline and, in CI, with the same examples always; and a Ctrl-C that is heard."""

import os
import signal

from hypothesis import settings

settings.register_profile("here", deadline=None, max_examples=50)
settings.register_profile("ci", settings.get_profile("here"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")
# Whoever a plain shell starts in the background is deaf to Ctrl-C, and so are its children: not so those of a test.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    """Add the flag that flies the golden recordings of tests/replay anew."""
    parser.addoption("--refresh-golden", action="store_true", help="fly the recordings of tests/replay/golden anew")
