"""The Micro-Modem's driver without a port: literal sentences, literal times."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.modem.micromodem import WAITING_MAX, MicroModem
from grex_agent.modem.micromodem_rates import (
    RATES,
    Rate,
    Setup,
    check_serial_modems,
    join,
    plan_addresses,
    plan_setup,
)
from grex_agent.modem.nmea import encode
from grex_link.errors import ConfigError
from grex_link.messages import BadFrame, ModemStatus, RangeRequest, RangeResult, Received, Transmit, TxEvent
from grex_link.profile import load_profile
from grex_link.scenario import loads
from grex_link.units import NS

ADDRESSES = {"auv1": 1, "auv2": 2, "auv3": 3}
ECHOES = [("SRC", "1"), ("ASD", "0"), ("REV", "1"), ("RXD", "1"), ("TXF", "1"), ("CST", "1"), ("SNV", "0")]
ZERO_TO_31 = "".join(f"{byte:02X}" for byte in range(32))


def s(seconds: float) -> int:
    return round(seconds * NS)


def setup(rate: str = "umodem_fsk0", **other) -> Setup:
    kind = RATES[rate]
    fields = {"payload_max_bytes": kind.frames * kind.frame_bytes, "airtime_ns": s(4.0), "answer_ns": s(8.0)}
    return Setup("auv1", ADDRESSES, kind, **(fields | {"nominal_mps": 1500.0} | other))


class Talker:
    """The modem's side by hand: says a line, and sees what the driver answers and tells."""

    def __init__(self, rate: str = "umodem_fsk0", *, ready: bool = True, **other) -> None:
        self.modem = MicroModem(setup(rate, **other))
        self.time_s = 0.0
        self.sent: list[str] = []
        self.told: list = []
        if ready:
            self.take(self.modem.on_connect(0))
            for key, value in ECHOES:
                self.say(f"CACFG,{key},{value}")
            assert self.told == [ModemStatus("ready")]
            self.sent.clear()
            self.told.clear()

    def take(self, out) -> None:
        for item in out:
            if isinstance(item, bytes):
                self.sent.append(item.decode().partition("*")[0].removeprefix("$"))
            else:
                self.told.append(item)

    def say(self, *lines: str, at: float | None = None) -> None:
        self.time_s = self.time_s if at is None else at
        for line in lines:
            self.take(self.modem.on_bytes(encode(*line.split(",")), s(self.time_s)))

    def wait(self, until: float) -> None:
        self.time_s = until
        self.take(self.modem.on_time(s(until)))

    def ask(self, request, at: float | None = None) -> None:
        start_ns = request.t_ns if at is None else s(at)
        self.take(self.modem.on_request(request, start_ns, s(self.time_s)))

    def send(
        self, payload: bytes = b"hello", to: str = "", *, seq: int = 0, ack: bool = False, at: float = 0.0
    ) -> None:
        self.ask(Transmit(seq, s(at), payload, to, ack))

    def reasons(self) -> list[str]:
        return [event.reason for event in self.told if isinstance(event, TxEvent) and event.status == "FAILED"]


# -- setting up --------------------------------------------------------------------------------------------------------


def test_the_modem_is_set_up_one_setting_after_the_other():
    """After connecting, each setting is sent when the one before has been echoed; then the modem is ready."""
    talker = Talker(ready=False)
    talker.take(talker.modem.on_connect(0))
    assert talker.sent == ["CCCFG,SRC,1"]
    assert not talker.modem.ready
    talker.say("CACFG,SRC,7")  # of somebody else's making
    assert len(talker.sent) == 1
    for key, value in ECHOES:
        talker.say(f"CACFG,{key},{value}")
    assert talker.sent == [*(f"CCCFG,{key},{value}" for key, value in ECHOES[:-1]), "CCCFQ,SNV"]
    assert talker.told == [ModemStatus("ready")]
    assert talker.modem.ready


def test_an_old_firmware_does_without_a_setting():
    """A setting that the firmware refuses is left out; its address it must take."""
    talker = Talker(ready=False)
    talker.take(talker.modem.on_connect(0))
    talker.say("CACFG,SRC,1", "CAERR,000010,NMEA,5,unknown setting", "CACFG,REV,1", "CACFG,RXD,1", "CACFG,TXF,1")
    talker.say("CAERR,000010,NMEA,5,unknown setting", "CACFG,SNV,0")
    assert talker.told == [ModemStatus("ready")]
    assert talker.modem.counts["error_NMEA"] == 2


