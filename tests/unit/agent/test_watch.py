"""A base that watches one craft: literal messages and ranges, and whether it knows how wrong it is."""

import math

import numpy as np
import pytest

from grex_agent.mission import plan_mission
from grex_agent.range_update import Range
from grex_agent.watch import Watch
from grex_link.config import SpeedModelConfig
from grex_link.ranging_config import BaseConfig, RangingConfig
from grex_link.scenario import loads
from grex_link.wire import NAVIGATION_VALID, ON_TASK, TeamState

PLACE = (150.0, -80.0, 20.0)
BASE = BaseConfig(place_ned_m=PLACE, watch="auv1")
PLAN = plan_mission(
    loads(
        "[mission]\ntype='lawnmower'\nleg_length_m=300.0\nturn_radius_m=50.0\nformation_m={auv1=[0,0,10]}\n[craft.auv1]\n"
    )
).craft["auv1"]


def watch(base=BASE):
    """A base with ranges of 0.2 m."""
    return Watch(base, RangingConfig(mode="two_way", sigma_m=0.2), SpeedModelConfig(), PLAN)


def told(t_s, north, east=0.0, *, sigma=0.5, flags=1, track=0, theta=None, speed=1.0, heading=0.0):
    """What the craft says, at 10 m depth."""
    theta = north / 300.0 if theta is None else theta
    return TeamState(0, t_s, north, east, 10.0, speed, heading, track, theta, sigma, flags)


def seen(t_s, north, east, extra=0.0):
    """The true range to a craft at 10 m depth."""
    slant = math.dist((north, east, 10.0), PLACE) + extra
    return Range(t_s, t_s, "auv1", slant, 0.0, 0.0, 10.0, 9.9)


def test_nothing_before_the_first_message():
    """Ranges alone are no position; the first valid message is."""
    base = watch()
    assert base.hear_range(seen(5.0, 0.0, 0.0))
    base.hear(told(6.0, 6.0, flags=0))
    assert base.belief("auv1", 12.0) is None
    base.hear(told(10.0, 10.0))
    mate, place = base.belief("auv1", 12.0)
    assert (mate.craft, mate.north_m, mate.east_m, mate.age_s) == pytest.approx(("auv1", 12.0, 0.0, 2.0))
    assert mate.progress == pytest.approx(12.0 / 300.0, abs=1e-3)
    assert place.covariance_m2[0] == pytest.approx(mate.sigma_m**2)
    assert mate.sigma_m > math.sqrt(2.0) * 0.5


def test_a_hundred_messages_do_not_make_an_offset_true():
    """The craft is 3 m west of where it says, with a sigma of 2 m: messages alone do not shrink the sigma much."""
    base = watch()
    for now in range(0, 200, 2):
        base.hear(told(float(now), float(now), sigma=2.0))
    assert base.belief("auv1", 198.0)[0].sigma_m > 1.5


def test_ranges_tell_the_offset():
    """With ranges besides, on the way past the base, the offset is found."""
    base = watch()
    for now in range(0, 250, 2):
        base.hear(told(float(now), float(now), sigma=2.0))
        assert base.hear_range(seen(float(now), float(now), -3.0))
    mate, _ = base.belief("auv1", 248.0)
    assert mate.east_m == pytest.approx(-3.0, abs=0.3)
    assert mate.north_m == pytest.approx(248.0, abs=0.5)
    assert mate.sigma_m < 0.6


def test_outliers_and_what_comes_out_of_order():
    """An outlier is rejected; a range or a message of an earlier time than the newest is left out."""
    base = watch()
    for now in range(0, 100, 2):
        base.hear(told(float(now), float(now)))
        base.hear_range(seen(float(now), float(now), 0.0))
    before = base.belief("auv1", 100.0)
    assert not base.hear_range(seen(98.0, 98.0, 0.0, extra=30.0))
    assert base.hear_range(seen(90.0, 90.0, 0.0, extra=30.0))
    base.hear(told(80.0, 95.0))
    assert base.belief("auv1", 100.0) == before


def test_a_wrong_position_is_set_free():
    """If the craft is 25 m from where it says, and claims 0.5 m, the ranges win from the fifth on."""
    base = watch()
    good = []
    for now in range(0, 280, 2):
        base.hear(told(float(now), float(now)))
        good.append(base.hear_range(seen(float(now), float(now), -25.0)))
    assert not any(good[:4])
    assert all(good[-20:])
    assert base.belief("auv1", 278.0)[0].east_m == pytest.approx(-25.0, abs=5.0)


