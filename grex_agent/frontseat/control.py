"""Who has the craft: the agent, the autopilot by itself, or a person.

The adapter takes it once, before the mission, and only when it has been told to (``arm = true``). It gives it back, to
a mode that holds, when the agent is stale, the position is lost or the run is over. A mode it did not ask for is a
person's decision, or that of the autopilot: it never fights it, sends nothing, and goes on when a person sets the mode
back and arms.
"""

from typing import Literal

from grex_agent.frontseat.belief import LOST_S
from grex_agent.frontseat.commands import Answer, Command
from grex_agent.frontseat.dialect import mavlink
from grex_agent.frontseat.families.table import Family
from grex_agent.frontseat.outputs import Note, warn

#: ``position``: waits for one. ``mode``, ``arming``: asks. ``person``: waits for a person. ``steering``: the agent's
#: set-points count. ``returning``: it has left the mode because set-points failed to arrive, and comes back by itself
#: when they do. ``taken``: somebody else has it. ``holding``: given back, the agent is stale. ``lost``: asked to hold,
#: the position is lost; then ``taken``. ``released``: for good.
Phase = Literal["position", "mode", "arming", "person", "steering", "returning", "taken", "holding", "lost", "released"]

#: Refused commands are tried again after so many seconds.
_AGAIN_S = 1.0
#: A mode that is left again this soon after it was asked for has been refused after all.
_REVERSAL_S = 4.0
#: Wait for a mode that was asked for, or for one that comes back by itself.
_PATIENCE_S = 3.0
MODE, ARM, HOLD = "mode", "arm", "hold"


