"""The acoustic medium: modems that share the water, each with its own ears (acoustic-link §3).

The physics of a packet – delay, level, lock, interference – is the `SoundField`'s. What a whole packet is worth, whom
it is for, and what the modems say of it is decided here.
"""

import heapq
from functools import partial
from itertools import count

from grex_link.acoustics import Water
from grex_link.channel_loss import ChannelLoss
from grex_link.config import Scenario
from grex_link.craft_clock import TeamClocks
from grex_link.hearing import Hearing
from grex_link.medium import Due
from grex_link.messages import (
    BadFrame,
    Happening,
    LinkEvent,
    ModemStatus,
    RangeRequest,
    RangeResult,
    Received,
    Request,
    Truth,
    TxEvent,
)
from grex_link.modem_rules import refusal
from grex_link.noise_sources import NoiseSources
from grex_link.packet import Draws, Packet, Purpose
from grex_link.profile import ModemProfile
from grex_link.propagation import Propagation, Shadowing
from grex_link.range_measurement import RangeMeasurement
from grex_link.sound_field import OTHER, SEND, Key, Sound, SoundField, power, ratio_db
from grex_link.units import NS

#: An answer is waited for as if it came from this far away, unless the profile says that the modem reaches less far.
_ANSWER_RANGE_M = 5000.0
_SLOWEST_MPS = 1400.0