def test_a_silent_modem_is_asked_again_and_reported_once():
    """Three times the same command, then one status, then again every ten seconds without another word."""
    talker = Talker(ready=False)
    talker.take(talker.modem.on_connect(0))
    for until in (5.0, 10.0, 15.0):
        talker.wait(until)
    assert talker.sent == ["CCCFG,SRC,1"] * 3
    assert talker.told == [ModemStatus("error", "the modem does not answer")]
    for until in (25.0, 30.0, 35.0, 40.0):
        talker.wait(until)
    assert talker.sent == ["CCCFG,SRC,1"] * 6
    assert len(talker.told) == 1
    assert talker.modem.counts["no_echo"] == 6
    talker.wait(50.0)
    talker.say(*(f"CACFG,{key},{value}" for key, value in ECHOES))
    assert talker.told[-1] == ModemStatus("ready")


def test_a_modem_that_falls_silent_is_found_out():
    """After a minute without a word the modem is asked; without an answer the agent is told."""
    talker = Talker()
    talker.wait(59.9)
    assert talker.sent == []
    for until in (60.0, 65.0, 70.0, 75.0):
        talker.wait(until)
    assert talker.sent == ["CCCFQ,SRC"] * 3
    assert talker.told == [ModemStatus("error", "the modem does not answer")]
    talker.send(at=76.0)
    talker.wait(76.0)
    assert talker.reasons() == ["off"]


def test_a_modem_that_answers_is_alive():
    """Any answer within the minute is enough."""
    talker = Talker()
    talker.wait(60.0)
    talker.say("CACFG,SRC,1", at=61.0)
    talker.wait(66.0)
    assert talker.told == []
    assert talker.modem.ready


def test_a_modem_with_another_address_is_set_up_again():
    """If the modem says that it has another address, it gets the right one."""
    talker = Talker()
    talker.say("CACFG,SRC,0")
    assert talker.sent == ["CCCFG,SRC,1"]
    assert not talker.modem.ready


# -- data --------------------------------------------------------------------------------------------------------------


def test_a_broadcast_at_rate_0():
    """Announced, its end of transmission ignored; asked for, given in full frames; SENT at the end of the data."""
    talker = Talker()
    talker.send(bytes(range(31)))
    assert talker.sent == ["CCCYC,0,1,15,0,0,1"]
    talker.say("CACYC,0,1,15,0,0,1", "CATXP,0", "CATXF,0")
    assert talker.told == []
    talker.say("CADRQ,000001,1,15,0,32,1")
    assert talker.sent[1:] == ["CCTXD,1,15,0," + ZERO_TO_31[:-2] + "80"]
    talker.say("CATXD,1,15,0,32", "CATXP,32")
    assert talker.told == []
    talker.say("CATXF,32", at=4.0)
    assert talker.told == [TxEvent(0, "SENT")]
    talker.send(seq=1, at=4.0)
    assert talker.sent[-1] == "CCCYC,0,1,15,0,0,1"


def test_a_packet_of_three_frames_with_acknowledgement():
    """Each frame is given as it is asked for; DELIVERED when all have been acknowledged by the right one."""
    talker = Talker("umodem_psk1")
    talker.send(b"x" * 150, "auv3", ack=True)
    assert talker.sent == ["CCCYC,0,1,3,1,1,3"]
    talker.say("CACYC,0,1,3,1,1,3")
    for frame in (1, 2, 3):
        talker.say(f"CADRQ,000001,1,3,1,64,{frame}", "CATXD,1,3,1,64")
    assert [line[:11] for line in talker.sent[1:]] == ["CCTXD,1,3,1"] * 3
    assert talker.sent[3] == "CCTXD,1,3,1," + "78" * 22 + "80" + "00" * 41
    talker.say("CATXP,192", "CATXF,192", at=3.4)
    assert talker.told == [TxEvent(0, "SENT")]
    talker.say("CAACK,3,1,1,1", "CAACK,2,1,2,1", "CAACK,3,2,2,1", "CAACK,3,1,3,1", at=5.0)
    assert talker.told[1:] == []
    talker.say("CAACK,3,1,2,1")
    assert talker.told[1:] == [TxEvent(0, "DELIVERED")]


def test_no_acknowledgement():
    """SENT, and then FAILED no_ack when the time for the acknowledgement is over."""
    talker = Talker()
    talker.send(to="auv2", ack=True)
    talker.say("CACYC,0,1,2,0,1,1", "CADRQ,000001,1,2,1,32,1", "CATXD,1,2,1,32", "CATXF,32", at=4.0)
    talker.wait(16.9)
    assert talker.told == [TxEvent(0, "SENT")]
    talker.wait(17.0)
    assert talker.told[1:] == [TxEvent(0, "FAILED", "no_ack")]


