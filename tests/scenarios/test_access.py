"""Who may speak when, flown in the water: guards that hold, clocks that break them, GPS, Aloha, and links over land.

Three craft in line abreast, so far apart that sound takes a good part of a slot::

    auv1 ──── 300 m ──── auv2 ──── 300 m ──── auv3        600 m: 0.4 s
"""

import math

import pytest
from missions import fly_text

TEAM = """
duration_s = 240.0
[mission]
type = "lawnmower"
legs = 1
leg_length_m = 1000.0
[mission.formation_m]
auv1 = [0.0, -300.0, 5.0]
auv2 = [0.0, 0.0, 5.0]
auv3 = [0.0, 300.0, 5.0]
[link]
profile = "s2c_im"
[craft.auv1]
[craft.auv2]
[craft.auv3]
"""
TRIANGLE = {1: "[0.0, -30.0, 5.0]", 2: "[51.96, 0.0, 5.0]", 3: "[0.0, 30.0, 5.0]"}
TIGHT = "link.mac={type='tdma',range_max_m=600.0}"


@pytest.mark.parametrize("mac", ["link.mac={type='tdma'}", TIGHT, "link.mac={type='tdma',guard_s=0.4}"])
def test_a_guard_that_holds_loses_nothing(mac):
    """With the guard worked out, or just as long as the sound takes, no message meets another one."""
    summary = fly_text(TEAM, mac)
    assert summary.messages_sent > 600 // 3
    assert (summary.lost, summary.refused) == (0, 0)


def test_several_craft_with_small_errors_of_their_clocks():
    """Clocks that are off by as much as the guard is made for lose nothing."""
    clocks = [
        "craft.auv1.clock={offset_s=0.01}",
        "craft.auv2.clock={offset_s=-0.01}",
        "craft.auv3.clock={drift_ppm=-40}",
    ]
    assert fly_text(TEAM, TIGHT, *clocks).lost == 0


def test_a_clock_off_by_a_slot_breaks_it():
    """A clock that is off by half a slot puts messages onto those of others."""
    summary = fly_text(TEAM, TIGHT, "craft.auv2.clock={offset_s=0.45}")
    assert summary.lost > summary.messages_sent / 4


def test_gps_at_the_surface_mends_it():
    """The same clock, set by GPS because the craft is at the surface, loses nothing."""
    surface = ["mission.formation_m.auv2=[0.0, 0.0, 0.0]", "craft.auv2.clock={offset_s=0.45,gps_at_surface=true}"]
    assert fly_text(TEAM, TIGHT, *surface).lost == 0


@pytest.mark.parametrize(
    ("mac", "share"),
    [
        ("link.mac={type='slotted_aloha',probability=0.25}", 0.75**2),
        ("link.mac={type='aloha',rate_per_s=0.5}", (math.exp(-0.5 * 0.31665) / (1.0 + 0.5 * 0.31665)) ** 2),
    ],
)
def test_aloha_keeps_its_law(mac, share):
    """The share of receptions that succeed is that of the law that ``grex check`` prints.

    It holds for craft that are equally loud and near each other: a triangle of 60 m.
    """
    triangle = [f"mission.formation_m.auv{place}={where}" for place, where in TRIANGLE.items()]
    summary = fly_text(TEAM, mac, *triangle, "duration_s=1500")
    receptions = summary.delivered + summary.lost
    assert receptions > 900
    # Receptions of one message are not independent: as if there were half as many.
    assert abs(summary.delivered / receptions - share) < 4.0 * math.sqrt(share * (1.0 - share) / (receptions / 2.0))


def test_land_links_carry_what_the_water_does_not():
    """With the modems off, two craft with a radio link know of each other, and nobody knows of the third."""
    off = ",".join(f"{{craft='auv{place}',start_s=0,end_s=1e6}}" for place in (1, 2, 3))
    land = "link.land=[{between=['auv1','auv3'],every_s=2.0}]"
    summary = fly_text(TEAM, f"link.outages=[{off}]", land, "duration_s=100")
    # 50 instants, both ways; the last ones may be on their way.
    assert 98 <= summary.delivered <= 100


@pytest.mark.parametrize("profile", ["janus", "nm3", "umodem_psk6"])
def test_every_form_keeps_the_team_together(profile):
    """In whatever form the states go, a craft that starts 1.25 % too fast is held in formation."""
    fast = "craft.auv1.vehicle.speed_error_relative=0.0125"
    kept = fly_text(TEAM, f"link.profile={profile}", fast, "duration_s=600")
    alone = fly_text(TEAM, f"link.profile={profile}", fast, "duration_s=600", "team.estimator=none")
    assert kept.bad_frames == {}
    assert kept.fd < alone.fd / 2.0
