"""A craft that the sea does not move: where it is comes from its own autopilot, through its fixes."""

import msgspec

from grex_link.messages import Fix, Pose
from grex_link.units import NS

#: A position is carried on by the last velocity for no longer than this.
_CARRY_S = 2.0


class External:
    """The best known pose of a craft on MAVLink.

    The medium, the recording and the score take it for the truth. A tick of the bench and the fix for it come at the
    same moment, so the fix before it may be all there is: it is carried on by the velocity between the last two.

    Parameters
    ----------
    craft : str
        Its name.
    start : tuple of float
        North, east, down (metres) and heading (radians) that are taken until it says where it is.
    """

    def __init__(self, craft: str, start: tuple[float, float, float, float]) -> None:
        self._craft = craft
        north_m, east_m, down_m, heading_rad = start
        self._newest = Fix(-1, 0, north_m, east_m, down_m, heading_rad, 0.0, 0.0)
        self._velocity = 0.0, 0.0
        self._heard = False

    def on_fix(self, fix: Fix, true_ns: int) -> None:
        """Take a fix; one that is not valid leaves the craft where it was.

        Parameters
        ----------
        fix : Fix
            What its frontseat says.
        true_ns : int
            Mission time at which the fix was valid; the fix itself is stamped by the craft's clock.
        """
        if not fix.valid or fix.tick <= self._newest.tick:
            return
        before, passed_s = self._newest, (true_ns - self._newest.t_ns) / NS
        if self._heard and 0.0 < passed_s <= _CARRY_S:
            self._velocity = (fix.north_m - before.north_m) / passed_s, (fix.east_m - before.east_m) / passed_s
        else:
            self._velocity = 0.0, 0.0
        self._heard = True
        self._newest = msgspec.structs.replace(fix, t_ns=true_ns)

    def pose(self, t_ns: int) -> Pose:
        """Find where it is at a mission time, as far as is known; roll and pitch are not."""
        fix = self._newest
        after_s = min(max((t_ns - fix.t_ns) / NS, 0.0), _CARRY_S)
        north_mps, east_mps = self._velocity
        return Pose(
            self._craft,
            fix.north_m + after_s * north_mps,
            fix.east_m + after_s * east_mps,
            fix.down_m,
            0.0,
            0.0,
            fix.heading_rad,
            fix.speed_mps,
        )
