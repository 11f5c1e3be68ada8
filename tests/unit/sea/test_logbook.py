"""The memory of a run: counts, positions, digest and recording."""

import pytest
from recordings import METADATA, recorded_messages

from grex_link.messages import AgentState, AgentStates, Fix, LinkEvent, LinkLedger, Pose, Setpoint, Truth
from grex_link.recorder import Recorder
from grex_link.recording import Recording
from grex_sim.logbook import Logbook

TEAM = ["auv1", "auv2"]


def truth(tick, north_m=0.0):
    """Poses of two craft."""
    poses = [Pose(craft, north_m + place, 10.0 * place, 0, 0, 0, 0, 1.0) for place, craft in enumerate(TEAM)]
    return Truth(tick, tick * 1_000_000_000, poses)


def setpoint(tick, speed_mps=1.0):
    """A setpoint of a tick."""
    return Setpoint(tick, tick * 1_000_000_000, "steer", 0.0, speed_mps, 0.0)


def state(tick, health=(), bad_frames=0):
    """An agent's state."""
    return AgentState(tick, tick * 1_000_000_000, 0, 0.5, 0.0, 1.0, 1.0, 0.0, [], list(health), bad_frames)


STARTED = LinkEvent(0, "started", "auv1", 0, "", 15)
DELIVERED = LinkEvent(10, "delivered", "auv1", 0, "auv2", 15)
LOST = LinkEvent(10, "lost", "auv1", 0, "auv3", 15, "loss")
REFUSED = LinkEvent(12, "refused", "auv2", 0, "", 15, "busy")


def test_positions():
    """Positions come out as they went in, ticks by craft by north and east."""
    book = Logbook()
    assert book.positions.shape == (0, 1, 2)
    for tick in range(3):
        book.truth(truth(tick, 5.0 * tick))
    assert book.positions.shape == (3, 2, 2)
    assert book.positions[2].tolist() == [[10.0, 0.0], [11.0, 10.0]]


def test_counts_of_the_link():
    """Messages, bytes, deliveries, losses and refusals are counted."""
    book = Logbook()
    book.link_events([STARTED, DELIVERED, LOST, REFUSED])
    book.link_events([STARTED])
    assert (book.messages_sent, book.bytes_sent) == (2, 30)
    assert (book.delivered, book.lost, book.refused) == (1, 1, 1)


def test_overheard_is_no_refusal():
    """What was whole but for somebody else is counted as that, and is no longer on its way."""
    book = Logbook()
    book.link_events([STARTED, DELIVERED, LinkEvent(10, "overheard", "auv1", 0, "auv3", 15)])
    assert (book.delivered, book.overheard, book.lost, book.refused) == (1, 1, 0, 0)
    assert (book.in_flight(3), book.in_flight(4)) == (0, 1)


def test_over_land():
    """A message over land is on its way to one craft, whatever the size of the team."""
    book = Logbook()
    book.link_events([LinkEvent(0, "started", "auv1", 0, "auv2", 15, purpose="land"), STARTED])
    assert (book.messages_sent, book.sent_by_land) == (2, 1)
    assert (book.in_flight(2), book.in_flight(10)) == (2, 10)


def test_ledgers_are_kept_and_recorded(tmp_path):
    """The newest ledger of the water and of each port are at hand, and every one is on record."""
    book = Logbook(Recorder(tmp_path / "run.mcap", METADATA))
    assert (book.ledger, book.ports) == (None, {})
    for t_ns in (1, 2):
        book.message("ledger", "", LinkLedger(t_ns, [], []))
    assert book.ledger == LinkLedger(2, [], [])
    book.close()
    assert [(entry.topic, entry.t_ns) for entry in Recording(tmp_path).entries()] == [("ledger", 1), ("ledger", 2)]


def test_ledgers_are_no_part_of_the_digest():
    """The digest is of truth, link events and setpoints, however often a ledger comes."""
    book = Logbook()
    before = book.digest
    book.message("ledger", "", LinkLedger(1, [], []))
    assert book.digest == before


def test_counts_of_the_agents():
    """Bad frames are the agents' newest count, unhealthy steps are counted by word; a healthy craft is not named."""
    book = Logbook()
    bundle = [state(1, ["stale_fix"], 1), state(2, ["stale_fix", "speed_limited"], 3), state(3, [], 3)]
    book.message("state", "auv1", AgentStates(bundle))
    book.message("state", "auv2", AgentStates([state(1), state(2)]))
    assert book.bad_frames == {"auv1": 3}
    assert book.unhealthy_steps == {"auv1": {"stale_fix": 2, "speed_limited": 1}}


