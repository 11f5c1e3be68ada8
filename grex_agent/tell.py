"""What a craft tells its mates of itself, and what it makes of what they tell."""

import msgspec

from grex_agent.manoeuvre import ManoeuvreProcessor
from grex_agent.mission import TeamPlan
from grex_agent.team.acknowledgement import Acknowledgements
from grex_agent.team.interface import Report
from grex_link import wire
from grex_link.errors import WireError
from grex_link.messages import Fix, Received
from grex_link.units import NS

#: Standard deviation of a position that a mate read from the short form: what rounding to a metre and the mate's own
#: navigation, of which the form says nothing, come to.
SHORT_SIGMA_M = 1.0
#: The same for the tiny form, which has no position: it is that of the plan, and the mate is beside it.
PLANNED_SIGMA_M = 5.0


class TeamTalk:
    """Packs the own state and reads those of the mates.

    Parameters
    ----------
    craft : str
        Whose talk it is.
    plan : TeamPlan
        Of the whole team, in its order: it holds what the shorter forms leave out.
    form : wire.Form
        How the own state goes on the air.
    acknowledgements : Acknowledgements or None
        Says what has been heard of the formation, where that is said.

    Attributes
    ----------
    bad_frames : int
        Datagrams that were no team state of a mate.
    """

    def __init__(
        self,
        craft: str,
        plan: TeamPlan,
        form: wire.Form = "full",
        acknowledgements: Acknowledgements | None = None,
    ) -> None:
        self._craft = craft
        self._plans = plan.everybody
        self._team = list(self._plans)
        self._form = form
        self._acknowledgements = acknowledgements
        self.bad_frames = 0

    def state(self, fix: Fix, processor: ManoeuvreProcessor, speed_mps: float) -> wire.TeamState:
        """Put together what is told: a fix, the place in the plan, the speed over ground, and what has been heard."""
        t_s = fix.t_ns / NS
        heard = 0 if self._acknowledgements is None else self._acknowledgements.flags(t_s)
        return wire.TeamState(
            source=self._team.index(self._craft),
            t_s=t_s,
            north_m=fix.north_m,
            east_m=fix.east_m,
            depth_m=fix.down_m,
            speed_mps=speed_mps,
            heading_rad=fix.heading_rad,
            track=processor.number,
            theta=processor.place.theta,
            sigma_m=fix.sigma_m,
            flags=wire.NAVIGATION_VALID | heard,
        )

    def pack(self, state: wire.TeamState, form: wire.Form | None = None) -> tuple[bytes, wire.TeamState]:
        """Pack the own state: what goes on the air, and what the mates will read.

        Raises
        ------
        WireError
            If it cannot be told.
        """
        payload = wire.pack(state, form or self._form)
        return payload, self._completed(self._craft, wire.unpack(payload, state.t_s))

    def read(self, event: Received, now_s: float) -> Report | None:
        """Read what was heard; None, and counted, if it is no team state of a mate."""
        try:
            state = wire.unpack(event.payload, now_s)
            place = self._team.index(event.source)
        except (WireError, ValueError):
            self.bad_frames += 1
            return None
        tracks = self._plans[event.source].tracks
        if event.source == self._craft or place % 16 != state.source or state.track >= len(tracks):
            self.bad_frames += 1
            return None
        if state.t_s > now_s:
            # The mate's clock is ahead of ours. It cannot be from the future, so it counts as of now.
            state = msgspec.structs.replace(state, t_s=now_s)
        if self._acknowledgements is not None:
            self._acknowledgements.hear(event.source, state.t_s)
        return Report(event.source, self._completed(event.source, state))

    def _completed(self, craft: str, state: wire.TeamState) -> wire.TeamState:
        """Fill in from the plan what a form has left out: there a craft at that Θ would be, so deep and so fast."""
        if state.form == "full":
            return state
        track = self._plans[craft].tracks[state.track]
        planned = track.point(state.theta)
        told = state.form == "short"
        north, east = (state.north_m, state.east_m) if told else planned
        return msgspec.structs.replace(
            state,
            north_m=north,
            east_m=east,
            depth_m=track.depth_m,
            speed_mps=track.speed_mps,
            heading_rad=track.locate(*planned).course_rad,
            sigma_m=SHORT_SIGMA_M if told else PLANNED_SIGMA_M,
        )
