"""What a craft tells its mates, and what it makes of what they tell: every form, and the plan for what is left out."""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import plan_mission
from grex_agent.tell import PLANNED_SIGMA_M, SHORT_SIGMA_M, TeamTalk
from grex_link import wire
from grex_link.messages import Fix, Received
from grex_link.scenario import decode

NS = 1_000_000_000
FORMATION = {"auv1": [0.0, 0.0, 4.0], "auv2": [-6.0, -25.0, 9.0]}
PLAN = plan_mission(
    decode(
        {
            "mission": {"type": "lawnmower", "formation_m": FORMATION, "legs": 4, "heading_deg": 30.0},
            "craft": {craft: {} for craft in FORMATION},
        }
    )
)


def heard(form, track, theta, now_s=100.0, beside_m=0.0):
    """What auv1 reads of a state of auv2 at a place of its plan, beside its track, and that state."""
    plan = PLAN.craft["auv2"].tracks[track]
    north, east = plan.point(theta)
    course = plan.locate(north, east).course_rad
    processor = ManoeuvreProcessor(PLAN.craft["auv2"])
    processor.go_to(track)
    processor.follow(north, east)
    place = north - beside_m * math.sin(course), east + beside_m * math.cos(course)
    fix = Fix(7, round((now_s - 3.0) * NS), *place, 9.0, course, 1.0, 0.2)
    talk = TeamTalk("auv2", PLAN, form)
    state = talk.state(fix, processor, 1.1)
    payload, as_read = talk.pack(state)
    report = TeamTalk("auv1", PLAN).read(Received("auv2", payload), now_s)
    assert report is not None
    assert report.craft == "auv2"
    return report.state, state, as_read, len(payload)


@pytest.mark.parametrize(("form", "size"), [("full", 15), ("short", 8), ("tiny", 5)])
def test_what_is_read_is_what_the_sender_takes_it_for(form, size):
    """The sender knows what its mates read of it: the same state, filled in from the same plan, without a gap."""
    read, _, as_read, length = heard(form, 2, 0.4)
    assert (read, length, read.form) == (as_read, size, form)
    numbers = [value for value in msgspec.structs.astuple(read) if isinstance(value, float)]
    assert len(numbers) == 8
    assert all(map(math.isfinite, numbers))


@given(st.integers(0, 6), st.floats(0.0, 0.999), st.floats(-30.0, 30.0))
def test_the_short_form_has_the_place_and_the_plan_the_rest(track, theta, beside_m):
    """Read from the short form, position and time are the sender's, to a metre; depth, speed, course are the plan's."""
    read, told, _, _ = heard("short", track, theta, beside_m=beside_m)
    planned = PLAN.craft["auv2"].tracks[track]
    assert (read.north_m, read.east_m) == pytest.approx((told.north_m, told.east_m), abs=0.501)
    assert (read.track, read.theta) == (track, pytest.approx(theta, abs=1e-3))
    assert read.t_s == pytest.approx(97.0, abs=0.25)
    assert (read.depth_m, read.speed_mps, read.sigma_m) == (9.0, planned.speed_mps, SHORT_SIGMA_M)
    assert math.cos(read.heading_rad - told.heading_rad) > 0.999


@given(st.integers(0, 6), st.floats(0.0, 0.999), st.floats(-30.0, 30.0))
def test_the_tiny_form_has_the_progress_and_the_plan_the_place(track, theta, beside_m):
    """Read from the tiny form, a craft is on its track where its Θ says, as deep and as fast as planned."""
    read, told, _, _ = heard("tiny", track, theta, beside_m=beside_m)
    planned = PLAN.craft["auv2"].tracks[track]
    assert math.dist((read.north_m, read.east_m), planned.point(theta)) < planned.length_m / 4095
    assert abs(math.dist((read.north_m, read.east_m), (told.north_m, told.east_m)) - abs(beside_m)) < 0.2
    assert (read.depth_m, read.speed_mps, read.sigma_m) == (9.0, planned.speed_mps, PLANNED_SIGMA_M)
    assert math.cos(read.heading_rad - told.heading_rad) > 0.999


def test_the_full_form_is_left_as_it_is():
    """Nothing of a full state is taken from the plan."""
    read, told, _, _ = heard("full", 0, 0.5, beside_m=12.0)
    assert read.depth_m == pytest.approx(told.depth_m)
    assert read.speed_mps == pytest.approx(1.1)
    assert (read.north_m, read.east_m) == pytest.approx((told.north_m, told.east_m), abs=0.0626)
    assert read.sigma_m == pytest.approx(0.2, rel=0.01)


@pytest.mark.parametrize("form", ["full", "short", "tiny"])
def test_a_track_that_is_not_in_the_plan_is_a_bad_frame(form):
    """A state on a track that the plan does not have is counted and dropped, in every form; it is not looked up."""
    talk = TeamTalk("auv1", PLAN)
    for track, bad in ((7, 1), (255, 2), (6, 2)):
        state = wire.TeamState(1, 100.0, 5.0, 5.0, 5.0, 1.0, 0.0, track, 0.5, 0.1)
        report = talk.read(Received("auv2", wire.pack(state, form)), 100.0)
        assert talk.bad_frames == bad
        assert (report is None) is (track > 6)


@given(st.binary(max_size=40), st.sampled_from(["auv1", "auv2", "stranger"]))
def test_any_bytes_are_a_state_or_counted(payload, source):
    """Whatever is heard from whomever is either a state without gaps or counted as a bad frame."""
    talk = TeamTalk("auv1", PLAN)
    report = talk.read(Received(source, payload), 100.0)
    assert (report is None) is (talk.bad_frames == 1)
    if report is not None:
        assert report.craft == "auv2"
        assert math.isfinite(report.state.north_m + report.state.east_m + report.state.sigma_m)


def test_a_mate_whose_clock_is_ahead():
    """What is from the future by our clock counts as of now: a mate cannot know what has not been."""
    tell = TeamTalk("auv2", PLAN)
    processor = ManoeuvreProcessor(PLAN.craft["auv2"])
    ahead, behind = (tell.state(Fix(0, t_s * NS, 1.0, 2.0, 9.0, 0.0, 1.0, 0.2), processor, 1.0) for t_s in (105, 95))
    listener = TeamTalk("auv1", PLAN)
    for state, read_s in ((ahead, 100.0), (behind, 95.0)):
        report = listener.read(Received("auv2", tell.pack(state)[0]), 100.0)
        assert report is not None
        assert report.state.t_s == read_s
