"""A simulated autopilot: messages and time go in, messages come out. It reads no clock and opens nothing.

Start, life and end of one: `Body` outlives reboots, `Brain` is one start. Time is the autopilot's own, in seconds since
its process began; everything on the link counts from the last start.
"""

import math

from grex_sim.autopilot import telemetry
from grex_sim.autopilot.brain import Body, Brain, Settings
from grex_sim.autopilot.craft import STEP_S
from grex_sim.autopilot.hearing import hear
from grex_sim.autopilot.message import Message, Out, Severity, whole

#: FS_EKF_ACTION of an ArduPilot: change the mode; 2 only reports.
_HOLD = 1


class Autopilot:
    """One simulated autopilot with its craft.

    Parameters
    ----------
    settings : Settings
        Everything a user chooses.

    Attributes
    ----------
    brain : Brain
        Its present start.
    log : list of str
        What happened, for people; whoever prints it empties it.
    """

    def __init__(self, settings: Settings) -> None:
        self._body = Body(settings)
        self._steps = 0
        self.log: list[str] = []
        self.brain = self._start(0.0)

    def heard(self, message: Message, link: int, now_s: float) -> None:
        """Take a message that came over a link.

        Parameters
        ----------
        message : Message
            With the sender's ids.
        link : int
            Number of the link, from 0.
        now_s : float
            Autopilot time.
        """
        if self._body.faults.hears(now_s):
            before = self.brain.modes.mode
            hear(self.brain, message, link, now_s)
            self._note_mode(before.name, f"by {message.system}/{message.component}", now_s)

    def step(self, now_s: float) -> list[Out]:
        """Go on to a time and return what goes out until then, in order."""
        out: list[Out] = []
        while (self._steps + 1) * STEP_S <= now_s + 1e-9:
            self._steps += 1
            out += self._tick(self._steps * STEP_S)
        return out

    # -- one tick -----------------------------------------------------------------------------------------------

    def _tick(self, now_s: float) -> list[Out]:
        self._happen(now_s)
        if now_s >= self.brain.reboot_at_s:
            self.brain = self._start(now_s)
        brain = self.brain
        before = brain.modes.mode.name
        self._live(brain, now_s)
        self._note_mode(before, "by itself", now_s)
        self._tell(brain, now_s)
        return list(self._body.faults.outgoing(self._body.outbox.due(now_s), now_s))

    def _start(self, now_s: float) -> Brain:
        self.log.append(f"{now_s:8.2f} s  starts")
        brain = Brain(self._body, now_s)
        for at_s, line in brain.boot.console():
            brain.outbox.put(at_s, line)
        return brain

    def _live(self, brain: Brain, now_s: float) -> None:
        family, craft = brain.family, brain.craft
        text = brain.modes.step(now_s)
        if text:
            brain.text(text, now_s)
        self._limits(brain)
        drive, text, leave = brain.control.step(brain.modes.mode, brain.pose, abs(craft.truth.surge_mps), now_s)
        if text:
            brain.text(text, now_s)
        self._offboard(brain, now_s, leave=leave)
        craft.step(drive, armed=brain.modes.armed)
        satellites = telemetry.satellites(brain) and not self._body.faults.value("gps", now_s)
        had_origin = brain.estimator.origin is not None
        for said in brain.estimator.step(craft.truth, craft.velocity, satellites, now_s):
            if family.autopilot == 3:
                brain.text(said, now_s, Severity.INFO)
        if brain.estimator.origin is not None and not had_origin and brain.home is None:
            pose = brain.pose
            brain.home = pose.north_m, pose.east_m, pose.down_m
        self._failsafes(brain, now_s)

    def _limits(self, brain: Brain) -> None:
        family, parameters = brain.family, brain.parameters
        limits = [parameters.get(name, math.inf) for name in family.speed_parameters]
        brain.craft.speed_max_mps = min((limit for limit in limits if limit > 0.0), default=math.inf)
        brain.control.timeout_s = parameters.get("COM_OF_LOSS_T", family.setpoints.timeout_s)

    def _offboard(self, brain: Brain, now_s: float, *, leave: bool) -> None:
        """Leave the guided mode for want of set-points, and go back to it when they come again (PX4)."""
        if leave and brain.modes.armed:
            brain.control.left = True
            brain.modes.force(brain.family.hold)
        elif brain.control.left and brain.control.streamed(now_s):
            brain.control.left = False
            brain.modes.force(brain.family.guided)

    def _failsafes(self, brain: Brain, now_s: float) -> None:
        loss, lost_s = brain.family.loss, brain.estimator.lost_for
        brain.critical = brain.critical and not brain.estimator.aiding
        if loss.failsafe_s is not None and lost_s is not None and brain.estimator.lies and not brain.critical:
            self._position_lost(brain, now_s - lost_s, now_s)
        action = brain.gcs.step(now_s)
        if action:
            self._station_lost(brain, action, now_s)

    def _station_lost(self, brain: Brain, action: str, now_s: float) -> None:
        if brain.family.gcs is not None and brain.family.gcs.lost_text:
            brain.text(brain.family.gcs.lost_text, now_s)
        possible = action != "disarm" and (brain.estimator.aiding or not brain.family.known(action).needs_position)
        if not possible:
            # As on a real one: what cannot be done is replaced by disarming.
            brain.modes.disarm()
        elif brain.modes.armed:
            brain.modes.force(action)

    def _position_lost(self, brain: Brain, for_s: float, now_s: float) -> None:
        loss = brain.family.loss
        if loss.failsafe_s is None or for_s < loss.failsafe_s:
            return
        mode, action = brain.modes.mode, int(brain.parameters.get("FS_EKF_ACTION", _HOLD))
        if not brain.modes.armed or not (mode.needs_position or mode.kind == "guided") or not action:
            return
        brain.critical = True
        if loss.failsafe_text:
            brain.text(loss.failsafe_text, now_s, Severity.CRITICAL)
        if action == _HOLD:
            brain.modes.force(loss.failsafe_mode)

    # -- faults and telling -------------------------------------------------------------------------------------

    def _happen(self, now_s: float) -> None:
        for kind, value in self._body.faults.happening(now_s):
            self.log.append(f"{now_s:8.2f} s  fault: {kind}")
            if kind == "reboot":
                self.brain.reboot_at_s = now_s
            elif kind == "disarm":
                self.brain.modes.disarm()
            else:
                self._pilot(value, now_s)

    def _pilot(self, wanted: float | str, now_s: float) -> None:
        family = self.brain.family
        mode = family.named(wanted) if isinstance(wanted, str) else family.mode(whole(wanted))
        before = self.brain.modes.mode.name
        self.brain.modes.force((mode or family.known(family.hold)).name)
        self.brain.control.left = False
        self._note_mode(before, "by a pilot", now_s)

    def _tell(self, brain: Brain, now_s: float) -> None:
        if not brain.boot.talks(now_s):
            return
        for link, streams in enumerate(brain.streams):
            for name in streams.due(now_s):
                fields = telemetry.build(brain, name, now_s)
                if fields is not None:
                    brain.say(name, fields, link, now_s)

    def _note_mode(self, before: str, who: str, now_s: float) -> None:
        after = self.brain.modes.mode.name
        if after != before:
            self.log.append(f"{now_s:8.2f} s  {before} -> {after} {who}")
