"""What a request must be, so that no other page in the user's browser can use this server, and what is answered.

A page elsewhere that lets its own name point to 127.0.0.1 (DNS rebinding) is told from ours by the Host it asks for;
one that opens our socket is told by its Origin.
"""

from collections.abc import Iterable

Headers = Iterable[tuple[bytes, bytes]]

_LOCAL = frozenset({b"127.0.0.1", b"localhost", b"[::1]"})
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
#: Sent with every answer: nothing is loaded from elsewhere, nothing is framed, nothing is kept.
ANSWER_HEADERS: list[tuple[bytes, bytes]] = [
    (b"content-security-policy", _POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-cache"),
]


def refusal(headers: Headers, method: str) -> tuple[int, str] | None:
    """Say why a request is refused: status and one line; None if it is welcome.

    Parameters
    ----------
    headers : iterable of (name, value)
        Names in lower case.
    method : str
        ``GET`` for a socket, too.
    """
    hosts = [value for name, value in headers if name == b"host"]
    if len(hosts) != 1 or not _is_local(hosts[0]):
        return 421, "this page is for this machine only: ask for http://127.0.0.1"
    if any(value.lower() != b"http://" + hosts[0].lower() for name, value in headers if name == b"origin"):
        return 403, "this request comes from another page"
    if method not in {"GET", "HEAD"}:
        return 405, "this server is for reading only"
    return None


def _is_local(host: bytes) -> bool:
    name, colon, port = host.lower().rpartition(b":")
    if not colon or not port.isdigit():
        name = host.lower()
    return name in _LOCAL
