"""The books of a modem port: what has become of everything that was asked of it."""

from grex_agent.modem.inbox import Inbox
from grex_agent.modem.outbox import Outbox
from grex_link.messages import PortLedger


def port_ledger(t_ns: int, outbox: Outbox, inbox: Inbox, slots_owned: int, slots_used: int) -> PortLedger:
    """Put the counts of a port together; requested = refused + superseded + expired + queued + started.

    Parameters
    ----------
    t_ns : int
        Time, by the craft's clock.
    outbox, inbox : Outbox, Inbox
        Of the port.
    slots_owned, slots_used : int
        Its slots so far.
    """
    return PortLedger(
        t_ns=t_ns,
        requested=outbox.requested,
        refused=dict(outbox.refused),
        superseded=outbox.superseded,
        expired=outbox.expired,
        queued=outbox.queued,
        started=outbox.started,
        failed=dict(outbox.failed),
        slots_owned=slots_owned,
        slots_used=slots_used,
        slots_skipped=slots_owned - slots_used,
        reassembled=inbox.reassembly.reassembled,
        abandoned=inbox.reassembly.abandoned,
        bad_frames=inbox.bad_frames,
    )
