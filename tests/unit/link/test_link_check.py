"""What one part of the link says about another is checked when a scenario is read, by everybody."""

import pytest

from grex_link.config import Scenario
from grex_link.errors import ConfigError
from grex_link.scenario import decode


def link_of(**link) -> Scenario:
    formation = {f"auv{place}": [0.0, 25.0 * place, 0.0] for place in (1, 2, 3)}
    mission = {"type": "lawnmower", "formation_m": formation, "legs": 1}
    return decode({"mission": mission, "craft": {name: {} for name in formation}, "link": link})


@pytest.mark.parametrize(
    ("link", "path", "says"),
    [
        ({"outages": [{"craft": "auv9", "start_s": 1, "end_s": 2}]}, "$.link.outages[0].craft", "auv1, auv2, auv3"),
        ({"outages": [{"craft": "auv1", "start_s": 2, "end_s": 2}]}, "$.link.outages[0].end_s", "not after"),
        (
            {"jammers": [{"position_ned_m": [0, 0, 0], "source_level_db": 150, "start_s": 9, "end_s": 8}]},
            "$.link.jammers[0].end_s",
            "not after start_s = 9 s",
        ),
        ({"land": [{"between": ["auv1", "auv9"]}]}, "$.link.land[0].between[1]", "auv1, auv2, auv3"),
        (
            {"land": [{"between": ["auv1", "auv2"]}, {"between": ["auv9", "auv2"]}]},
            "$.link.land[1].between[0]",
            "unknown craft 'auv9'",
        ),
        ({"land": [{"between": ["auv2", "auv2"]}]}, "$.link.land[0].between", "name two craft"),
        ({"burst": {"loss": 0.1, "mean_length_s": 9, "loss_good": 0.2}}, "$.link.burst.loss", "between them"),
        ({"burst": {"loss": 0.9, "mean_length_s": 9, "loss_bad": 0.8}}, "$.link.burst.loss", "between them"),
        (
            {
                "outages": [
                    {"craft": "auv1", "start_s": 50, "end_s": 60},
                    {"craft": "auv2", "start_s": 5, "end_s": 15},
                    {"craft": "auv1", "start_s": 10, "end_s": 51},
                ]
            },
            "$.link.outages[0].start_s",
            "another outage of auv1, which ends at 51 s",
        ),
        (
            {"water": {"layers": [[0, 1500], [30, 1480], [30, 1490]]}},
            "$.link.water.layers[2]",
            "30 m is not below 30 m",
        ),
    ],
)
def test_what_is_said_of_the_link_must_make_sense(link, path, says):
    """Unknown craft, times that end before they begin, links to oneself and impossible means are named by path."""
    with pytest.raises(ConfigError) as caught:
        link_of(**link)
    assert caught.value.path == path
    assert says in caught.value.problem


def test_what_touches_does_not_overlap() -> None:
    """An outage may begin when another of the same craft ends."""
    outages = [{"craft": "auv1", "start_s": 1, "end_s": 2}, {"craft": "auv1", "start_s": 2, "end_s": 3}]
    assert len(link_of(outages=outages).link.outages) == 2


def test_tdma_is_meant_where_no_mac_is_named() -> None:
    """A mac without a type is TDMA, so that one of its values can be overridden alone."""
    assert link_of(mac={"cycle_s": 60.0}).link.mac.cycle_s == 60.0
    assert link_of(mac={"type": "aloha", "rate_per_s": 0.1}).link.mac.rate_per_s == 0.1
