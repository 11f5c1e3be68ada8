"""A serial line brings anything: every fault has its counter, nothing raises, every request ends."""

import random
from collections import Counter

from fuzzing import INPUTS, spoiled

from grex_agent.modem.micromodem import MicroModem
from grex_agent.modem.micromodem_rates import RATES, Setup
from grex_agent.modem.nmea import encode
from grex_link.messages import BadFrame, RangeRequest, RangeResult, Received, Transmit, TxEvent
from grex_link.units import NS

KINDS = ["CAACK", "CACFG", "CACST", "CACYC", "CADRQ", "CAERR", "CAMFD", "CAMPA", "CAMPC", "CAMPR", "CAMSG", "CAMUA",
         "CAMUC", "CAMUR", "CAREV", "CARXD", "CATXD", "CATXF", "CAXST", "CATXP", "CARXP", "CADQF", "CAXYZ",
         "GPGGA"]  # fmt: skip
FIELDS = ["", "0", "1", "2", "3", "15", "32", "64", "99", "-1", "1e308", "nan", "SRC", "SNV", "INIT", "AUV", "NMEA",
          "BAD_CRC", "PACKET_TIMEOUT", "20110914", "0.2501", "1fab", "68656C6C6F80", "223413.2013", "9" * 30,
          ]  # fmt: skip
SETTINGS = [("SRC", 1), ("ASD", 0), ("REV", 1), ("RXD", 1), ("TXF", 1), ("CST", 1), ("SNV", 0)]
#: Whole exchanges, so that the spoilt ones lead deep into the driver.
CYCLE = [("CACYC", 0, 1, 2, 0, 1, 1), ("CADRQ", "000001", 1, 2, 1, 32, 1), ("CATXD", 1, 2, 1, 32), ("CATXF", 32),
         ("CAACK", 2, 1, 1, 1)]  # fmt: skip
HEARD = [("CACYC", 0, 2, 15, 0, 0, 1), ("CARXD", 2, 15, 0, 1, "68656C6C6F80"),
         ("CACST", 0, "223413.2013", 3, 1440, 25, "0175", "0166", 75, 1, 1, 1, 3, 0, 2, 15, 0, 1, 1, 0, 146, 3, 4, -100,
          -1, 0, -1.2, 45, 25000, 4000)]  # fmt: skip


def ending(event, ranges: set[int]) -> list[int]:
    """Return the ticket that an event ends; a range that was refused has a result, and besides a reason."""
    if isinstance(event, RangeResult):
        ranges.add(event.ticket)
        return [event.ticket]
    final = isinstance(event, TxEvent) and event.status != "SENT" and event.ticket not in ranges
    return [event.ticket] if final else []


def test_any_serial_line():
    """Whatever comes in, spoilt or strange: nothing raises, faults are counted, requests end exactly once."""
    draw = random.Random(20080906)
    rate = RATES["umodem_fsk0"]
    modem = MicroModem(Setup("auv1", {"auv1": 1, "auv2": 2, "auv3": 3}, rate, 32, 4 * NS, 8 * NS, 1500.0))
    now_ns = asked = 0
    script: list[tuple[object, ...]] = []
    told: Counter[str] = Counter()
    ends: Counter[int] = Counter()
    ranges: set[int] = set()
    out = modem.on_connect(0)
    for _ in range(INPUTS):
        now_ns += round(draw.expovariate(1.0) * NS)
        if not script and draw.random() < 0.3:
            script = list(draw.choice([CYCLE, HEARD, [("CAMPC", 1, 2), ("CAMPR", 2, 1, 0.2)]]))
        if not modem.ready and draw.random() < 0.5:
            script = [("CACFG", *setting) for setting in SETTINGS]
        fields = script.pop(0) if script else (draw.choice(KINDS), *draw.choices(FIELDS, k=draw.randrange(30)))
        line = encode(*map(str, fields))
        out += modem.on_bytes(spoiled(draw, line) if draw.random() < 0.2 else line, now_ns)
        if draw.random() < 0.1:
            request = RangeRequest(asked, 0, "auv2") if draw.random() < 0.3 else Transmit(asked, 0, b"x", "auv2", True)  # noqa: FBT003
            out += modem.on_request(request, now_ns, now_ns)
            asked += 1
        out += modem.on_time(now_ns)
        for event in out:
            told[type(event).__name__] += 1
            ends.update(ending(event, ranges))
        out = []
    for _ in range(3):
        now_ns += 30 * NS
        out += modem.on_time(now_ns)
    for event in out:
        ends.update(ending(event, ranges))
    assert len(ends) == asked
    assert set(ends.values()) == {1}
    assert min(told[kind.__name__] for kind in (BadFrame, Received, RangeResult, TxEvent)) > 0
    expected = (
        "bad_checksum",
        "no_checksum",
        "malformed",
        "non_ascii",
        "stray_bytes",
        "cut_off",
        "unknown",
        "bad_fields",
    )
    assert all(modem.counts[fault] > 0 for fault in (*expected, "unknown_address", "overheard", "reboots"))