class AcousticMedium:
    """See the module's docstring and `Medium`.

    Parameters
    ----------
    scenario : Scenario
        Team, water, losses, jammers, outages, clocks and seed.
    profile : ModemProfile
        Everybody's modem.
    """

    def __init__(self, scenario: Scenario, profile: ModemProfile) -> None:
        link = scenario.link
        self._profile = profile
        self._names = list(scenario.craft)
        self._places = {craft: place for place, craft in enumerate(self._names)}
        self._clocks = TeamClocks(scenario)
        self._team_clocks = list(self._clocks.craft.values())
        draws = Draws(scenario.link_seed, self._names)
        self._hearing = Hearing(profile, ChannelLoss(link, scenario.link_seed), draws, self._names)
        self._measurement = RangeMeasurement(profile, link.ranging, link.water.nominal_sound_speed_mps, draws)
        water = Water(
            link.water,
            profile.frequency_hz or 1.0,
            profile.bandwidth_hz or 1.0,
            spreading=profile.spreading,
            noise_psd_db=profile.noise_psd_db,
        )
        shadowing = Shadowing(link.shadowing, scenario.link_seed, self._names) if link.shadowing else None
        nowhere = [(0.0, 0.0, 0.0)] * len(self._names)
        self._propagation = Propagation(water, profile.source_level_db or 0.0, nowhere, shadowing)
        ambient = power(self._hearing.noise_db(water.noise_db))
        self._field = SoundField(len(self._names), ambient, self._hearing.lock_sinr_db, self)
        self._noise = NoiseSources(scenario, self._field, self._propagation, ambient)
        self._decode_ns = round(profile.decode_latency_s * NS)
        self._upcoming: list[tuple[int, int]] = []
        self._on_air: list[Sound | None] = [None] * len(self._names)
        self._waiting: dict[tuple[int, int], tuple[Packet, int]] = {}
        self._off_ns = [-(2**62)] * len(self._names)  # when a modem last went off
        self._order = count()
        self._events: list[tuple[int, int, Key, int, Due]] = []
        self._lines: list[LinkEvent] = []
        # An own transmission spoils at once what is just being heard: nothing is certain in advance.
        self.lookahead_ns = 0
        for number, outage in enumerate(link.outages):
            node = self._places[outage.craft]
            for when_s, switch in ((outage.start_s, self._switch_off), (outage.end_s, self._switch_on)):
                self._field.at(round(when_s * NS), OTHER, (node, number, 2, 0), partial(switch, node))

    @property
    def bad_positions(self) -> int:
        """How many positions were no numbers; such a node is taken to go straight on."""
        return self._propagation.bad_positions

    # -- Medium -------------------------------------------------------------------------------------------------

    def place(self, truth: Truth) -> None:
        """Take note of the true poses at a time."""
        self._clocks.see(truth)
        self._propagation.place(truth.t_ns, [(pose.north_m, pose.east_m, pose.down_m) for pose in truth.poses])
        self._noise.place(truth)

    def request(self, source: str, request: Request, start_ns: int) -> None:
        """Accept a request for a true time."""
        node = self._places[source]
        begin_ns = max(start_ns, self._field.now_ns) + round(self._profile.transmit_latency_s * NS)
        self._upcoming.append((node, begin_ns))
        self._field.at(begin_ns, SEND, (node, request.seq, 0, 0), partial(self._begin, node, request))

    def advance(self, until_ns: int) -> None:
        """Work through everything before a time."""
        if self._upcoming:
            self._propagation.prepare([send for send in self._upcoming if send[1] < until_ns])
            self._upcoming = [send for send in self._upcoming if send[1] >= until_ns]
        self._field.advance(until_ns)

    def events(self, before_ns: int) -> list[Due]:
        """Take the modem events before a time."""
        taken = []
        while self._events and self._events[0][0] < before_ns:
            taken.append(heapq.heappop(self._events)[-1])
        return taken

    def log(self, before_ns: int) -> list[LinkEvent]:
        """Take the log lines before a time; nothing later has been worked through."""
        del before_ns
        lines, self._lines = self._lines, []
        return lines

    def next_event_ns(self) -> int | None:
        """Next time at which anything happens."""
        times = [self._events[0][0]] if self._events else []
        if (field_ns := self._field.next_ns()) is not None:
            times.append(field_ns)
        return min(times, default=None)

    # -- sending ------------------------------------------------------------------------------------------------

    def _begin(self, node: int, request: Request, t_ns: int) -> None:
        packet = self._packet(node, request)
        reason = self._refusal(node, request, t_ns)
        if reason:
            self._note(t_ns, "refused", packet, "", reason)
            self._announce(t_ns, node, packet.key, TxEvent(request.seq, "FAILED", reason))
            return
        sound = self._emit(packet, t_ns)
        end_ns = t_ns + sound.airtime_ns
        self._field.at(end_ns, OTHER, packet.key, partial(self._end_transmission, sound))
        if packet.purpose == "ping" or packet.acknowledge:
            self._waiting[node, packet.seq] = packet, t_ns
            self._field.at(end_ns + self._patience_ns(), OTHER, packet.key, partial(self._give_up, packet))

    def _packet(self, node: int, request: Request) -> Packet:
        destination = self._places.get(request.destination)
        if isinstance(request, RangeRequest):
            return Packet(
                self._names, node, request.seq, "ping", self._profile.ranging.ping_bytes, destination=destination
            )
        return Packet(self._names, node, request.seq, "data", len(request.payload), request.payload, destination,
                      acknowledge=request.acknowledge)  # fmt: skip

    def _refusal(self, node: int, request: Request, t_ns: int) -> str:
        if self._field.off[node]:
            return "off"
        reason = refusal(self._profile, request, self._names[node], self._places)
        return reason or ("busy" if t_ns < self._field.deaf_until_ns[node] else "")

    def _emit(self, packet: Packet, t_ns: int) -> Sound:
        paths = self._propagation.paths(packet.source, t_ns)
        paths, audible = self._hearing.paths(packet, paths)
        airtime_ns = (
            self._profile.airtime_ns(packet.size) if packet.purpose == "data" else self._profile.ping_airtime_ns
        )
        sound = Sound(packet.key, t_ns, airtime_ns, paths, audible, packet)
        packet.clock_error_ns = self._team_clocks[packet.source].error_ns(t_ns)
        self._note(t_ns, "started", packet, lasting_ns=airtime_ns)
        self._on_air[packet.source] = sound
        self._field.send(packet.source, sound, round(self._profile.turnaround_s * NS))
        return sound

    def _end_transmission(self, sound: Sound, t_ns: int) -> None:
        packet: Packet = sound.content
        if not sound.cut and packet.purpose == "data":
            self._announce(t_ns, packet.source, packet.key, TxEvent(packet.seq, "SENT"))

    # -- hearing ------------------------------------------------------------------------------------------------

    def missed(self, t_ns: int, sound: Sound, index: int, reason: str, others: int) -> None:
        """See `Listener`."""
        del others
        packet: Packet = sound.content
        self._lines.append(
            LinkEvent(t_ns, "lost", packet.name, packet.seq, self._names[sound.receivers[index]], packet.size, reason,
                      packet.purpose, packet.asked_by))  # fmt: skip

    def decide(self, t_ns: int, sound: Sound, index: int, others: int) -> None:
        """See `Listener`."""
        packet: Packet = sound.content
        node = sound.receivers[index]
        sinr_db = ratio_db(sound.power[index], others)
        noise = self._field.noise(node)
        reason = "lost_cut" if sound.cut else self._hearing.loss_reason(sound, index, others, noise, t_ns)
        if not reason:
            hear = partial(self._hear, sound, index, sinr_db)
            self._field.at(t_ns + self._decode_ns, OTHER, packet.key, hear)
            return
        self._note(t_ns, "lost", packet, self._names[node], reason, sinr_db=sinr_db)
        # Which packet it was is known to nobody who could not read it.
        self._field.at(t_ns + self._decode_ns, OTHER, packet.key, partial(self._garbled, packet, node))

    def _garbled(self, packet: Packet, node: int, t_ns: int) -> None:
        if self._off_ns[node] < t_ns - self._decode_ns:
            self._announce(t_ns, node, packet.key, BadFrame())

    def _hear(self, sound: Sound, index: int, sinr_db: float, t_ns: int) -> None:
        packet: Packet = sound.content
        node = sound.receivers[index]
        kind = "delivered" if packet.is_for(node) else "overheard"
        if self._off_ns[node] >= t_ns - self._decode_ns:
            self._note(t_ns, "lost", packet, self._names[node], "aborted_off", sinr_db=sinr_db)
            return
        self._note(t_ns, kind, packet, self._names[node], lasting_ns=t_ns - sound.start_ns, sinr_db=sinr_db)
        if kind == "overheard":
            return
        if packet.purpose == "data":
            self._announce(t_ns, node, packet.key, self._received(sound, index, sinr_db))
            if packet.acknowledge:
                self._answer_with("ack", node, packet, t_ns)
        elif packet.purpose == "ping":
            self._answer_with("answer", node, packet, t_ns)
        else:
            self._answered(node, packet, t_ns)

    def _received(self, sound: Sound, index: int, sinr_db: float) -> Received:
        packet: Packet = sound.content
        node, delay_ns = sound.receivers[index], sound.delay_ns[index]
        return Received(
            packet.name,
            packet.payload,
            "" if packet.destination is None else self._names[packet.destination],
            rssi_db=round(float(sound.level_db[index]), 3),
            snr_db=round(sinr_db, 3),
            relative_speed_mps=round(self._propagation.closing_mps(packet.source, node, sound.start_ns), 3),
            one_way_s=self._measurement.one_way_s(packet, node, sound.start_ns, delay_ns, self._team_clocks),
        )

    # -- answers ------------------------------------------------------------------------------------------------

    def _answer_with(self, purpose: Purpose, node: int, packet: Packet, t_ns: int) -> None:
        """Have a modem answer by itself, a fixed time after it has heard the question."""
        size = self._profile.ranging.ping_bytes
        answer = Packet(self._names, node, packet.seq, purpose, size, destination=packet.source, asker=packet.source)
        reply_ns = round(self._profile.ranging.reply_s * NS)
        self._field.at(t_ns + reply_ns, SEND, answer.key, partial(self._begin_answer, answer))

    def _begin_answer(self, answer: Packet, t_ns: int) -> None:
        """Answer, unless the modem is off or still busy with something of its own."""
        node = answer.source
        if not self._field.off[node] and t_ns >= self._field.deaf_until_ns[node]:
            self._emit(answer, t_ns)

    def _answered(self, node: int, answer: Packet, t_ns: int) -> None:
        waiting = self._waiting.pop((node, answer.seq), None)
        if waiting is None:
            return
        packet, start_ns = waiting
        if packet.purpose == "data":
            self._announce(t_ns, node, packet.key, TxEvent(packet.seq, "DELIVERED"))
        else:
            range_m = self._measurement.two_way_m(packet, t_ns - start_ns)
            self._announce(t_ns, node, packet.key, RangeResult(packet.seq, self._names[answer.source], range_m))

    def _give_up(self, packet: Packet, t_ns: int) -> None:
        if self._waiting.pop((packet.source, packet.seq), None) is None:
            return
        if packet.purpose == "data":
            self._announce(t_ns, packet.source, packet.key, TxEvent(packet.seq, "FAILED", "no_ack"))
        else:
            silent = self._names[packet.destination or 0]
            self._announce(t_ns, packet.source, packet.key, RangeResult(packet.seq, silent, None))

    def _patience_ns(self) -> int:
        """How long after the end of a question an answer may take: there and back as far as the modem reaches."""
        profile = self._profile
        seconds = 2.0 * min(self._hearing.reach_m, _ANSWER_RANGE_M) / _SLOWEST_MPS
        seconds += profile.ranging.reply_s + 2.0 * profile.decode_latency_s
        return round(seconds * NS) + profile.ping_airtime_ns

    # -- outages ------------------------------------------------------------------------------------------------

    def _switch_off(self, node: int, t_ns: int) -> None:
        """Cut short what a modem transmits, lose what it hears, and give up what it waits for."""
        sound, cut = self._on_air[node], None
        if sound is not None and t_ns < self._field.sending_until_ns[node]:
            self._field.cut(sound, t_ns)
            cut = sound.content
            if cut.purpose == "data":
                self._announce(t_ns, node, sound.key, TxEvent(cut.seq, "FAILED", "off"))
        for place, seq in [waiting for waiting in self._waiting if waiting[0] == node]:
            packet, _ = self._waiting[place, seq]
            if packet is cut and packet.purpose == "data":
                del self._waiting[place, seq]
            else:
                self._give_up(packet, t_ns)
        self._off_ns[node] = t_ns
        self._field.switch(node, t_ns, off=True)
        self._announce(t_ns, node, (node, 0, 2, 0), ModemStatus("off"))

    def _switch_on(self, node: int, t_ns: int) -> None:
        self._field.switch(node, t_ns, off=False)
        self._announce(t_ns, node, (node, 0, 2, 0), ModemStatus("rebooted"))

    # -- what comes out -----------------------------------------------------------------------------------------

    def _announce(self, t_ns: int, node: int, cause: Key, event: Happening) -> None:
        due = (t_ns, self._names[node], event)
        heapq.heappush(self._events, (t_ns, node, cause, next(self._order), due))

    def _note(
        self,
        t_ns: int,
        kind: str,
        packet: Packet,
        receiver: str = "",
        reason: str = "",
        *,
        lasting_ns: int = 0,
        sinr_db: float | None = None,
    ) -> None:
        sinr_db = None if sinr_db is None else round(sinr_db, 3)
        self._lines.append(
            LinkEvent(t_ns, kind, packet.name, packet.seq, receiver, packet.size, reason, packet.purpose,  # type: ignore[arg-type]
                      packet.asked_by, lasting_ns, sinr_db))  # fmt: skip