@pytest.mark.parametrize(
    ("said", "until"),
    [
        ((), 5.0),
        (("CACYC,0,1,15,0,0,1",), 9.0),
        (("CACYC,0,1,15,0,0,1", "CADRQ,000001,1,15,0,32,1"), 9.0),
        (("CACYC,0,1,15,0,0,1", "CADRQ,000001,1,15,0,32,1", "CATXD,1,15,0,32", "CATXP,32"), 9.0),
    ],
    ids=["no echo", "not asked for", "not taken", "no end"],
)
def test_every_step_has_an_end(said, until):
    """Wherever the modem falls silent, the request ends FAILED error, and the next one begins."""
    talker = Talker()
    talker.send()
    talker.say(*said)
    assert talker.modem.next_deadline_ns == s(until)
    talker.wait(until)
    assert talker.told == [TxEvent(0, "FAILED", "error")]
    talker.send(seq=1)
    assert talker.sent[-1] == "CCCYC,0,1,15,0,0,1"


def test_a_request_waits_for_its_time():
    """A request for a later time begins then, not before."""
    talker = Talker()
    talker.send(at=12.0)
    assert talker.sent == []
    assert talker.modem.next_deadline_ns == s(12.0)
    talker.wait(11.99)
    assert talker.sent == []
    talker.wait(12.0)
    assert talker.sent == ["CCCYC,0,1,15,0,0,1"]


def test_busy():
    """A second request while one is under way fails, and does not disturb the first."""
    talker = Talker()
    talker.send()
    talker.send(seq=1)
    assert talker.told == [TxEvent(1, "FAILED", "busy")]
    talker.say("CACYC,0,1,15,0,0,1", "CADRQ,000001,1,15,0,32,1", "CATXD,1,15,0,32", "CATXF,32")
    assert talker.told[1:] == [TxEvent(0, "SENT")]


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        (Transmit(0, 0, b"x" * 33), "size"),
        (Transmit(0, 0, b"x" * 31 + b"\x80"), "size"),
        (Transmit(0, 0, b"x", "nobody"), "address"),
        (Transmit(0, 0, b"x", "auv1"), "address"),
        (Transmit(0, 0, b"x", "", True), "address"),  # noqa: FBT003 - the field's place
        (Transmit(0, 0, b"x", by_land=True), "address"),
        (RangeRequest(0, 0, "nobody"), "address"),
        (RangeRequest(0, 0, "auv1"), "address"),
    ],
)
def test_what_the_modem_cannot_do_is_refused(request_, reason):
    """A request that cannot be carried out fails at once with its reason, and nothing is sent."""
    talker = Talker()
    talker.ask(request_)
    assert talker.sent == []
    assert [event for event in talker.told if not isinstance(event, ModemStatus)] == [TxEvent(0, "FAILED", reason)]


def test_what_the_profile_cannot_do_is_refused():
    """Neither ranges nor acknowledgements are asked of a modem whose profile has none."""
    talker = Talker(two_way=False, acknowledges=False)
    talker.ask(RangeRequest(0, 0, "auv2"))
    talker.send(to="auv2", ack=True, seq=1)
    assert talker.reasons() == ["error", "error"]


def test_too_many_waiting():
    """More requests for later than there is room for are refused."""
    talker = Talker()
    for seq in range(WAITING_MAX + 1):
        talker.send(seq=seq, at=100.0)
    assert talker.told == [TxEvent(WAITING_MAX, "FAILED", "overflow")]


def test_a_modem_at_another_rate():
    """If the modem asks for less than a frame, it is not at our rate: FAILED error."""
    talker = Talker("umodem_psk1")
    talker.send(b"x" * 60)
    talker.say("CACYC,0,1,15,1,0,1", "CADRQ,000001,1,15,0,32,1")
    assert talker.reasons() == ["error"]


def test_data_that_nobody_announced():
    """A poll by somebody else is answered with nothing, so that the modem does not ask again."""
    talker = Talker()
    talker.say("CACYC,0,1,3,0,0,1", "CADRQ,000001,1,3,0,32,1")
    assert talker.sent == ["CCTXD,1,3,0,"]
    assert talker.modem.counts["stray_request"] == 1


def test_more_frames_than_announced():
    """A frame beyond the last is asked for in vain."""
    talker = Talker()
    talker.send()
    talker.say("CACYC,0,1,15,0,0,1", "CADRQ,000001,1,15,0,32,2")
    assert talker.sent[-1] == "CCTXD,1,15,0,"