class Control:
    """See the module's docstring. Times are ours, seconds.

    Parameters
    ----------
    family : Family
        Modes and what proves that it holds.
    may_arm : bool
        Whether mode and arming may be asked for.
    """

    def __init__(self, family: Family, *, may_arm: bool) -> None:
        self._family = family
        self._may_arm = may_arm
        self.phase: Phase = "position"
        self.mode: int | None = None
        self.armed = False
        self.refusal = ""
        self._ask_at_s = 0.0
        self._mode_asked_s = -1e9
        self._hold_asked_s = -1e9
        self._returns_by_s = 0.0
        self._hold = 0
        self._hold_wanted = False
        self._has_steered = False
        self._told_person = False

    @property
    def obeys(self) -> bool:
        """Whether the autopilot is in the mode that obeys set-points, and armed, by its heartbeat."""
        return self.armed and self.mode == self._family.guided

    @property
    def at_rest(self) -> bool:
        """Whether it holds, by its heartbeat, or somebody else has it."""
        return self.mode != self._family.guided

    @property
    def streams(self) -> bool:
        """Whether set-points are to be sent."""
        before = self._family.streams_before and self.phase in {"mode", "arming"}
        return self.phase in {"steering", "returning"} or before

    @property
    def waits_for(self) -> str:
        """What is missing before the agent may steer, for a person."""
        name = self._family.mode_name(self._family.guided)
        return {
            "mode": f"it is not in {name} yet",
            "arming": "it is not armed yet",
            "person": f"a person has to set {name} and arm",
            "taken": f"somebody else has it; a person has to set {name} and arm",
        }.get(self.phase, "") + (f": {self.refusal}" if self.refusal and self.phase in {"mode", "arming"} else "")

    # -- what happens -------------------------------------------------------------------------------------------

    def on_heartbeat(self, mode: int, now_s: float, *, armed: bool) -> list[Note]:
        """Take mode and arming as the autopilot tells them: only this is a fact."""
        before, was_armed = self.mode, self.armed
        self.mode, self.armed = mode, armed
        notes = []
        if before is not None and (mode, armed) != (before, was_armed):
            notes.append(Note(f"the autopilot is in {self._name()}, {'armed' if armed else 'disarmed'}"))
        if self.phase == "steering" and not self.obeys:
            notes.append(self._lose(now_s, disarmed=was_armed and not armed))
        elif self.phase == "lost" and not self.obeys:
            self.phase = "taken"
        elif self.phase == "arming" and mode != self._family.guided:
            notes += self._leave_mode(now_s)
        elif self.phase == "mode" and before not in {None, mode} and mode != self._family.guided:
            notes.append(self._lose(now_s, disarmed=False))
        elif self.phase == "holding" and before != mode and mode not in {*self._family.holds, self._family.guided}:
            self.phase = "taken"
            notes.append(warn(f"somebody has set {self._name()}: the craft is left to them"))
        return notes

    def on_answer(self, answer: Answer, now_s: float, why: str) -> list[Note]:
        """Take what became of a command of `ask`.

        Parameters
        ----------
        answer : Answer
            The autopilot's.
        now_s : float
            Time.
        why : str
            What the autopilot has said in words about it; may be empty.
        """
        if answer.status == "accepted":
            return []
        self._ask_at_s = now_s + _AGAIN_S
        if answer.command.purpose == HOLD:
            self._hold = (self._hold + 1) % len(self._family.holds)
            # The next one at once; when all have been refused, later.
            self._ask_at_s = now_s if self._hold else self._ask_at_s
        words = why or ("it does not say why" if answer.result else "no answer")
        refusal = f"{answer.command.purpose} {answer.result or 'unanswered'} ({words})"
        if refusal == self.refusal:
            return []
        self.refusal = refusal
        return [warn(f"the autopilot refuses: {refusal}; it is asked again")]

    def on_reboot(self) -> None:
        """Begin anew; but once the agent has steered, only a person gives it the craft again."""
        self.mode, self.armed = None, False
        if self.phase != "released":
            self.phase = "taken" if self._has_steered else "position"
        self._ask_at_s = 0.0

    def release(self) -> None:
        """Give the craft back for good."""
        was = self.phase
        self.phase = "released"
        self._ask_at_s = 0.0
        # One that obeys and was steered would go on waiting for set-points, even if it is not steered just now.
        ours = was in {"steering", "mode", "arming", "holding"}
        self._hold_wanted = ours or (self._has_steered and self.obeys)

    @property
    def released(self) -> bool:
        """Whether it has been given back, by the autopilot's heartbeat, or was not ours."""
        return self.phase == "released" and (not self._hold_wanted or self.at_rest)

    def step(
        self, now_s: float, *, position: bool, fresh: bool, lost: bool = False
    ) -> tuple[list[Command], list[Note]]:
        """Do what is to be done now.

        Parameters
        ----------
        now_s : float
            Time.
        position : bool
            Whether the position is valid.
        fresh : bool
            Whether the agent speaks, or need not yet.
        lost : bool
            Whether the position has not been valid for long.

        Returns
        -------
        commands, notes
            What to ask of the autopilot, and what to say.
        """
        notes: list[Note] = []
        if self.phase == "released":
            return self._ask_hold(now_s), notes
        if self.phase == "steering" and lost:
            self._hand_over("lost")
            notes.append(
                warn(
                    f"no valid position for {LOST_S:g} s: the craft is handed back to its autopilot, to hold; "
                    f"set {self._guided()} to let the agent steer again"
                )
            )
        elif self.phase == "steering" and not fresh:
            self._hand_over("holding")
            notes.append(warn("the agent is silent: the craft is handed back to its autopilot, to hold"))
        elif self.phase == "holding" and fresh:
            self._take_back(now_s, notes)
        elif self.phase == "returning" and now_s > self._returns_by_s and not self.obeys:
            notes.append(self._lose(now_s, disarmed=False))
        elif self.phase not in {"steering", "holding", "lost"} and self.obeys and position and fresh:
            self._steer(notes)
        elif self.phase == "position" and position:
            self.phase = "mode" if self._may_arm else "person"
        return self._commands(now_s, notes), notes

    # -- inside -------------------------------------------------------------------------------------------------

    def _commands(self, now_s: float, notes: list[Note]) -> list[Command]:
        if self.phase in {"holding", "lost"}:
            return self._ask_hold(now_s)
        if self.phase == "mode" and self.mode == self._family.guided:
            self.phase = "arming"
        if self.phase == "person" and not self._told_person:
            self._told_person = True
            notes.append(Note(f"ready: waiting for a person to set {self._guided()} and to arm"))
        if now_s < self._ask_at_s:
            return []
        if self.phase == "mode":
            self._ask_at_s = self._mode_asked_s = now_s
            self._ask_at_s += _AGAIN_S
            return [self._mode_command(MODE, self._family.guided)]
        if self.phase == "arming" and not self.armed:
            self._ask_at_s = now_s + _AGAIN_S
            return [Command(ARM, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,))]
        return []

    def _ask_hold(self, now_s: float) -> list[Command]:
        if self.phase == "released" and not self._hold_wanted:
            return []
        if self.mode != self._family.guided or now_s < self._ask_at_s:
            return []
        self._ask_at_s, self._hold_asked_s = now_s + _AGAIN_S, now_s
        return [self._mode_command(HOLD, self._family.holds[self._hold])]

    def _mode_command(self, purpose: str, mode: int) -> Command:
        return Command(purpose, mavlink.MAV_CMD_DO_SET_MODE, self._family.mode_parameters(mode))

    def _hand_over(self, phase: Phase) -> None:
        self.phase = phase
        self._ask_at_s, self._hold = 0.0, 0

    def _steer(self, notes: list[Note]) -> None:
        self.phase = "steering"
        self._has_steered = True
        self.refusal = ""
        notes.append(Note(f"{self._guided()} and armed: the agent steers"))

    def _take_back(self, now_s: float, notes: list[Note]) -> None:
        """Take again what was held for an agent that was silent, if it was allowed to take it in the first place."""
        if self.obeys:
            # The order to hold may still be on its way.
            if now_s - self._hold_asked_s > _PATIENCE_S:
                self._steer(notes)
            return
        self._ask_at_s = now_s
        notes.append(Note("the agent speaks again"))
        if self._may_arm and self.armed and self.mode in self._family.holds:
            self.phase = "mode"
        else:
            self.phase, self._told_person = "person", False

    def _leave_mode(self, now_s: float) -> list[Note]:
        """Guided was reached and left again before arming: refused after all, or somebody's decision."""
        if now_s - self._mode_asked_s <= _REVERSAL_S:
            self.phase = "mode"
            self._ask_at_s = now_s + _AGAIN_S
            return [warn(f"the autopilot went back to {self._name()}; {self._guided()} is asked for again")]
        return [self._lose(now_s, disarmed=False)]

    def _lose(self, now_s: float, *, disarmed: bool) -> Note:
        if self.phase == "steering" and self._family.returns_by_itself and self.armed:
            self.phase, self._returns_by_s = "returning", now_s + _PATIENCE_S
            return warn(f"the autopilot has left {self._guided()} for {self._name()}")
        self.phase = "taken"
        self._ask_at_s = now_s
        what = "disarmed the craft" if disarmed else f"set {self._name()}"
        return warn(
            f"a person or the autopilot has {what}: no set-points are sent; "
            f"set {self._guided()} and arm to let the agent steer again"
        )

    def _name(self) -> str:
        return self._family.mode_name(self.mode)

    def _guided(self) -> str:
        return self._family.mode_name(self._family.guided)
