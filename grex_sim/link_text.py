"""What ``grex check`` says of the link: who speaks when, how old news gets, and what clocks and modem do to it."""

import math
from collections.abc import Iterator

from grex_agent.capabilities import heard_up_to_m, state_form
from grex_agent.closest import closest_approach
from grex_agent.mission import TeamPlan, planned_places, range_max_m
from grex_link.config import CraftClockConfig, Scenario
from grex_link.link_config import Tdma
from grex_link.mac import Mac, PureAlohaMac, SlottedAlohaMac, plan_mac, slot_needs
from grex_link.profile import ModemProfile
from grex_link.tdma import Schedule, SlotNeeds
from grex_link.units import NS
from grex_link.wire import BYTES, Form
from grex_sim.layout import entry, table

_CONTENT: dict[Form, str] = {
    "full": "time, position, depth, speed, heading, track, Θ, sigma",
    "short": "time, position, track, Θ; the rest is taken from the plan",
    "tiny": "time, track, Θ; the position is taken from the plan",
}


class LinkText:
    """The link of a scenario in words.

    Parameters
    ----------
    scenario : Scenario
        What was asked for.
    plan : TeamPlan
        What was planned for it.
    profile : ModemProfile
        The modem of all.

    Raises
    ------
    ConfigError
        If the slots cannot work.
    """

    def __init__(self, scenario: Scenario, plan: TeamPlan, profile: ModemProfile) -> None:
        self._scenario = scenario
        self._plan = plan
        self._profile = profile
        self._many = len(scenario.craft) > 1
        self._form = state_form(scenario, profile)
        self._planned_m = 0.0 if profile.one_speaker_at_a_time else range_max_m(plan)
        self._size = BYTES[self._form]
        self._mac: Mac = plan_mac(scenario, self._planned_m, self._size)
        self._needs: SlotNeeds = slot_needs(scenario, self._planned_m, self._size)
        self._airtime_s = profile.airtime_ns(self._size) / NS

    def access(self) -> Iterator[str]:
        """Say who may speak when."""
        mac = self._mac
        if isinstance(mac, Schedule):
            yield from _slots(mac)
        elif isinstance(mac, SlottedAlohaMac):
            yield f"Slotted Aloha (slot C = {mac.slot_ns / NS:g} s from mission time 0)"
            yield from entry("Rate", f"every craft speaks in {mac.probability:.3g} of the slots, at random")
        elif isinstance(mac, PureAlohaMac):
            yield "Pure Aloha"
            yield from entry("Rate", f"every craft speaks {mac.rate_per_s:g} times a second on average, at random")
        if not self._profile.one_speaker_at_a_time:
            if self._many and not isinstance(mac, Schedule):
                yield from entry("Success", self._success_text())
            if not isinstance(mac, PureAlohaMac):
                yield from entry("Guard", self._guard_text())
            yield from entry("Distance", self._distance_text())

    def message(self) -> Iterator[str]:
        """Say what is told, and how old it gets."""
        loss = self._scenario.link.loss
        yield from entry("Message", f"{self._size} bytes, airtime T = {self._airtime_s:g} s, lost with p = {loss:g}")
        yield from entry("Form", f"{self._form}: {_CONTENT[self._form]}")
        if self._many and (isinstance(self._mac, Schedule) or not self._profile.one_speaker_at_a_time):
            yield from self._ages()
            yield from self._separation()
        yield from self._clocks()
        yield from self._land()

    # -- access -------------------------------------------------------------------------------------------------

    def _guard_text(self) -> str:
        needs = self._needs
        profile = self._profile
        turnaround_s = profile.decode_latency_s + profile.turnaround_s
        kept_s = self._mac.guard_ns / NS if isinstance(self._mac, Schedule) else needs.guard_s
        text = (
            f"{kept_s:.3f} s; needed: {needs.guard_s:.3f} s = {needs.reach_m / needs.sound_speed_mps:.3f} s for "
            f"{needs.reach_m:.0f} m at {needs.sound_speed_mps:g} m/s + 2·{needs.clock_error_s:g} s for clocks + "
            f"{turnaround_s:.3g} s for decoding and turnaround + {needs.jitter_s:g} s for jitter"
        )
        return text if kept_s >= needs.guard_s - 1e-3 else f"{text}: a team that is apart will collide"

    def _distance_text(self) -> str:
        most_m = heard_up_to_m(self._profile)
        text = (
            f"at most {self._planned_m:.1f} m between two craft by the plan, on which sound takes "
            f"τ = {self._needs.delay_s:.3f} s"
        )
        if most_m is not None and most_m < self._planned_m:
            text += f"; WARNING: this modem is not heard beyond {most_m:g} m"
        return text

    def _success_text(self) -> str:
        others = len(self._scenario.craft) - 1
        law = "(1 - p)^(N - 1)" if isinstance(self._mac, SlottedAlohaMac) else "[e^(-λT)/(1 + λT)]^(N - 1)"
        return (
            f"{self._success():.3f} of the messages meet no other one and a mate that listens: {law}, "
            f"N = {others + 1}; more where the nearer craft is the louder one, or sound takes longer than a message"
        )

    def _success(self) -> float:
        """Share of messages that a mate hears, as far as access goes (acoustic-link, section 6)."""
        others = len(self._scenario.craft) - 1
        if isinstance(self._mac, SlottedAlohaMac):
            return (1.0 - self._mac.probability) ** others
        if isinstance(self._mac, PureAlohaMac):
            load = self._mac.rate_per_s * self._airtime_s
            return (math.exp(-load) / (1.0 + load)) ** others
        return 1.0

    # -- age ----------------------------------------------------------------------------------------------------

    def _ages(self) -> Iterator[str]:
        by_age: dict[str, list[str]] = {}
        for craft in self._scenario.formation:
            by_age.setdefault(f"{self._age_s(craft):.1f}", []).append(craft)
        for age_s, team in by_age.items():
            if age_s == "inf":
                yield from entry("Never heard", ", ".join(team))
            else:
                formula = " + ".join([*self._delays(), self._waiting(team[0])])
                yield from entry("Mean age", f"{age_s} s = {formula}, of what the mates know of {', '.join(team)}")

    def _separation(self) -> Iterator[str]:
        """Say what the guard that keeps craft apart has room for: a mate slows down unnoticed until it is heard."""
        least_m, nearest = self._scenario.team.separation_min_m, closest_approach(planned_places(self._plan))
        if least_m is None or nearest is None:
            return
        unheard_s = self._mac.interval_ns / NS + sum(self._delays().values())
        room_m = max(nearest.distance_m - least_m, 0.0)
        yield from entry(
            "Separation",
            f"{least_m:g} m, of {nearest.distance_m:.1f} m planned at the nearest: in one lane, the craft ahead may "
            f"lose {room_m / unheard_s:.2f} m/s in the {unheard_s:.1f} s from one message to the arrival of the next",
        )

    def _delays(self) -> dict[str, float]:
        """Parts of the delay from the sampling of a state until a mate has it, seconds, by their symbols."""
        profile = self._profile
        parts = {
            "latency": profile.transmit_latency_s,
            "T": self._airtime_s,
            "τ": self._needs.delay_s,
            "decoding": profile.decode_latency_s,
        }
        return {symbol: seconds for symbol, seconds in parts.items() if seconds}

    def _age_s(self, craft: str) -> float:
        delay_s, loss, mac = sum(self._delays().values()), self._scenario.link.loss, self._mac
        if isinstance(mac, Schedule):
            return age_of_information_s(mac, craft, delay_s, loss)
        heard = self._success() * (1.0 - loss)
        if not heard:
            return math.inf
        if isinstance(mac, SlottedAlohaMac):
            return delay_s + mac.slot_ns / NS * (1.0 / (heard * mac.probability) - 0.5)
        rate_per_s = self._rate_per_s()
        return delay_s + 1.0 / (heard * rate_per_s)

    def _rate_per_s(self) -> float:
        """Messages a second of a craft that speaks at random, but not while it speaks already."""
        rate_per_s = self._mac.rate_per_s if isinstance(self._mac, PureAlohaMac) else 0.0
        return rate_per_s / (1.0 + rate_per_s * self._airtime_s)

    def _waiting(self, craft: str) -> str:
        mac, loss = self._mac, self._scenario.link.loss
        if isinstance(mac, SlottedAlohaMac):
            return "C·(1/s - 1/2) with the share s of slots in which it is heard"
        if isinstance(mac, PureAlohaMac):
            return "mean time between two that are heard"
        if sum(slot.craft == craft for slot in mac.slots) > 1 if isinstance(mac, Schedule) else False:
            return "mean time since the opening of the last slot heard"
        return f"C·(1/(1 - {loss:g}) - 1/2)" if loss else "C/2"

    # -- clocks and land ----------------------------------------------------------------------------------------

    def _clocks(self) -> Iterator[str]:
        for craft, config in self._scenario.craft.items():
            if config.clock.offset_s or config.clock.drift_ppm:
                yield from entry("Clock", f"{craft}: {self._clock(config.clock)}")

    def _clock(self, clock: CraftClockConfig) -> str:
        text = f"{clock.offset_s:+g} s, drifts by {clock.drift_ppm:+g} ppm"
        if clock.gps_at_surface:
            text += f", set by GPS above {clock.surface_depth_m:g} m of depth"
        mac = self._scenario.link.mac
        if not isinstance(mac, Tdma) or self._profile.one_speaker_at_a_time:
            return text
        limit_s = mac.clock_error_s
        towards_s = limit_s - math.copysign(clock.offset_s, clock.offset_s * clock.drift_ppm)
        if abs(clock.offset_s) > limit_s:
            return f"{text}; at once off by more than the clock_error_s = {limit_s:g} s the guard is for"
        if clock.drift_ppm:
            after_s = towards_s / (abs(clock.drift_ppm) * 1e-6)
            return f"{text}; off by more than the clock_error_s = {limit_s:g} s the guard is for after {after_s:.0f} s"
        return text

    def _land(self) -> Iterator[str]:
        for land in self._scenario.link.land:
            one, other = land.between
            yield from entry(
                "Land",
                f"{one} and {other} by {land.kind} every {land.every_s:g} s, latency {land.latency_s:g} s, "
                f"{land.rate_bps:g} bit/s, lost with p = {land.loss:g}",
            )