@pytest.mark.parametrize(
    "line",
    [
        "CAXST,20110914,204459.0000,1,3,40,4000,25120,0,1,15,0,1,1,1,32",
        "CAXST,6,20110914,204459.0000,1,3,40,4000,25120,0,1,15,0,1,1,1,32",
    ],
)
def test_a_transmission_that_the_modem_reports_as_failed(line):
    """Transmit statistics with another mode than 0 fail the request, with and without a version in front."""
    talker = Talker()
    talker.send()
    talker.say("CACYC,0,1,15,0,0,1", line)
    assert talker.reasons() == ["error"]


@pytest.mark.parametrize("request_", [Transmit(0, 0, b"\x01\x02"), RangeRequest(0, 0, "auv2")])
def test_a_minipacket_or_ping_that_the_modem_reports_as_failed(request_):
    """The same holds for minipackets and pings; statistics of a good transmission change nothing."""
    talker = Talker("umodem_mini")
    talker.ask(request_)
    talker.say("CAXST,20110914,204459.0000,1,0,40,4000,25120,0,1,15,0,1,1,1,32")
    assert talker.told == []
    talker.say("CAXST,20110914,204459.0000,1,3,40,4000,25120,0,1,15,0,1,1,1,32")
    assert talker.reasons() == ["error"]


def test_a_command_that_the_modem_does_not_understand():
    """An error of module NMEA fails what has just been commanded; others are counted."""
    talker = Talker()
    talker.send()
    talker.say("CAERR,000010,TXPROC,3,too hot")
    assert talker.told == []
    talker.say("CAERR,000010,NMEA,5,bad command")
    assert talker.reasons() == ["error"]
    assert talker.modem.counts["error_TXPROC"] == talker.modem.counts["error_NMEA"] == 1


# -- minipackets -------------------------------------------------------------------------------------------------------


def test_a_minipacket():
    """13 bits go out without announcement, and are SENT when the modem says so or their airtime is over."""
    for ends in ("CATXF,0", None):
        talker = Talker("umodem_mini")
        talker.send(b"\x1f\xab", "auv2")
        assert talker.sent == ["CCMUC,1,2,1FAB"]
        talker.say("CAMUC,1,2,1fab", "CATXP,0")
        assert talker.told == []
        if ends is None:
            talker.wait(4.0)
        else:
            talker.say(ends)
        assert talker.told == [TxEvent(0, "SENT")]


@pytest.mark.parametrize("payload", [b"\x20\x00", b"\x01", b"abc", b""])
def test_what_is_no_minipacket(payload):
    """Only two bytes of which the first three bits are zero go into a minipacket."""
    talker = Talker("umodem_mini")
    talker.send(payload)
    assert talker.reasons() == ["size"]


def test_an_acknowledged_minipacket():
    """The reply to a minipacket is its acknowledgement; without one it ends no_ack."""
    talker = Talker("umodem_mini")
    talker.send(b"\x01\x02", "auv2", ack=True)
    talker.say("CAMUC,1,2,0102", "CATXF,0", "CAMUR,2,1")
    assert talker.told == [TxEvent(0, "SENT"), TxEvent(0, "DELIVERED")]
    talker.send(b"\x01\x02", "auv2", ack=True, seq=1)
    talker.say("CAMUC,1,2,0102", "CATXF,0")
    talker.wait(13.0)
    assert talker.told[2:] == [TxEvent(1, "SENT"), TxEvent(1, "FAILED", "no_ack")]
    talker.send(b"\x01\x02", "auv2", seq=2)
    talker.wait(18.0)
    assert talker.told[-1] == TxEvent(2, "FAILED", "error")


def test_a_minipacket_is_heard():
    """The documentation's own minipacket arrives with two bytes and the level that was detected."""
    talker = Talker("umodem_mini")
    talker.say("CAMFD,1440,25,175,166", "CAMUA,2,1,1fab", "CAMUA,2,15,0001")
    assert talker.told == [
        Received("auv2", b"\x1f\xab", "auv1", rssi_db=166.0),
        Received("auv2", b"\x00\x01", ""),
    ]


# -- ranges ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("answer", ["CAMPR,2,1,0.2501", "CAMPR,1,2,0.2501"])
def test_a_range(answer):
    """The one-way travel time of the answer becomes metres at the nominal speed of sound."""
    talker = Talker()
    talker.ask(RangeRequest(0, 0, "auv2"))
    assert talker.sent == ["CCMPC,1,2"]
    talker.say("CAMPC,1,2", "CATXP,0", "CAMPR,3,1,0.9", answer)
    assert talker.told == [RangeResult(0, "auv2", pytest.approx(375.15))]


