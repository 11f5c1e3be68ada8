"""The driver of a WHOI Micro-Modem, without the port: requests and bytes go in, bytes and modem events come out.

Theory of operation. The modem answers every command with an echo (``CC…`` becomes ``CA…``). To send data at rate r:
``$CCCYC`` announces a packet; the modem asks for each frame (``$CADRQ``), gets it (``$CCTXD``), transmits (from
``$CATXP`` to ``$CATXF``) and tells of acknowledgements (``$CAACK``). At rate 0 the announcement is a packet of its own,
with its own ``$CATXF``, before the frames are asked for. ``$CCMPC`` pings; the answer comes as
one-way travel time (``$CAMPR``). ``$CCMUC`` sends a minipacket. Each step has a deadline, so that every request ends.

Sources: GobySoft goby, ``mm_driver`` and its sequence diagrams; WHOI libumutil; LSTS DUNE, Micro-Modem driver. Field
names are those of the Micro-Modem Software Interface Guide, which these cite.
"""

import heapq
from collections import Counter
from collections.abc import Callable

from grex_agent.modem.micromodem_hearing import Heard, Hearing, read_statistics
from grex_agent.modem.micromodem_rates import BROADCAST_ADDRESS, Setup, join
from grex_agent.modem.micromodem_talk import Failed, Talk, make_talk
from grex_agent.modem.micromodem_upkeep import ECHO_NS, Upkeep
from grex_agent.modem.nmea import Sentence, SentenceReader, encode
from grex_link.messages import (
    BROADCAST,
    BadFrame,
    Happening,
    Received,
    Request,
    TxEvent,
)

#: What comes out: bytes for the modem, or something for the agent.
Output = bytes | Happening

#: Requests that wait for their time.
WAITING_MAX = 64
_FRAMES_MAX = 64

#: Sentences of the interface that tell this driver nothing it needs.
_UNUSED = {
    "CA" + kind
    for kind in (
        "AGC", "BBD", "CFR", "CLK", "DBG", "DOP", "DQF", "EXL", "IRE", "MEA", "MEC", "MER", "MSA", "MSC", "MSE", "MSR",
        "RDP", "RSP", "RXA", "RXP", "SHF", "SNR", "TDP", "TMG", "TMQ", "TMS", "TOA", "TXA",
    )
} | {"SNCFR", "SNMFD", "SNPDT", "SNPNT", "SNRSP", "SNTTA"}  # fmt: skip


