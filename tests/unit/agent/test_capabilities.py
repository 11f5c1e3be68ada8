"""What a modem cannot do is said before anything starts, with what would do."""

import pytest

from grex_agent.capabilities import check_capabilities, heard_up_to_m, state_form
from grex_agent.core import AgentCore
from grex_agent.mission import plan_mission
from grex_link.errors import ConfigError
from grex_link.profile import load_profile, profile_names
from grex_link.scenario import decode


def team(size=3, spacing_m=25.0, clock=None, craft=None, **link):
    """A scenario of a team in line abreast."""
    formation = {f"auv{place}": [0.0, spacing_m * place, 0.0] for place in range(1, size + 1)}
    mission = {"type": "lawnmower", "formation_m": formation, "legs": 1}
    tables = {name: (craft or {}).get(name, {}) for name in formation}
    return decode({"mission": mission, "craft": tables, "link": link, "clock": clock or {}})


def fault(scenario):
    """The complaint about a scenario; an agent of its own does not start, for the same reason."""
    with pytest.raises(ConfigError) as caught:
        check_capabilities(scenario, plan_mission(scenario), load_profile(scenario.link.profile))
    with pytest.raises(ConfigError) as started:
        AgentCore(scenario, "auv1")
    assert str(started.value) == str(caught.value)
    assert "\n" not in str(caught.value)
    return caught.value.path, caught.value.problem


def check(scenario):
    """A scenario that can work."""
    check_capabilities(scenario, plan_mission(scenario), load_profile(scenario.link.profile))


SERIAL = {"type": "serial", "port": "/dev/ttyS0"}


def test_a_modem_for_a_pair():
    """A team of three does not start on a modem without broadcast; a pair does."""
    path, problem = fault(team(profile="waterlinked_m64"))
    assert path == "$.link.profile"
    assert "for 3 craft there are" in problem
    others = problem.split("there are ")[1].split(", ")
    assert "nm3" in others
    assert "waterlinked_m64" not in others
    check(team(2, profile="waterlinked_m64"))


def test_more_craft_than_addresses():
    """A team larger than the modem's addresses is refused, with modems that have enough."""
    most = load_profile("seatrac_x150").addresses_max
    assert most == 15
    check(team(15, profile="seatrac_x150"))
    path, problem = fault(team(16, profile="seatrac_x150"))
    assert path == "$.link.profile"
    assert problem.startswith("seatrac_x150 has 15 addresses; for 16 craft there are ")
    assert "seatrac_x150" not in problem.split("there are ")[1]


@pytest.mark.parametrize(
    ("profile", "form"), [("grex2008", "full"), ("s2c_im", "full"), ("waterlinked_m64", "short"), ("janus", "tiny")]
)
def test_the_fullest_form_that_fits(profile, form):
    """Left to itself, a team state goes in the fullest form that the modem carries."""
    scenario = team(2, profile=profile)
    check(scenario)
    assert state_form(scenario, load_profile(profile)) == form


@pytest.mark.parametrize(
    ("profile", "wanted", "fits"), [("janus", "short", "tiny"), ("waterlinked_m64", "full", "short")]
)
def test_a_form_that_does_not_fit(profile, wanted, fits):
    """A form too long for the modem is refused with the one that fits, and that one is accepted."""
    path, problem = fault(team(2, profile=profile, message=wanted))
    assert path == "$.link.message"
    assert repr(fits) in problem
    check(team(2, profile=profile, message=fits))


def test_a_modem_that_carries_no_state(tmp_path):
    """A modem of one's own with payloads of four bytes carries no team state in any form."""
    file = tmp_path / "narrow.toml"
    text = 'title = "narrow"\npayload_max_bytes = 4\nairtime_fixed_s = 1.0\nairtime_per_byte_s = 0.0\n'
    file.write_text(f"{text}one_speaker_at_a_time = true\nsources = []\nassumed = []\n", "utf-8")
    path, problem = fault(team(profile=str(file)))
    assert path == "$.link.profile"
    assert "34 bits" in problem


def test_out_of_earshot():
    """A plan that keeps all craft farther apart than the modem is ever heard is refused; one that does not, is not."""
    assert heard_up_to_m(load_profile("ahoi")) == 200.0
    path, problem = fault(team(spacing_m=250.0, profile="ahoi"))
    assert path == "$.link.profile"
    assert "beyond 200 m" in problem
    assert "at least 250 m apart" in problem
    check(team(spacing_m=150.0, profile="ahoi"))
    check(team(1, profile="ahoi"))
    assert heard_up_to_m(load_profile("grex2008")) is None
    assert heard_up_to_m(load_profile("unet_default")) == 2000.0


@pytest.mark.parametrize("pace", ["lockstep", 2.0])
def test_a_real_modem_is_not_hurried(pace):
    """A craft with a modem on a serial port does not start in lockstep, nor faster than the wall clock."""
    real = {"auv2": {"modem": SERIAL}}
    path, problem = fault(team(profile="umodem_fsk0", clock={"pace": pace}, craft=real))
    assert path == "$.craft.auv2.modem"
    assert "'live' would do" in problem
    check(team(profile="umodem_fsk0", clock={"pace": "live"}, craft=real))
    check(team(profile="umodem_fsk0", clock={"pace": 1.0}, craft=real))


def test_an_address_taken_twice():
    """Two real modems cannot have one address, given or by their place in the team."""
    other = SERIAL | {"port": "/dev/ttyS1"}
    craft = {"auv1": {"modem": SERIAL | {"address": 3}}, "auv3": {"modem": other}}
    path, problem = fault(team(profile="umodem_fsk0", clock={"pace": "live"}, craft=craft))
    assert path == "$.craft.auv3.modem.address"
    assert "3 is the address of auv1" in problem


@pytest.mark.parametrize(
    ("link", "path"),
    [
        ({"shadowing": {"sigma_db": 3.0}}, "$.link.shadowing"),
        ({"jammers": [{"position_ned_m": [0, 0, 0], "source_level_db": 150}]}, "$.link.jammers"),
        ({"water": {"spreading": 2.0}}, "$.link.water"),
    ],
)
def test_a_modem_without_acoustics(link, path):
    """The paper's channel has no physics: what asks for some is refused, not ignored."""
    found, problem = fault(team(**link))
    assert found == path
    assert "grex2008 has no acoustics" in problem


def test_what_makes_sense_is_accepted():
    """Outages, jammers, land links and bursts of known craft, in order, are nothing to complain about."""
    check(
        team(
            profile="nm3",
            outages=[{"craft": "auv1", "start_s": 1, "end_s": 2}],
            jammers=[{"position_ned_m": [0, 0, 0], "source_level_db": 150}],
            land=[{"between": ["auv1", "auv3"]}],
            burst={"loss": 0.2, "mean_length_s": 9.0, "loss_good": 0.2, "loss_bad": 0.2},
        )
    )


@pytest.mark.parametrize("profile", profile_names())
def test_every_modem_of_the_house_serves_a_pair(profile):
    """Two craft 25 m apart can use any modem that comes with GREX."""
    check(team(2, profile=profile))