@pytest.mark.parametrize("travel", ["", "-1", "nan", "inf", "99"])
def test_a_range_that_is_none(travel):
    """A travel time that is none is no range."""
    talker = Talker()
    talker.ask(RangeRequest(0, 0, "auv2"))
    talker.say("CAMPC,1,2", f"CAMPR,2,1,{travel}")
    assert talker.told == [RangeResult(0, "auv2", None)]


def test_nobody_answers_a_ping():
    """Without an answer the result says so; without an echo the request has failed."""
    talker = Talker()
    talker.ask(RangeRequest(0, 0, "auv2"))
    talker.say("CAMPC,1,2")
    talker.wait(13.0)
    assert talker.told == [RangeResult(0, "auv2", None)]
    talker.ask(RangeRequest(1, 0, "auv2"))
    talker.wait(18.0)
    assert talker.told[1:] == [TxEvent(1, "FAILED", "error")]


def test_being_pinged():
    """Somebody else's ping is counted; the modem answers by itself."""
    talker = Talker()
    talker.say("CAMPA,2,1")
    assert talker.modem.counts["pinged"] == 1
    assert talker.told == talker.sent == []


# -- hearing -----------------------------------------------------------------------------------------------------------

#: Statistics as a Micro-Modem 1 has printed them (goby, mm_driver.proto): PSK, 166 dB, SNR 3 dB.
PSK_GOOD = (
    "CACST,0,223413.0000,0,1440,25,0175,0166,75,01,01,01,03,1,007,006,0,3,3,0,146,03,04,-100,-1,000,-1.2,45,10000,2000"
)
#: And one that had a bad frame (WHOI libumutil).
PSK_BAD = (
    "CACST,1,153026.0000,0,4105,30,0318,0193,10,00,00,01,01,2,004,004,3,3,3,1,154,09,08,10,-6,000,0.0,4125000,5000"
)


def frames(payload: bytes, rate: str = "umodem_fsk0") -> list[str]:
    return [frame.hex().upper() for frame in RATES[rate].split(payload)]


def test_a_packet_is_heard_with_its_level():
    """Announcement, frame, statistics: one reception with payload, source, level; FSK has no signal-to-noise ratio."""
    talker = Talker()
    talker.say("CARXP,0", "CACYC,0,2,15,0,0,1", PSK_GOOD.replace(",0,3,3,0,", ",0,2,1,0,"))
    talker.say(f"CARXD,2,15,0,1,{frames(b'hello')[0]}")
    assert talker.told == []
    talker.say(PSK_GOOD.replace(",0,3,3,0,", ",0,1,1,0,"))
    assert talker.told == [Received("auv2", b"hello", "", rssi_db=166.0)]


def test_a_packet_of_several_frames_is_put_together():
    """The frames of a packet make one payload; PSK tells the signal-to-noise ratio, version 6 shifts the fields."""
    for statistics in (PSK_GOOD, PSK_GOOD.replace("CACST,", "CACST,6,")):
        talker = Talker("umodem_psk1")
        payload = bytes(range(150))
        talker.say("CACYC,0,3,1,1,1,3")
        for number, data in enumerate(frames(payload, "umodem_psk1"), start=1):
            talker.say(f"CARXD,3,1,1,{number},{data}")
        talker.say(statistics)
        assert talker.told == [Received("auv3", payload, "auv1", rssi_db=166.0, snr_db=3.0)]


@pytest.mark.parametrize(
    ("snv", "clock_mode", "one_way_s"), [("1", "3", 0.2013), ("1", "2", 0.2013), ("1", "1", None), ("0", "3", None)]
)
def test_one_way_travel_time(snv, clock_mode, one_way_s):
    """With all clocks on the beat of a second the fraction of the time of arrival is the travel time."""
    talker = Talker("umodem_psk1")
    talker.say(f"CACFG,SNV,{snv}", "CACYC,0,2,15,1,0,1", f"CARXD,2,15,0,1,{frames(b'hello', 'umodem_psk1')[0]}")
    talker.say(PSK_GOOD.replace("223413.0000,0,", f"223413.2013,{clock_mode},"))
    assert talker.told == [Received("auv2", b"hello", "", rssi_db=166.0, snr_db=3.0, one_way_s=one_way_s)]


def test_without_statistics_a_packet_is_handed_over_after_a_second():
    """Firmware that prints no statistics costs a second, not the packet; its detector tells the level."""
    talker = Talker()
    talker.say("CAMFD,1440,25,175,150", "CACYC,0,2,15,0,0,1", f"CARXD,2,15,0,1,{frames(b'hello')[0]}", at=10.0)
    assert talker.modem.next_deadline_ns == s(11.0)
    talker.wait(11.0)
    assert talker.told == [Received("auv2", b"hello", "", rssi_db=150.0)]


