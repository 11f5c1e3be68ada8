"""The failsafe of the ground station's heartbeat, in autopilot time. A station never seen never fails."""

from grex_sim.autopilot.family import GcsRules
from grex_sim.autopilot.message import Message
from grex_sim.autopilot.parameters import Parameters

_TIMEOUT_S = 5.0


class GcsFailsafe:
    """Watches for heartbeats of one system id.

    Parameters
    ----------
    rules : GcsRules or None
        None: there is no such failsafe.
    parameters : Parameters
        Where it is enabled, and whose heartbeat counts.
    """

    def __init__(self, rules: GcsRules | None, parameters: Parameters) -> None:
        self._rules, self._parameters = rules, parameters
        self._heard_s: float | None = None
        self.lost = False

    def on_heartbeat(self, message: Message, now_s: float) -> str:
        """Count a heartbeat if it is from the ground station; returns a text if that ends a loss."""
        if message.system != int(self._parameters.get("SYSID_MYGCS", 255)):
            return ""
        self._heard_s = now_s
        back, self.lost = self.lost, False
        return self._rules.back_text if back and self._rules else ""

    def step(self, now_s: float) -> str:
        """Return what to do if the station is lost just now – a mode's name, or ``disarm`` –, otherwise nothing."""
        if self._rules is None or self._heard_s is None or self.lost:
            return ""
        action = dict(self._rules.actions).get(int(self._parameters.get(self._rules.enable)), "")
        if not action:
            return ""
        name = self._rules.timeout
        timeout_s = _TIMEOUT_S if name is None else self._parameters.get(name, _TIMEOUT_S)
        self.lost = now_s - self._heard_s > timeout_s + self._rules.extra_s
        return action if self.lost else ""
