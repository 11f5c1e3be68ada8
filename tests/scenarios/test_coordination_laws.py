"""What the coordination laws beside the paper's and talk by events are worth; see README for 20 seeds.

::

    2 ──────────────►
         1 ──────────────►      a craft that makes 0.8 m/s for a while: who waits for it?
    3 ──────►
"""

import csv

import pytest
from missions import fly

TEAM = ("auv1", "auv2", "auv3")
SLOW = "craft.auv3.vehicle.speed_limits=[{start_s=100.0, end_s=300.0, max_mps=0.8}]"
UNKNOWN = ("sea.current_ned_mps=[0.15, 0.1, 0.0]", "sea.known_current_ned_mps=[0.0, 0.0, 0.0]")
EVENTS = 'team.talk={type="event", threshold_m=0.2, heartbeat_slots=9}'
#: The paper's law, stiffer, with the guidance of the shared reference.
STIFF = ("team.gain_mps=8.0", "guidance.cross_track_gain_rad_per_m=0.2", "guidance.curvature_feedforward=1.27",
         "team.estimator=along_track", "team.own_filter={}")  # fmt: skip


def fd(name, *overrides, duration_s=700):
    """FD of a part of the paper's mission."""
    return fly(name, f"duration_s={duration_s}", *overrides).fd


def test_the_shared_reference_on_the_papers_mission():
    """FD is below 0.008, where the paper's law with perfect communication leaves 0.43; with few messages."""
    summary = fly("shared-reference")
    assert summary.fd < 0.008
    assert summary.messages_sent < 463 / 8
    assert summary.bytes_sent == 9 * summary.messages_sent
    assert not summary.bad_frames
    assert not summary.unhealthy_steps


@pytest.mark.parametrize(("loss", "worst"), [(0.0, 0.3), (0.5, 0.8)])
def test_everybody_waits_for_a_slow_craft(loss, worst):
    """A craft that cannot keep up is waited for, also with half of the messages lost; unheard it is not."""
    waited = fd("shared-reference", SLOW, f"link.loss={loss}")
    unheard = fd("shared-reference", SLOW, "link.loss=1.0")
    assert waited < worst
    assert unheard > 2.0


def test_without_messages_nothing_is_lost_that_needs_none():
    """On the paper's mission the shared reference needs no messages at all: they prove nothing about it there."""
    assert fd("shared-reference", "link.loss=1.0") == pytest.approx(fd("shared-reference"), abs=1e-3)


def test_a_modem_that_is_off_for_a_while(tmp_path):
    """Who was deaf while the others waited for a slow mate falls back to them, and then the formation is as before."""
    off = 'link.outages=[{craft="auv2", start_s=90.0, end_s=330.0}]'
    fly("shared-reference", "duration_s=900", SLOW, off, out=tmp_path)
    with (tmp_path / "series.csv").open() as file:
        series = [float(row["fd"]) for row in csv.DictReader(file)]
    assert max(series[250:330]) > 5.0
    assert max(series[600:]) < 0.3
    assert sum(series[700:]) / len(series[700:]) < 0.03


def test_an_unknown_current_is_compensated():
    """With the own filter a current nobody knows costs hardly anything."""
    assert fd("shared-reference", *UNKNOWN) < 0.02
    assert fd("paper-d", *UNKNOWN, "team.own_filter={}") < 0.5 * fd("paper-d", *UNKNOWN)


def test_the_own_speed_error_is_removed():
    """The paper's law without the own speed error is twice as good, though no message tells it."""
    assert fd("paper-d", *STIFF, "team.controller=theta_p_unbiased") < 0.5 * fd("paper-d", *STIFF)


def test_events_save_four_of_five_messages():
    """Told only where the mates are wrong, the along-track filter loses less than 2 % with a fifth of the messages."""
    ideal, by_events = fly("paper-b"), fly("paper-d", "team.estimator=along_track", EVENTS)
    assert by_events.messages_sent <= 0.2 * ideal.messages_sent
    assert by_events.fd / ideal.fd < 1.02