def test_statistics_of_a_minipacket_in_between():
    """An acknowledgement between two others has statistics of its own; they are not those of the packet."""
    talker = Talker()
    talker.say("CACYC,0,2,15,0,0,1", f"CARXD,2,15,0,1,{frames(b'hello')[0]}")
    talker.say(PSK_GOOD.replace(",0,3,3,0,", ",0,2,1,0,").replace("0166", "0120"))
    assert talker.told == []
    talker.say(PSK_GOOD.replace(",0,3,3,0,", ",0,1,1,0,"))
    assert talker.told == [Received("auv2", b"hello", "", rssi_db=166.0)]


def test_a_packet_without_announcement():
    """If the announcement was missed, frames that come are still a packet; another packet ends it."""
    talker = Talker()
    talker.say(f"CARXD,2,15,0,1,{frames(b'one')[0]}", f"CARXD,2,15,0,1,{frames(b'two')[0]}")
    assert talker.told == [Received("auv2", b"one", "")]
    talker.say("CACYC,0,3,15,0,0,1")
    assert talker.told[1:] == [Received("auv2", b"two", "")]


@pytest.mark.parametrize(
    "lines",
    [
        ["CAMSG,BAD_CRC,1"],
        ["CAMSG,Bad CRC,4"],
        ["CAMSG,BAD_CRC,2", PSK_BAD],
        [PSK_BAD],
        [
            "CACYC,0,2,15,1,0,3",
            "CAMSG,BAD_CRC,1",
            f"CARXD,2,15,0,2,{'00' * 64}",
            f"CARXD,2,15,0,3,{'00' * 64}",
            PSK_BAD,
        ],
        ["CACYC,0,2,15,0,0,1", "CARXD,2,15,0,1,xyz"],
    ],
)
def test_what_cannot_be_decoded_is_one_bad_frame(lines):
    """However many sentences complain, a packet that was heard and not decoded is one bad frame."""
    talker = Talker()
    talker.say(*lines)
    talker.wait(20.0)
    assert talker.told == [BadFrame("corrupt")]


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        (["CACYC,0,2,15,0,0,1", "CAMSG,PACKET_TIMEOUT,0"], "timeout"),
        (["CACYC,0,2,15,0,0,1", PSK_BAD.replace("CACST,1", "CACST,2")], "timeout"),
        (["CACYC,0,2,15,1,0,3", f"CARXD,2,15,0,2,{'00' * 64}"], "incomplete"),
    ],
)
def test_a_packet_that_does_not_come_whole(lines, reason):
    """An announced packet that does not come, or not whole, is a bad frame that says so."""
    talker = Talker()
    talker.say(*lines)
    talker.wait(20.0)
    assert talker.told == [BadFrame(reason)]


def test_an_announcement_alone_is_nothing():
    """An announcement that nothing follows is forgotten."""
    talker = Talker()
    talker.say("CACYC,0,2,15,0,0,1")
    talker.wait(20.0)
    assert talker.told == []
    assert talker.modem.next_deadline_ns == s(60.0)


def test_what_is_for_others_is_counted():
    """The modem prints whatever it hears: what is for somebody else, or from nobody we know, is counted and dropped."""
    talker = Talker()
    data = frames(b"hello")[0]
    talker.say(f"CARXD,2,3,0,1,{data}", f"CARXD,99,15,0,1,{data}", f"CARXD,1,15,0,1,{data}", "CACYC,0,2,15,0,0,1")
    assert talker.told == []
    assert talker.modem.counts == {"overheard": 1, "unknown_address": 2}


# -- the modem itself --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("line", ["CAREV,000000,INIT,0.93.0.09", "CAREV,INIT,0.1.2.3.4"])
def test_a_reboot_in_the_middle(line):
    """What is under way fails, the agent is told, and after a rest the modem is set up and works again."""
    talker = Talker()
    talker.send()
    talker.send(seq=1, at=30.0)
    talker.say("CACYC,0,1,15,0,0,1", line, at=1.0)
    assert talker.told == [TxEvent(0, "FAILED", "error"), ModemStatus("rebooted")]
    talker.send(seq=2)
    assert talker.told[2:] == [TxEvent(2, "FAILED", "off")]
    talker.say("CAREV,000001,AUV,0.93.0.09")
    talker.wait(3.0)
    for key, value in ECHOES:
        talker.say(f"CACFG,{key},{value}")
    assert talker.told[3:] == [ModemStatus("ready", "0.93.0.09")]
    talker.wait(30.0)
    assert talker.sent[-1] == "CCCYC,0,1,15,0,0,1"
    assert talker.modem.counts["reboots"] == 1


