"""The plan as text: what ``grex check`` prints."""

import math

import pytest
from missions import SCENARIOS

from grex_agent.mission import plan_mission
from grex_link.scenario import load, loads
from grex_link.tdma import Schedule, Slot
from grex_link.units import NS
from grex_sim.link_text import age_of_information_s
from grex_sim.plan_text import plan_text

TRACKS = """
[mission]
type = "tracks"
at_end = "hold"
[mission.craft.boat]
start_ned_m = [0.0, 0.0, 0.0]
tracks = [
    { type = "line", to_ned_m = [300.0, 0.0, 0.0], speed_mps = 1.5 },
    { type = "arc", centre_ne_m = [300.0, -100.0], turn_deg = -90.0, speed_mps = 1.0 },
]
[craft.boat]
"""


def text_of(source, *overrides):
    """Return the text of a scenario of deploy/scenarios, or of TOML."""
    scenario = loads(source, overrides) if "\n" in source else load(SCENARIOS / f"{source}.toml", overrides)
    return plan_text(scenario, plan_mission(scenario))


def rows(text, heading):
    """Return the lines of a paragraph, each as its words."""
    paragraph = next(part for part in text.split("\n\n") if part.startswith(heading))
    return [line.split() for line in paragraph.splitlines()[2:]]


def entry(text, name):
    """Return the text of a named entry, unwrapped."""
    lines = iter(text.splitlines())
    found = [next(line for line in lines if line.startswith(name)).removeprefix(name)]
    for line in lines:
        if not line.startswith(" " * 15):
            break
        found.append(line)
    return " ".join(" ".join(found).split())


def test_the_head_says_who_does_what_and_how_long():
    """Title, team, estimator, controller with its gain, pace, tick and duration of the paper's case d are there."""
    text = text_of("paper-d")
    assert text.startswith("GREX 2008, case d: estimators of two levels\n\n")
    assert entry(text, "Team") == "grex, 3 craft: auv1, auv2, auv3"
    assert entry(text, "Estimator") == "second_level"
    assert entry(text, "Controller") == "theta_p, gain K = 0.8 m/s per unit of Θ, speed 0.3 … 3 m/s"
    assert entry(text, "Pace") == "lockstep, tick 1 s"
    assert entry(text, "Duration") == f"{3200.0 + 7.0 * 65.0 * math.pi:.1f} s, 4629 ticks (the planned mission)"


def test_overrides_show():
    """What a user changes is what the text says: pace, tick, gain, duration."""
    text = text_of("paper-d", "clock.pace=2.5", "clock.tick_s=0.5", "team.gain_mps=1.25", "duration_s=100")
    assert entry(text, "Pace") == "2.5 x real time, tick 0.5 s"
    assert "gain K = 1.25 m/s" in entry(text, "Controller")
    assert entry(text, "Duration") == "100.0 s, 200 ticks (the planned mission takes 4629.4 s)"


def test_a_scenario_without_a_title_begins_with_its_team():
    """There is no empty line where a title would be."""
    assert text_of(TRACKS).startswith("Team ")


def test_tracks_of_the_paper_have_their_numbers():
    """Lines are 400 m; arcs π times the radius, which the formation makes different; all take a craft equally long."""
    table = rows(text_of("paper-d"), "Tracks")
    assert table[0] == ["auv1", "0,", "2", "…", "14", "8", "line", "400.0", "1.000", "400.0", "0.0"]
    arc = "arc 180° to starboard, radius"
    radius = math.hypot(65.0 + 25.0, 6.0)
    assert " ".join(table[4]) == (
        f"1, 5 … 13 4 {arc} {radius:.1f} m {math.pi * radius:.1f} {radius / 65.0:.3f} {65.0 * math.pi:.1f} 0.0"
    )
    assert len(table) == 9


def test_explicit_tracks_have_their_numbers():
    """A line of 300 m at 1.5 m/s takes 200 s; a quarter of a circle of 100 m to port is 157.1 m long."""
    text = text_of(TRACKS)
    assert entry(text, "Mission") == "explicit tracks; at the end every craft holds its place"
    assert [" ".join(row) for row in rows(text, "Tracks")] == [
        "boat 0 1 line 300.0 1.500 200.0 0.0",
        "1 1 arc 90° to port, radius 100.0 m 157.1 1.000 157.1 0.0",
    ]