def filled(*events, speed=1.0, north_m=0.0, order="tsl"):
    """A digest of one tick, its parts taken down in an order."""
    book = Logbook()
    parts = {
        "t": lambda: book.truth(truth(0, north_m)),
        "s": lambda: book.setpoints({"auv2": setpoint(0), "auv1": setpoint(0, speed)}, TEAM),
        "l": lambda: book.link_events(events),
    }
    for part in order:
        parts[part]()
    return book.digest


def test_digest_tells_runs_apart():
    """Another truth, another setpoint or another link event is another digest; the same run is the same."""
    assert filled(STARTED, DELIVERED) == filled(STARTED, DELIVERED)
    others = {
        filled(STARTED, DELIVERED),
        filled(STARTED, LOST),
        filled(DELIVERED, STARTED),
        filled(STARTED, DELIVERED, speed=1.0 + 1e-15),
        filled(STARTED, DELIVERED, north_m=1e-300),
    }
    assert len(others) == 5


def test_digest_knows_no_order_of_arrival():
    """When truth, setpoints and link events come relative to each other is no part of the digest."""
    assert filled(STARTED, order="tsl") == filled(STARTED, order="lst")


def test_digest_takes_setpoints_in_the_order_of_the_team():
    """The order in which craft answered is no part of the digest; a craft that did not is left out."""
    one, other, fewer = Logbook(), Logbook(), Logbook()
    one.setpoints({"auv1": setpoint(0), "auv2": setpoint(1)}, TEAM)
    other.setpoints({"auv2": setpoint(1), "auv1": setpoint(0)}, TEAM)
    fewer.setpoints({"auv1": setpoint(0)}, TEAM)
    assert one.digest == other.digest != fewer.digest


def test_digest_can_be_looked_at_on_the_way():
    """Asking for the digest does not disturb it."""
    asked, whole = Logbook(), Logbook()
    for book in (asked, whole):
        book.truth(truth(0))
        if book is asked:
            assert len(book.digest) == 64
        book.truth(truth(1))
    assert asked.digest == whole.digest


def test_recording(tmp_path):
    """What passed on the bus, the truth and the link's log are on record, in the order in which they were taken."""
    book = Logbook(Recorder(tmp_path / "run.mcap", METADATA))
    book.truth(truth(0))
    book.message("fix", "auv1", Fix(0, 0, 1.5, 0.0, 0.0, 0.0, 1.0, 0.1))
    book.message("state", "auv1", AgentStates([state(1), state(2)]))
    book.link_events([STARTED])
    book.close()
    recorded = list(Recording(tmp_path).entries())
    assert [(entry.topic, entry.craft) for entry in recorded] == [
        ("truth", ""), ("fix", "auv1"), ("state", "auv1"), ("state", "auv1"), ("link_event", ""),
    ]  # fmt: skip
    assert [entry.t_ns for entry in recorded] == [0, 0, 1_000_000_000, 2_000_000_000, 0]
    assert recorded[1].message.north_m == 1.5


def test_is_on_disk_now_and_then(tmp_path):
    """Half a second of wall time after the last time, everything is on disk, though the file is not closed."""
    path = tmp_path / "run.mcap"
    book = Logbook(Recorder(path, METADATA))
    book.truth(truth(0))
    book.write_if_due(100.0)
    assert len(recorded_messages(path, "truth")) == 1
    book.truth(truth(1))
    book.write_if_due(100.4)
    assert len(recorded_messages(path, "truth")) == 1
    book.write_if_due(100.5)
    assert len(recorded_messages(path, "truth")) == 2
    book.close()


def test_writes_in_idle_time(tmp_path):
    """In idle time what has piled up is written little by little, in order, until nothing is left."""
    book = Logbook(Recorder(tmp_path / "run.mcap", METADATA))
    assert not book.write_some()
    for tick in range(200):
        book.truth(truth(tick))
    calls = 1
    while book.write_some():
        calls += 1
    assert calls > 1
    assert not book._unwritten
    book.close()
    assert [truth.tick for truth in recorded_messages(tmp_path, "truth")] == list(range(200))


@pytest.mark.parametrize("recording", [True, False])
def test_does_not_pile_up(tmp_path, recording):
    """However long the wall clock stands still, what waits to be written is bounded."""
    book = Logbook(Recorder(tmp_path / "run.mcap", METADATA) if recording else None)
    book.write_if_due(100.0)
    for tick in range(5000):
        book.truth(truth(tick))
        book.write_if_due(100.1)
    assert len(book._unwritten) <= 2001
    book.close()
    assert not book._unwritten
