"""What a modem refuses at once, because it could never do it."""

from collections.abc import Container

from grex_link.messages import BROADCAST, RangeRequest, Request
from grex_link.profile import ModemProfile


def refusal(profile: ModemProfile, request: Request, source: str, team: Container[str]) -> str:
    """Say why a modem refuses a request – ``size``, ``address`` or ``error`` – or "" if it does not.

    Parameters
    ----------
    profile : ModemProfile
        The modem.
    request : Request
        What it is asked for.
    source : str
        The craft it is on.
    team : container of str
        Whom it can address.
    """
    destination = request.destination
    if isinstance(request, RangeRequest):
        if not profile.ranging.two_way:
            return "error"
        to_one = True
    else:
        if len(request.payload) > profile.payload_max_bytes:
            return "size"
        to_one = request.acknowledge or not profile.broadcast
    if destination == BROADCAST:
        return "address" if to_one else ""
    if destination == source or destination not in team:
        return "address"
    acknowledged = not isinstance(request, RangeRequest) and request.acknowledge
    return "error" if acknowledged and not profile.acknowledges else ""
