"""Who may ask the page's server, and how much a browser may say."""

import asyncio

import pytest

from grex_sim.view.guard import ANSWER_HEADERS, refusal
from grex_sim.view.mailbox import Mailbox, Patience


def headers(host=b"127.0.0.1:8080", origin=None):
    return [(b"host", host), *([(b"origin", origin)] if origin else [])]


@pytest.mark.parametrize("host", [b"127.0.0.1:8080", b"localhost:8080", b"LOCALHOST", b"[::1]:8080", b"[::1]"])
def test_this_machine_is_welcome(host) -> None:
    """Every name of this machine is let in, from its own page as well."""
    assert refusal(headers(host), "GET") is None
    assert refusal(headers(host, b"http://" + host), "GET") is None


@pytest.mark.parametrize(
    "host", [b"evil.example", b"evil.example:8080", b"127.0.0.1.evil.example", b"", b"127.0.0.1:a"]
)
def test_another_name_is_refused(host) -> None:
    """A name that only points to this machine is refused: that is how DNS rebinding comes in."""
    assert refusal(headers(host), "GET")[0] == 421
    assert refusal([], "GET")[0] == 421
    assert refusal([*headers(), (b"host", b"evil.example")], "GET")[0] == 421


@pytest.mark.parametrize("origin", [b"http://evil.example", b"https://127.0.0.1:8080", b"http://127.0.0.1:9", b"null"])
def test_another_page_is_refused(origin) -> None:
    """A page from elsewhere, even from another port of this machine, is refused."""
    assert refusal(headers(origin=origin), "GET")[0] == 403


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "PATCH"])
def test_it_is_for_reading(method) -> None:
    """Nothing but reading is answered."""
    assert refusal(headers(), method)[0] == 405


def test_the_browser_may_load_nothing_from_elsewhere() -> None:
    """The policy begins with nothing, and adds this server only: no inline script or style, no eval, no frame."""
    policy = dict(ANSWER_HEADERS)[b"content-security-policy"].decode()
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy
    assert "http" not in policy
    assert "*" not in policy


def test_the_newest_wins() -> None:
    """Of frames that nobody takes only the newest is kept."""

    async def run():
        mailbox = Mailbox()
        for number in range(1000):
            mailbox.put(str(number).encode())
        first = await mailbox.take()
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(mailbox.take(), 0.01)
        return first

    assert asyncio.run(run()) == b"999"


def test_patience_ends_and_comes_back() -> None:
    """Twenty messages in ten seconds are borne, not one more; later it begins anew."""
    patience = Patience()
    assert all(patience.bears(100.0) for _ in range(20))
    assert not patience.bears(109.0)
    assert patience.bears(111.0)
