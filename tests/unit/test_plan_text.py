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