class MicroModem:
    """See the module's docstring. All times are integer nanoseconds of one clock that does not jump.

    Parameters
    ----------
    setup : Setup
        Addresses, rate and times.

    Attributes
    ----------
    counts : Counter
        Everything that was out of order, by kind: the faults of the line (see `SentenceReader`), ``unknown`` and
        ``bad_fields`` sentences, ``unknown_address``, ``overheard`` (whole, but for somebody else), ``unexpected``
        echoes, ``stray_request`` (data asked for that nobody announced), ``reboots``, ``pinged``, ``no_echo`` (commands
        without an answer), and the modem's own complaints as ``error_<module>``.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._names = {address: craft for craft, address in setup.addresses.items()}
        self._reader = SentenceReader()
        self.counts: Counter[str] = self._reader.faults
        self._hearing = Hearing(setup.airtime_ns + ECHO_NS)
        self._talk: Talk | None = None
        self._waiting: list[tuple[int, int, Request]] = []
        self._out: list[Output] = []
        self._upkeep = Upkeep(setup.own)
        self._now_ns = 0
        self._takers: dict[str, Callable[[Sentence], None]] = {
            **dict.fromkeys(("CAACK", "CAMPC", "CAMPR", "CAMUC", "CAMUR"), self._to_talk),
            **dict.fromkeys(("CATXD", "CATXF", "CATXP", "CAXST"), self._of_transmission),
            "CACFG": self._on_setting, "CACST": self._on_statistics, "CACYC": self._on_cycle,
            "CADRQ": self._on_data_request, "CAERR": self._on_error, "CAMFD": self._on_matched_filter,
            "CAMPA": self._on_pinged, "CAMSG": self._on_message, "CAMUA": self._on_minipacket,
            "CAREV": self._on_revision, "CARXD": self._on_frame,
        }  # fmt: skip

    @property
    def ready(self) -> bool:
        """Whether the modem is configured and takes requests."""
        return self._upkeep.ready

    @property
    def next_deadline_ns(self) -> int | None:
        """When `on_time` wants to be called; None for not before something comes in."""
        times = [self._upkeep.until_ns, self._hearing.until_ns, None if self._talk is None else self._talk.until_ns]
        times += [self._waiting[0][0]] if self._waiting else []
        return min((time for time in times if time is not None), default=None)

    # -- what comes in ------------------------------------------------------------------------------------------

    def on_connect(self, now_ns: int) -> list[Output]:
        """Begin with a modem that has just been connected: set it up."""
        self._now_ns = now_ns
        self._reader.reset()
        self._keep(self._upkeep.configure(now_ns))
        return self._take_out()

    def on_disconnect(self, why: str, now_ns: int) -> list[Output]:
        """Give up what is under way: the modem is no longer there."""
        self._now_ns = now_ns
        self._keep(self._upkeep.disconnected(why))
        return self._take_out()

    def on_request(self, request: Request, start_ns: int, now_ns: int) -> list[Output]:
        """Take a request for a time; one that is in the past already begins at once."""
        self._now_ns = now_ns
        if len(self._waiting) >= WAITING_MAX:
            self._refuse(request, "overflow")
        else:
            heapq.heappush(self._waiting, (start_ns, request.seq, request))
            self._begin_what_is_due()
        return self._take_out()

    def on_bytes(self, data: bytes, now_ns: int) -> list[Output]:
        """Take what the modem has said."""
        self._now_ns = now_ns
        for sentence in self._reader.feed(data):
            self._upkeep.alive(now_ns)
            taker = self._takers.get(sentence.kind)
            if taker is not None:
                self._guarded(taker, sentence)
            elif sentence.kind not in _UNUSED:
                self.counts["unknown"] += 1
        return self._take_out()

    def on_time(self, now_ns: int) -> list[Output]:
        """Do what is due because time has passed."""
        self._now_ns = now_ns
        self._heard(self._hearing.on_time(now_ns))
        if self._talk is not None and self._talk.until_ns <= now_ns:
            self._run(self._talk.on_timeout)
        self._keep(self._upkeep.on_time(now_ns))
        self._begin_what_is_due()
        return self._take_out()

    # -- requests -----------------------------------------------------------------------------------------------

    def _begin_what_is_due(self) -> None:
        while self._waiting and self._waiting[0][0] <= self._now_ns:
            request = heapq.heappop(self._waiting)[-1]
            try:
                talk = make_talk(request, self._setup) if self.ready else None
            except Failed as refusal:
                self._refuse(request, refusal.reason)
                continue
            if talk is None or self._talk is not None:
                self._refuse(request, "off" if talk is None else "busy")
            else:
                self._talk = talk
                self._out.append(talk.begin(self._now_ns))

    def _refuse(self, request: Request, reason: str) -> None:
        self._out.append(TxEvent(request.seq, "FAILED", reason))

    def _to_talk(self, sentence: Sentence) -> None:
        talk = self._talk
        if talk is None or sentence.kind not in talk.takes:
            self.counts["unexpected"] += 1
        else:
            self._run(lambda now_ns: talk.on_sentence(sentence, now_ns))

    def _of_transmission(self, sentence: Sentence) -> None:
        # The modem transmits by itself, too: acknowledgements and answers to pings.
        if self._talk is not None and sentence.kind in self._talk.takes:
            self._to_talk(sentence)

    def _run(self, step: Callable[[int], list[Output]]) -> None:
        """Let the talk do something, and forget it when it is over."""
        talk = self._talk
        try:
            self._out += step(self._now_ns)
        except Failed as failure:
            self._fail(failure.reason)
        if talk is not None and talk.over:
            self._talk = None

    def _fail(self, reason: str) -> None:
        """End what is under way; what waits for its time may wait on."""
        talk, self._talk = self._talk, None
        if talk is not None:
            self._refuse(talk.request, reason)

    # -- what is heard ------------------------------------------------------------------------------------------

    def _on_cycle(self, sentence: Sentence) -> None:
        """``$CACYC,CMD,ADR1,ADR2,Packet Type,ACK,Npkt``: the echo of an own command, or somebody's announcement."""
        _, source, destination, _, _, count = map(int, sentence.fields[:6])
        if source == self._setup.own:
            self._to_talk(sentence)
        else:
            _require(0 <= count <= _FRAMES_MAX)
            self._heard(self._hearing.announced(source, destination, count, self._now_ns))

    def _on_frame(self, sentence: Sentence) -> None:
        """``$CARXD,SRC,DEST,ACK,F#,HH…HH``."""
        source, destination, _, number = map(int, sentence.fields[:4])
        _require(1 <= number <= _FRAMES_MAX)
        try:
            data = bytes.fromhex(sentence.fields[4])
        except ValueError:
            data = None
        self._heard(self._hearing.frame(source, destination, number, data, self._now_ns))

    def _on_statistics(self, sentence: Sentence) -> None:
        """``$CACST``: how a packet was received."""
        statistics = read_statistics(sentence.fields)
        _require(statistics is not None)
        if statistics is not None:
            self._heard(self._hearing.statistics(statistics))

    def _on_message(self, sentence: Sentence) -> None:
        """``$CAMSG,type,value``."""
        kind = sentence.fields[0].upper().replace(" ", "_")
        if kind in {"BAD_CRC", "PACKET_TIMEOUT"}:
            fault = "corrupt" if kind == "BAD_CRC" else "timeout"
            self._heard(self._hearing.complaint(fault, self._now_ns))

    def _on_minipacket(self, sentence: Sentence) -> None:
        """``$CAMUA,SRC,DEST,HHHH``: 13 bits of somebody."""
        source, destination = map(int, sentence.fields[:2])
        payload = int(sentence.fields[2], 16).to_bytes(2, "big")
        self._deliver(Heard(source, destination, [], level_db=self._hearing.take_level()), payload)

    def _on_matched_filter(self, sentence: Sentence) -> None:
        """``$CAMFD,peak,power,rssi,spl``: the level of what is about to be decoded, if there are no statistics."""
        self._hearing.detected(float(sentence.fields[3]))

    def _on_pinged(self, sentence: Sentence) -> None:
        """``$CAMPA,SRC,DEST``: somebody has measured the range to here; the modem has answered by itself."""
        del sentence
        self.counts["pinged"] += 1

    def _heard(self, packets: list[Heard]) -> None:
        for packet in packets:
            if packet.fault:
                self._out.append(BadFrame(packet.fault))
            else:
                self._deliver(packet, join(packet.frames))

    def _deliver(self, packet: Heard, payload: bytes) -> None:
        name = self._names.get(packet.source)
        if name is None or packet.source == self._setup.own:
            self.counts["unknown_address"] += 1
        elif packet.destination not in {BROADCAST_ADDRESS, self._setup.own}:
            self.counts["overheard"] += 1
        else:
            to = BROADCAST if packet.destination == BROADCAST_ADDRESS else self._setup.craft
            one_way_s = packet.past_second_s if self._upkeep.synchronous else None
            self._out.append(Received(name, payload, to, packet.level_db, packet.snr_db, one_way_s=one_way_s))

    # -- the modem itself ---------------------------------------------------------------------------------------

    def _on_data_request(self, sentence: Sentence) -> None:
        """``$CADRQ,HHMMSS,SRC,DEST,ACK,N,F#``: give the frame, or nothing, so that it does not ask again."""
        if self._talk is not None and "CADRQ" in self._talk.takes:
            self._to_talk(sentence)
        else:
            source, destination, acknowledge = map(int, sentence.fields[1:4])
            self.counts["stray_request"] += 1
            self._out.append(encode("CCTXD", source, destination, acknowledge, ""))

    def _on_revision(self, sentence: Sentence) -> None:
        """``$CAREV,HHMMSS,ident,version``: printed now and then, and with ``INIT`` after a reboot."""
        if "INIT" in sentence.fields[:2]:
            self.counts["reboots"] += 1
            self._keep(self._upkeep.rebooted(self._now_ns))
        elif len(sentence.fields) >= 3 and sentence.fields[1] == "AUV":
            self._upkeep.version = sentence.fields[2]

    def _on_error(self, sentence: Sentence) -> None:
        """``$CAERR,HHMMSS,module,number,message``: module NMEA has not understood the last command."""
        module = sentence.fields[1] if len(sentence.fields) > 1 else ""
        known = module if module.isalnum() and len(module) <= 16 else "other"
        self.counts[f"error_{known}"] += 1
        if module != "NMEA":
            return
        if self._upkeep.configuring:
            self._keep(self._upkeep.rejected(self._now_ns))
        elif self._talk is not None and self._talk.unechoed:
            self._fail("error")

    def _on_setting(self, sentence: Sentence) -> None:
        """``$CACFG,NNN,vv``: the echo of a setting, or the answer to a question."""
        key, value = sentence.fields[:2]
        self._keep(self._upkeep.setting(key, value, self._now_ns))

    def _keep(self, out: list[Output]) -> None:
        """Take what the upkeep says. What is under way in a modem that is not ready any more has failed."""
        if not self.ready:
            self._hearing.forget()
            self._fail("error")
        self._out += out
        if self._upkeep.no_echo:
            self.counts["no_echo"] = self._upkeep.no_echo

    # -- both ---------------------------------------------------------------------------------------------------

    def _guarded(self, taker: Callable[[Sentence], None], sentence: Sentence) -> None:
        """Count a sentence whose fields are not what they should be; it changes nothing."""
        try:
            taker(sentence)
        except (ValueError, IndexError, OverflowError):
            self.counts["bad_fields"] += 1

    def _take_out(self) -> list[Output]:
        out, self._out = self._out, []
        return out


def _require(condition: bool) -> None:  # noqa: FBT001 - an assertion on input
    if not condition:
        raise ValueError
