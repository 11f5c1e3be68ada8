"""The manoeuvre processor: which track a craft is on, and how far it has come (paper, Fig. 8)."""

from grex_agent.mission import CraftPlan
from grex_agent.path import Place, Track


class ManoeuvreProcessor:
    """Follows a plan track by track.

    The track changes when Θ reaches 1 and never back, so that noise cannot make it chatter. The last track never ends:
    Θ grows beyond 1. *Progress* is the cumulative Θ, track number plus Θ, which does not jump when tracks change.

    Parameters
    ----------
    plan : CraftPlan
        The craft's tracks.

    Attributes
    ----------
    number : int
        Number of the present track.
    """

    __slots__ = ("_tracks", "number", "place", "progress", "track")

    def __init__(self, plan: CraftPlan) -> None:
        self._tracks = plan.tracks
        self.number = 0
        self.track: Track = plan.tracks[0]
        self.place = Place(0.0, 0.0, 0.0)
        self.progress = 0.0

    def follow(self, north_m: float, east_m: float) -> Place:
        """Take a position; change track if the present one is done. Returns where the position stands."""
        place = self.track.locate(north_m, east_m)
        while place.theta >= 1.0 and self.number < len(self._tracks) - 1:
            self.go_to(self.number + 1)
            place = self.track.locate(north_m, east_m)
        self.place = place
        self.progress = self.number + place.theta
        return place

    def go_to(self, number: int) -> None:
        """Take up a track by its number, limited to those there are."""
        self.number = min(max(number, 0), len(self._tracks) - 1)
        self.track = self._tracks[self.number]
