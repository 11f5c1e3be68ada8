"""What stays where it is: a base, in the place of a simulated craft."""

from grex_link.messages import Pose, Setpoint


class Anchored:
    """A modem on a buoy, a quay or the sea bed.

    Parameters
    ----------
    craft : str
        Its name.
    place_ned_m : tuple of float
        Where it is.

    Attributes
    ----------
    pose : Pose
        Always the same.
    holdable : bool
        Always: no current takes it away.
    """

    holdable = True

    def __init__(self, craft: str, place_ned_m: tuple[float, float, float]) -> None:
        self.pose = Pose(craft, *place_ned_m, 0.0, 0.0, 0.0, 0.0)

    def step(self, setpoint: Setpoint | None) -> None:
        """Stay."""