def test_round_the_bend_between_messages():
    """Between two messages the craft goes round the half circle of 50 m, as planned."""
    base = watch()
    base.hear(told(300.0, 300.0, 0.0, track=1, theta=0.0))
    quarter_s = 25.0 * math.pi
    mate, _ = base.belief("auv1", 300.0 + quarter_s)
    assert (mate.north_m, mate.east_m) == pytest.approx((350.0, 50.0), abs=1.0)


def test_on_a_task_the_plan_does_not_turn_it():
    """A craft on a task is carried on as it heads, not round the bend, with more doubt; its progress stands still."""
    on_task = NAVIGATION_VALID | ON_TASK
    believed = {}
    for flags in (NAVIGATION_VALID, on_task):
        base = watch()
        base.hear(told(300.0, 300.0, 0.0, track=1, theta=0.0, flags=flags))
        believed[flags], _ = base.belief("auv1", 320.0)
    assert (believed[on_task].north_m, believed[on_task].east_m) == pytest.approx((320.0, 0.0))
    assert believed[on_task].progress == pytest.approx(1.0)
    assert believed[NAVIGATION_VALID].east_m > 3.0
    # A craft that may turn by 0.2 rad a second at random is this far beside its course after 20 s, at least.
    assert believed[on_task].sigma_m > 0.2 * math.sqrt(20.0**3 / 3.0)
    assert believed[NAVIGATION_VALID].sigma_m < 2.0


def test_a_task_has_a_speed_of_its_own():
    """Across the end of a track, and from a track to another, a craft on a task is not thought to change its speed."""
    base = watch()
    base.hear(told(0.0, 250.0, 60.0, speed=0.4, flags=NAVIGATION_VALID | ON_TASK, theta=0.99))
    base.hear(told(10.0, 254.0, 60.0, speed=0.4, flags=NAVIGATION_VALID | ON_TASK, track=2, theta=0.5))
    mate, _ = base.belief("auv1", 30.0)
    assert (mate.north_m, mate.east_m) == pytest.approx((262.0, 60.0), abs=0.5)
    assert mate.progress == pytest.approx(2.5)


def test_who_comes_back_heads_elsewhere():
    """A craft that has ended its task, and heads 90° from its plan, is carried on as it heads until then."""
    base = watch()
    base.hear(told(300.0, 300.0, -40.0, track=1, theta=0.01, heading=math.pi / 2.0))
    assert base.belief("auv1", 310.0)[0].north_m == pytest.approx(300.0)
    assert base.belief("auv1", 310.0)[0].east_m == pytest.approx(-30.0)
    doubt = base.belief("auv1", 330.0)[0].sigma_m
    base.hear(told(330.0, 300.0, 0.0, track=1, theta=0.01, heading=0.05))
    assert base.belief("auv1", 360.0)[0].sigma_m < doubt / 5.0


def test_consistent():
    """With errors drawn as the base models them, NEES over position is in its 95 % band, with ranges and without."""
    for ranges in (True, False):
        draw = np.random.default_rng(1)
        total = sum(_normalised_error(draw, ranges=ranges) for _ in range(200))
        # χ² with 400 degrees of freedom: 95 % lie between 346.5 and 457.3.
        assert 346.5 < total < 457.3


def _normalised_error(draw, *, ranges):
    """Position error after 60 s, weighed with the covariance claimed."""
    base, keep = watch(), math.exp(-2.0 / BASE.told_time_s)
    place, velocity, offset = np.zeros(2), np.array([1.0, 0.0]), 0.5 * draw.normal(size=2)
    for now in range(0, 62, 2):
        if now:
            pushed = BASE.acceleration_noise_mps * math.sqrt(0.5) * draw.normal(size=(4, 2))
            for push in pushed:
                place, velocity = place + 0.5 * velocity + 0.25 * push, velocity + push
            offset = keep * offset + 0.5 * math.sqrt(1.0 - keep * keep) * draw.normal(size=2)
        at = place + offset + 0.5 * draw.normal(size=2)
        v_north, v_east = velocity + 0.05 * draw.normal(size=2)
        base.hear(told(float(now), *at, theta=max(place[0], 0.0) / 300.0, speed=math.hypot(v_north, v_east),
                       heading=math.atan2(v_east, v_north)))  # fmt: skip
        if ranges:
            base.hear_range(seen(float(now), *place, extra=0.2 * draw.normal()))
    _, believed = base.belief("auv1", 60.0)
    wrong = np.array([believed.north_m, believed.east_m]) - place
    north, east, both = believed.covariance_m2
    return float(wrong @ np.linalg.solve(np.array([[north, both], [both, east]]), wrong))
