"""What a modem hears besides other modems: the sea, the craft it is on, and jammers."""

from collections.abc import Callable
from functools import partial

from grex_link.config import Scenario, SelfNoiseConfig
from grex_link.link_config import JammerConfig
from grex_link.messages import Truth
from grex_link.propagation import Propagation
from grex_link.sound_field import OTHER, SoundField, power
from grex_link.units import NS

#: A jammer's level is computed anew this often, because the craft move.
_STEP_NS = NS
_JAMMER = -1  # stands for the source in keys


class NoiseSources:
    """Keeps the noise at every node of a field up to date.

    Parameters
    ----------
    scenario : Scenario
        Jammers and the craft's own noise.
    field : SoundField
        Where the noise is heard.
    propagation : Propagation
        The way from a jammer to the nodes.
    ambient : int
        Power of the noise of the sea.
    """

    def __init__(self, scenario: Scenario, field: SoundField, propagation: Propagation, ambient: int) -> None:
        self._field = field
        self._propagation = propagation
        self._ambient = ambient
        self._craft = [config.self_noise for config in scenario.craft.values()]
        self._own = [0] * len(self._craft)
        self._jammed = [[0] * len(scenario.link.jammers) for _ in self._craft]
        for number, jammer in enumerate(scenario.link.jammers):
            if jammer.end_s > jammer.start_s:
                step = partial(self._jam, jammer, number)
                field.at(round(jammer.start_s * NS), OTHER, (_JAMMER, number, 0, 0), step)

    def place(self, truth: Truth) -> None:
        """Take note of the craft's speeds."""
        for node, pose in enumerate(truth.poses):
            config = self._craft[node]
            if config is not None:
                self._own[node] = self_noise(config, pose.surge_mps)
                self._set(node, truth.t_ns)

    def _set(self, node: int, t_ns: int) -> None:
        self._field.set_noise(node, self._ambient + self._own[node] + sum(self._jammed[node]), t_ns)

    def _jam(self, jammer: JammerConfig, number: int, t_ns: int) -> None:
        """Have a jammer's present level, or its end, arrive at every node."""
        end_ns = round(jammer.end_s * NS)
        over = t_ns >= end_ns
        delays_ns, losses_db = self._propagation.from_point(jammer.position_ned_m, t_ns)
        for node, (delay_ns, loss_db) in enumerate(zip(delays_ns, losses_db, strict=True)):
            strength = 0 if over else power(jammer.source_level_db - loss_db)
            arrive: Callable[[int], None] = partial(self._hear, node, number, strength)
            self._field.at(t_ns + delay_ns, OTHER, (_JAMMER, number, 0, node), arrive)
        if not over:
            again = partial(self._jam, jammer, number)
            self._field.at(min(t_ns + _STEP_NS, end_ns), OTHER, (_JAMMER, number, 0, 0), again)

    def _hear(self, node: int, number: int, strength: int, t_ns: int) -> None:
        self._jammed[node][number] = strength
        self._set(node, t_ns)


def self_noise(config: SelfNoiseConfig, speed_mps: float) -> int:
    """Power of a craft's own noise at a speed; a speed that is no number counts as none."""
    level_db = config.level_db + config.slope_db_per_mps * abs(speed_mps)
    return power(min(level_db, 250.0)) if level_db == level_db else power(config.level_db)  # noqa: PLR0124 - not NaN