def test_depths_and_starts_are_those_of_each_craft():
    """Starts and depths of a craft below the others are its own, and no zero has a sign."""
    place = "[-6.0, -25.0, 12.5]"
    astern = "mission.formation_m.auv3=[-6.0, 0.0, 0.0]"
    text = text_of("paper-d", f"mission.formation_m.auv2={place}", astern, "mission.heading_deg=90")
    assert rows(text, "Starts")[1] == ["auv2", "25.0", "-6.0", "12.5", "90.0"]
    assert rows(text, "Starts")[2] == ["auv3", "0.0", "-6.0", "0.0", "90.0"]
    assert [row[-1] for row in rows(text, "Tracks")] == ["0.0"] * 3 + ["12.5"] * 3 + ["0.0"] * 3


def test_many_equal_tracks_take_few_lines():
    """A lawnmower of 120 legs takes as many lines as one of eight, and irregular numbers are cut short."""
    assert len(rows(text_of("paper-d", "mission.legs=120"), "Tracks")) == 9
    lines = "".join(
        f'    {{ type = "line", to_ned_m = [{(north + 1) * 10.0}, 0.0, {depth}.0], speed_mps = 1.0 }},\n'
        for north, depth in enumerate([1, 2, 1, 1, 2, 1, 1, 1, 2, 1, 1])
    )
    many = TRACKS.split("tracks = [", maxsplit=1)[0] + f"tracks = [\n{lines}]\n[craft.boat]\n"
    first, second = rows(text_of(many), "Tracks")
    assert " ".join(first).startswith("boat 0, 2, 3, 5, 6 … 10 8 line")
    assert " ".join(second).startswith("1, 4, 8 3 line")


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        ((), "none"),
        (
            ("sea.current_ned_mps=[0.3,0.4,0]",),
            "north 0.3, east 0.4, down 0 m/s, 0.50 m/s towards 53°, known to the craft",
        ),
        (
            ("sea.current_ned_mps=[0,-0.2,0]", "sea.known_current_ned_mps=[0,0,0]"),
            "north 0, east -0.2, down 0 m/s, 0.20 m/s towards 270°; the craft compensate for none",
        ),
    ],
)
def test_the_current_is_the_true_one_and_the_known_one(overrides, expected):
    """The text tells the true current from what the craft compensate for."""
    assert entry(text_of("paper-d", *overrides), "Sea current") == expected


def test_the_schedule_of_the_paper_and_its_mean_age():
    """Three slots of ten seconds, a cycle of thirty, and a mean age of T + C/2 = 25 s."""
    text = text_of("paper-d")
    assert "TDMA schedule (cycle C = 30 s from mission time 0; 100% of it in slots)" in text
    assert rows(text, "TDMA") == [["auv1", "0", "10"], ["auv2", "10", "10"], ["auv3", "20", "10"]]
    assert entry(text, "Message") == "15 bytes, airtime T = 10 s, lost with p = 0"
    assert entry(text, "Mean age") == "25.0 s = T + C/2, of what the mates know of auv1, auv2, auv3"


def test_slots_are_in_the_order_of_time_and_the_silent_are_named():
    """Slots are listed as they come; a craft with two is known better, and one without is never heard."""
    slots = [
        f"{{craft='{craft}',start_s={start_s},length_s={length_s}}}"
        for craft, start_s, length_s in (("auv2", 40, 12), ("auv1", 0, 10), ("auv1", 20, 10))
    ]
    text = text_of(
        "paper-d",
        "link.mac.type=tdma",
        "link.mac.cycle_s=64",
        f"link.mac.slots=[{','.join(slots)}]",
    )
    assert rows(text, "TDMA") == [["auv1", "0", "10"], ["auv1", "20", "10"], ["auv2", "40", "12"]]
    assert "cycle C = 64 s from mission time 0; 50% of it" in text
    auv1 = 10.0 + (20.0**2 + 44.0**2) / (2.0 * 64.0)
    assert entry(text, "Mean age") == (
        f"{auv1:.1f} s = T + mean time since the opening of the last slot heard, of what the mates know of auv1"
    )
    assert "42.0 s = T + C/2, of what the mates know of auv2" in text
    assert entry(text, "Never heard") == "auv3"


def test_loss_makes_news_older():
    """With one message in five lost the mean age is T + C(1/0.8 - 1/2)."""
    assert entry(text_of("paper-d", "link.loss=0.2"), "Mean age").startswith("32.5 s = T + C·(1/(1 - 0.2) - 1/2)")


