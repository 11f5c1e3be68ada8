"""Fifty craft at once."""

from missions import fly


def test_fifty_craft_keep_their_v():
    """Fifty craft start, speak in turn, keep formation and distance, and nobody has anything to complain of."""
    summary = fly("fifty", "duration_s=20")
    assert len(summary.ports) == 50
    assert summary.messages_sent == 21
    assert summary.fd < 0.1
    assert 11.0 < summary.closest.distance_m < 12.0
    assert summary.unhealthy_steps == {}
    assert summary.ledger_faults == []
