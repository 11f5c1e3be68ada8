"""The page of a live run, in a real browser, beside real processes. One run for all: the test that kills comes last."""

import http.client
import json
import signal
import socket as sockets
import time

import pytest
from launching import SCENARIO, participants, running
from watching import LIVELY, LOST, PIXELS, cell, viewing
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from grex_sim.launch import free_port

EVERYBODY = {"sim", "link", "agent auv1", "agent auv2", "agent auv3"}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A live run and a page server that was there before it: (the run's processes, address of the page)."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = (*LIVELY, "--set", f'bus.endpoints=["{endpoint}"]', "--out", str(tmp_path_factory.mktemp("live")))
    with viewing("--connect", endpoint) as address, running("run", str(SCENARIO), *options) as launcher:
        yield launcher, address


def states(page):
    """State of every participant in the health table."""
    rows = page.locator("#health tbody tr").all()
    return {row.get_attribute("data-name"): row.locator(".state").get_attribute("data-state") for row in rows}


def test_three_craft_move_and_everybody_is_alive(run, open_page):
    """The page finds the run that began after it: three craft move, everybody is alive and says enough."""
    page = open_page(run[1])
    page.wait_for_function("() => document.querySelectorAll('#health .state[data-state=alive]').length === 5")
    assert set(states(page)) == EVERYBODY
    page.wait_for_function("() => document.getElementById('phase').textContent === 'running'")
    before = {name: cell(page, name, 0) for name in ("auv1", "auv2", "auv3")}
    page.wait_for_timeout(3000)
    for name, north_m in before.items():
        assert 1.5 < cell(page, name, 0) - north_m < 6.0  # at 1 m/s
    row = page.locator("#health tr[data-name='agent auv2'] td").nth(2).inner_text()
    assert "setpoint" in row
    assert "(10.0)" in row


def test_a_message_is_drawn_and_dies_with_its_cause(run, open_page):
    """Losses appear in the list with their cause, and as red crosses on the plan while they are new."""
    page = open_page(run[1])
    page.locator("#messages .lost", has_text="burst").first.wait_for()
    page.wait_for_function(f"colour => ({PIXELS})(['plan', ...colour])[0] > 20", arg=LOST)


def test_whoever_comes_in_the_middle_sees_the_past(run, open_page):
    """A page that is opened late has the history of the charts at once."""
    page = open_page(run[1])
    assert page.evaluate("grexPage.past.columns[0].length") > 20
    assert page.evaluate("grexPage.past.columns[0][0]") < 2.0


def test_another_page_cannot_use_it(run):
    """Who asks for another host, or comes from another page, is refused; so is everything but reading."""
    host = run[1].removeprefix("http://").rstrip("/")

    def status(method="GET", **headers):
        connection = http.client.HTTPConnection(host, timeout=5)
        connection.request(method, "/scene.json", headers={name.title(): value for name, value in headers.items()})
        answer = connection.getresponse()
        connection.close()
        return answer

    assert status().status == 200
    assert "default-src 'none'" in status().headers["content-security-policy"]
    assert status(host="evil.example:80").status == 421
    assert status(origin="http://evil.example").status == 403
    assert status("POST").status == 405
    with pytest.raises(Exception, match="403"):
        connect(f"ws://{host}/live", origin="http://evil.example").close()


def cut_off(socket, said):
    """Whether the server closes a socket on which all this is said."""
    try:
        for words in said:
            socket.send(words)
            socket.recv(timeout=5)
        while True:
            socket.recv(timeout=5)
    except ConnectionClosed:
        return True


def test_a_flood_is_cut_off_and_changes_nothing(run, open_page):
    """A socket that talks is closed after a few words, one that sends a lot at once, too; pages see nothing of it."""
    page = open_page(run[1])
    address = run[1].replace("http", "ws") + "live"
    words = json.dumps({"seek": 0, "setpoint": {"speed_mps": 9}})
    for said in ([words] * 10_000, ["x" * 1_000_000]):
        with connect(address) as socket:
            assert cut_off(socket, said)
    seen = page.evaluate("grexPage.past.version")
    page.wait_for_function(f"() => grexPage.past.version > {seen + 5}")
    assert set(states(page).values()) == {"alive"}


def test_a_stalled_browser_holds_up_nobody(run, open_page):
    """Of sockets that take nothing the newest frame alone is kept; other pages go on in the meantime."""
    host, port = run[1].removeprefix("http://").rstrip("/").split(":")
    request = (
        f"GET /live HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    stalled = []
    for _ in range(5):
        stalled.append(sockets.create_connection((host, int(port))))
        stalled[-1].sendall(request.encode())
    page = open_page(run[1])
    seen = page.evaluate("grexPage.past.version")
    started = time.monotonic()
    page.wait_for_function(f"() => grexPage.past.version > {seen + 20}")
    assert time.monotonic() - started < 10.0
    for connection in stalled:
        connection.close()


def test_a_killed_agent_turns_red(run, open_page):
    """An agent that dies is red within three seconds, by name; nobody else is, and the page says what happened."""
    page = open_page(run[1])
    page.wait_for_function("() => document.querySelectorAll('#health .state[data-state=alive]').length === 5")
    participants(run[0].pid)["auv2"].send_signal(signal.SIGKILL)
    page.wait_for_selector("#health tr[data-name='agent auv2'] .state[data-state=lost]", timeout=3000)
    red = page.locator("#health tr[data-name='agent auv2'] .state").evaluate("badge => getComputedStyle(badge).color")
    assert red == "rgb({}, {}, {})".format(*LOST[:3])
    page.wait_for_function("() => document.getElementById('reason').textContent.includes('agent auv2 left the bus')")
    assert page.locator("#phase").inner_text() == "broken off"
    page.wait_for_timeout(1500)
    others = {who: state for who, state in states(page).items() if who != "agent auv2"}
    assert "lost" not in others.values()