def test_what_the_guard_has_room_for():
    """Of 25.7 m between craft 17.7 m are to spare, and a mate may be unheard for C + T = 40 s; no guard, no line."""
    text = text_of("paper-d", "team.separation_min_m=8.0")
    nearest_m = math.hypot(6.0, 25.0)
    assert entry(text, "Separation") == (
        f"8 m, of {nearest_m:.1f} m planned at the nearest: in one lane, the craft ahead may lose "
        f"{(nearest_m - 8.0) / 40.0:.2f} m/s in the 40.0 s from one message to the arrival of the next"
    )
    assert "Separation" not in text_of("paper-d")


def test_a_craft_alone_is_known_to_nobody():
    """A team of one has no mean age, and nobody who is never heard."""
    text = text_of(TRACKS)
    assert "Mean age" not in text
    assert "Never heard" not in text


def test_the_mean_age_is_what_counting_gives():
    """For uneven slots and loss, the formula agrees with the average over all that may have been lost."""
    opens, cycle_s, airtime_s, loss = (3.0, 10.0, 31.0), 40.0, 2.0, 0.3
    slots = tuple(Slot("auv1", round(start * NS), NS) for start in opens)
    times = [cycle * cycle_s + start for cycle in range(-40, 1) for start in opens]
    total, steps = 0.0, 4000
    for step in range(steps):
        now = (step + 0.5) * cycle_s / steps
        before = sorted(now - time for time in times if time <= now)
        total += sum(age * (1.0 - loss) * loss**back for back, age in enumerate(before))
    counted = airtime_s + total / steps
    schedule = Schedule(slots, round(cycle_s * NS))
    assert age_of_information_s(schedule, "auv1", airtime_s, loss) == pytest.approx(counted, rel=1e-4)
    assert age_of_information_s(schedule, "auv1", airtime_s, 1.0) == math.inf
    assert age_of_information_s(schedule, "auv2", airtime_s) == math.inf


def test_assumed_numbers_of_the_modem_are_marked():
    """Exactly the numbers that nobody has published are marked, and sources are named."""
    text = text_of("paper-d")
    modem = next(part for part in text.split("\n\n") if part.startswith("Modem"))
    assert "grex2008: GREX 2008, as the paper describes it" in modem
    marked = [line.split()[:2] for line in modem.splitlines() if "assumed" in line]
    assert marked == [["payload_max_bytes", "32"]]
    assert ["airtime_fixed_s", "10"] in [line.split() for line in modem.splitlines()]
    assert "Schneider et al. 2008, section V" in modem


def test_no_line_is_too_long_for_a_terminal():
    """A team of thirty is wrapped, not one line of four hundred characters."""
    places = "".join(f"craft_number_{place} = [0.0, {place}.0, 0.0]\n" for place in range(30))
    craft = "".join(f"[craft.craft_number_{place}]\n" for place in range(30))
    text = text_of(f'[mission]\ntype = "lawnmower"\n[mission.formation_m]\n{places}{craft}')
    assert max(map(len, text.splitlines())) <= 120
    assert "craft_number_29" in entry(text, "Team")


# -- modems in the water ------------------------------------------------------------------------------------------


def test_the_guard_is_explained():
    """On an acoustic modem the text says guard and what it is made of, and how far the plan takes the craft apart."""
    text = text_of("paper-d", "link.profile=s2c_im", "link.mac={type='tdma',range_max_m=500,jitter_s=0.02}")
    guard = 500.0 / 1500.0 + 2 * 0.01 + 0.0904 + 0.02
    assert entry(text, "Guard") == (
        f"{guard:.3f} s; needed: {guard:.3f} s = 0.333 s for 500 m at 1500 m/s + 2·0.01 s for clocks + 0.0904 s for "
        "decoding and turnaround + 0.02 s for jitter"
    )
    assert entry(text, "Distance").startswith(
        "at most 50.0 m between two craft by the plan, on which sound takes τ = 0.033 s"
    )
    slot = math.ceil((guard + 0.1503 + 15 * 0.01109) * 1000) / 1000
    assert [float(row[2]) for row in rows(text, "TDMA")[:3]] == [slot] * 3


def test_a_guard_too_short_to_be_wise():
    """A guard that covers the plan but nothing more is accepted, and the text says what that means."""
    text = text_of("paper-d", "link.profile=s2c_im", "link.mac={type='tdma',guard_s=0.05}")
    assert entry(text, "Guard").startswith("0.050 s; needed: 0.204 s")
    assert entry(text, "Guard").endswith("a team that is apart will collide")