def age_of_information_s(schedule: Schedule, craft: str, airtime_s: float, loss: float = 0.0) -> float:
    """Mean age of what the mates know of a craft: T + C/2 for one slot in a cycle and no loss.

    A state is sampled when a slot opens and known T later, until the next one arrives. With the gaps g_i between a
    craft's n openings and the probability q of loss the mean is T + Σ g_i/C·[g_i/2 + Σ_j q^j g_(i-j) / (1 - q^n)].

    Parameters
    ----------
    schedule : Schedule
        The slots.
    craft : str
        Whose state it is.
    airtime_s : float
        T, seconds.
    loss : float
        q.

    Returns
    -------
    float
        Seconds; infinite for a craft that is never heard.
    """
    opens = sorted(slot.start_ns / NS for slot in schedule.slots if slot.craft == craft)
    if not opens or loss >= 1.0:
        return math.inf
    count, cycle_s = len(opens), schedule.cycle_ns / NS
    gaps = [later - earlier for earlier, later in zip(opens, [*opens[1:], opens[0] + cycle_s], strict=True)]
    age_s = airtime_s
    for place, gap in enumerate(gaps):
        missed = sum(loss**back * gaps[place - back] for back in range(1, count + 1)) / (1.0 - loss**count)
        age_s += gap / cycle_s * (gap / 2.0 + missed)
    return age_s


def _slots(schedule: Schedule) -> Iterator[str]:
    on_air_ns = sum(slot.length_ns for slot in schedule.slots)
    yield (
        f"TDMA schedule (cycle C = {schedule.cycle_ns / NS:g} s from mission time 0; "
        f"{on_air_ns / schedule.cycle_ns:.0%} of it in slots)"
    )
    in_order = sorted(schedule.slots, key=lambda slot: slot.start_ns)
    rows = [(slot.craft, f"{slot.start_ns / NS:g}", f"{slot.length_ns / NS:g}") for slot in in_order]
    yield from table(("craft", "start s", "length s"), rows, left=1)
