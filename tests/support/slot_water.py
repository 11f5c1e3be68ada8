"""The paper's channel for tests: requests begin at their own time; what is asked for has been worked through."""

from collections.abc import Sequence

from grex_link.config import CraftConfig, Scenario, TrackList, Tracks
from grex_link.link_config import LinkConfig
from grex_link.medium import Due
from grex_link.messages import LinkEvent, Transmit
from grex_link.profile import ModemProfile, load_profile
from grex_link.slot_medium import SlotMedium


def team_scenario(team: Sequence[str], link: LinkConfig, seed: int = 1) -> Scenario:
    """Build a scenario of which only team, link and seed matter."""
    mission = Tracks(craft={craft: TrackList((0.0, 0.0, 0.0), ()) for craft in team})
    return Scenario(seed=seed, mission=mission, link=link, craft={craft: CraftConfig() for craft in team})


class SlotWater(SlotMedium):
    """See the module's docstring."""

    def __init__(self, team: Sequence[str], loss: float = 0.0, seed: int = 1, profile: ModemProfile | None = None):
        super().__init__(team_scenario(team, LinkConfig(loss=loss), seed), profile or load_profile("grex2008"))

    def transmit(self, source: str, request: Transmit) -> None:
        """Request a transmission for the time that stands in it."""
        self.request(source, request, request.t_ns)

    def events(self, before_ns: int) -> list[Due]:
        """Work through and take the events before a time."""
        self.advance(before_ns)
        return super().events(before_ns)

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Work through and take the log before a time."""
        self.advance(before_ns)
        return super().log(before_ns)