def test_the_mean_age_counts_all_of_the_way():
    """The age is airtime, way of the sound, decoding and half a cycle, each named where it is not nothing."""
    text = text_of("paper-d", "link.profile=s2c_im")
    cycle = 3 * 0.521
    age = 0.31665 + 50.0 / 1500.0 + 0.0904 + cycle / 2.0
    assert (
        entry(text, "Mean age") == f"{age:.1f} s = T + τ + decoding + C/2, of what the mates know of auv1, auv2, auv3"
    )


@pytest.mark.parametrize(
    ("profile", "form", "size"),
    [
        ("s2c_im", "full: time, position,", 15),
        ("janus", "tiny: time, track, Θ; the position is taken from the plan", 5),
    ],
)
def test_the_form_of_the_message(profile, form, size):
    """The text says which form of the team state goes on the air, and how long it is."""
    text = text_of("paper-d", f"link.profile={profile}")
    assert entry(text, "Form").startswith(form)
    assert entry(text, "Message").startswith(f"{size} bytes,")


def test_slotted_aloha_and_its_law():
    """Of slotted Aloha the text gives slot, rate and (1 - p)^(N - 1), and the age that follows."""
    text = text_of("paper-d", "link.profile=s2c_im", "link.mac={type='slotted_aloha',probability=0.2,slot_s=0.6}")
    assert "Slotted Aloha (slot C = 0.6 s from mission time 0)" in text
    assert entry(text, "Rate") == "every craft speaks in 0.2 of the slots, at random"
    assert entry(text, "Success").startswith("0.640 of the messages")
    age = 0.31665 + 50.0 / 1500.0 + 0.0904 + 0.6 * (1.0 / (0.2 * 0.64) - 0.5)
    assert entry(text, "Mean age").startswith(f"{age:.1f} s = T + τ + decoding + C·(1/s - 1/2)")


def test_pure_aloha_and_its_law():
    """Of pure Aloha the text gives the rate and [e^(-λT)/(1 + λT)]^(N - 1)."""
    text = text_of("paper-d", "link.profile=s2c_im", "link.mac={type='aloha',rate_per_s=0.5}")
    load = 0.5 * 0.31665
    success = (math.exp(-load) / (1.0 + load)) ** 2
    assert entry(text, "Rate") == "every craft speaks 0.5 times a second on average, at random"
    assert entry(text, "Success").startswith(f"{success:.3f} of the messages")
    age = 0.31665 + 50.0 / 1500.0 + 0.0904 + (1.0 + load) / 0.5 / success
    assert entry(text, "Mean age").startswith(f"{age:.1f} s = T + τ + decoding + mean time between two that are heard")
    assert "Guard" not in text


def test_aloha_on_the_papers_modem_promises_nothing():
    """Where one speaks at a time no law of collisions holds, and none is printed."""
    text = text_of("paper-d", "link.mac={type='aloha',rate_per_s=0.05}")
    assert "Pure Aloha" in text
    assert all(word not in text for word in ("Success", "Mean age", "Distance", "Guard"))


def test_clocks_are_said_if_they_are_wrong():
    """Clocks with errors are listed, and when the guard does not cover them any more."""
    text = text_of(
        "paper-d",
        "link.profile=s2c_im",
        "craft.auv1.clock={drift_ppm=-20,offset_s=0.002}",
        "craft.auv3.clock={offset_s=0.5,gps_at_surface=true}",
    )
    assert entry(text, "Clock          auv1").startswith(
        ": +0.002 s, drifts by -20 ppm; off by more than the clock_error_s = 0.01 s the guard is for after 600 s"
    )
    assert "auv3: +0.5 s, drifts by +0 ppm, set by GPS above 0.5 m of depth; at once off by more than" in " ".join(
        text.split()
    )
    assert "auv2:" not in text
    assert "Clock" not in text_of("paper-d")


def test_land_links_are_listed():
    """Land links are listed with what they can do."""
    text = text_of("paper-d", "link.land=[{between=['auv1','auv3'],kind='cable',every_s=2.0,loss=0.1}]")
    assert entry(text, "Land") == ("auv1 and auv3 by cable every 2 s, latency 0.05 s, 1e+06 bit/s, lost with p = 0.1")


def test_a_modem_that_does_not_reach_the_whole_plan_is_said():
    """Where craft are planned farther apart than the modem is ever heard, the text warns."""
    far = "mission.formation_m.auv3=[-600.0, 10.0, 0.0]"
    assert "WARNING: this modem is not heard beyond 200 m" in entry(
        text_of("paper-d", "link.profile=ahoi", "mission.legs=1", far), "Distance"
    )