def test_a_reboot_while_hearing():
    """Half a packet before a reboot is not mixed with another one after it."""
    talker = Talker("umodem_psk1")
    talker.say("CACYC,0,2,15,1,0,2", f"CARXD,2,15,0,1,{'11' * 64}", "CAREV,000000,INIT,0.93.0.09")
    talker.wait(30.0)
    assert [event for event in talker.told if not isinstance(event, ModemStatus)] == []


def test_a_lost_port():
    """When the device is gone, what is under way fails and requests fail off; back again, it is set up anew."""
    talker = Talker()
    talker.ask(RangeRequest(0, 0, "auv2"))
    talker.take(talker.modem.on_disconnect("unplugged", s(1.0)))
    assert talker.told == [
        TxEvent(0, "FAILED", "error"),
        ModemStatus("error", "unplugged"),
    ]
    talker.send(seq=1)
    assert talker.told[2:] == [TxEvent(1, "FAILED", "off")]
    assert talker.modem.next_deadline_ns is None
    talker.take(talker.modem.on_connect(s(2.0)))
    talker.say(*(f"CACFG,{key},{value}" for key, value in ECHOES), at=2.0)
    assert talker.told[-1] == ModemStatus("ready")


@pytest.mark.parametrize(
    ("line", "count"),
    [
        ("CAXYZ,1", "unknown"),
        ("CARXD,2,15", "bad_fields"),
        ("CARXD,a,15,0,1,00", "bad_fields"),
        ("CARXD,2,15,0,999999999,00", "bad_fields"),
        ("CACYC,0,2,15,0,0,999999999", "bad_fields"),
        ("CACST,1,2,3", "bad_fields"),
        ("CAMUA,2,1,FFFFFF", "bad_fields"),
        ("CADRQ,1", "bad_fields"),
        ("CAMFD,1", "bad_fields"),
        ("CAACK,2,1,1,1", "unexpected"),
        ("CAMPR,2,1,0.1", "unexpected"),
        ("CAERR", "error_other"),
        ("CAERR,1,-", "error_other"),
    ],
)
def test_every_fault_has_its_counter(line, count):
    """A sentence that makes no sense is counted by what is wrong with it and changes nothing."""
    talker = Talker()
    talker.say(line)
    assert talker.modem.counts == {count: 1}
    assert talker.told == talker.sent == []


def test_sentences_that_are_not_needed():
    """Sentences of the interface that the driver has no use for are no faults."""
    talker = Talker()
    talker.say(
        "CADQF,199,1", "CARXP,1", "CASHF,1,2,3,4,5", "CACLK,2026,1,1,0,0,0", "SNTTA,1,2,3,4,000000.00", "CATXP,1"
    )
    assert talker.modem.counts == {}


KINDS = ["AACK", "ACFG", "ACST", "ACYC", "ADRQ", "AERR", "AMFD", "AMPC", "AMPR", "AMSG", "AMUA", "AMUC", "AMUR", "AREV"]
KINDS += ["ARXD", "ATXD", "ATXF", "AXST", "AMPA", "AZZZ"]
LINES = st.builds(
    lambda kind, fields: encode("C" + kind, *fields),
    st.sampled_from(KINDS),
    st.lists(st.sampled_from(["", "0", "1", "2", "3", "15", "32", "64", "-1", "1e9", "nan", "SRC", "INIT", "NMEA", "6",
                              "BAD_CRC", "20110914", "AABB"]), max_size=32),
)  # fmt: skip


@given(
    steps=st.lists(st.one_of(st.binary(max_size=60), LINES, st.floats(0.0, 30.0), st.booleans()), max_size=80),
    rate=st.sampled_from(sorted(RATES)),
)
def test_every_request_ends_whatever_the_modem_says(steps, rate):
    """Arbitrary bytes and sentences never raise; every request ends exactly once, and soon after the talk stops."""
    talker = Talker(rate)
    asked = 0
    for step in steps:
        if isinstance(step, bytes):
            talker.take(talker.modem.on_bytes(step, s(talker.time_s)))
        elif isinstance(step, bool):
            talker.ask(RangeRequest(asked, 0, "auv2") if step else Transmit(asked, 0, b"\x01\x02", "auv2", True))  # noqa: FBT003
            asked += 1
        else:
            talker.wait(talker.time_s + step)
    for _ in range(4):
        talker.wait(talker.time_s + 20.0)
    ends = [event.ticket for event in talker.told if isinstance(event, RangeResult)]
    ends += [e.ticket for e in talker.told if isinstance(e, TxEvent) and e.status != "SENT" and e.ticket not in ends]
    assert sorted(ends) == list(range(asked))


