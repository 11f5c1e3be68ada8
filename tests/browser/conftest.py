"""Chromium, without a screen; skipped with a clear line where there is none."""

import os
import shutil

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="install the extra 'dev': playwright is missing")


@pytest.fixture(scope="session")
def chromium():
    """A browser for all tests."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium: apt-get install chromium")
    # A browser run as root, as in CI, has no sandbox. GPU memory is /dev/shm, which containers have little of.
    options = ["--disable-dev-shm-usage", *(["--no-sandbox"] if os.geteuid() == 0 else [])]
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=options)
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium):
    """A function that opens a page; at the end nothing may have been complained of, or asked of another machine."""
    contexts, complaints, requests = [], [], []

    def open_at(address, width=1440, height=900, **options):
        context = chromium.new_context(viewport={"width": width, "height": height}, color_scheme="light", **options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.on("websocket", lambda socket: requests.append(socket.url))
        page.goto(address)
        page.wait_for_function("() => window.grexPage?.drawn > 0")
        return page

    yield open_at
    for context in contexts:
        context.close()
    # That the canvas is slow to read is the tests' own doing.
    assert [complaint for complaint in complaints if "willReadFrequently" not in complaint] == []
    assert len(requests) > 5
    assert {url.split("/")[2].split(":")[0] for url in requests} == {"127.0.0.1"}