# -- rates, padding, addresses -----------------------------------------------------------------------------------------


@given(payload=st.binary(max_size=200), tail=st.sampled_from([b"", b"\x80", b"\0", b"\x80\0\0"]))
def test_padding_is_taken_off_again(payload, tail):
    """A payload comes out as it went in, whatever it ends in; or it is refused."""
    rate = Rate(1, 3, 64)
    payload = (payload + tail)[:192]
    cut = rate.split(payload)
    if cut is None:
        assert len(payload) == 192
        assert payload.rstrip(b"\0").endswith(b"\x80")
    else:
        assert {len(frame) for frame in cut} == {64}
        assert join(cut) == payload


def test_as_few_frames_as_possible():
    """A payload takes the frames it needs; one that fills them needs no mark."""
    rate = Rate(5, 8, 256)
    assert [len(rate.split(b"x" * size)) for size in (0, 1, 255, 256, 257, 2048)] == [1, 1, 1, 1, 2, 8]
    assert rate.split(b"x" * 2049) is None


def team(*modems: str, **link: str) -> str:
    names = [f"auv{place}" for place in range(1, len(modems) + 1)]
    places = "\n".join(f"{name} = [0, {50 * place}, 0]" for place, name in enumerate(names))
    craft = "\n".join(f"[craft.{name}]\n{text}" for name, text in zip(names, modems, strict=True))
    settings = "\n".join(f"{key} = {value}" for key, value in ({"profile": '"umodem_fsk0"'} | link).items())
    return (
        f'[clock]\npace = "live"\n[link]\n{settings}\n[mission]\ntype = "lawnmower"\n'
        f"[mission.formation_m]\n{places}\n{craft}"
    )


SERIAL = 'modem = {{ type = "serial", port = "/dev/ttyS{}" }}'


def test_addresses_of_a_team():
    """Without an address a craft has its place in the team, counted from 1; nobody has the broadcast address."""
    addresses = plan_addresses(loads(team(*[""] * 16)))
    assert list(addresses.values()) == [*range(1, 15), 16, 17]
    own = 'modem = { type = "serial", port = "/dev/ttyS0", address = 99 }'
    assert plan_addresses(loads(team("", own))) == {"auv1": 1, "auv2": 99}


@pytest.mark.parametrize(
    ("address", "problem"),
    [(15, "15 is the broadcast address"), (128, "128 is above 127"), (1, "1 is the address of auv1, too")],
)
def test_impossible_addresses(address, problem):
    """An address that a Micro-Modem cannot have is named with its craft."""
    own = f'modem = {{ type = "serial", port = "/dev/ttyS0", address = {address} }}'
    with pytest.raises(ConfigError, match=rf"^\$\.craft\.auv2\.modem\.address: {problem}"):
        check_serial_modems(loads(team("", own)))


def test_setup_of_a_scenario():
    """Rate, times and sound speed come from the scenario and its profile."""
    scenario = loads(team("", "") + "\n[link.water]\nnominal_sound_speed_mps = 1480.0")
    profile = load_profile("umodem_fsk0")
    plan = plan_setup(scenario, "auv2", profile)
    assert (plan.own, plan.rate, plan.payload_max_bytes, plan.nominal_mps) == (2, Rate(0, 1, 32), 32, 1480.0)
    assert plan.airtime_ns == profile.airtime_ns(32)
    # There and back over 5 km at 1400 m/s, and two minipackets of a second.
    assert plan.answer_ns > s(7.1 + 2.0)


@pytest.mark.parametrize(
    ("text", "path"),
    [
        (team(SERIAL.format(0), "").replace('"live"', '"lockstep"'), "$.craft.auv1.modem"),
        (team(SERIAL.format(0), "").replace('"live"', "2.0"), "$.craft.auv1.modem"),
        (team(SERIAL.format(0), SERIAL.format(0)), "$.craft.auv2.modem.port"),
        (team(SERIAL.format(0), "", profile='"s2c_im"'), "$.link.profile"),
        (team(SERIAL.format(0), "", land='[{ between = ["auv1", "auv2"] }]'), "$.link.land[0].between"),
    ],
)
def test_scenarios_that_do_not_suit_a_serial_modem(text, path):
    """What cannot work with a serial modem is refused with its path before anything starts."""
    with pytest.raises(ConfigError) as caught:
        check_serial_modems(loads(text))
    assert caught.value.path == path


def test_scenarios_without_serial_modems_are_not_looked_at():
    """A team of emulated modems may use any profile at any pace."""
    check_serial_modems(loads(team("", "", profile='"s2c_im"').replace('"live"', '"lockstep"')))
